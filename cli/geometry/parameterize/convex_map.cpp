// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/convex_map.cpp
#include "geometry/parameterize/convex_map.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/mesh/half_edges.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {

struct ConvexMapSolver::Impl {
    using Matrix = Eigen::SparseMatrix<double>;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    std::vector<std::uint32_t> border;
    std::vector<std::uint32_t> unknown;      // per vertex: row, or kNone on the border
    std::vector<std::uint32_t> border_slot;  // per vertex: place in `border`, or kNone inside
    Matrix matrix;
    std::vector<Eigen::Index> diagonal;  // of matrix.valuePtr(), per unknown
    std::vector<Eigen::Index> off;       // per edge between two unknowns, else -1
    Eigen::SimplicialLDLT<Matrix, Eigen::Lower> ldlt;
    bool analysed = false;
};

ConvexMapSolver::~ConvexMapSolver() = default;
ConvexMapSolver::ConvexMapSolver(ConvexMapSolver&&) noexcept = default;

ConvexMapSolver::ConvexMapSolver(std::size_t vertex_count, std::span<const Face> faces,
                                 std::span<const std::uint32_t> border)
    : impl_(std::make_unique<Impl>()) {
    Impl& s = *impl_;
    s.border.assign(border.begin(), border.end());
    s.border_slot.assign(vertex_count, kNone);
    for (std::uint32_t k = 0; k < border.size(); ++k) s.border_slot[border[k]] = k;
    s.unknown.assign(vertex_count, kNone);
    std::uint32_t n = 0;
    for (std::size_t v = 0; v < vertex_count; ++v)
        if (s.border_slot[v] == kNone) s.unknown[v] = n++;
    for (const Face& f : faces)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            s.edges.emplace_back(std::min(a, b), std::max(a, b));
        }
    std::sort(s.edges.begin(), s.edges.end());
    s.edges.erase(std::unique(s.edges.begin(), s.edges.end()), s.edges.end());
    std::vector<Eigen::Triplet<double>> triplets;
    for (std::uint32_t k = 0; k < n; ++k) triplets.emplace_back(k, k, 1.0);
    for (const auto& [a, b] : s.edges)
        if (s.unknown[a] != kNone && s.unknown[b] != kNone)
            triplets.emplace_back(std::max(s.unknown[a], s.unknown[b]), std::min(s.unknown[a], s.unknown[b]), 1.0);
    s.matrix.resize(n, n);
    s.matrix.setFromTriplets(triplets.begin(), triplets.end());
    s.matrix.makeCompressed();
    const auto slot = [&](std::uint32_t row, std::uint32_t col) {
        const int* inner = s.matrix.innerIndexPtr();
        const int* first = inner + s.matrix.outerIndexPtr()[col];
        const int* last = inner + s.matrix.outerIndexPtr()[col + 1];
        return static_cast<Eigen::Index>(std::lower_bound(first, last, static_cast<int>(row)) - inner);
    };
    for (std::uint32_t k = 0; k < n; ++k) s.diagonal.push_back(slot(k, k));
    for (const auto& [a, b] : s.edges) {
        const std::uint32_t i = s.unknown[a], j = s.unknown[b];
        s.off.push_back(i == kNone || j == kNone ? Eigen::Index{-1} : slot(std::max(i, j), std::min(i, j)));
    }
}

std::span<const std::pair<std::uint32_t, std::uint32_t>> ConvexMapSolver::edges() const {
    return impl_->edges;
}

std::vector<Vec2d> ConvexMapSolver::solve(std::span<const double> weights, std::span<const Vec2d> border_uv) {
    Impl& s = *impl_;
    const auto n = s.matrix.rows();
    std::vector<Vec2d> uv(s.unknown.size());
    for (std::size_t k = 0; k < s.border.size(); ++k) uv[s.border[k]] = border_uv[k];
    if (n == 0) return uv;
    double* values = s.matrix.valuePtr();
    std::fill(values, values + s.matrix.nonZeros(), 0.0);
    Eigen::MatrixX2d rhs = Eigen::MatrixX2d::Zero(n, 2);
    for (std::size_t e = 0; e < s.edges.size(); ++e) {
        const auto [a, b] = s.edges[e];
        const double w = weights[e];
        const std::uint32_t i = s.unknown[a], j = s.unknown[b];
        if (i != kNone) values[s.diagonal[i]] += w;
        if (j != kNone) values[s.diagonal[j]] += w;
        if (i != kNone && j != kNone) {
            values[s.off[e]] -= w;
        } else if (i != kNone) {
            rhs(i, 0) += w * uv[b].x;
            rhs(i, 1) += w * uv[b].y;
        } else if (j != kNone) {
            rhs(j, 0) += w * uv[a].x;
            rhs(j, 1) += w * uv[a].y;
        }
    }
    if (!s.analysed) {
        s.ldlt.analyzePattern(s.matrix);
        s.analysed = true;
    }
    s.ldlt.factorize(s.matrix);
    if (s.ldlt.info() != Eigen::Success)
        throw model::Error(model::codes::kMapInvalid, "the weights of the convex map could not be factorized");
    const Eigen::MatrixX2d x = s.ldlt.solve(rhs);
    for (std::size_t v = 0; v < uv.size(); ++v)
        if (s.unknown[v] != kNone) uv[v] = {x(s.unknown[v], 0), x(s.unknown[v], 1)};
    return uv;
}

