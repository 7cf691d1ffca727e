// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flip_free_start.cpp
// A map without flips to start a descent from: Tutte's embedding, with weights that survive doubles.
//
// [Tutte 1963] How to Draw a Graph. Proc. London Math. Soc. 13.
//
// Uniform weights shrink a finger, or a ribbon whose two sides lie on one side of the square, ring after ring by a
// constant factor, so that some tens of rings underflow the spacing of doubles. Two cures, a power law each:
//
// A finger that the border goes around. On a tube of k vertices around let s count the rings to the tip. With radial
// weight kappa s^2 and weight 1 along the rings, the radius r solves kappa (s^2 r')' = theta^2 r, theta = 2 pi / k,
// hence r = s^p with p (p + 1) = theta^2 / kappa.
//
// A ribbon along the border. Read weights as conductances, heights over the border as voltages, the border as ground.
// A vertex with s steps of a tree from the middle of the surface behind it, whose branch leaks G to the ground, gets
// the conductance G s to its parent: the voltage falls by about 1/s of itself on that edge, hence grows like s.
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/parameterize/slim.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;

constexpr double kKappa = 0.25;         // p between 0 and 3.5 for 3 or more vertices around
constexpr double kShortestShare = 0.1;  // of a border edge's equal share of the circle
constexpr const char* kStage = "flip-free start";

std::vector<Vec2d> circle(const DiskView& disk) {
    const std::size_t n = disk.border.size();
    std::vector<double> length_of(n);
    double total = 0;
    for (std::size_t k = 0; k < n; ++k) {
        length_of[k] = length(disk.positions[disk.border[(k + 1) % n]] - disk.positions[disk.border[k]]);
        total += length_of[k];
    }
    const double shortest = kShortestShare * total / static_cast<double>(n);
    total = 0;
    for (double& l : length_of) total += l = std::max(l, shortest);
    std::vector<Vec2d> out(n);
    double walked = 0;
    for (std::size_t k = 0; k < n; ++k) {
        const double angle = 2 * std::numbers::pi * walked / total;
        out[k] = {math::cos(angle), math::sin(angle)};
        walked += length_of[k];
    }
    return out;
}

/// Neighbours of each vertex, by face: vertex v's are neighbour[first[v]] .. neighbour[first[v + 1] - 1], most of them
/// twice.
struct Neighbours {
    std::vector<std::uint32_t> first, vertex;

    explicit Neighbours(const DiskView& disk) : first(disk.positions.size() + 1, 0), vertex(6 * disk.faces.size()) {
        for (const Face& f : disk.faces)
            for (const std::uint32_t v : f) first[v + 1] += 2;
        for (std::size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
        std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
        for (const Face& f : disk.faces)
            for (std::size_t k = 0; k < 3; ++k) {
                vertex[fill[f[k]]++] = f[(k + 1) % 3];
                vertex[fill[f[k]]++] = f[(k + 2) % 3];
            }
    }
    [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t v) const {
        return std::span(vertex).subspan(first[v], first[v + 1] - first[v]);
    }
};

constexpr std::uint32_t kNobody = 0xffffffff;

/// A tree over the interior from its innermost vertex outwards (one for each part that border-to-border edges cut off).
struct Tree {
    std::vector<std::uint32_t> parent;  ///< kNobody for roots and the border
    std::vector<double> pull;           ///< weight of the edge to the parent
};

/// Steps from the border, and from there the steps to the deepest vertex that lies behind.
struct Depths {
    std::vector<std::uint32_t> depth, behind, order;  ///< order: the border, then by depth
};

Depths measure_depths(const DiskView& disk, const Neighbours& neighbours) {
    const std::size_t n = disk.positions.size();
    Depths out{std::vector<std::uint32_t>(n, kNobody), std::vector<std::uint32_t>(n, 0),
               std::vector<std::uint32_t>(disk.border.begin(), disk.border.end())};
    for (const std::uint32_t v : out.order) out.depth[v] = 0;
    for (std::size_t k = 0; k < out.order.size(); ++k)
        for (const std::uint32_t w : neighbours.of(out.order[k]))
            if (out.depth[w] == kNobody) {
                out.depth[w] = out.depth[out.order[k]] + 1;
                out.order.push_back(w);
            }
    for (std::size_t k = out.order.size(); k-- > 0;)
        for (const std::uint32_t w : neighbours.of(out.order[k]))
            if (out.depth[w] + 1 == out.depth[out.order[k]])
                out.behind[w] = std::max(out.behind[w], out.behind[out.order[k]] + 1);
    return out;
}

Tree grow_tree(const DiskView& disk, const Neighbours& neighbours, const Depths& depths) {
    const std::size_t n = disk.positions.size();
    const std::vector<std::uint32_t>& order = depths.order;
    Tree out{std::vector<std::uint32_t>(n, kNobody), std::vector<double>(n, 1.0)};
    std::vector<std::uint8_t> seen(n, 0);
    std::vector<double> behind(n, 1.0), leak(n, 0.0);
    std::vector<std::uint32_t> tree;
    for (std::size_t r = order.size(); r-- > disk.border.size();) {  // innermost first
        if (seen[order[r]] != 0) continue;
        tree.assign(1, order[r]);
        seen[order[r]] = 1;
        for (std::size_t k = 0; k < tree.size(); ++k)
            for (const std::uint32_t w : neighbours.of(tree[k]))
                if (depths.depth[w] > 0 && seen[w] == 0) {
                    seen[w] = 1;
                    out.parent[w] = tree[k];
                    tree.push_back(w);
                }
        for (std::size_t k = tree.size(); k-- > 1;) {
            const std::uint32_t v = tree[k], p = out.parent[v];
            leak[v] += 0.5 * static_cast<double>(neighbours.of(v).size());
            out.pull[v] = leak[v] * behind[v];
            behind[p] = std::max(behind[p], behind[v] + 1);
            leak[p] += leak[v];
        }
    }
    return out;
}

/// Interior vertices at the weighted means of their neighbours; symmetric positive weights by edge.
template <typename Weight>
std::vector<Vec2d> embed(const DiskView& disk, std::span<const Vec2d> border_points, const Weight& weight) {
    const std::size_t n = disk.positions.size();
    std::vector<Vec2d> x(n);
    std::vector<std::uint8_t> fixed(n, 0);
    for (std::size_t k = 0; k < disk.border.size(); ++k) {
        fixed[disk.border[k]] = 1;
        x[disk.border[k]] = border_points[k];
    }
    std::vector<int> unknown(n, -1);
    int count = 0;
    for (std::size_t v = 0; v < n; ++v)
        if (fixed[v] == 0) unknown[v] = count++;
    if (count == 0) return x;

    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(disk.faces.size() * 6);
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(count, 2);
    for (const Face& f : disk.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            // Each face adds half the edge's weight; interior edges have two faces, and edges of the border none to
            // add.
            const std::uint32_t v = f[k], w = f[(k + 1) % 3];
            const double c = 0.5 * weight(v, w);
            for (const auto& [i, j] : {std::pair{v, w}, std::pair{w, v}}) {
                if (unknown[i] < 0) continue;
                entries.emplace_back(unknown[i], unknown[i], c);
                if (unknown[j] < 0) {
                    right(unknown[i], 0) += c * x[j].x;
                    right(unknown[i], 1) += c * x[j].y;
                } else if (unknown[i] > unknown[j]) {
                    entries.emplace_back(unknown[i], unknown[j], -c);
                }
            }
        }
    SparseMatrix matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> solver(matrix);
    if (solver.info() != Eigen::Success) return {};
    Eigen::MatrixX2d solution = solver.solve(right);
    // One step of refinement: crowded regions need every bit.
    solution += solver.solve(Eigen::MatrixX2d(right - matrix.selfadjointView<Eigen::Lower>() * solution));
    for (std::size_t v = 0; v < n; ++v)
        if (unknown[v] >= 0) x[v] = {solution(unknown[v], 0), solution(unknown[v], 1)};
    return x;
}
}  // namespace

