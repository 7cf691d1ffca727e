// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_detail_test.cpp
// Coarse states and how they are shown on fine ones: what is exact, what does not move, and what is refused.
#include <dgm/dgm_physics.h>
#include <gtest/gtest.h>

#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {

using V = std::array<double, 3>;
V at(const PointView& view, std::uint32_t k) {
    return {double{view[k].x}, double{view[k].y}, double{view[k].z}};
}
/// Moves every sample of a state, as physics does.
template <class F>
void move(State& state, F f) {
    detail::StateImpl& s = *state.impl();
    const PointView rest = state.rest_positions();
    for (std::uint32_t k = 0; k < rest.count; ++k) {
        const V x = f(at(rest, k));
        s.now.x[k] = static_cast<float>(x[0]);
        s.now.y[k] = static_cast<float>(x[1]);
        s.now.z[k] = static_cast<float>(x[2]);
    }
    s.touch_all();
}
struct Pair {
    State fine, coarse;
    Detail detail;
    Pair(const ChartSpec& chart, std::uint32_t stride)
        : fine(make_state(chart)),
          coarse(coarse_state(fine, stride).value()),
          detail(Detail::create(fine, coarse, stride).value()) {}
    void show() { ASSERT_TRUE(detail.show(coarse, fine).ok()); }
    /// Largest distance of a sample from where f takes its rest place.
    template <class F>
    double off(F f) const {
        const PointView rest = fine.rest_positions(), now = fine.positions();
        double far = 0;
        for (std::uint32_t k = 0; k < rest.count; ++k) {
            const V x = f(at(rest, k)), y = at(now, k);
            far = std::max(far, std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]));
        }
        return far;
    }
    std::size_t unlike_rest() const {
        const PointView rest = fine.rest_positions(), now = fine.positions();
        std::size_t count = 0;
        for (std::uint32_t k = 0; k < rest.count; ++k) {
            const float a[3] = {rest[k].x, rest[k].y, rest[k].z}, b[3] = {now[k].x, now[k].y, now[k].z};
            count += std::memcmp(a, b, sizeof a) != 0 ? 1 : 0;
        }
        return count;
    }
};
/// Half a turn and more around no axis of the grid, and a long way.
V turned(V x) {
    const double c = std::cos(2.0), s = std::sin(2.0);
    const V y{c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]};
    return {y[0] + 10, c * y[1] - s * y[2] - 20, s * y[1] + c * y[2] + 5};
}

/// Three folds of the border that meet in one node, at odd samples.
ChartSpec three_folds_chart(std::uint32_t side) {
    const std::uint32_t e = side - 1, loop = 4 * e, a = e, b = 2 * e + 4;
    const auto sample = [=](std::uint32_t k) {
        k %= loop;
        if (k < e) return k * side;
        if (k < 2 * e) return e * side + (k - e);
        if (k < 3 * e) return (3 * e - k) * side + e;
        return loop - k;
    };
    SeamPairs seams;
    const auto fold = [&](std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t k = 1; 2 * k < to - from; ++k) {
            const std::uint32_t s = sample(from + k), t = sample(to - k);
            if (s != t) seams.push_back({std::min(s, t), std::max(s, t)});
        }
    };
    fold(1, 1 + a);
    fold(1 + a, 1 + b);
    fold(1 + b, 1 + loop);
    const std::uint32_t nodes[3] = {sample(1), sample(1 + a), sample(1 + b)},
                        first = *std::min_element(nodes, nodes + 3);
    for (const std::uint32_t node : nodes)
        if (node != first) seams.push_back({first, node});
    return grid_chart(
        side, side,
        [=](double i, double j) {
            const double x = 2 * i / e - 1, y = 2 * j / e - 1, r = std::max(std::fabs(x), std::fabs(y));
            const double length = std::sqrt(x * x + y * y), polar = 2.8 * r;
            const double c = length > 0 ? x / length : 1, s = length > 0 ? y / length : 0;
            return Point{float(70 * std::sin(polar) * c), float(60 * std::sin(polar) * s), float(50 * std::cos(polar))};
        },
        seams);
}

