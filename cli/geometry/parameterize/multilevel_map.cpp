// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/multilevel_map.cpp
// [Hormann, Labsik, Greiner 1999] Remeshing triangulated surfaces with optimal parameterizations.
// [Sander 2001] Sander, Snyder, Gortler, Hoppe. Texture Mapping Progressive Meshes. SIGGRAPH 2001.
#include "geometry/parameterize/multilevel_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/mesh/infinity.h"
#include "geometry/mesh/vertex_corners.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/damped_reweight.h"
#include "geometry/parameterize/slim.h"
#include "geometry/simplify/simplify.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

// A level of more faces is relaxed about those alone that stretch so many times as much as most, and more often: all
// others lie well where they were put back, and ten scans of 0.5 to 1.3 million faces have the same error.
constexpr std::size_t kFineLevel = 300'000;
constexpr double kFarStretched = 3;
constexpr int kSweepsOfFew = 30, kLooksAgain = 5;
constexpr double kStillOfFew = 0.02;

/// One face about a vertex: the map of its far side, and its shape on the surface.
struct Wedge {
    Vec2d p1, p2;
    double area;
    double l0, l1, l2;  ///< squared lengths opposite the vertex, p1 and p2
};

/// Stretch of the faces about a vertex as a function of its place in the map.
///
/// For one face it is N(x) / T(x)^2, with T the doubled area in the map, linear in x, and N quadratic (edge form of
/// (|S_s|^2 + |S_t|^2) / 2, convex_map.cpp).
class Ring {
 public:
    explicit Ring(double power) : power_(power) {}

    std::vector<Wedge> wedges;

    /// Squared, of one face with the vertex at x.
    [[nodiscard]] static double stretch_of(const Wedge& w, Vec2d x) {
        const double t = cross(w.p1 - x, w.p2 - x);
        return numerator(w, x) / (t * t);
    }

    [[nodiscard]] double energy(Vec2d x) const {
        double sum = 0;
        for (const Wedge& w : wedges) {
            const double t = cross(w.p1 - x, w.p2 - x);
            if (!(t > 0)) return kInfinity;
            sum += w.area * raised(numerator(w, x) / (t * t), power_);
        }
        return std::isfinite(sum) ? sum : kInfinity;
    }

    /// Newton steps from x, where the energy is finite; each lowers it.
    [[nodiscard]] Vec2d relax(Vec2d x, int steps) const {
        for (int k = 0; k < steps; ++k) {
            Vec2d g;
            double e = 0, xx = 0, xy = 0, yy = 0;
            for (const Wedge& w : wedges) {
                const Vec2d d0 = w.p2 - w.p1, turn{-d0.y, d0.x};
                const double t = cross(w.p1 - x, w.p2 - x), n = numerator(w, x), i = 1 / t, i2 = i * i, i3 = i2 * i;
                const Vec2d dn = (x * 2 - w.p1 - w.p2) * w.l0 + d0 * (w.l1 - w.l2);
                // q, its gradient and Hessian; then of q^p.
                const double q = n * i2;
                const Vec2d dq = dn * i2 - turn * (2 * n * i3);
                const double a = 2 * w.l0 * i2, b = 2 * i3, c = 6 * n * i2 * i2;
                const double first = w.area * power_ * raised(q, power_ - 1);
                const double second = power_ == 2 ? 2 * w.area : first * (power_ - 1) / q;
                e += w.area * raised(q, power_);
                g = g + dq * first;
                xx += first * (a - 2 * b * dn.x * turn.x + c * turn.x * turn.x) + second * dq.x * dq.x;
                xy += first * (-b * (dn.x * turn.y + dn.y * turn.x) + c * turn.x * turn.y) + second * dq.x * dq.y;
                yy += first * (a - 2 * b * dn.y * turn.y + c * turn.y * turn.y) + second * dq.y * dq.y;
            }
            // Shift the smaller eigenvalue to at least a hundredth of the larger one: the energy need not be convex.
            const double mean = 0.5 * (xx + yy), radius = length(Vec2d{0.5 * (xx - yy), xy});
            const double shift = std::max(0.0, 0.01 * (mean + radius) - (mean - radius));
            const double a = xx + shift, c = yy + shift, det = a * c - xy * xy;
            if (!(det > 0)) return x;
            const Vec2d step{-(c * g.x - xy * g.y) / det, -(a * g.y - xy * g.x) / det};
            double s = 1;
            for (int halving = 0; halving < 12; ++halving, s *= 0.5) {
                const Vec2d y = x + step * s;
                const double now = energy(y);
                if (now < e) {
                    x = y;
                    if (now > 0.999 * e) return x;
                    break;
                }
                if (halving == 11) return x;
            }
        }
        return x;
    }

