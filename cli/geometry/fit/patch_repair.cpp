// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/patch_repair.cpp
#include "geometry/fit/patch_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/fit/inverted_faces.h"
#include "geometry/fit/points_by_face.h"
#include "geometry/mesh/infinity.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr std::array kRings{1, 2, 3, 5, 8};  // of a patch, until one unfolds
constexpr std::size_t kMostFaces = 200;      // with more, the source has no distinct sides (slivers, folds onto itself)
constexpr int kSweeps = 60;
constexpr double kUpright = 0.15;  // area over that of its shape from which a face is upright
constexpr double kLeastEpsilon = 1e-3, kEpsilonShare = 0.2;
constexpr double kThinnest = 0.1;  // of a shape that a face is held to: its height over its longest edge
constexpr double kSettled = 1e-3;  // of an edge: a sweep that moves none further is the last
constexpr double kProbe = 1e-3;    // of an edge: step of the differences

/// The shape of a face by the products of its edges from its first corner.
struct Shape {
    double aa, ab, bb;
    [[nodiscard]] double determinant() const { return aa * bb - ab * ab; }
};

Shape shape_of(const std::array<Vec3d, 3>& q) {
    const Vec3d a = q[1] - q[0], b = q[2] - q[0];
    return {dot(a, a), dot(a, b), dot(b, b)};
}

/// A function of two variables at a place and one step to each side of it.
struct Differences {
    double centre, px, mx, py, my, pp, mm;
};

/// Newton's step, in steps of the differences; the second derivatives are made definite along the diagonal.
Vec2d newton_step(const Differences& f) {
    const double gx = (f.px - f.mx) / 2, gy = (f.py - f.my) / 2;
    double xx = f.px + f.mx - 2 * f.centre, yy = f.py + f.my - 2 * f.centre;
    const double xy = (f.pp + f.mm - f.px - f.mx - f.py - f.my + 2 * f.centre) / 2;
    const double middle = (xx + yy) / 2, least = middle - math::hypot((xx - yy) / 2, xy);
    const double floor = 1e-3 * (std::abs(middle) + math::hypot((xx - yy) / 2, xy)) + 1e-300;
    if (least < floor) {
        xx += floor - least;
        yy += floor - least;
    }
    const double det = xx * yy - xy * xy;
    return {(xy * gy - yy * gx) / det, (xy * gx - xx * gy) / det};
}

struct Error {
    double squares = 0;        // of the distances of the source's points over some faces to the grid
    double fourth_powers = 0;  // of these and of the faces' middles: between mean and largest error
    double largest = 0;        // of both, squared
};

/// Classes with the places they have or had.
struct Patch {
    std::vector<std::uint32_t> classes;
    std::vector<Match> places;
    void take(const std::vector<std::uint32_t>& from, const Matches& matches) {
        classes = from;
        places.clear();
        for (const std::uint32_t c : classes) places.push_back(matches.classes[c]);
    }
};

std::size_t inverted_among(const LinkedSurface& grid, const ClosestPointIndex& index,
                           std::span<const std::uint32_t> faces) {
    TriMesh own;
    std::vector<char> either_side;
    for (const std::uint32_t f : faces) {
        if (!grid.either_side.empty()) either_side.push_back(grid.either_side[f]);
        const auto first = static_cast<std::uint32_t>(own.positions.size());
        for (const Vec3d& p : grid.corners(f)) own.positions.push_back(p);
        own.faces.push_back({first, first + 1, first + 2});
    }
    std::vector<std::uint32_t> found = find_turned_faces(index, own, kSafeTie, kSafeCosine, either_side);
    for (std::uint32_t f = 0; f < own.faces.size(); ++f)
        if (is_flat(own.corners(f))) found.push_back(f);
    std::sort(found.begin(), found.end());
    return static_cast<std::size_t>(std::unique(found.begin(), found.end()) - found.begin());
}

class PatchRepair {
 public:
    PatchRepair(const LinkedSurface& source, const ClosestPointIndex& index, std::span<const Vec3d> upward,
                WeldedGrid& grid, Matches& matches, std::span<const char> fixed, std::size_t& effort,
                const PatchAllowance& allowance)
        : source_(source),
          index_(index),
          upward_(upward),
          grid_(grid.surface),
          matches_(matches),
          fixed_(fixed),
          effort_(effort),
          rings_(grid.rings()),
          in_patch_(grid_.positions.size(), 0),
          number_(grid_.faces.size(), kNone),
          over_(matches.points, grid_.faces.size()) {
        for (const Match& m : matches.points) purse_ += allowance.squares * m.hit.squared;
        limit_ = allowance.largest * allowance.largest * (matches.largest * matches.largest);
    }

    bool run(std::span<const std::uint32_t> inverted) {
        bool moved = false;
        for (const std::uint32_t f : inverted)
            if (effort_ > 0 && is_inverted(f)) moved = lay_flat(f) || moved;
        matches_.count_looks(looked_);
        return moved;
    }

