// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flip_free_problem.h
// The energies of slim.h, face by face: values, gradients and projected Hessians. For slim.cpp alone.
//
// [Smith, De Goes, Kim 2019] Analytic Eigensystems for Isotropic Distortion Energies. ACM TOG 38(1).
// [Sander 2001] Sander, Snyder, Gortler, Hoppe. Texture Mapping Progressive Meshes. SIGGRAPH 2001.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "geometry/mesh/infinity.h"
#include "geometry/parameterize/rest_shapes.h"
#include "geometry/parameterize/slim.h"
#include "math/portable.h"
#include "model/codes.h"
#include "model/error.h"

namespace dgm::bake {

/// s^-p; the powers in use are spared the logarithm.
inline double inverse_power(double s, double p) {
    if (p == 4) return 1 / (s * s * s * s);
    if (p == 0.5) return 1 / std::sqrt(s);
    return math::pow(s, -p);
}

/// g'(s) = c1 s + c0 + c2 s^-2 + c3 s^-3: the energies are rows of one family, but for powers that are not 2.
struct Density {
    double c1 = 0, c0 = 0, c2 = 0, c3 = 0, constant = 0;
    double power = 0;  ///< if positive, g(s) = c1 s^2 / 2 + s^-power instead

    [[nodiscard]] double value(double s) const {
        if (power > 0) return 0.5 * c1 * s * s + inverse_power(s, power);
        return 0.5 * c1 * s * s + c0 * s - c2 / s - 0.5 * c3 / (s * s) + constant;
    }
    [[nodiscard]] double slope(double s) const {
        if (power > 0) return c1 * s - power * inverse_power(s, power) / s;
        return c1 * s + c0 + (c2 + c3 / s) / (s * s);
    }
    [[nodiscard]] double curvature(double s) const {
        if (power > 0) return c1 + power * (power + 1) * inverse_power(s, power) / (s * s);
        return c1 - (2 * c2 + 3 * c3 / s) / (s * s * s);
    }
    /// (g'(s1) - g'(s2)) / (s1 - s2), written out because it cancels where s1 = s2.
    [[nodiscard]] double divided_difference(double s1, double s2) const {
        constexpr double kAlike = 1e-5;  // the difference has lost half the digits; the mean value is off by kAlike^2
        if (power > 0)
            return s1 - s2 < kAlike * s2 ? curvature(std::sqrt(s1 * s2)) : (slope(s1) - slope(s2)) / (s1 - s2);
        const double p = s1 * s2;
        return c1 - c2 * (s1 + s2) / (p * p) - c3 * (s1 * s1 + p + s2 * s2) / (p * p * p);
    }
};

inline Density density_of(const SlimOptions& o) {
    switch (o.energy) {
        case FlipFreeEnergy::kArap:
            return {.c1 = 2, .c0 = -2, .c2 = 2 * o.barrier, .c3 = -2 * o.barrier, .constant = 1 + o.barrier};
        case FlipFreeEnergy::kStretch:
            if (o.stretch_power != 2) return {.c1 = 2 * o.stretch_epsilon, .power = o.stretch_power};
            return {.c1 = 2 * o.stretch_epsilon, .c3 = -2};
        case FlipFreeEnergy::kSymmetricDirichlet:
            break;
    }
    return {.c1 = 1, .c3 = -1};
}

/// A face laid flat: columns of the inverse of its edge matrix, so that F = [x1 - x0, x2 - x0] * inverse.
struct Rest {
    std::array<Vec2d, 3> b;  ///< gradients of the three hat functions: F = sum x_k b_k^T
    double weight = 0;       ///< share of the area
    double inverse_det = 0;  ///< 1 / (2 area)
};

/// F = R(phi) diag(s1, s2) R(theta); of both angles cosine and sine.
struct Decomposition {
    double s1 = 0, s2 = 0;
    Vec2d phi, theta;
};

/// Cosine and sine of half the angle, between -90 and 90 degrees, of the vector d with length l; of 0 if l is 0.
/// Square roots are rounded alike everywhere, a library's sines are not.
inline Vec2d half_angle(Vec2d d, double l) {
    if (!(l > 0)) return {1, 0};
    const double c = d.x / l, s = d.y / l;
    if (c >= 0) {
        const double x = std::sqrt(0.5 * (1 + c));
        return {x, 0.5 * s / x};
    }
    const double y = std::copysign(std::sqrt(0.5 * (1 - c)), s);
    return {0.5 * s / y, y};
}

/// a*d - b*c to nearly full precision (Kahan).
inline double difference_of_products(double a, double d, double b, double c) {
    const double bc = b * c;
    return std::fma(a, d, -bc) + std::fma(-b, c, bc);
}

inline double twice_area(const std::vector<Vec2d>& x, const Face& f) {
    const Vec2d e1 = x[f[1]] - x[f[0]], e2 = x[f[2]] - x[f[0]];
    return difference_of_products(e1.x, e2.y, e1.y, e2.x);
}

class Problem {
 public:
    Problem(const DiskView& disk, const SlimOptions& options) : disk_(disk), density_(density_of(options)) {
        std::vector<RestShape> own;
        if (options.rest.empty()) own = rest_shapes(disk);
        const std::span<const RestShape> shapes = options.rest.empty() ? own : options.rest;
        rest_.resize(disk.faces.size());
        for (const RestShape& s : shapes) area_ += s.area;
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            // 1 / (2 area) of the shape itself, which the weight need not be.
            const std::array<Vec2d, 3> b = upright(shapes[f].hat);
            rest_[f] = {b, shapes[f].area / area_, cross(b[1], b[2])};
        }
    }

