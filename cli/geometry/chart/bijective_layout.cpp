// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/bijective_layout.cpp
// [Jiang, Schaefer, Panozzo 2017] Simplicial Complex Augmentation Framework for Bijective Maps. ACM TOG 36(6).
#include "geometry/chart/bijective_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "geometry/mesh/infinity.h"
#include "geometry/parameterize/coarse_descent.h"
#include "geometry/parameterize/convex_map.h"

namespace dgm::bake {
namespace {
constexpr int kRounds = 40;
constexpr std::size_t kStepsPerRound = 5;
constexpr double kOutsideWeight = 0.01;      // of all triangles outside, against the surface's energy
constexpr std::size_t kStepsInside = 60;     // at most, before the border moves
constexpr double kIdle = 1e-2;               // gained by one of them: no more
constexpr double kCrowded = 20;              // energy that calls for them; an isometric map has 2
constexpr double kFlat = 0.05, kWiden = 30;  // of rest shapes outside
constexpr double kMargin = 0.5;              // of the chart's extent, between it and the box
constexpr std::uint32_t kBoxPoints = 8;      // per side
constexpr double kStepIdle = 0.5;            // of a round's tolerance: gained by one step, no more in that round
constexpr double kTolerance = 2e-3;          // of the energy, gained by a round
constexpr double kRoughly = 2e-2;            // the same where another energy follows
constexpr double kOnceMore = 2e-2;           // the same where a coarser level has come to kTolerance and 0 is isometric

double twice_area(Vec2d a, Vec2d b, Vec2d c) {
    return cross(b - a, c - a);
}

/// The rest shape of a triangle that is at rest as it lies.
RestShape at_rest(Vec2d a, Vec2d b, Vec2d c, double weight) {
    const double inverse = 1 / twice_area(a, b, c);
    const auto hat = [&](Vec2d p, Vec2d q) { return Vec2d{p.y - q.y, q.x - p.x} * inverse; };
    return {{hat(b, c), hat(c, a), hat(a, b)}, weight};
}

/// The triangle abc, up to kWiden times as high over its longest side, but not higher than kFlat sides. Rest shapes as
/// flat as their triangles would let the borders on both sides of a gap close in on each other round by round, until
/// doubles resolve no gap any more and no step is left.
std::array<Vec2d, 3> widened(std::array<Vec2d, 3> q) {
    std::size_t apex = 0;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (const double side = length(q[(k + 2) % 3] - q[(k + 1) % 3]); side > longest) {
            longest = side;
            apex = k;
        }
    const Vec2d base = q[(apex + 1) % 3], along = (q[(apex + 2) % 3] - base) * (1 / longest), up{-along.y, along.x};
    const double height = dot(q[apex] - base, up);
    if (height > 0 && height < kFlat * longest)
        q[apex] = q[apex] + up * (std::min(kWiden * height, kFlat * longest) - height);
    return q;
}

SlimOptions round_options(FlipFreeEnergy energy, double tolerance) {
    SlimOptions options;
    options.energy = energy;
    options.border_fixed = true;
    options.iterations = kStepsPerRound;
    options.tolerance = tolerance;
    return options;
}

/// Evenly spaced points on a box, counter-clockwise.
std::vector<Vec2d> points_of_box(const Vec2d& lo, const Vec2d& hi) {
    const Vec2d corners[] = {lo, {hi.x, lo.y}, hi, {lo.x, hi.y}, lo};
    std::vector<Vec2d> out;
    for (int side = 0; side < 4; ++side)
        for (std::uint32_t p = 0; p < kBoxPoints; ++p)
            out.push_back(corners[side] + (corners[side + 1] - corners[side]) * (double(p) / kBoxPoints));
    return out;
}

class Augmented {
 public:
    Augmented(const DiskView& disk, const Triangulate& triangulate)
        : disk_(disk),
          triangulate_(triangulate),
          rest_(rest_shapes(disk)),
          faces_(disk.faces.begin(), disk.faces.end()) {
        for (const RestShape& r : rest_) area_ += r.area;
    }

    [[nodiscard]] double area() const { return area_; }

