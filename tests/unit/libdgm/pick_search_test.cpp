// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/pick_search_test.cpp
// pick_ray() to the bit against the same test on every triangle, and against another triangle test in long double.
// DGM_PICK_RAYS=1000000 asks for the long form of the first.
#include <gtest/gtest.h>

#include <dgm/tick.h>

#include "pick_rays.h"

namespace dgm::test {
namespace {

TEST(Pick, EqualsExhaustiveSearch) {
    const long count = rays_wanted();
    int hits = 0;
    const ChartSpec charts[] = {grid_chart(43, 41, folds, tube_seams(43, 41)),
                                mixed(grid_chart(43, 41, folds, tube_seams(43, 41)), 5),
                                sphere_chart(33),
                                mixed(sphere_chart(41), 6),
                                free_chart(30, 21, folds),
                                mixed(free_chart(26, 35, test::sheet), 7),
                                grid_chart(18, 10, test::sheet),
                                grid_chart(2, 9, test::sheet)};
    unsigned seed = 1;
    for (const ChartSpec& chart : charts) {
        State state = make_state(chart);
        compare(state, count / 8, seed++, &hits);
        if (HasFatalFailure()) return;
    }
    RecordProperty("hits", hits);
}

TEST(Pick, EqualsAnotherTriangleTest) {
    for (const ChartSpec& chart :
         {mixed(grid_chart(43, 41, folds, tube_seams(43, 41)), 5), free_chart(30, 21, folds)}) {
        State state = make_state(chart);
        compare_oracle(state, 400, 9);
    }
}

TEST(Pick, FollowsEveryChange) {
    const ChartSpec charts[] = {mixed(sphere_chart(33), 8), free_chart(30, 35, test::sheet),
                                grid_chart(43, 41, folds, tube_seams(43, 41))};
    for (const ChartSpec& chart : charts) {
        State state = make_state(chart);
        const DeformTable table = dent_table(6);
        const Around box(state);
        std::mt19937 random(11);
        const auto sample = [&] {
            for (;;) {
                const auto k = static_cast<std::uint32_t>(random() % state.sample_count());
                if (state.on_surface(k)) return k;
            }
        };
        for (int round = 0; round < 40; ++round) {
            Touch touch;
            touch.sample = sample();
            touch.d_max = box.size / 5;
            touch.displacement = {float(random() % 9) - 4, float(random() % 9) - 4, float(random() % 9) - 4};
            touch.mode = round % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
            if (round % 3 == 0) {
                ASSERT_TRUE(deform(state, table, touch).ok());
            } else {
                TickOptions options;
                options.d_max = touch.d_max;
                options.relax_rate = round % 3 == 1 ? 20.0f : kInfinity;
                ToolInput in;
                in.position = state.positions()[touch.sample] - (box.size / 40) * state.normal(touch.sample);
                for (int k = 0; k < 5; ++k) ASSERT_TRUE(tick(state, table, options, {&in, 1}, {}).ok());
            }
            if (round % 7 == 0) { ASSERT_TRUE(state.relax(0.01f, 30).ok()); }
            if (round % 11 == 0) state.release();
            if (round == 30) state.reset();
            compare(state, 100, 100 + static_cast<unsigned>(round));
            if (HasFatalFailure()) return;
        }
    }
}

TEST(Pick, EachMovedBorderSampleTakesItsFacesAlong) {
    // Faces of the strip may have corners in several tiles: all their leaves must be marked for each corner.
    State state = make_state(free_chart(28, 35, flat));
    const DeformTable table = dent_table(1);  // less than a step around the contact
    const Exhaustive all(state);
    for (std::uint32_t k = 28 * 35; k < state.sample_count(); ++k) {
        Touch touch;
        touch.sample = k;
        touch.displacement = {0.125f, 0.25f, 3};
        touch.d_max = 4;
        ASSERT_TRUE(deform(state, table, touch).ok());
        const Vec3 p = state.positions()[k];
        for (std::size_t f = 2 * (27 - 2) * (34 - 2) * std::size_t{3}; f < all.indices.size(); f += 3) {
            const std::uint32_t* c = all.indices.data() + f;
            if (c[0] != k && c[1] != k && c[2] != k) continue;
            // Sideways through a place of the face near the moved corner.
            Vec3 middle = 0.9f * p;
            for (int e = 0; e < 3; ++e)
                if (c[e] != k) middle = middle + 0.05f * state.positions()[c[e]];
            for (const Vec3 d : {Vec3{1, 0.25f, 0.5f}, Vec3{-0.25f, 1, -0.125f}, Vec3{0.5f, 1, 0.25f}}) {
                const auto hit = pick_ray(state, middle - 4 * d, d);
                const auto want = all(state, middle - 4 * d, d, {});
                ASSERT_EQ(hit.ok(), want.found) << k;
                if (want.found) { ASSERT_EQ(hit.value().distance, static_cast<float>(want.distance)) << k; }
            }
        }
        state.release();
        // Boxes are up to date before the next touch, which alone must be marked.
        static_cast<void>(pick_ray(state, {}, {0, 0, 1}));
    }
}

}  // namespace
}  // namespace dgm::test
