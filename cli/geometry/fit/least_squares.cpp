// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/least_squares.cpp
#include "geometry/fit/least_squares.h"

#include <cmath>

namespace dgm::bake {
namespace {

using model::Vec3d;

/// Symmetric 3x3: xx, xy, xz, yy, yz, zz.
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

double dot_all(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += dot(a[k], b[k]);
    return sum;
}

}  // namespace

std::vector<Vec3d> least_squares_step(std::span<const FitRow> rows, std::size_t unknowns, std::span<const char> fixed,
                                      double share, double damping, int iterations) {
    std::vector<Block> diagonal(unknowns, Block{});
    std::vector<Vec3d> residual(unknowns, Vec3d{}), step(unknowns, Vec3d{}), direction, z(unknowns), product(unknowns);
    double trace = 0;
    for (const FitRow& row : rows) {
        const Vec3d& n = row.normal;
        const Vec3d pull = row.gap * share + n * ((1 - share) * dot(n, row.gap));
        const Block m{share + (1 - share) * n.x * n.x, (1 - share) * n.x * n.y, (1 - share) * n.x * n.z,
                      share + (1 - share) * n.y * n.y, (1 - share) * n.y * n.z, share + (1 - share) * n.z * n.z};
        for (int k = 0; k < 3; ++k) {
            const double wb = row.weight * row.b[k], wbb = wb * row.b[k];
            residual[row.unknown[k]] += pull * wb;
            for (int e = 0; e < 6; ++e) diagonal[row.unknown[k]][e] += wbb * m[e];
            trace += wbb;
        }
    }
    // By each unknown's own weight [Marquardt 1963]: one damping for all would freeze the samples of crowded regions,
    // whose rows weigh little, while their neighbours move.
    const double floor = 1e-6 * damping * trace / static_cast<double>(unknowns);
    std::vector<double> lambda(unknowns);
    std::vector<Block> preconditioner(unknowns);
    for (std::size_t k = 0; k < unknowns; ++k) {
        Block d = diagonal[k];
        lambda[k] = floor + damping * (d[0] + d[3] + d[5]);
        d[0] += lambda[k], d[3] += lambda[k], d[5] += lambda[k];
        preconditioner[k] = inverse(d);
        if (fixed[k]) residual[k] = {};
    }
    const auto precondition = [&] {
        for (std::size_t k = 0; k < unknowns; ++k) z[k] = multiply(preconditioner[k], residual[k]);
    };
    precondition();
    direction = z;
    double rz = dot_all(residual, z);
    const double enough = 1e-6 * rz;
    for (int it = 0; it < iterations && rz > enough; ++it) {
        for (std::size_t k = 0; k < unknowns; ++k) product[k] = direction[k] * lambda[k];
        for (const FitRow& row : rows) {
            const auto& u = row.unknown;
            const Vec3d moved = direction[u[0]] * row.b[0] + direction[u[1]] * row.b[1] + direction[u[2]] * row.b[2];
            const Vec3d pull = (moved * share + row.normal * ((1 - share) * dot(row.normal, moved))) * row.weight;
            for (int k = 0; k < 3; ++k) product[u[k]] += pull * row.b[k];
        }
        for (std::size_t k = 0; k < unknowns; ++k)
            if (fixed[k]) product[k] = {};
        const double curvature = dot_all(direction, product);
        if (!(curvature > 0)) break;
        const double t = rz / curvature;
        for (std::size_t k = 0; k < unknowns; ++k) step[k] += direction[k] * t, residual[k] -= product[k] * t;
        precondition();
        const double next = dot_all(residual, z), beta = next / rz;
        for (std::size_t k = 0; k < unknowns; ++k) direction[k] = z[k] + direction[k] * beta;
        rz = next;
    }
    return step;
}

}  // namespace dgm::bake