    /// A point inside the kernel, near `wish` if that is not; nothing if rounding leaves no kernel.
    [[nodiscard]] std::optional<Vec2d> inside(Vec2d wish) const {
        if (energy(wish) < kInfinity) return wish;
        // Half-planes left of the far sides, clipping their bounding box.
        Vec2d lo = wedges[0].p1, hi = lo;
        for (const Wedge& w : wedges) {
            lo = {std::min(lo.x, w.p1.x), std::min(lo.y, w.p1.y)};
            hi = {std::max(hi.x, w.p1.x), std::max(hi.y, w.p1.y)};
        }
        std::vector<Vec2d> polygon{lo, {hi.x, lo.y}, hi, {lo.x, hi.y}}, clipped;
        for (const Wedge& w : wedges) {
            clipped.clear();
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                const Vec2d a = polygon[k], b = polygon[(k + 1) % polygon.size()];
                const double sa = cross(w.p2 - w.p1, a - w.p1), sb = cross(w.p2 - w.p1, b - w.p1);
                if (sa >= 0) clipped.push_back(a);
                if ((sa > 0 && sb < 0) || (sa < 0 && sb > 0)) clipped.push_back(a + (b - a) * (sa / (sa - sb)));
            }
            polygon.swap(clipped);
            if (polygon.size() < 3) return std::nullopt;
        }
        Vec2d centre;
        for (const Vec2d& p : polygon) centre = centre + p * (1.0 / static_cast<double>(polygon.size()));
        if (!(energy(centre) < kInfinity)) return std::nullopt;
        for (double share : {0.75, 0.5, 0.25}) {
            const Vec2d x = centre + (wish - centre) * share;
            if (energy(x) < kInfinity) return x;
        }
        return centre;
    }

 private:
    [[nodiscard]] static double raised(double q, double p) {
        return p == 1 ? q : p == 0 ? 1.0 : p == 2 ? q * q : math::pow(q, p);
    }
    [[nodiscard]] static double numerator(const Wedge& w, Vec2d x) {
        const Vec2d d0 = w.p2 - w.p1;
        return w.l0 * dot(x - w.p2, x - w.p1) - w.l1 * dot(w.p1 - x, d0) - w.l2 * dot(d0, x - w.p2);
    }

    double power_;
};

/// Area of a face and squared lengths of its sides, opposite each corner.
std::array<double, 4> shape(std::span<const Vec3d> positions, const Face& f) {
    const Vec3d e0 = positions[f[2]] - positions[f[1]], e1 = positions[f[0]] - positions[f[2]],
                e2 = positions[f[1]] - positions[f[0]];
    return {0.5 * length(cross(e2, e0)), dot(e0, e0), dot(e1, e1), dot(e2, e2)};
}

/// Mean of the ring in the map by mean-value weights on the surface [Floater 2003].
Vec2d mean_value(std::span<const Vec3d> positions, std::uint32_t v, std::span<const std::uint32_t> ring,
                 const std::vector<Vec2d>& uv) {
    const std::size_t n = ring.size();
    std::vector<double> half_tangent(n);
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3d a = positions[ring[k]] - positions[v], b = positions[ring[(k + 1) % n]] - positions[v];
        // tan(angle / 2) = |a x b| / (|a||b| + a.b)
        const double below = length(a) * length(b) + dot(a, b);
        half_tangent[k] = below > 0 ? std::min(100.0, length(cross(a, b)) / below) : 100.0;
    }
    Vec2d sum;
    double total = 0;
    for (std::size_t k = 0; k < n; ++k) {
        const double r = std::max(length(positions[ring[k]] - positions[v]), 1e-300);
        const double w = (half_tangent[(k + n - 1) % n] + half_tangent[k]) / r;
        sum = sum + uv[ring[k]] * w;
        total += w;
    }
    return total > 0 && std::isfinite(total) ? sum * (1 / total) : uv[ring[0]];
}