std::optional<std::vector<Vec2d>> flip_free_start(const DiskView& disk, const model::Progress& progress,
                                                  FlipFreeStart kind) {
    progress.update(kStage, 0);
    const std::vector<Vec2d> border =
        disk.border_uv.empty() ? circle(disk) : std::vector<Vec2d>(disk.border_uv.begin(), disk.border_uv.end());
    const auto is_valid = [&](const std::vector<Vec2d>& x) {
        return !x.empty() && count_not_positive(disk.faces, x) == 0;
    };

    std::vector<Vec2d> x;
    if (kind == FlipFreeStart::kFirstValid) {
        x = embed(disk, border, [](std::uint32_t, std::uint32_t) { return 1.0; });
        if (is_valid(x)) return x;
        progress.update(kStage, 0.5);
    }
    const Neighbours neighbours(disk);
    const Depths depths = measure_depths(disk, neighbours);
    const Tree tree = grow_tree(disk, neighbours, depths);
    const auto along_tree = [&](std::uint32_t v, std::uint32_t w) {
        return tree.parent[v] == w ? tree.pull[v] : tree.parent[w] == v ? tree.pull[w] : 1.0;
    };
    const auto inwards = [&](std::uint32_t v, std::uint32_t w) {
        if (depths.depth[v] == depths.depth[w]) return 1.0;
        const double s = 0.5 + std::min(depths.behind[v], depths.behind[w]);
        return 1 + kKappa * s * s;
    };
    // The caller sees which of the two crowds less; where one underflows, both cures together may still work.
    std::optional<std::vector<Vec2d>> best;
    double least = std::numeric_limits<double>::infinity();
    const SlimOptions stretch{.energy = FlipFreeEnergy::kStretch, .border_fixed = true};
    const auto consider = [&](std::vector<Vec2d> candidate, double share) {
        progress.update(kStage, share);
        if (!is_valid(candidate)) return;
        const double energy = flip_free_energy(disk, candidate, stretch);
        if (best && !(energy < least)) return;
        least = energy;
        best = std::move(candidate);
    };
    consider(embed(disk, border, along_tree), 0.7);
    consider(embed(disk, border, inwards), 0.9);
    if (!best)
        consider(
            embed(disk, border, [&](std::uint32_t v, std::uint32_t w) { return along_tree(v, w) * inwards(v, w); }), 1);
    return best;
}

}  // namespace dgm::bake
