// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/normal_equations.cpp
#include "geometry/fit/normal_equations.h"

#include <cmath>
#include <utility>

#include "geometry/fit/pieces.h"

namespace dgm::bake {
namespace {

using Block = std::array<double, 6>;

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

/// The classes that may move, and for each the blocks that join it with others of them. Where few are free (around
/// repaired faces), the rest costs next to nothing.
struct Unknowns {
    struct Joint {
        std::uint32_t edge, other;  // number of the other unknown
    };
    std::vector<std::uint32_t> classes, first;
    std::vector<Joint> joints;  // of unknown u: first[u] .. first[u + 1]

    Unknowns(const WeldedGrid& grid, std::span<const Freedom> freedom) {
        std::vector<std::uint32_t> number(freedom.size(), kNone);
        for (std::uint32_t c = 0; c < freedom.size(); ++c)
            if (freedom[c] != Freedom::kHeld) {
                number[c] = static_cast<std::uint32_t>(classes.size());
                classes.push_back(c);
            }
        first.assign(classes.size() + 1, 0);
        const auto for_each_live_edge = [&](const auto& body) {
            for (std::uint32_t e = 0; e < grid.edges.size(); ++e) {
                const std::uint32_t a = number[grid.edges[e].first], b = number[grid.edges[e].second];
                if (a != kNone && b != kNone) body(e, a, b);
            }
        };
        for_each_live_edge([&](std::uint32_t, std::uint32_t a, std::uint32_t b) {
            ++first[a + 1];
            ++first[b + 1];
        });
        for (std::size_t u = 0; u < classes.size(); ++u) first[u + 1] += first[u];
        joints.resize(first.back());
        std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
        for_each_live_edge([&](std::uint32_t e, std::uint32_t a, std::uint32_t b) {
            joints[next[a]++] = {e, b};
            joints[next[b]++] = {e, a};
        });
    }
};

/// What the iterations read, but for the structure.
struct System {
    const std::vector<Block>& off;              // per edge
    std::vector<Block> damped, preconditioner;  // per unknown
    std::vector<Vec3d> residual;
};

/// The steps of the unknowns, by conjugate gradients.
/// @param confined  confined(u, v): the part of v along which unknown u may move
template <class Confined>
std::vector<Vec3d> descend(const Unknowns& unknowns, System system, int iterations, const Confined& confined) {
    const std::size_t count = unknowns.classes.size();
    std::vector<Vec3d>& residual = system.residual;
    std::vector<Vec3d> step(count), direction(count), z(count), product(count);
    // A pass does all that needs one class alone: the vectors are longer than the nearer caches.
    double rz = sum_in_pieces(count, [&](std::size_t u) {
        z[u] = multiply(system.preconditioner[u], residual[u]);
        return dot(residual[u], z[u]);
    });
    const double enough = 1e-4 * rz;  // against 1e-6: nothing lost in the mean of a whole fit
    double beta = 0;
    for (int it = 0; it < iterations && rz > enough; ++it) {
        each_in_pieces(count, [&](std::size_t u) { direction[u] = z[u] + direction[u] * beta; });
        const double curvature = sum_in_pieces(count, [&](std::size_t u) {
            Vec3d sum = multiply(system.damped[u], direction[u]);
            for (std::uint32_t k = unknowns.first[u]; k < unknowns.first[u + 1]; ++k)
                sum += multiply(system.off[unknowns.joints[k].edge], direction[unknowns.joints[k].other]);
            product[u] = confined(u, sum);
            return dot(direction[u], product[u]);
        });
        if (!(curvature > 0)) break;
        const double t = rz / curvature;
        const double next = sum_in_pieces(count, [&](std::size_t u) {
            step[u] += direction[u] * t;
            residual[u] -= product[u] * t;
            z[u] = multiply(system.preconditioner[u], residual[u]);
            return dot(residual[u], z[u]);
        });
        beta = next / rz;
        rz = next;
    }
    return step;
}

}  // namespace

NormalEquations::NormalEquations(const WeldedGrid& grid) : grid_(grid) {
    clear();
}

void NormalEquations::clear() {
    along_normal_.assign(grid_.surface.faces.size(), FaceSums{});
    later_.clear();
    diagonal_.assign(grid_.sample_of.size(), Block{});
    off_.assign(grid_.edges.size(), Block{});
    right_.assign(grid_.sample_of.size(), Vec3d{});
}

void NormalEquations::add_at_middle(std::uint32_t face, const Vec3d& gap, const Vec3d& n, double weight) {
    const Vec3d wn = n * (weight / 9), pull = n * (weight / 3 * dot(n, gap));
    const Block m{wn.x * n.x, wn.x * n.y, wn.x * n.z, wn.y * n.y, wn.y * n.z, wn.z * n.z};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t c = grid_.surface.faces[face][k];
        right_[c] += pull;
        Block& d = diagonal_[c];
        Block& o = off_[grid_.edge_of[face][k]];
        for (std::size_t e = 0; e < 6; ++e) {
            d[e] += m[e];
            o[e] += m[e];
        }
    }
}