class DetailOf : public testing::TestWithParam<std::uint32_t> {};

TEST_P(DetailOf, RigidMotionsAreExact) {
    for (const ChartSpec& chart : {organ_chart(33), torus_chart(33)}) {
        Pair p(chart, GetParam());
        move(p.coarse, turned);
        p.show();
        EXPECT_LT(p.off(turned), 5e-5) << "of 150 units, in floats";
        expect_closed_seams(p.fine);
        EXPECT_GT(p.unlike_rest(), 900u);
    }
}

TEST_P(DetailOf, AffineMapsOfAFlatSheetAreExact) {
    ChartSpec chart = grid_chart(26, 33, [](double i, double j) {
        return Point{float(4 * i + 0.9 * j + 0.3 * std::sin(2 * i + j)), float(3 * j + 0.4 * std::cos(3 * i)), 0};
    });
    add_mixed_diagonals(chart);
    Pair p(chart, GetParam());
    const auto affine = [](V x) {
        return V{1.3 * x[0] + 0.4 * x[1] + 2, 0.8 * x[1] - 0.2 * x[0], 0.5 * x[0] + 0.1 * x[1] - 3};
    };
    move(p.coarse, affine);
    p.show();
    EXPECT_LT(p.off(affine), 2e-4) << "of 130 units, in floats";
}

TEST_P(DetailOf, WhatIsNotMovedKeepsItsBits) {
    Pair p(organ_chart(33), GetParam());
    p.show();
    EXPECT_EQ(p.unlike_rest(), 0u);
    // One coarse sample: its own quads, and those of its neighbours, whose gradients it changes.
    detail::StateImpl& c = *p.coarse.impl();
    const std::uint32_t i = c.tables.rows / 2, j = c.tables.cols / 2;
    c.now.z[i * c.tables.cols + j] += 3;
    c.touch_all();
    p.show();
    const std::uint32_t reach = 2 * GetParam();
    EXPECT_GT(p.unlike_rest(), 0u);
    EXPECT_LE(p.unlike_rest(), std::size_t{2 * reach + 1} * (2 * reach + 1));
    expect_closed_seams(p.fine);
}
INSTANTIATE_TEST_SUITE_P(Strides, DetailOf, testing::Values(1u, 2u, 4u));

TEST(DetailOfPhysics, AtStride1IsTheStepItself) {
    Body body(organ_chart(17));
    Pair p(organ_chart(17), 1);
    PhysicsOptions options;
    options.metres_per_unit = 1e-3;
    Physics physics = Physics::create(p.coarse, options).value();
    StepOptions how;
    how.tool_radius = 10;
    for (int k = 0; k < 20; ++k) {
        ToolInput ball;
        ball.position = {0, 0, float(60 - 0.4 * k)};
        ASSERT_TRUE(step(body.state, body.physics, how, {&ball, 1}).ok());
        ASSERT_TRUE(step(p.coarse, physics, how, {&ball, 1}).ok());
    }
    p.show();
    const PointView a = body.state.positions(), b = p.fine.positions();
    for (std::uint32_t k = 0; k < a.count; ++k) {
        EXPECT_EQ(a[k].x, b[k].x) << k;
        EXPECT_EQ(a[k].y, b[k].y) << k;
        EXPECT_EQ(a[k].z, b[k].z) << k;
    }
    EXPECT_GT(p.unlike_rest(), 100u);
}

TEST(DetailOfPhysics, StaysClosedWhereTheNodesOfSeamsLieBetweenItsSamples) {
    for (const ChartSpec& chart : {tree_chart(33), three_folds_chart(33)}) {
        Pair p(chart, 2);
        EXPECT_FALSE(p.fine.impl()->open_surface);
        EXPECT_FALSE(p.coarse.impl()->open_surface);
        expect_closed_seams(p.coarse);
        move(p.coarse, turned);
        p.show();
        EXPECT_LT(p.off(turned), 1e-4);
        expect_closed_seams(p.fine);
        PhysicsOptions options;
        options.metres_per_unit = 1e-3;
        Physics physics = Physics::create(p.coarse, options).value();
        StepOptions how;
        how.tool_radius = 10;
        for (int k = 0; k < 20; ++k) {
            ToolInput ball;
            ball.position = {0, 0, float(60 - 0.3 * k)};
            const StepReport r = step(p.coarse, physics, how, {&ball, 1}).value();
            EXPECT_FALSE(r.clamped);
            EXPECT_LE(std::fabs(r.volume_error), 1e-8);
        }
    }
}