std::vector<double> positive_cotangent_weights(std::span<const Vec3d> positions, std::span<const Face> faces,
                                               std::span<const std::pair<std::uint32_t, std::uint32_t>> edges) {
    std::vector<double> weights(edges.size(), 0.0);
    for (const Face& f : faces)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            const Vec3d u = positions[a] - positions[f[(k + 2) % 3]], v = positions[b] - positions[f[(k + 2) % 3]];
            const double sine = length(cross(u, v)), cosine = dot(u, v);
            const double cotangent = sine > 0 ? std::clamp(cosine / sine, -100.0, 100.0) : cosine > 0 ? 100.0 : -100.0;
            const auto it = std::lower_bound(edges.begin(), edges.end(), std::pair(std::min(a, b), std::max(a, b)));
            weights[static_cast<std::size_t>(it - edges.begin())] += 0.5 * cotangent;
        }
    for (double& w : weights) w = std::clamp(w, 0.01, 100.0);
    return weights;
}

namespace {

/// Squared L2 stretch of a face and twice its map area; infinite stretch where that is not positive.
double squared_stretch(const std::array<Vec3d, 3>& q, Vec2d p0, Vec2d p1, Vec2d p2) {
    const double twice = cross(p1 - p0, p2 - p0);
    if (!(twice > 0)) return std::numeric_limits<double>::infinity();
    // Edge form of (|S_s|^2 + |S_t|^2) / 2 [Sander 2001]: the map's cotangents weigh the squared edges of the surface.
    const Vec3d e0 = q[2] - q[1], e1 = q[0] - q[2], e2 = q[1] - q[0];
    const Vec2d d0 = p2 - p1, d1 = p0 - p2, d2 = p1 - p0;
    const double sum = -dot(e0, e0) * dot(d1, d2) - dot(e1, e1) * dot(d2, d0) - dot(e2, e2) * dot(d0, d1);
    return sum / (2 * twice * twice);
}

}  // namespace

double stretch_energy(std::span<const Vec3d> positions, std::span<const Face> faces, std::span<const Vec2d> uv) {
    double sum = 0;
    for (const Face& f : faces) {
        const std::array<Vec3d, 3> q{positions[f[0]], positions[f[1]], positions[f[2]]};
        const double area = face_area(q);
        if (area > 0) sum += area * squared_stretch(q, uv[f[0]], uv[f[1]], uv[f[2]]);
    }
    return sum;
}

double l2_stretch(std::span<const Vec3d> positions, std::span<const Face> faces, std::span<const Vec2d> uv) {
    double area = 0;
    for (const Face& f : faces) area += face_area({positions[f[0]], positions[f[1]], positions[f[2]]});
    return std::sqrt(stretch_energy(positions, faces, uv)) / area;
}

std::vector<Vec2d> reweighted_stretch_map(const DiskView& disk, const ReweightOptions& options,
                                          const model::Progress& progress) {
    ConvexMapSolver solver(disk.positions.size(), disk.faces, disk.border);
    std::vector<double> weights = positive_cotangent_weights(disk.positions, disk.faces, solver.edges());
    std::vector<Vec2d> uv;
    try {
        uv = solver.solve(weights, disk.border_uv);
    } catch (const model::Error&) {  // weights over many powers of ten; equal ones always have a solution
        weights.assign(weights.size(), 1.0);
        uv = solver.solve(weights, disk.border_uv);
    }
    std::vector<Vec2d> best = uv;
    double least = stretch_energy(disk.positions, disk.faces, uv);
    std::vector<double> stretch(disk.positions.size()), area(disk.positions.size());
    int worse = 0;
    for (int k = 0; k < options.iterations && worse < 2; ++k) {
        progress.update("parameterize", static_cast<double>(k) / options.iterations);
        std::fill(stretch.begin(), stretch.end(), 0.0);
        std::fill(area.begin(), area.end(), 0.0);
        double total = 0, total_area = 0;
        for (const Face& f : disk.faces) {
            const std::array<Vec3d, 3> q{disk.positions[f[0]], disk.positions[f[1]], disk.positions[f[2]]};
            const double a = face_area(q);
            const double s = std::min(squared_stretch(q, uv[f[0]], uv[f[1]], uv[f[2]]), 1e12);
            for (std::uint32_t v : f) {
                stretch[v] += a * s;
                area[v] += a;
            }
            total += a * s;
            total_area += a;
        }
        const double mean = std::sqrt(total / total_area);
        for (std::size_t v = 0; v < stretch.size(); ++v)
            stretch[v] = area[v] > 0 ? std::clamp(std::sqrt(stretch[v] / area[v]) / mean, 1e-3, 1e3) : 1.0;
        const auto edges = solver.edges();
        for (std::size_t e = 0; e < edges.size(); ++e) {
            const double product = stretch[edges[e].first] * stretch[edges[e].second];
            weights[e] = std::clamp(weights[e] / math::pow(product, options.exponent), 1e-12, 1e12);
        }
        try {
            uv = solver.solve(weights, disk.border_uv);
        } catch (const model::Error&) {
            break;  // reweighted beyond the range that doubles can factorize; the best map so far stands
        }
        const double energy = stretch_energy(disk.positions, disk.faces, uv);
        if (energy < least || (!std::isfinite(least) && k == 0)) {
            least = energy;
            best = uv;
            worse = 0;
        } else
            ++worse;
    }
    return best;
}

}  // namespace dgm::bake