 private:
    [[nodiscard]] std::span<const std::uint32_t> ring(std::uint32_t c) const {
        return std::span(rings_.faces).subspan(rings_.first[c], rings_.first[c + 1] - rings_.first[c]);
    }

    [[nodiscard]] std::size_t count_inverted(std::span<const std::uint32_t> faces) const {
        return inverted_among(grid_, index_, faces);
    }
    [[nodiscard]] bool is_inverted(std::uint32_t f) const { return count_inverted(std::array{f}) != 0; }

    /// The free classes around a face, and the faces around those.
    void gather(std::uint32_t face, int rings) {
        const auto add = [&](std::uint32_t c) {
            in_patch_[c] = 1;
            patch_.push_back(c);
        };
        patch_.clear();
        faces_.clear();
        for (const std::uint32_t c : grid_.faces[face]) add(c);
        std::size_t from = 0;
        for (int k = 0; k < rings; ++k) {
            const std::size_t end = patch_.size();
            for (; from < end; ++from)
                for (const std::uint32_t f : ring(patch_[from]))
                    for (const std::uint32_t c : grid_.faces[f])
                        if (!in_patch_[c]) add(c);
        }
        for (const std::uint32_t c : patch_) in_patch_[c] = 0;
        std::erase_if(patch_, [&](std::uint32_t c) { return fixed_[c] != 0; });
        for (const std::uint32_t c : patch_) faces_.insert(faces_.end(), ring(c).begin(), ring(c).end());
        std::sort(faces_.begin(), faces_.end());
        faces_.erase(std::unique(faces_.begin(), faces_.end()), faces_.end());
    }

    /// Each face is held to the shape that it has, but none to a thin one.
    void note_shapes() {
        shapes_.clear();
        up_.resize(faces_.size());
        for (std::uint32_t k = 0; k < faces_.size(); ++k) {
            number_[faces_[k]] = k;
            const auto q = grid_.corners(faces_[k]);
            Shape s = shape_of(q);
            const double longest = longest_edge_squared(q),
                         lack = kThinnest * longest - std::sqrt(std::max(0.0, s.determinant()));
            if (lack > 0) s = {s.aa + lack, s.ab + lack / 2, s.bb + lack};
            shapes_.push_back(s);
        }
    }

    /// Direction that each face should have: that of the source below its corners.
    void note_upward() {
        for (std::size_t k = 0; k < faces_.size(); ++k) {
            Vec3d sum;
            for (const std::uint32_t c : grid_.faces[faces_[k]]) sum += upward_[matches_.classes[c].hit.face];
            up_[k] = normalized(sum, upward_[matches_.classes[grid_.faces[faces_[k]][0]].hit.face]);
        }
    }

    /// Area over that of its shape, negative where it is inverted.
    [[nodiscard]] double stretch(std::uint32_t k) const {
        const auto q = grid_.corners(faces_[k]);
        return dot(up_[k], cross(q[1] - q[0], q[2] - q[0])) / std::sqrt(shapes_[k].determinant());
    }

    [[nodiscard]] double energy(std::uint32_t c) const {
        double sum = 0;
        for (const std::uint32_t f : ring(c)) {
            const std::uint32_t k = number_[f];
            const Shape &r = shapes_[k], s = shape_of(grid_.corners(f));
            const double d = stretch(k), barrier = (d + std::sqrt(epsilon_ * epsilon_ + d * d)) / 2;
            const double trace = (r.bb * s.aa - 2 * r.ab * s.ab + r.aa * s.bb) / r.determinant();
            sum += (trace + 1 + d * d) / barrier;
        }
        return sum;
    }

    /// One Newton step in the tangent plane, shortened until it helps. Returns how far it went, in edges.
    double relax(std::uint32_t c) {
        Match& match = matches_.classes[c];
        const Vec3d old = grid_.positions[c], up = upward_[match.hit.face];
        double reach = kInfinity;
        for (const std::uint32_t f : ring(c)) {
            const Shape& r = shapes_[number_[f]];
            reach = std::min({reach, r.aa, r.bb});
        }
        reach = std::sqrt(reach);
        const Vec3d x = any_perpendicular(up), y = cross(up, x);
        const double h = kProbe * reach, start = energy(c);
        const auto at = [&](double a, double b) {
            grid_.positions[c] = old + (x * a + y * b) * h;
            return energy(c);
        };
        const double px = at(1, 0), mx = at(-1, 0), py = at(0, 1), my = at(0, -1), pp = at(1, 1), mm = at(-1, -1);
        const Vec2d by = newton_step({start, px, mx, py, my, pp, mm});
        Vec3d step = (x * by.x + y * by.y) * h;
        if (const double l = length(step); !(l <= reach)) step = std::isfinite(l) ? step * (reach / l) : Vec3d{};
        constexpr int kHalvings = 8;
        for (int k = 0; k < kHalvings; ++k, step *= 0.4) {
            const SurfaceHit hit = walk_to_closest(source_, old + step, match.hit.face, &looked_);
            grid_.positions[c] = point_at(source_, hit);
            if (energy(c) < start) {
                match.hit = hit;
                match.position = grid_.positions[c];
                return length(match.position - old) / reach;
            }
        }
        grid_.positions[c] = old;
        return 0;
    }