void NormalEquations::add_at_class(std::uint32_t c, const Vec3d& gap, const Vec3d& n, double weight) {
    const Vec3d wn = n * weight;
    const Block m{wn.x * n.x, wn.x * n.y, wn.x * n.z, wn.y * n.y, wn.y * n.z, wn.z * n.z};
    right_[c] += wn * dot(n, gap);
    for (std::size_t e = 0; e < 6; ++e) diagonal_[c][e] += m[e];
}

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
    for (const Row& r : later_) add(r.face, r.b, r.gap, r.normal, r.weight);
    later_.clear();
    for (std::size_t f = 0; f < along_normal_.size(); ++f) {
        const FaceSums& sums = along_normal_[f];
        if (sums.own == std::array<double, 3>{}) continue;
        const Vec3d& n = grid_.surface.normals[f];
        take(f, sums, {n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z}, n);
    }
}

std::vector<Vec3d> NormalEquations::solve(std::span<const Freedom> freedom, std::span<const Vec3d> rails,
                                          double damping, int iterations, std::span<const Vec3d> onward) const {
    const Unknowns unknowns(grid_, freedom);
    const std::vector<std::uint32_t>& live = unknowns.classes;
    const std::size_t count = live.size();
    double trace = 0;
    for (const Block& d : diagonal_) trace += d[0] + d[3] + d[5];
    // By each class's own weight [Marquardt 1963]: one damping for all would freeze the samples of crowded regions,
    // whose rows weigh little, while their neighbours move.
    const double floor = 1e-6 * damping * trace / static_cast<double>(diagonal_.size());
    const auto confined = [&](std::size_t u, const Vec3d& v) {
        const std::uint32_t c = live[u];
        return freedom[c] == Freedom::kFree ? v : rails[c] * dot(rails[c], v);
    };
    System system{off_, std::vector<Block>(count), std::vector<Block>(count), std::vector<Vec3d>(count)};
    each_in_pieces(count, [&](std::size_t u) {
        const std::uint32_t c = live[u];
        Block& own = system.damped[u] = diagonal_[c];
        damp(own, floor, damping);
        system.preconditioner[u] = freedom[c] == Freedom::kSlides ? inverse_along(own, rails[c]) : inverse(own);
        Vec3d right = right_[c];
        if (!onward.empty()) {
            right -= multiply(diagonal_[c], confined(u, onward[c]));
            for (std::uint32_t k = unknowns.first[u]; k < unknowns.first[u + 1]; ++k) {
                const auto [edge, other] = unknowns.joints[k];
                right -= multiply(off_[edge], confined(other, onward[live[other]]));
            }
        }
        system.residual[u] = confined(u, right);
    });
    const std::vector<Vec3d> step = descend(unknowns, std::move(system), iterations, confined);
    std::vector<Vec3d> out(diagonal_.size(), Vec3d{});
    each_in_pieces(count, [&](std::size_t u) {
        out[live[u]] = step[u];
        if (!onward.empty()) out[live[u]] += confined(u, onward[live[u]]);
    });
    return out;
}

void NormalEquations::snap(std::vector<Vec3d>& positions, const Lattice& lattice, std::span<const Freedom> freedom,
                           std::span<const char> on_lattice, std::span<const char> tight,
                           const std::function<int(std::uint32_t)>& spoilt) const {
    constexpr int kPasses = 6;
    const auto count = static_cast<std::uint32_t>(diagonal_.size());
    const Unknowns all(grid_, std::vector<Freedom>(count, Freedom::kFree));  // their numbers are those of the classes
    std::vector<Vec3d> residual = right_;
    const auto go = [&](std::uint32_t c, const Vec3d& to) {
        const Vec3d by = to - positions[c];
        residual[c] -= multiply(diagonal_[c], by);
        for (std::uint32_t k = all.first[c]; k < all.first[c + 1]; ++k)
            residual[all.joints[k].other] -= multiply(off_[all.joints[k].edge], by);
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