TEST(DetailOfPhysics, FollowsASmoothBendBetweenItsSamples) {
    // A sheet rolled into a quarter of a cylinder: chords of the coarse quads lie up to h^2 / (8 R) inside it.
    const auto flat = [](double i, double j) { return Point{float(5 * i), float(5 * j), 0}; };
    Pair p(grid_chart(33, 33, flat), 4);
    const double radius = 160 / 1.5707963;
    const auto rolled = [&](V x) {
        return V{x[0], radius * std::sin(x[1] / radius), radius * (1 - std::cos(x[1] / radius))};
    };
    move(p.coarse, rolled);
    p.show();
    const double chord = 20 * 20 / (8 * radius);
    const PointView rest = p.fine.rest_positions(), now = p.fine.positions();
    double inside = 0;
    for (std::uint32_t k = 0; k < rest.count; ++k) {
        const double v = double{rest[k].y};
        if (v < 20 || v > 140) continue;  // at the border a gradient is that of one side
        const V x = rolled(at(rest, k)), y = at(now, k);
        inside = std::max(inside, std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]));
    }
    EXPECT_LT(inside, 0.1 * chord);
}

TEST(DetailOfPhysics, RefusesWhatCannotBeCoarse) {
    const State fine = make_state(organ_chart(33));
    EXPECT_EQ(coarse_state(fine, 0).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(coarse_state(fine, 32).error().code, ErrorCode::Unsupported) << "2 x 2";
    // Octahedral seams are folded in the middle of each side: at stride 3 its two halves have other samples.
    EXPECT_EQ(coarse_state(fine, 3).error().code, ErrorCode::Unsupported);
    StateOptions bad;
    bad.max_tools = 65;
    EXPECT_EQ(coarse_state(fine, 2, bad).error().code, ErrorCode::BadArgument);
    StateOptions small;
    small.max_bytes = 1000;
    EXPECT_EQ(coarse_state(fine, 2, small).error().code, ErrorCode::LimitExceeded);
    const State coarse = coarse_state(fine, 2).value();
    EXPECT_EQ(Detail::create(fine, coarse, 4).error().code, ErrorCode::BadArgument);
    Detail detail = Detail::create(fine, coarse, 2).value();
    State other = make_state(organ_chart(17));
    EXPECT_EQ(detail.show(coarse, other).error().code, ErrorCode::BadArgument);
}

TEST(DetailOfPhysics, TakesAnySizeAlong) {
    // 32 x 27 samples at stride 3 and 5: the last rows are nearer.
    for (const std::uint32_t stride : {3u, 5u}) {
        Pair p(grid_chart(27, 32,
                          [](double i, double j) {
                              return Point{float(4 * i), float(4 * j), float(i * j / 50)};
                          }),
               stride);
        EXPECT_EQ(p.coarse.rows(), (25 / stride) + 2);
        move(p.coarse, turned);
        p.show();
        EXPECT_LT(p.off(turned), 1e-4);
    }
}

TEST(DetailOfPhysics, CoarseStatesKeepMaterialStiffnessAndMobility) {
    ChartSpec chart = organ_chart(17);
    State fine = make_state(chart);
    detail::StateImpl& f = *fine.impl();
    f.material[0] = 1e-3f;
    const State coarse = coarse_state(fine, 2).value();
    EXPECT_EQ(stored_material(coarse).metres_per_unit, stored_material(fine).metres_per_unit);
    EXPECT_FALSE(stored_material(coarse).material.has_value());
    EXPECT_EQ(coarse.impl()->open_surface, f.open_surface);
}

}  // namespace
}  // namespace dgm::test
