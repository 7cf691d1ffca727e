// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/vertex_repair.cpp
#include "geometry/fit/vertex_repair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/fit/cover.h"
#include "geometry/mesh/infinity.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr int kPasses = 20;
constexpr int kDirections = 12;
constexpr double kInverted = 0.3;  // price of an inverted face without area
constexpr double kWanted = 0.3;    // cosine from which a face counts as upright
constexpr double kCover = 3;       // price of a source vertex one spacing away from the ring that covered it
constexpr double kOff = 0.1;       // price of a face whose middle is a ring's reach away from the source
constexpr double kLeastGain = 1e-3;
// Faces looked at, in one call. A few hundred inverted faces take a tenth of it; where thousands are, the source has no
// distinct sides (slivers, folds onto itself), and trying the rest of them would fail.
constexpr std::size_t kMostEffort = 4'000'000;

class VertexRepair {
 public:
    VertexRepair(const LinkedSurface& source, WeldedGrid& grid, Matches& matches, std::span<const char> fixed)
        : source_(source),
          grid_(grid.surface),
          matches_(matches),
          fixed_(fixed),
          rings_(grid.rings()),
          cover_(matches, grid.surface.faces.size()) {
        settled_.assign(grid_.positions.size(), 0);
        squared_spacing_ = surface_area(source) / static_cast<double>(grid_.positions.size());
    }

    bool run(double upright) {
        bool any = false;
        for (int pass = 0; pass < kPasses; ++pass) {
            bool moved = false;
            for (std::uint32_t f = 0; f < grid_.faces.size(); ++f)
                if (dot(grid_.normals[f], source_.normals[matches_.middles[f].hit.face]) < upright)
                    moved = mend(f) || moved;
            if (!moved) break;
            any = true;
        }
        return any;
    }

    bool mend(std::uint32_t face) {
        bool moved = false;
        for (const std::uint32_t c : grid_.faces[face])
            if (!fixed_[c] && !settled_[c] && has_effort() && improve(c)) moved = true;
        return moved;
    }

    [[nodiscard]] std::uint64_t looked() const { return looked_; }

 private:
    [[nodiscard]] bool has_effort() const { return effort_ < kMostEffort && looked_ < Matches::kMostLooksOfRepair; }

    [[nodiscard]] std::span<const std::uint32_t> ring(std::uint32_t c) const {
        return std::span(rings_.faces).subspan(rings_.first[c], rings_.first[c + 1] - rings_.first[c]);
    }

    /// Exact if it is less than `least`.
    [[nodiscard]] double penalty(std::uint32_t c, double reach, double least) {
        double sum = 0;
        effort_ += ring(c).size();
        for (const std::uint32_t f : ring(c)) {
            const auto q = grid_.corners(f);
            const Vec3d area = cross(q[1] - q[0], q[2] - q[0]), normal = normalized(area, Vec3d{});
            const SurfaceHit hit =
                walk_to_closest(source_, (q[0] + q[1] + q[2]) / 3, matches_.middles[f].hit.face, &looked_);
            // Also by area: a face that lies flat on its back turns no less while it shrinks.
            sum += std::max(0.0, kWanted - dot(normal, source_.normals[hit.face])) *
                   (kInverted + length(area) / (reach * reach));
            sum += kOff * std::min(1.0, hit.squared / (reach * reach));
            effort_ += cover_.over(f).size();
        }
        const auto price = [&](double squared) { return sum + kCover * squared / squared_spacing_; };
        return price(cover_.farthest(grid_, ring(c), [&](double squared) { return price(squared) >= least; }));
    }

    bool improve(std::uint32_t c) {
        const Vec3d old = grid_.positions[c];
        Vec3d mean, up;
        double reach = 0;
        for (const std::uint32_t f : ring(c)) {
            for (const std::uint32_t o : grid_.faces[f]) {
                mean += grid_.positions[o];
                reach = std::max(reach, length(grid_.positions[o] - old));
            }
            up += source_.normals[matches_.middles[f].hit.face];
        }
        settled_[c] = 1;
        if (!(reach > 0)) return false;
        // A ring's corners are its middle and each rim vertex twice: half the way to the rim's mean and more.
        const Vec3d inward = (mean / (3.0 * static_cast<double>(ring(c).size())) - old) * 1.5;
        up = normalized(up, Vec3d{0, 0, 1});
        const Vec3d x = any_perpendicular(up), y = cross(up, x);

        Vec3d best = old;
        double least = penalty(c, reach, kInfinity) - kLeastGain;
        const auto attempt = [&](const Vec3d& to) {
            grid_.positions[c] =
                point_at(source_, walk_to_closest(source_, to, matches_.classes[c].hit.face, &looked_));
            const double now = penalty(c, reach, least);
            if (now < least) {
                least = now;
                best = grid_.positions[c];
            }
        };
        for (const double t : {0.25, 0.5, 1.0}) attempt(old + inward * t);
        for (int k = 0; k < kDirections; ++k) {
            const double angle = k * (2 * std::numbers::pi / kDirections);
            const auto [sine, cosine] = math::sine_cosine(angle);
            for (const double t : {0.1, 0.3}) attempt(old + (x * cosine + y * sine) * (t * reach));
        }
        grid_.positions[c] = best;
        if (best == old) return false;
        matches_.classes[c].hit = walk_to_closest(source_, best, matches_.classes[c].hit.face);
        for (const std::uint32_t f : ring(c)) {
            grid_.update_normal(f);
            matches_.update_middle(f);
            for (const std::uint32_t o : grid_.faces[f]) settled_[o] = 0;
        }
        return true;
    }

    const LinkedSurface& source_;
    LinkedSurface& grid_;
    Matches& matches_;
    std::span<const char> fixed_;
    WeldedGrid::Rings rings_;
    Cover cover_;
    double squared_spacing_ = 1;
    std::vector<char> settled_;  // per class: nothing that it depends on has changed since it stayed
    std::size_t effort_ = 0;     // faces judged
    std::uint64_t looked_ = 0;   // faces that walks looked at
};

}  // namespace

bool repair_by_vertex(const LinkedSurface& source, WeldedGrid& grid, Matches& matches, std::span<const char> fixed,
                      double upright) {
    VertexRepair repair(source, grid, matches, fixed);
    const bool moved = repair.run(upright);
    matches.count_looks(repair.looked());
    return moved;
}

bool repair_by_vertex(const LinkedSurface& source, WeldedGrid& grid, Matches& matches, std::span<const char> fixed,
                      std::span<const std::uint32_t> faces) {
    VertexRepair repair(source, grid, matches, fixed);
    bool moved = false;
    for (const std::uint32_t f : faces) moved = repair.mend(f) || moved;
    matches.count_looks(repair.looked());
    return moved;
}

}  // namespace dgm::bake