    [[nodiscard]] double area() const { return area_; }

    /// Multiplies all rest lengths.
    void scale_rest(double s) {
        for (Rest& r : rest_) {
            for (Vec2d& b : r.b) b = b * (1 / s);
            r.inverse_det /= s * s;
        }
        area_ *= s * s;
    }

    [[nodiscard]] Decomposition decompose(const std::vector<Vec2d>& x, std::size_t f) const {
        const Face& face = disk_.faces[f];
        const Rest& r = rest_[f];
        const Vec2d e1 = x[face[1]] - x[face[0]], e2 = x[face[2]] - x[face[0]];
        const double a = e1.x * r.b[1].x, b = e1.x * r.b[1].y + e2.x * r.b[2].y;
        const double c = e1.y * r.b[1].x, d = e1.y * r.b[1].y + e2.y * r.b[2].y;
        const Vec2d turn{0.5 * (a + d), 0.5 * (c - b)}, mirror{0.5 * (a - d), 0.5 * (c + b)};
        const double turned = length(turn), mirrored = length(mirror);
        Decomposition out;
        out.s1 = turned + mirrored;
        // Not the difference of the two: it cancels for needles.
        out.s2 = twice_area(x, face) * r.inverse_det / out.s1;
        const Vec2d h = half_angle(turn, turned), g = half_angle(mirror, mirrored);
        out.phi = {h.x * g.x - h.y * g.y, h.y * g.x + h.x * g.y};
        out.theta = {h.x * g.x + h.y * g.y, h.y * g.x - h.x * g.y};
        return out;
    }

