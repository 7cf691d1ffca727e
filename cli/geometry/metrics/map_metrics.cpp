// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/map_metrics.cpp
// Distortion of a map and exact orientation.
//
// [Sander 2001] Sander, Snyder, Gortler, Hoppe. Texture Mapping Progressive Meshes. SIGGRAPH 2001. Names follow it: q
// surface corners, (s, t) map corners, A area in the map, A' on the surface, Gamma and gamma the singular values.
// [Shewchuk 1997] Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates.
#include "geometry/metrics/map_metrics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/portable.h"

namespace dgm::bake {
namespace {
using model::Face;
using model::Vec2d;
using model::Vec3d;

/// Adds `x` to a nonoverlapping expansion, exactly ([Shewchuk 1997] GROW-EXPANSION with zero elimination).
struct Expansion {
    std::array<double, 16> term{};  // increasing magnitude
    int size = 0;

    void add(double x) {
        int kept = 0;
        for (int k = 0; k < size; ++k) {
            const double sum = x + term[k];
            const double virt = sum - x;
            const double error = (x - (sum - virt)) + (term[k] - virt);
            if (error != 0) term[kept++] = error;
            x = sum;
        }
        if (x != 0) term[kept++] = x;
        size = kept;
    }
    void add_product(double a, double b) {
        const double product = a * b;
        add(std::fma(a, b, -product));
        add(product);
    }
    [[nodiscard]] int sign() const { return size == 0 ? 0 : (term[size - 1] > 0 ? 1 : -1); }
};

int orient2d_exact(Vec2d a, Vec2d b, Vec2d c) {
    Expansion sum;
    sum.add_product(a.x, b.y);
    sum.add_product(-a.x, c.y);
    sum.add_product(-c.x, b.y);
    sum.add_product(-a.y, b.x);
    sum.add_product(a.y, c.x);
    sum.add_product(c.y, b.x);
    return sum.sign();
}

bool is_finite(Vec2d a) {
    return std::isfinite(a.x) && std::isfinite(a.y);
}

struct Sums {
    double surface = 0, map = 0;       // sum A', sum A
    double l2 = 0;                     // sum L2^2 A'
    double squares = 0, inverses = 0;  // sums of (s1^2 + s2^2) A' and (s1^-2 + s2^-2) A'
    double angle = 0;                  // sum (s1/s2 + s2/s1)/2 A'
    double ratio = 0, inverse_ratio = 0;
    double measured = 0;  // sum A' of the faces with A' > 0
};

}  // namespace

int orient2d(Vec2d a, Vec2d b, Vec2d c) {
    const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
    const double det = left - right;
    constexpr double kEpsilon = 0x1p-53;
    constexpr double kErrorBound = (3 + 16 * kEpsilon) * kEpsilon;  // ccwerrboundA
    const double bound = kErrorBound * (std::abs(left) + std::abs(right));
    if (det > bound) return 1;
    if (-det > bound) return -1;
    return orient2d_exact(a, b, c);
}

MapMetrics measure_map(std::span<const Vec3d> positions, std::span<const Face> faces, std::span<const Vec2d> uv) {
    MapMetrics out;
    const auto finite = [&](std::size_t v) { return model::is_finite(positions[v]) && is_finite(uv[v]); };
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!finite(v)) ++out.not_finite;

    Sums sum;
    double worst = 0;
    for (const Face& f : faces) {
        if (!finite(f[0]) || !finite(f[1]) || !finite(f[2])) continue;
        const Vec2d p1 = uv[f[0]], p2 = uv[f[1]], p3 = uv[f[2]];
        const int orientation = orient2d(p1, p2, p3);
        if (orientation < 0) ++out.flips;
        if (orientation == 0) ++out.degenerate;
        const double A = 0.5 * cross(p2 - p1, p3 - p1);
        if (orientation <= 0 || !(A > 0)) continue;
        // Corners relative to the first: the sums of the paper cancel large coordinates only if they are small.
        const Vec3d q2 = positions[f[1]] - positions[f[0]], q3 = positions[f[2]] - positions[f[0]];
        const Vec3d Ss = (q2 * (p3.y - p1.y) + q3 * (p1.y - p2.y)) / (2 * A);
        const Vec3d St = (q2 * (p1.x - p3.x) + q3 * (p2.x - p1.x)) / (2 * A);
        const double a = dot(Ss, Ss), b = dot(Ss, St), c = dot(St, St);
        const double Gamma_squared = 0.5 * (a + c + math::hypot(a - c, 2 * b));
        const double surface = 0.5 * length(cross(q2, q3));
        worst = std::max(worst, Gamma_squared);
        sum.surface += surface;
        sum.map += A;
        sum.l2 += 0.5 * (a + c) * surface;
        // gamma from Gamma * gamma = A'/A: the difference of squares would cancel for needle shapes.
        const double r = A / surface;
        const double gamma_squared = 1 / (r * r * Gamma_squared);
        if (!(surface > 0) || !(gamma_squared > 0) || !std::isfinite(1 / gamma_squared)) continue;
        sum.measured += surface;
        sum.squares += (Gamma_squared + gamma_squared) * surface;
        sum.inverses += (1 / Gamma_squared + 1 / gamma_squared) * surface;
        sum.angle += 0.5 * (Gamma_squared + gamma_squared) * r * surface;  // (G/g + g/G)/2 = (G^2 + g^2) / (2 G g)
        sum.ratio += r * surface;
        sum.inverse_ratio += surface / r;
    }
    if (sum.surface > 0) {
        const double normalise = std::sqrt(sum.map / sum.surface);
        out.stretch_l2 = std::sqrt(sum.l2 / sum.surface) * normalise;
        out.stretch_linf = std::sqrt(worst) * normalise;
    }
    if (sum.measured > 0) {
        // A global scale k turns P/k^2 + Q k^2 into its minimum 2 sqrt(PQ); likewise for r + 1/r.
        out.symmetric_dirichlet = 0.5 * std::sqrt(sum.squares / sum.measured) * std::sqrt(sum.inverses / sum.measured);
        out.angle = sum.angle / sum.measured;
        out.area = std::sqrt(sum.ratio / sum.measured) * std::sqrt(sum.inverse_ratio / sum.measured);
    }
    return out;
}

}  // namespace dgm::bake