struct Level {
    TriMesh mesh;
    std::vector<std::uint32_t> original;  ///< vertices on the next finer level; none on the finest
    Simplified coarser;                   ///< how the next coarser level was made of this one
};

}  // namespace

struct MultilevelMemory::Settled {
    std::vector<Level> ladder;             ///< finest first
    std::size_t level = 0;                 ///< that `finish` moves
    std::optional<std::vector<Vec2d>> uv;  ///< its map; none if there is no flip-free one
    std::vector<Vec2d> border_uv;          ///< of the disk

    [[nodiscard]] bool is_of(const DiskView& disk) const {
        return !ladder.empty() && std::ranges::equal(ladder.front().mesh.positions, disk.positions) &&
               std::ranges::equal(ladder.front().mesh.faces, disk.faces) &&
               std::ranges::equal(border_uv, disk.border_uv);
    }
};

namespace {

class Multilevel {
 public:
    Multilevel(const DiskView& disk, const MultilevelOptions& options, const model::Progress& progress,
               MultilevelMemory::Settled& settled)
        : disk_(disk),
          options_(options),
          progress_(progress),
          ladder_(settled.ladder),
          settled_(settled),
          on_border_(disk.positions.size(), 0) {
        for (std::uint32_t v : disk.border) on_border_[v] = 1;
    }

    std::optional<std::vector<Vec2d>> run() {
        if (ladder_.empty()) settle();
        if (!settled_.uv) return std::nullopt;
        std::vector<Vec2d> uv = *settled_.uv;
        if (options_.finish) finish(settled_.level, uv);
        for (std::size_t l = settled_.level; l-- > 0;)
            if (!refine(l, uv, options_.finish ? options_.sweeps_after : options_.sweeps)) return std::nullopt;
        if (count_not_positive(disk_.faces, uv) > 0) return std::nullopt;
        return uv;
    }

 private:
    /// Maps the levels up to the one that `finish` moves.
    void settle() {
        build_ladder();
        settled_.border_uv.assign(disk_.border_uv.begin(), disk_.border_uv.end());
        settled_.level = finish_level();
        Level& coarsest = ladder_.back();
        std::vector<Vec2d> uv;
        if (!map_coarsest(coarsest, uv)) return;
        relax(coarsest, uv, ladder_.size() - 1, options_.coarsest_sweeps);
        for (std::size_t l = ladder_.size() - 1; l-- > settled_.level;)
            if (!refine(l, uv, options_.sweeps)) return;
        settled_.uv = std::move(uv);
    }

    /// From level l + 1 to level l.
    bool refine(std::size_t l, std::vector<Vec2d>& uv, int sweeps) {
        const Level &fine = ladder_[l], &coarse = ladder_[l + 1];
        std::vector<Vec2d> finer(fine.mesh.positions.size());
        for (std::size_t v = 0; v < uv.size(); ++v) finer[coarse.original[v]] = uv[v];
        if (!put_back(fine, finer)) return false;
        uv = std::move(finer);
        relax(fine, uv, l, sweeps);
        return true;
    }

    void build_ladder() {
        Level first;
        first.mesh.positions.assign(disk_.positions.begin(), disk_.positions.end());
        first.mesh.faces.assign(disk_.faces.begin(), disk_.faces.end());
        ladder_.push_back(std::move(first));
        std::vector<char> locked = on_border_;
        const std::size_t least = options_.coarsest_faces + 2 * disk_.border.size();
        while (ladder_.back().mesh.faces.size() > least + least / 2) {
            Level& fine = ladder_.back();
            const std::size_t wanted = std::max(least, fine.mesh.faces.size() / 4);
            SimplifyOptions simplify_options;
            simplify_options.locked = locked;
            simplify_options.allow_chords = false;  // one along a side of the square would have no area
            simplify_options.regularity = 1e-3;     // the map wants round rings more than the last detail
            fine.coarser = simplify(fine.mesh, wanted, simplify_options, progress_);
            if (fine.coarser.faces.size() * 4 > fine.mesh.faces.size() * 3) break;
            CompactMesh small = compact(fine.mesh.positions, fine.coarser.faces);
            Level next;
            next.mesh = std::move(small.mesh);
            next.original = std::move(small.original);
            std::vector<char> next_locked(next.original.size());
            for (std::size_t v = 0; v < next_locked.size(); ++v) next_locked[v] = locked[next.original[v]];
            locked = std::move(next_locked);
            ladder_.push_back(std::move(next));
        }
    }