    [[nodiscard]] double energy(const std::vector<Vec2d>& x) const {
        double sum = 0;
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            const Face& face = disk_.faces[f];
            const Rest& r = rest_[f];
            const Vec2d e1 = x[face[1]] - x[face[0]], e2 = x[face[2]] - x[face[0]];
            const double det = difference_of_products(e1.x, e2.y, e1.y, e2.x) * r.inverse_det;
            if (!(det > 0)) return kInfinity;
            const double a = e1.x * r.b[1].x, b = e1.x * r.b[1].y + e2.x * r.b[2].y;
            const double c = e1.y * r.b[1].x, d = e1.y * r.b[1].y + e2.y * r.b[2].y;
            const double s1 = 0.5 * (length(Vec2d{a + d, c - b}) + length(Vec2d{a - d, c + b}));
            sum += r.weight * (density_.value(s1) + density_.value(det / s1));
        }
        return std::isfinite(sum) ? sum : kInfinity;
    }

    /// Best global factor for the symmetric Dirichlet energy; the other energies take it if it lowers them.
    [[nodiscard]] double best_scale(const std::vector<Vec2d>& x) const {
        double squares = 0, inverses = 0;
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            const Decomposition s = decompose(x, f);
            squares += rest_[f].weight * (s.s1 * s.s1 + s.s2 * s.s2);
            inverses += rest_[f].weight * (1 / (s.s1 * s.s1) + 1 / (s.s2 * s.s2));
        }
        return std::sqrt(std::sqrt(inverses / squares));
    }

    /// Calls sink(face, gradient of the three corners, modes) with A' already multiplied in; a mode is a vector of six
    /// entries q (x0 y0 x1 y1 x2 y2) such that the projected Hessian is the sum of q q^T.
    template <typename Sink>
    void each_face(const std::vector<Vec2d>& x, const Sink& sink) const {
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            const Rest& r = rest_[f];
            const Decomposition s = decompose(x, f);
            const auto [cp, sp] = s.phi;
            const auto [ct, st] = s.theta;
            // R(phi) M R(theta) b for M = e_i e_j^T: column i of R(phi) times (row j of R(theta)) . b.
            const Vec2d u1{cp, sp}, u2{-sp, cp};
            const double g1 = density_.slope(s.s1), g2 = density_.slope(s.s2);
            const double root_half = std::sqrt(0.5);
            const std::array<double, 4> lambda{density_.curvature(s.s1), density_.curvature(s.s2),
                                               density_.divided_difference(s.s1, s.s2), (g1 + g2) / (s.s1 + s.s2)};
            std::array<double, 6> gradient{};
            std::array<std::array<double, 6>, 4> modes{};
            std::array<double, 4> root{};
            for (std::size_t m = 0; m < 4; ++m) root[m] = std::sqrt(r.weight * std::max(lambda[m], 0.0));
            for (std::size_t k = 0; k < 3; ++k) {
                const double v1 = ct * r.b[k].x - st * r.b[k].y, v2 = st * r.b[k].x + ct * r.b[k].y;
                const Vec2d flip = (u1 * v2 + u2 * v1) * root_half, twist = (u2 * v1 - u1 * v2) * root_half;
                const Vec2d gk = (u1 * (g1 * v1) + u2 * (g2 * v2)) * r.weight;
                gradient[2 * k] = gk.x;
                gradient[2 * k + 1] = gk.y;
                const std::array<Vec2d, 4> d{u1 * v1, u2 * v2, flip, twist};
                for (std::size_t m = 0; m < 4; ++m) {
                    modes[m][2 * k] = root[m] * d[m].x;
                    modes[m][2 * k + 1] = root[m] * d[m].y;
                }
            }
            sink(f, gradient, modes);
        }
    }

    [[nodiscard]] std::span<const Face> faces() const { return disk_.faces; }

 private:
    /// The shape turned until its first edge lies along x, which the energies do not see: decompose() and energy()
    /// count on b[2].x = 0.
    [[nodiscard]] static std::array<Vec2d, 3> upright(std::array<Vec2d, 3> b) {
        if (b[2].x == 0 && b[2].y > 0) return b;
        const double l = length(b[2]), c = b[2].y / l, s = b[2].x / l;
        for (Vec2d& p : b) p = {c * p.x - s * p.y, s * p.x + c * p.y};
        b[2] = {0, l};
        return b;
    }

    const DiskView& disk_;
    Density density_;
    std::vector<Rest> rest_;
    double area_ = 0;
};

}  // namespace dgm::bake
