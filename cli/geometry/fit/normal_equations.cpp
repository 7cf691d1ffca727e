// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/normal_equations.cpp
#include "geometry/fit/normal_equations.h"

#include <cmath>

namespace dgm::bake {
namespace {

using Block = std::array<double, 6>;

/// The edges at each class: entries first[c] .. first[c + 1] of `list`.
struct EdgesByClass {
    std::vector<std::uint32_t> first;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> list;  ///< edge, class across
};

EdgesByClass edges_by_class(std::span<const std::pair<std::uint32_t, std::uint32_t>> edges, std::uint32_t count) {
    EdgesByClass out{std::vector<std::uint32_t>(count + 1, 0), {}};
    for (const auto& [a, b] : edges) {
        ++out.first[a + 1];
        ++out.first[b + 1];
    }
    for (std::uint32_t c = 0; c < count; ++c) out.first[c + 1] += out.first[c];
    out.list.resize(out.first.back());
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        const auto [a, b] = edges[e];
        out.list[next[a]++] = {e, b};
        out.list[next[b]++] = {e, a};
    }
    return out;
}

Vec3d multiply(const Block& a, const Vec3d& v) {
    return {a[0] * v.x + a[1] * v.y + a[2] * v.z, a[1] * v.x + a[3] * v.y + a[4] * v.z,
            a[2] * v.x + a[4] * v.y + a[5] * v.z};
}

Block inverse(const Block& a) {
    const double c0 = a[3] * a[5] - a[4] * a[4], c1 = a[2] * a[4] - a[1] * a[5], c2 = a[1] * a[4] - a[2] * a[3];
    const double d = a[0] * c0 + a[1] * c1 + a[2] * c2;
    if (!(std::abs(d) > 0)) return {1, 0, 0, 1, 0, 1};
    const double s = 1 / d;
    return {c0 * s,
            c1 * s,
            c2 * s,
            (a[0] * a[5] - a[2] * a[2]) * s,
            (a[1] * a[2] - a[0] * a[4]) * s,
            (a[0] * a[3] - a[1] * a[1]) * s};
}

/// Adds to a class's block a share of its own trace, and a floor.
void damp(Block& d, double floor, double damping) {
    const double lambda = floor + damping * (d[0] + d[3] + d[5]);
    d[0] += lambda;
    d[3] += lambda;
    d[5] += lambda;
}

/// The inverse of a block along a rail, as a multiple of the identity.
Block inverse_along(const Block& d, const Vec3d& rail) {
    const double along = dot(rail, multiply(d, rail)), s = along > 0 ? 1 / along : 1;
    return {s, 0, 0, s, 0, s};
}

struct Unknowns {
    std::vector<std::uint32_t> classes, edges;
};

/// The classes that may move and the edges between them. Where few are free (around repaired faces), the rest costs
/// next to nothing.
Unknowns unknowns_of(const WeldedGrid& grid, std::span<const Freedom> freedom) {
    Unknowns out;
    for (std::uint32_t k = 0; k < freedom.size(); ++k)
        if (freedom[k] != Freedom::kHeld) out.classes.push_back(k);
    for (std::uint32_t e = 0; e < grid.edges.size(); ++e)
        if (freedom[grid.edges[e].first] != Freedom::kHeld && freedom[grid.edges[e].second] != Freedom::kHeld)
            out.edges.push_back(e);
    return out;
}

}  // namespace

NormalEquations::NormalEquations(const WeldedGrid& grid)
    : grid_(grid),
      along_normal_(grid.surface.faces.size()),
      diagonal_(grid.sample_of.size(), Block{}),
      off_(grid.edges.size(), Block{}),
      right_(grid.sample_of.size(), Vec3d{}) {}

void NormalEquations::add(std::uint32_t face, const std::array<double, 3>& b, const Vec3d& gap, const Vec3d& n,
                          double weight) {
    const Vec3d wn = n * weight;
    const Block m{wn.x * n.x, wn.x * n.y, wn.x * n.z, wn.y * n.y, wn.y * n.z, wn.z * n.z};
    const FaceSums row{{b[0] * b[0], b[1] * b[1], b[2] * b[2]}, {b[0] * b[1], b[1] * b[2], b[2] * b[0]}, b};
    take(face, row, m, wn * dot(n, gap));
}

void NormalEquations::take(std::size_t face, const FaceSums& sums, const Block& m, const Vec3d& pull) {
    const Face& f = grid_.surface.faces[face];
    const auto& edges = grid_.edge_of[face];
    for (std::size_t k = 0; k < 3; ++k) {
        right_[f[k]] += pull * sums.pull[k];
        Block& d = diagonal_[f[k]];
        Block& o = off_[edges[k]];
        for (std::size_t e = 0; e < 6; ++e) {
            d[e] += sums.own[k] * m[e];
            o[e] += sums.pair[k] * m[e];
        }
    }
}

void NormalEquations::close() {
    for (std::size_t f = 0; f < along_normal_.size(); ++f) {
        const FaceSums& sums = along_normal_[f];
        if (sums.own == std::array<double, 3>{}) continue;
        const Vec3d& n = grid_.surface.normals[f];
        take(f, sums, {n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z}, n);
    }
}