    bool map_coarsest(const Level& level, std::vector<Vec2d>& uv) {
        const std::vector<std::uint32_t> border = border_on(ladder_.size() - 1);
        const DiskView view{level.mesh.positions, level.mesh.faces, border, disk_.border_uv};
        if (options_.map_coarsest) {
            std::optional<std::vector<Vec2d>> given = options_.map_coarsest(view);
            if (!given || count_not_positive(view.faces, *given) > 0) return false;
            uv = std::move(*given);
            return true;
        }
        uv = damped_stretch_map(view, 12, progress_);
        if (count_not_positive(view.faces, uv) > 0) uv = reweighted_stretch_map(view, {}, progress_);
        if (count_not_positive(view.faces, uv) > 0) return false;
        SlimOptions newton;
        newton.energy = FlipFreeEnergy::kStretch;
        newton.border_fixed = true;
        newton.iterations = options_.newton_steps;
        newton.tolerance = 1e-4;
        uv = descend_flip_free(view, std::move(uv), newton, progress_);
        return true;
    }

    /// Vertices of the border by their number on level l.
    [[nodiscard]] std::vector<std::uint32_t> border_on(std::size_t l) const {
        std::vector<std::uint32_t> here(disk_.positions.size(), kNone), border;
        for (std::uint32_t v = 0; v < ladder_[l].mesh.positions.size(); ++v) {
            std::uint32_t at = v;
            for (std::size_t k = l; k >= 1; --k) at = ladder_[k].original[at];
            here[at] = v;
        }
        for (std::uint32_t v : disk_.border) border.push_back(here[v]);
        return border;
    }

    [[nodiscard]] std::size_t finish_level() const {
        std::size_t l = 0;
        while (l + 1 < ladder_.size() && ladder_[l].mesh.faces.size() > options_.finish_faces) ++l;
        return l;
    }

    void finish(std::size_t l, std::vector<Vec2d>& uv) const {
        const TriMesh& mesh = ladder_[l].mesh;
        const std::vector<std::uint32_t> border = border_on(l);
        const DiskView view{mesh.positions, mesh.faces, border, disk_.border_uv};
        if (count_not_positive(view.faces, uv) == 0) uv = options_.finish(view, std::move(uv));
    }

    /// Takes the collapses below `fine` back, last one first.
    bool put_back(const Level& fine, std::vector<Vec2d>& uv) {
        Ring ring(options_.power);
        const std::span<const Vec3d> positions = fine.mesh.positions;
        for (std::size_t k = fine.coarser.collapses.size(); k-- > 0;) {
            const Collapse& c = fine.coarser.collapses[k];
            const auto link = fine.coarser.link(c);
            ring.wedges.clear();
            for (std::size_t j = 0; j < link.size(); ++j) {
                const std::uint32_t a = link[j], b = link[(j + 1) % link.size()];
                const auto [area, l0, l1, l2] = shape(positions, {c.removed, a, b});
                ring.wedges.push_back({uv[a], uv[b], area, l0, l1, l2});
            }
            const std::optional<Vec2d> x = ring.inside(mean_value(positions, c.removed, link, uv));
            if (!x) return false;
            uv[c.removed] = ring.relax(*x, 2);
        }
        return true;
    }

