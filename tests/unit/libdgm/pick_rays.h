// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/pick_rays.h
// Rays of every kind, and two other ways to find what they meet.
#pragma once
#include <dgm/deform.h>
#include <dgm/pick.h>

#include <cmath>
#include <limits>
#include <random>

#include "asked.h"
#include "contact_shapes.h"
#include "opened.h"
#include "query/ray_triangle.h"

namespace dgm::test {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

inline Point flat(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j), 0};
}
/// A closed tube with folds: near sheets that are far apart along the surface.
inline Point folds(double i, double j) {
    const double a = 2 * 3.14159265358979 * j / 40, r = 3 + 2.5 * std::sin(3 * a) * std::cos(i / 4);
    return {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i / 5)};
}
inline ChartSpec mixed(ChartSpec chart, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bits((chart.rows - 1) * (chart.cols - 1));
    for (std::uint8_t& bit : bits) bit = static_cast<std::uint8_t>(random() >> 31);
    chart.add("diagonals", ElementType::kU8, {chart.rows - 1, chart.cols - 1}, bits);
    return chart;
}
inline DeformTable dent_table(std::uint32_t reach) {
    KernelOptions kernel;
    kernel.reach = reach;
    kernel.sigma = static_cast<float>(reach);
    return DeformTable::create(kernel).value();
}
inline double length(Vec3 v) {
    return std::sqrt(double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z);
}

/// The library's own test on every triangle, in index order.
struct Exhaustive {
    std::vector<std::uint32_t> indices;
    explicit Exhaustive(const State& state) : indices(Triangles(state).indices) {}
    struct Answer {
        bool found = false;
        double distance = 0;
        std::uint32_t corners[3] = {};
        detail::TriangleHit hit;
    };
    [[nodiscard]] Answer operator()(const State& state, Vec3 origin, Vec3 direction, const PickOptions& o) const {
        const detail::Ray ray = detail::make_ray(origin, direction);
        const PointView p = state.positions();
        const detail::RayPlanes planes = detail::planes_of(ray, {p.x, p.y, p.z});
        Answer best;
        best.distance = o.max_distance;
        for (std::size_t k = 0; k < indices.size(); k += 3) {
            detail::TriangleHit hit;
            if (!detail::meets(ray, detail::shear(ray, planes, indices[k]), detail::shear(ray, planes, indices[k + 1]),
                               detail::shear(ray, planes, indices[k + 2]), hit) ||
                (!hit.front && !o.back_faces))
                continue;
            if (hit.distance > best.distance || (best.found && hit.distance == best.distance)) continue;
            best = {true, hit.distance, {indices[k], indices[k + 1], indices[k + 2]}, hit};
        }
        return best;
    }
};