    /// Triangulates the outside of `uv`, where the energy is `now`, and moves the vertices by a few Newton steps.
    /// Ends where a step gains less than `tolerance` of the energy.
    void improve(std::vector<Vec2d>& uv, FlipFreeEnergy energy, double now, double tolerance,
                 const model::Progress& progress) {
        const std::size_t n = disk_.positions.size(), k = disk_.border.size();
        std::vector<Vec2d> points, x = uv;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> constraints;
        const auto close = [&](std::size_t from) {
            for (std::size_t p = from; p < points.size(); ++p)
                constraints.emplace_back(static_cast<std::uint32_t>(p),
                                         static_cast<std::uint32_t>(p + 1 < points.size() ? p + 1 : from));
        };
        for (const std::uint32_t v : disk_.border) points.push_back(uv[v]);
        close(0);
        const auto [lo, hi] = box_around(points);
        std::vector<std::uint32_t> box;
        for (const Vec2d& p : points_of_box(lo, hi)) {
            box.push_back(static_cast<std::uint32_t>(x.size()));
            x.push_back(p);
            points.push_back(p);
        }
        close(k);
        fill_outside(lo, hi, k, points);

        faces_.resize(disk_.faces.size());
        rest_.resize(disk_.faces.size());
        const std::vector<Face> outside = triangulate_(points, constraints);
        // Beside a large energy gaps would cost nothing, and close. An isometric map has an energy of 2.
        const double share = kOutsideWeight * std::max(1.0, 0.5 * now);
        const double weight = share * area_ / static_cast<double>(outside.size());
        // Border vertices are the disk's own, the box and the points that fill the outside come after them; points
        // inside the chart belong to no face and get no number.
        std::vector<std::uint32_t> number(points.size(), kNone);
        for (std::size_t p = 0; p < points.size(); ++p)
            number[p] = p < k ? disk_.border[p] : p < k + box.size() ? box[p - k] : kNone;
        for (const Face& f : outside) {
            Face face;
            for (std::size_t c = 0; c < 3; ++c) {
                std::uint32_t& v = number[f[c]];
                if (v == kNone) {
                    v = static_cast<std::uint32_t>(x.size());
                    x.push_back(points[f[c]]);
                }
                face[c] = v;
            }
            faces_.push_back(face);
            const auto [a, b, c] = widened({x[face[0]], x[face[1]], x[face[2]]});
            rest_.push_back(at_rest(a, b, c, weight));
        }
        const std::vector<Vec3d> nowhere(x.size());  // rest shapes stand for positions
        SlimOptions options = round_options(energy, tolerance);
        options.rest = rest_;
        const model::Progress silent{.on_update = {}, .cancelled = progress.cancelled};
        x = descend_flip_free({nowhere, faces_, box, {}}, std::move(x), options, silent);
        std::copy_n(x.begin(), n, uv.begin());
    }

 private:
    /// Two corners of a box that holds all points with a margin.
    static std::pair<Vec2d, Vec2d> box_around(const std::vector<Vec2d>& points) {
        Vec2d lo = points[0], hi = lo;
        for (const Vec2d& p : points) {
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
        }
        const Vec2d margin = Vec2d{1, 1} * (kMargin * std::max(hi.x - lo.x, hi.y - lo.y));
        return {lo - margin, hi + margin};
    }

    /// Adds points between the border (the first `border` points) and the box, as far apart as they are from the
    /// border: without them the triangles outside are needles that hold the border where it is.
    static void fill_outside(Vec2d lo, Vec2d hi, std::size_t border, std::vector<Vec2d>& points) {
        double around = 0;
        for (std::size_t p = 0; p < border; ++p) around += length(points[(p + 1) % border] - points[p]);
        const double extent = std::max(hi.x - lo.x, hi.y - lo.y);
        // Not finer than the border is on average, nor than a 200th of the box.
        double spacing = std::max(1.5 * around / static_cast<double>(border), extent / 200);
        constexpr std::size_t kMostMeasured = 2000;  // border points that distances are measured to
        std::vector<Vec2d> fixed;
        for (std::size_t p = 0; p < points.size(); p += 1 + border / kMostMeasured) fixed.push_back(points[p]);
        for (; spacing < 0.25 * extent; spacing *= 2) {
            const double nearest = 0.8 * spacing, farthest = 1.6 * spacing;
            const Buckets buckets(fixed, lo, hi, farthest);
            for (double y = lo.y + spacing; y < hi.y - 0.5 * spacing; y += spacing)
                for (double x = lo.x + spacing; x < hi.x - 0.5 * spacing; x += spacing) {
                    const double squared = buckets.nearest_squared({x, y});
                    if (squared > nearest * nearest && squared <= farthest * farthest) points.push_back({x, y});
                }
        }
    }

    /// Points by the square of side `reach` that they lie in: those within reach of a place are in nine of them.
    class Buckets {
     public:
        Buckets(std::span<const Vec2d> points, Vec2d lo, Vec2d hi, double reach)
            : lo_(lo),
              reach_(reach),
              columns_(static_cast<std::size_t>((hi.x - lo.x) / reach) + 1),
              rows_(static_cast<std::size_t>((hi.y - lo.y) / reach) + 1),
              first_(rows_ * columns_ + 1, 0),
              points_(points.size()) {
            const auto bucket = [&](Vec2d p) {
                return index(p.y - lo_.y, rows_) * columns_ + index(p.x - lo_.x, columns_);
            };
            for (const Vec2d& p : points) ++first_[bucket(p) + 1];
            for (std::size_t b = 0; b + 1 < first_.size(); ++b) first_[b + 1] += first_[b];
            std::vector<std::size_t> fill(first_.begin(), first_.end() - 1);
            for (const Vec2d& p : points) points_[fill[bucket(p)]++] = p;
        }