    void relax(const Level& level, std::vector<Vec2d>& uv, std::size_t number, int sweeps) {
        const std::span<const Face> faces = level.mesh.faces;
        const std::size_t n = uv.size();
        const VertexCorners corners(faces, n);
        std::vector<char> fixed(n, 0);
        for (std::uint32_t v = 0; v < n; ++v) {
            std::uint32_t at = v;
            for (std::size_t l = number; l >= 1; --l) at = ladder_[l].original[at];
            fixed[v] = on_border_[at];
        }
        std::vector<std::array<double, 4>> shapes(faces.size());
        for (std::size_t f = 0; f < faces.size(); ++f) shapes[f] = shape(level.mesh.positions, faces[f]);
        Ring ring(options_.power);
        // A vertex that hardly moved rests until one next to it has moved.
        const bool few = faces.size() > kFineLevel;
        const double still = few ? kStillOfFew : 2e-4;  // of its farthest neighbour's distance
        if (few) sweeps = kSweepsOfFew;
        std::vector<char> awake(n, 1);
        for (int sweep = 0; sweep < sweeps; ++sweep) {
            if (few && sweep % kLooksAgain == 0) awake = far_stretched(faces, shapes, uv);
            progress_.update("parameterize", 0.5 + 0.5 * sweep / sweeps);
            for (std::uint32_t i = 0; i < n; ++i) {
                const std::uint32_t v = sweep % 2 == 0 ? i : static_cast<std::uint32_t>(n - 1 - i);
                if (fixed[v] || !awake[v]) continue;
                ring.wedges.clear();
                for (std::uint32_t k = corners.first[v]; k < corners.first[v + 1]; ++k) {
                    const Face& f = faces[corners.of[k] / 3];
                    const std::array<double, 4>& l = shapes[corners.of[k] / 3];
                    const std::uint32_t i0 = corners.of[k] % 3, i1 = (i0 + 1) % 3, i2 = (i0 + 2) % 3;
                    ring.wedges.push_back({uv[f[i1]], uv[f[i2]], l[0], l[1 + i0], l[1 + i1], l[1 + i2]});
                }
                const Vec2d to = ring.relax(uv[v], 1), by = to - uv[v];
                double reach = 0;  // squared
                for (const Wedge& w : ring.wedges) reach = std::max(reach, dot(w.p1 - to, w.p1 - to));
                uv[v] = to;
                awake[v] = 0;
                if (!(dot(by, by) > still * still * reach)) continue;
                awake[v] = 1;
                for (std::uint32_t k = corners.first[v]; k < corners.first[v + 1]; ++k)
                    for (const std::uint32_t u : faces[corners.of[k] / 3]) awake[u] = 1;
            }
        }
    }

    /// Per vertex, 1 at the corners of faces that stretch much more than most.
    static std::vector<char> far_stretched(std::span<const Face> faces, std::span<const std::array<double, 4>> shapes,
                                           std::span<const Vec2d> uv) {
        std::vector<double> stretch(faces.size());  // squared
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const auto& [area, l0, l1, l2] = shapes[f];
            stretch[f] = Ring::stretch_of({uv[faces[f][1]], uv[faces[f][2]], area, l0, l1, l2}, uv[faces[f][0]]);
        }
        std::vector<double> sorted = stretch;
        const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
        std::nth_element(sorted.begin(), middle, sorted.end());
        std::vector<char> out(uv.size(), 0);
        for (std::size_t f = 0; f < faces.size(); ++f)
            if (!(stretch[f] <= kFarStretched * kFarStretched * *middle))
                for (const std::uint32_t v : faces[f]) out[v] = 1;
        return out;
    }

    const DiskView& disk_;
    const MultilevelOptions& options_;
    const model::Progress& progress_;
    std::vector<Level>& ladder_;
    MultilevelMemory::Settled& settled_;
    std::vector<char> on_border_;
};

}  // namespace

MultilevelMemory::MultilevelMemory() = default;
MultilevelMemory::~MultilevelMemory() = default;

std::optional<std::vector<Vec2d>> multilevel_stretch_map(const DiskView& disk, const MultilevelOptions& options,
                                                         const model::Progress& progress, MultilevelMemory* memory) {
    std::unique_ptr<MultilevelMemory::Settled> own;
    std::unique_ptr<MultilevelMemory::Settled>& settled = memory ? memory->settled : own;
    if (!settled || !settled->is_of(disk)) settled = std::make_unique<MultilevelMemory::Settled>();
    return Multilevel(disk, options, progress, *settled).run();
}

}  // namespace dgm::bake