/// Nearest crossing in long double by Moeller and Trumbore's rule; `margin`: how far from every edge, at the least.
struct Oracle {
    long double distance = std::numeric_limits<long double>::infinity();
    long double margin = std::numeric_limits<long double>::infinity();
    void offer(Vec3 a, Vec3 b, Vec3 c, Vec3 origin, Vec3 direction) {
        using Real = long double;
        const auto sub = [](Vec3 p, Vec3 q) {
            return std::array<Real, 3>{Real(p.x) - q.x, Real(p.y) - q.y, Real(p.z) - q.z};
        };
        const auto cross = [](const auto& p, const auto& q) {
            return std::array<Real, 3>{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
        };
        const auto product = [](const auto& p, const auto& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; };
        const auto e = sub(b, a), f = sub(c, a), o = sub(origin, a), d = sub(direction, {});
        const auto h = cross(d, f);
        const Real det = product(e, h);
        if (det == 0) return;
        const Real u = product(o, h) / det;
        const auto q = cross(o, e);
        const Real v = product(d, q) / det, t = product(f, q) / det * std::sqrt(product(d, d));
        const Real inside = std::min({u, v, 1 - u - v});
        if (t > -1e-6L) margin = std::min({margin, std::fabs(inside), std::fabs(t)});
        if (inside >= 0 && t >= 0) distance = std::min(distance, t);
    }
};

inline long rays_wanted() {
    return asked("DGM_PICK_RAYS", 20000);
}

struct Around {
    Vec3 middle;
    float size;
    explicit Around(const State& state) {
        Vec3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
        for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
            if (!state.on_surface(k)) continue;
            const Vec3 p = state.positions()[k];
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        middle = 0.5f * (low + high);
        size = static_cast<float>(length(high - low));
    }
};

/// Rays of every kind: from anywhere, from and to samples, along edges and axes, grazing.
struct Rays {
    std::mt19937 random;
    Around box;
    Rays(const State& state, unsigned seed) : random(seed), box(state) {}
    Vec3 anywhere(float size) {
        std::normal_distribution<float> n(0, size);
        const float x = n(random), y = n(random), z = n(random);
        return {x, y, z};
    }
    Vec3 sample(const State& state) {
        for (;;) {
            const auto k = static_cast<std::uint32_t>(random() % state.sample_count());
            if (state.on_surface(k)) return state.positions()[k];
        }
    }
    void next(const State& state, Vec3& origin, Vec3& direction, PickOptions& o) {
        o = {};
        o.back_faces = random() % 4 != 0;
        if (random() % 4 == 0) o.max_distance = box.size * static_cast<float>(random() % 100) / 80;
        const Vec3 p = sample(state), q = sample(state);
        origin = box.middle + anywhere(box.size);
        switch (random() % 8) {
            case 0:
                direction = anywhere(1);
                break;
            case 1:
            case 2:
                direction = box.middle + anywhere(box.size / 4) - origin;
                break;
            case 3:
                direction = p - origin;
                break;  // through a corner, but for rounding
            case 4:
                direction = 0.5f * (p + q) - origin;
                break;
            case 5:
                origin = p;
                direction = random() % 2 == 0 ? q - p : anywhere(1);
                break;  // starts on the surface
            case 6:     // along an axis, through a corner to the bit
                origin = p;
                (&origin.x)[random() % 3] += box.size;
                direction = p - origin;
                break;
            default: {  // nearly along an edge: from outside, past p and its neighbour in memory
                direction = sample(state) - p;
                origin = p - (2 * box.size / std::max(1e-6f, static_cast<float>(length(direction)))) * direction;
            }
        }
        if (direction == Vec3{}) direction = {1, 0, 0};
    }
};

inline void compare(State& state, long count, unsigned seed, int* found = nullptr) {
    const Exhaustive all(state);
    Rays rays(state, seed);
    int hits = 0;
    for (long k = 0; k < count; ++k) {
        Vec3 origin, direction;
        PickOptions o;
        rays.next(state, origin, direction, o);
        const auto got = pick_ray(state, origin, direction, o);
        const auto want = all(state, origin, direction, o);
        ASSERT_EQ(got.ok(), want.found) << k;
        if (!want.found) {
            ASSERT_EQ(got.error().code, ErrorCode::NotFound);
            continue;
        }
        ++hits;
        const RayHit& h = got.value();
        ASSERT_EQ(h.distance, static_cast<float>(want.distance)) << k;
        double sum = 0;
        int nearest = 0;
        for (int c = 0; c < 3; ++c) {
            ASSERT_EQ(h.corners[c], want.corners[c]) << k;
            ASSERT_EQ(h.barycentric[c], static_cast<float>(want.hit.weight[c])) << k;
            ASSERT_GE(h.barycentric[c], 0) << k;
            sum += double{h.barycentric[c]};
            if (want.hit.weight[c] > want.hit.weight[nearest]) nearest = c;
        }
        ASSERT_NEAR(sum, 1, 1e-6);
        ASSERT_EQ(h.front, want.hit.front);
        const std::uint32_t id = state.class_of(h.corners[nearest]);
        ASSERT_EQ(h.sample, id == kNone ? h.corners[nearest] : state.class_members(id)[0]);
        const double size = length(origin) + static_cast<double>(h.distance) + static_cast<double>(rays.box.size);
        const double step = static_cast<double>(h.distance) / length(direction);
        for (int a = 0; a < 3; ++a)
            ASSERT_NEAR((&h.point.x)[a], double{(&origin.x)[a]} + step * double{(&direction.x)[a]}, 4e-7 * size) << k;
    }
    if (found != nullptr) *found += hits;
    EXPECT_GT(hits, count / 10);
}

/// Compares with the independent oracle where no edge is near.
inline void compare_oracle(State& state, int count, unsigned seed) {
    const Exhaustive all(state);
    const PointView p = state.positions();
    std::mt19937 random(seed);
    Rays rays(state, seed);
    int compared = 0;
    for (int k = 0; k < count; ++k) {
        const Vec3 origin = rays.box.middle + rays.anywhere(rays.box.size);
        const Vec3 direction = rays.box.middle + rays.anywhere(rays.box.size / 4) - origin;
        Oracle oracle;
        for (std::size_t t = 0; t < all.indices.size(); t += 3)
            oracle.offer(p[all.indices[t]], p[all.indices[t + 1]], p[all.indices[t + 2]], origin, direction);
        if (oracle.margin < 1e-9L) continue;
        ++compared;
        const auto hit = pick_ray(state, origin, direction);
        ASSERT_EQ(hit.ok(), std::isfinite(oracle.distance)) << k;
        if (!hit.ok()) continue;
        const auto distance = static_cast<double>(oracle.distance);
        ASSERT_NEAR(hit.value().distance, distance, 2e-7 * distance + 1e-12) << k;
    }
    EXPECT_GT(compared, count * 9 / 10);
}

}  // namespace dgm::test
