// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_shapes.h
// Maps to try physics on: closed bodies of genus 0 and 1, and open sheets, with uneven and turned diagonals.
#pragma once
#include <dgm/physics.h>

#include <algorithm>
#include <new>
#include <optional>

#include "contact_shapes.h"
#include "exact_shapes.h"

namespace dgm::test {

/// Memory from the C++ library that counts what is in use.
struct CountedMemory {
    std::size_t now = 0, most = 0;

    /// That of this object, which must outlive what it allocates.
    [[nodiscard]] Allocator allocator() {
        constexpr std::align_val_t kAligned{64};  // as much as any of the runtime's objects needs
        Allocator out;
        out.user = this;
        out.allocate = [](void* user, std::size_t bytes, std::size_t alignment) -> void* {
            if (alignment > static_cast<std::size_t>(kAligned)) return nullptr;
            auto& memory = *static_cast<CountedMemory*>(user);
            memory.most = std::max(memory.most, memory.now += bytes);
            return ::operator new(bytes, kAligned, std::nothrow);
        };
        out.release = [](void* user, void* block, std::size_t bytes) {
            static_cast<CountedMemory*>(user)->now -= bytes;
            ::operator delete(block, kAligned);
        };
        return out;
    }
};

/// An ellipsoid of 150 x 120 x 100 on the octahedral map.
inline ChartSpec organ_chart(std::uint32_t side) {
    return closed_chart(side, [](std::array<double, 3> n) {
        return std::array<double, 3>{75 * n[0], 60 * n[1] * (1 + 0.2 * n[0]), 50 * n[2]};
    });
}
/// A torus: both pairs of sides of the square are glued.
inline ChartSpec torus_chart(std::uint32_t side, double major = 60, double minor = 25) {
    SeamPairs seams;
    const std::uint32_t e = side - 1;
    for (std::uint32_t k = 1; k < e; ++k) {
        seams.push_back({k, e * side + k});
        seams.push_back({k * side, k * side + e});
    }
    for (const std::uint32_t corner : {e, e * side, e * side + e}) seams.push_back({0, corner});
    return grid_chart(
        side, side,
        [=](double i, double j) {
            const double u = 2 * 3.14159265358979 * i / e, v = -2 * 3.14159265358979 * j / e;
            const double r = major + minor * std::cos(u);
            return Point{float(r * std::cos(v)), float(r * std::sin(v)), float(minor * std::sin(u))};
        },
        seams);
}
/// A body whose seam is a tree with a branch: nodes of the cut lie on odd samples, so that strides do not meet there.
/// Side i = 0 is folded at an odd sample, the other three together are folded at one point.
inline ChartSpec tree_chart(std::uint32_t side) {
    // The border, counter-clockwise, is cut by nodes into paths that fold onto themselves: any such border is that of a
    // cut sphere. Two paths: `short_end` samples long around its middle, and the rest.
    const std::uint32_t e = side - 1, loop = 4 * e, split = 2 * (e / 2 - 3);
    const auto sample = [=](std::uint32_t k) {
        k %= loop;
        if (k < e) return k * side;
        if (k < 2 * e) return e * side + (k - e);
        if (k < 3 * e) return (3 * e - k) * side + e;
        return loop - k;
    };
    SeamPairs seams;
    std::vector<std::uint32_t> low(loop);
    const auto pair = [&](std::uint32_t a, std::uint32_t b) {
        const std::uint32_t s = sample(a), t = sample(b);
        if (s != t) seams.push_back({std::min(s, t), std::max(s, t)});
    };
    for (std::uint32_t k = 1; k < split / 2; ++k) pair(1 + k, 1 + split - k);
    for (std::uint32_t k = 0; 2 * k < loop - split; ++k) pair(1 + split + k, 1 + loop - k);
    // The node where both paths end has the samples 1 and 1 + split of the loop: the last loop pairs them at k = 0.
    return grid_chart(
        side, side,
        [=](double i, double j) {
            // A disk wrapped around a ball: its border shrinks to a slit along a meridian.
            const double x = 2 * i / e - 1, y = 2 * j / e - 1, r = std::max(std::fabs(x), std::fabs(y));
            const double length = std::sqrt(x * x + y * y), polar = 2.4 * r;
            const double c = length > 0 ? x / length : 1, s = length > 0 ? y / length : 0;
            return Point{float(70 * std::sin(polar) * c), float(60 * std::sin(polar) * s), float(50 * std::cos(polar))};
        },
        seams);
}

struct Body {
    State state;
    Physics physics;
    explicit Body(const ChartSpec& chart, PhysicsOptions options = {}, bool plain = false)
        : state(make_state(chart)), physics(make(state, options, plain)) {}
    static Physics make(const State& state, PhysicsOptions o, bool plain) {
        if (o.metres_per_unit == 0) o.metres_per_unit = 1e-3;
        o.plain_loops = plain;
        auto made = Physics::create(state, o);
        EXPECT_TRUE(made.ok()) << made.error().message;
        return std::move(made).value();
    }
};

}  // namespace dgm::test