    /// Slides the patch until no face of it is inverted.
    void slide() {
        note_shapes();
        if (std::any_of(shapes_.begin(), shapes_.end(), [](const Shape& s) { return !(s.determinant() > 0); })) return;
        for (int sweep = 0; sweep < kSweeps && effort_ > 0; ++sweep) {
            note_upward();
            double least = kInfinity, farthest = 0;
            for (std::uint32_t k = 0; k < faces_.size(); ++k) least = std::min(least, stretch(k));
            if (sweep > 0 && least > kUpright && count_inverted(faces_) == 0) break;
            epsilon_ = math::hypot(kLeastEpsilon, kEpsilonShare * std::min(0.0, least));
            for (const std::uint32_t c : patch_) farthest = std::max(farthest, relax(c));
            effort_ -= looked_ < Matches::kMostLooksOfRepair ? std::min(effort_, patch_.size()) : effort_;
            if (farthest < kSettled) break;
        }
    }

    [[nodiscard]] Error error_over(std::span<const std::uint32_t> faces) const {
        Error out;
        const auto add = [&](double squared) {
            out.fourth_powers += squared * squared;
            out.largest = std::max(out.largest, squared);
            return squared;
        };
        for (const std::uint32_t f : faces) {
            for (std::uint32_t k = over_.first[f]; k < over_.first[f + 1]; ++k) {
                out.squares += add(walk_to_closest(grid_, matches_.points[over_.of[k]].position, f).squared);
            }
            const auto q = grid_.corners(f);
            add(walk_to_closest(source_, (q[0] + q[1] + q[2]) / 3, matches_.middles[f].hit.face).squared);
        }
        return out;
    }

    void put(const Patch& patch) {
        for (std::size_t k = 0; k < patch.classes.size(); ++k) {
            matches_.classes[patch.classes[k]] = patch.places[k];
            grid_.positions[patch.classes[k]] = patch.places[k].position;
        }
    }

    /// Ever larger patches around a face, until one lies flat and the next does not lie better.
    bool lay_flat(std::uint32_t face) {
        gather(face, kRings.back());
        const std::vector<std::uint32_t> all = faces_;
        Patch start, best;
        for (const std::uint32_t c : patch_) matches_.classes[c].position = grid_.positions[c];
        start.take(patch_, matches_);
        std::size_t fewest = count_inverted(all);
        const double squares = error_over(all).squares;
        double least = kInfinity, price = 0;
        for (const int rings : kRings) {
            gather(face, rings);
            slide();
            const std::size_t left = count_inverted(all);
            bool better = left < fewest || (left == fewest && !best.classes.empty());
            if (better) {
                const Error error = error_over(all);
                better = (left < fewest || error.fourth_powers < least) && error.largest <= limit_ &&
                         error.squares - squares <= purse_;
                if (better) {
                    fewest = left;
                    least = error.fourth_powers;
                    price = error.squares - squares;
                    best.take(patch_, matches_);
                }
            }
            const bool done = !best.classes.empty() && !better;
            for (const std::uint32_t f : faces_) number_[f] = kNone;
            put(start);
            if (done) break;
        }
        if (best.classes.empty()) return false;
        put(best);
        purse_ -= price;
        for (const std::uint32_t f : all) {
            grid_.update_normal(f);
            matches_.update_middle(f);
        }
        return true;
    }

    const LinkedSurface& source_;
    const ClosestPointIndex& index_;
    std::span<const Vec3d> upward_;
    LinkedSurface& grid_;
    Matches& matches_;
    std::span<const char> fixed_;
    std::size_t& effort_;
    WeldedGrid::Rings rings_;
    std::vector<char> in_patch_;         // per class, while a patch is gathered
    std::vector<std::uint32_t> number_;  // per face: in the patch
    PointsByFace over_;                  // source points over each face
    std::vector<std::uint32_t> patch_, faces_;
    double limit_ = 0;           // squared distance, of a patch that lies flat
    double purse_ = 0;           // squared distances that laying flat may yet add
    std::vector<Shape> shapes_;  // per face of the patch
    std::vector<Vec3d> up_;
    double epsilon_ = 1;
    std::uint64_t looked_ = 0;  // faces that walks looked at
};

}  // namespace

bool repair_by_patch(const LinkedSurface& source, const ClosestPointIndex& index, std::span<const Vec3d> upward,
                     WeldedGrid& grid, Matches& matches, std::span<const char> fixed,
                     std::span<const std::uint32_t> inverted, std::size_t& effort, const PatchAllowance& allowance) {
    if (inverted.size() > kMostFaces) return false;
    return PatchRepair(source, index, upward, grid, matches, fixed, effort, allowance).run(inverted);
}

}  // namespace dgm::bake