        /// Squared distance to the nearest of the points within reach, or of some farther off; infinity if there are
        /// none.
        [[nodiscard]] double nearest_squared(Vec2d at) const {
            const std::size_t row = index(at.y - lo_.y, rows_), column = index(at.x - lo_.x, columns_);
            double squared = kInfinity;
            for (std::size_t r = row - (row > 0); r <= std::min(row + 1, rows_ - 1); ++r) {
                const std::size_t base = r * columns_;
                const std::size_t end = first_[base + std::min(column + 1, columns_ - 1) + 1];
                for (std::size_t p = first_[base + column - (column > 0)]; p < end; ++p)
                    squared = std::min(squared, dot(points_[p] - at, points_[p] - at));
            }
            return squared;
        }

     private:
        [[nodiscard]] std::size_t index(double along, std::size_t count) const {
            return std::min(static_cast<std::size_t>(std::max(along, 0.0) / reach_), count - 1);
        }

        Vec2d lo_;
        double reach_;
        std::size_t columns_, rows_;
        std::vector<std::size_t> first_;
        std::vector<Vec2d> points_;
    };

    const DiskView& disk_;
    const Triangulate& triangulate_;
    std::vector<RestShape> rest_;
    std::vector<Face> faces_;
    double area_ = 0;
};
/// Rounds for one energy after the other, each until one gains less than its share.
std::vector<Vec2d> descend_in_rounds(const DiskView& disk, std::vector<Vec2d> uv,
                                     std::span<const std::pair<FlipFreeEnergy, double>> energies,
                                     const Triangulate& triangulate, const model::Progress& progress) {
    Augmented augmented(disk, triangulate);
    double map = 0;
    for (const Face& f : disk.faces) map += 0.5 * twice_area(uv[f[0]], uv[f[1]], uv[f[2]]);
    if (!(map > 0)) throw model::Error(model::codes::kMapInvalid, "the start of the descent has no area");
    for (Vec2d& p : uv) p = p * std::sqrt(augmented.area() / map);
    // A crowded start spreads inside first, where there is no gap to close: loops about many handles need that most.
    SlimOptions inside;
    inside.border_fixed = true;
    inside.iterations = kStepsInside;
    inside.tolerance = kIdle;
    if (flip_free_energy(disk, uv, inside) > kCrowded)
        uv = descend_flip_free(disk, std::move(uv), inside, {.on_update = {}, .cancelled = progress.cancelled});
    for (const auto& [energy, tolerance] : energies) {
        SlimOptions options;
        options.energy = energy;
        double last = flip_free_energy(disk, uv, options);
        for (int round = 0; round < kRounds; ++round) {
            progress.update("parameterize", static_cast<double>(round) / kRounds);
            std::vector<Vec2d> next = uv;
            augmented.improve(next, energy, last, kStepIdle * tolerance, progress);
            const double lowered = flip_free_energy(disk, next, options);
            if (!(lowered < last)) break;
            uv = std::move(next);
            const bool done = last - lowered < tolerance * lowered;
            last = lowered;
            if (done) break;
        }
    }
    return uv;
}
}  // namespace

std::vector<Vec2d> descend_bijective(const DiskView& disk, std::vector<Vec2d> start, FlipFreeEnergy energy,
                                     const Triangulate& triangulate, const model::Progress& progress) {
    using Steps = std::vector<std::pair<FlipFreeEnergy, double>>;
    // The symmetric Dirichlet energy unfolds a crowded start; the others would stay near it.
    Steps steps{{energy, kTolerance}};
    if (energy != FlipFreeEnergy::kSymmetricDirichlet)
        steps.insert(steps.begin(), {FlipFreeEnergy::kSymmetricDirichlet, kRoughly});
    // From the convex outline in `start`: a border that does not overlap itself on the coarse level does not here.
    const auto descend = [&](const DiskView& coarse) -> std::optional<std::vector<Vec2d>> {
        ConvexMapSolver solver(coarse.positions.size(), coarse.faces, coarse.border);
        std::vector<Vec2d> uv =
            solver.solve(positive_cotangent_weights(coarse.positions, coarse.faces, solver.edges()), coarse.border_uv);
        if (count_not_positive(coarse.faces, uv) > 0) return std::nullopt;
        return descend_in_rounds(coarse, std::move(uv), steps, triangulate, progress);
    };
    if (auto coarse = map_coarsely(disk, start, descend, progress)) {
        start = std::move(*coarse);
        // The long way is behind it. A tenth of the share is as much for the energy that is 2 where isometric.
        steps = {{energy, energy == FlipFreeEnergy::kSymmetricDirichlet ? kTolerance : kOnceMore}};
    }
    return descend_in_rounds(disk, std::move(start), steps, triangulate, progress);
}

}  // namespace dgm::bake
