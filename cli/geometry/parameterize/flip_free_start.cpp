// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flip_free_start.cpp
// A map without flips to start a descent from: Tutte's embedding, with weights that survive doubles.
//
// [Tutte 1963] How to Draw a Graph. Proc. London Math. Soc. 13.
//
// Why depth weights: on a tube of k vertices around, uniform weights shrink ring after ring by a constant factor, so
// that some tens of rings underflow the spacing of doubles. Let s count the rings to the tip. With radial weight
// kappa s^2 and weight 1 along the rings, the radius r solves kappa (s^2 r')' = theta^2 r, theta = 2 pi / k, hence
// r = s^p with p (p + 1) = theta^2 / kappa: a power law instead of an exponential.
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/parameterize/slim.h"

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
        out[k] = {std::cos(angle), std::sin(angle)};
        walked += length_of[k];
    }
    return out;
}

/// Steps from the border, and from there the steps to the deepest vertex that lies behind.
struct Depths {
    std::vector<std::uint32_t> depth, behind;
};

Depths measure_depths(const DiskView& disk) {
    const std::size_t n = disk.positions.size();
    std::vector<std::uint32_t> first(n + 1, 0), neighbour(6 * disk.faces.size());
    for (const Face& f : disk.faces)
        for (const std::uint32_t v : f) first[v + 1] += 2;
    for (std::size_t v = 0; v < n; ++v) first[v + 1] += first[v];
    std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
    for (const Face& f : disk.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            neighbour[fill[f[k]]++] = f[(k + 1) % 3];
            neighbour[fill[f[k]]++] = f[(k + 2) % 3];
        }
    constexpr std::uint32_t kUnseen = 0xffffffff;
    Depths out{std::vector<std::uint32_t>(n, kUnseen), std::vector<std::uint32_t>(n, 0)};
    std::vector<std::uint32_t> order(disk.border.begin(), disk.border.end());
    order.reserve(n);
    for (const std::uint32_t v : order) out.depth[v] = 0;
    for (std::size_t k = 0; k < order.size(); ++k)
        for (std::uint32_t e = first[order[k]]; e < first[order[k] + 1]; ++e)
            if (const std::uint32_t w = neighbour[e]; out.depth[w] == kUnseen) {
                out.depth[w] = out.depth[order[k]] + 1;
                order.push_back(w);
            }
    for (std::size_t k = order.size(); k-- > 0;) {
        const std::uint32_t v = order[k];
        for (std::uint32_t e = first[v]; e < first[v + 1]; ++e)
            if (const std::uint32_t w = neighbour[e]; out.depth[w] + 1 == out.depth[v])
                out.behind[w] = std::max(out.behind[w], out.behind[v] + 1);
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

std::optional<std::vector<Vec2d>> flip_free_start(const DiskView& disk, const model::Progress& progress) {
    progress.update(kStage, 0);
    const std::vector<Vec2d> border =
        disk.border_uv.empty() ? circle(disk) : std::vector<Vec2d>(disk.border_uv.begin(), disk.border_uv.end());
    const auto is_valid = [&](const std::vector<Vec2d>& x) {
        return !x.empty() && count_not_positive(disk.faces, x) == 0;
    };

    std::vector<Vec2d> x = embed(disk, border, [](std::uint32_t, std::uint32_t) { return 1.0; });
    if (is_valid(x)) return x;
    progress.update(kStage, 0.5);

    const Depths depths = measure_depths(disk);
    x = embed(disk, border, [&](std::uint32_t v, std::uint32_t w) {
        if (depths.depth[v] == depths.depth[w]) return 1.0;
        const double s = 0.5 + std::min(depths.behind[v], depths.behind[w]);
        return 1 + kKappa * s * s;
    });
    progress.update(kStage, 1);
    if (is_valid(x)) return x;
    return std::nullopt;
}

}  // namespace dgm::bake