std::vector<Vec3d> NormalEquations::solve(std::span<const Freedom> freedom, std::span<const Vec3d> rails,
                                          double damping, int iterations) const {
    const std::size_t count = diagonal_.size();
    std::vector<Vec3d> residual(count), step(count, Vec3d{}), direction(count), z(count), product(count);
    double trace = 0;
    for (const Block& d : diagonal_) trace += d[0] + d[3] + d[5];
    // By each class's own weight [Marquardt 1963]: one damping for all would freeze the samples of crowded regions,
    // whose rows weigh little, while their neighbours move.
    const double floor = 1e-6 * damping * trace / static_cast<double>(count);
    const auto confined = [&](std::size_t k, const Vec3d& v) {
        return freedom[k] == Freedom::kFree ? v : rails[k] * dot(rails[k], v);
    };
    const Unknowns unknowns = unknowns_of(grid_, freedom);
    const std::vector<std::uint32_t>&live = unknowns.classes, &live_edges = unknowns.edges;
    std::vector<Block> damped = diagonal_, preconditioner(count);
    for (const std::uint32_t k : live) {
        damp(damped[k], floor, damping);
        preconditioner[k] = inverse(damped[k]);
        if (freedom[k] == Freedom::kSlides) preconditioner[k] = inverse_along(damped[k], rails[k]);
    }
    // A pass does all that needs one class alone: the vectors are longer than the nearer caches.
    double rz = 0;
    for (const std::uint32_t k : live) {
        residual[k] = confined(k, right_[k]);
        z[k] = multiply(preconditioner[k], residual[k]);
        rz += dot(residual[k], z[k]);
    }
    const double enough = 1e-4 * rz;  // against 1e-6: nothing lost in the mean of a whole fit
    double beta = 0;
    for (int it = 0; it < iterations && rz > enough; ++it) {
        for (const std::uint32_t k : live) {
            direction[k] = it == 0 ? z[k] : z[k] + direction[k] * beta;
            product[k] = multiply(damped[k], direction[k]);
        }
        for (const std::uint32_t e : live_edges) {
            const auto [a, b] = grid_.edges[e];
            product[a] += multiply(off_[e], direction[b]);
            product[b] += multiply(off_[e], direction[a]);
        }
        double curvature = 0;
        for (const std::uint32_t k : live) {
            product[k] = confined(k, product[k]);
            curvature += dot(direction[k], product[k]);
        }
        if (!(curvature > 0)) break;
        const double t = rz / curvature;
        double next = 0;
        for (const std::uint32_t k : live) {
            step[k] += direction[k] * t;
            residual[k] -= product[k] * t;
            z[k] = multiply(preconditioner[k], residual[k]);
            next += dot(residual[k], z[k]);
        }
        beta = next / rz;
        rz = next;
    }
    return step;
}

void NormalEquations::snap(std::vector<Vec3d>& positions, const Lattice& lattice, std::span<const Freedom> freedom,
                           std::span<const char> on_lattice, std::span<const char> tight,
                           const std::function<int(std::uint32_t)>& spoilt) const {
    constexpr int kPasses = 6;
    const auto count = static_cast<std::uint32_t>(diagonal_.size());
    const EdgesByClass edges = edges_by_class(grid_.edges, count);
    std::vector<Vec3d> residual = right_;
    const auto go = [&](std::uint32_t c, const Vec3d& to) {
        const Vec3d by = to - positions[c];
        residual[c] -= multiply(diagonal_[c], by);
        for (std::uint32_t k = edges.first[c]; k < edges.first[c + 1]; ++k)
            residual[edges.list[k].second] -= multiply(off_[edges.list[k].first], by);
        positions[c] = to;
    };
    std::vector<Vec3d> nearest(count);
    for (std::uint32_t c = 0; c < count; ++c)
        if (on_lattice[c]) go(c, nearest[c] = lattice.nearest(positions[c]));
    for (int pass = 0; pass < kPasses; ++pass) {
        bool moved = false;
        for (std::uint32_t c = 0; c < count; ++c) {
            if (!on_lattice[c] || freedom[c] != Freedom::kFree) continue;
            const Vec3d old = positions[c];
            Vec3d best = old;
            int least_spoilt = tight[c] ? spoilt(c) : 0;
            double least = 0;
            for (int k = 0; k < 27; ++k) {
                const Vec3d at =
                    nearest[c] + Vec3d{double(k % 3 - 1), double(k / 3 % 3 - 1), double(k / 9 - 1)} * lattice.step;
                const Vec3d by = at - old;
                const double change = dot(by, multiply(diagonal_[c], by)) - 2 * dot(by, residual[c]);
                if (!lattice.holds(at) || (!tight[c] && !(change < least))) continue;
                int now = 0;
                if (tight[c]) {
                    positions[c] = at;
                    now = spoilt(c);
                    positions[c] = old;
                    if (now > least_spoilt || (now == least_spoilt && !(change < least))) continue;
                }
                best = at;
                least = change;
                least_spoilt = now;
            }
            if (best == old) continue;
            go(c, lattice.nearest(best));
            moved = true;
        }
        if (!moved) break;
    }
}

}  // namespace dgm::bake
