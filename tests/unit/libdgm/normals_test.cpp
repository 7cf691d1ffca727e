// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/normals_test.cpp
// Normals kept up to date where touched, against all normals computed anew and against sums of triangles in double.
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/reconstruct.h>

#include <cmath>
#include <random>
#include <vector>

#include "opened.h"

namespace dgm::test {
namespace {

ChartSpec with_diagonals(ChartSpec chart, std::uint32_t seed) {
    std::vector<std::uint8_t> bits((chart.rows - 1) * (chart.cols - 1));
    std::mt19937 random(seed);
    for (std::uint8_t& b : bits) b = random() & 1;
    chart.add("diagonals", ElementType::kU8, {chart.rows - 1, chart.cols - 1}, bits);
    return chart;
}

State make(const ChartSpec& chart, bool plain) {
    StateOptions options;
    options.plain_loops = plain;
    return State::create(Opened(build({chart})).chart(), options).value();
}

/// Area vectors of the reconstructed triangles, summed over classes, in double.
std::vector<std::array<double, 3>> reference(const State& state) {
    std::vector<std::uint32_t> indices(mesh_counts(state).value().indices);
    EXPECT_TRUE(reconstruct(state, {}, indices).ok());
    std::vector<std::array<double, 3>> sum(state.sample_count());
    const PointView p = state.positions();
    const auto weld = [&](std::uint32_t s) {
        return state.class_of(s) == kNone ? s : state.class_members(state.class_of(s))[0];
    };
    for (std::size_t k = 0; k < indices.size(); k += 3) {
        double e[2][3];
        for (int side = 0; side < 2; ++side) {
            const std::uint32_t to = indices[k + 1 + static_cast<std::size_t>(side)], from = indices[k];
            e[side][0] = double{p.x[to]} - p.x[from];
            e[side][1] = double{p.y[to]} - p.y[from];
            e[side][2] = double{p.z[to]} - p.z[from];
        }
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t a = 0; a < 3; ++a)
                sum[weld(indices[k + c])][a] +=
                    e[0][(a + 1) % 3] * e[1][(a + 2) % 3] - e[0][(a + 2) % 3] * e[1][(a + 1) % 3];
    }
    for (auto& n : sum) {
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (double& v : n) v = length > 0 ? v / length : 0;
    }
    for (std::uint32_t s = 0; s < state.sample_count(); ++s) sum[s] = sum[weld(s)];
    return sum;
}

void expect_right(State& state) {
    state.update_normals();
    const auto want = reference(state);
    const PointView n = state.normals();
    for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
        if (!state.on_surface(s)) {
            ASSERT_EQ(n[s], (Vec3{0, 0, 0}));
            continue;
        }
        // Incremental is full, to the bit: normal() computes from the positions alone.
        ASSERT_TRUE(same_bits(n[s], state.normal(s))) << s;
        ASSERT_NEAR(double{n.x[s]}, want[s][0], 4e-6) << s;
        ASSERT_NEAR(double{n.y[s]}, want[s][1], 4e-6) << s;
        ASSERT_NEAR(double{n.z[s]}, want[s][2], 4e-6) << s;
    }
}

void poke_and_check(const ChartSpec& chart, float size = 1) {
    for (const bool plain : {true, false}) {
        State state = make(chart, plain);
        expect_right(state);
        KernelOptions kernel;
        kernel.reach = 5;
        kernel.sigma = 7;
        const DeformTable table = DeformTable::create(kernel).value();
        std::mt19937 random(3);
        for (int round = 0; round < 60; ++round) {
            Touch touch;
            do touch.sample = random() % state.sample_count();
            while (!state.on_surface(touch.sample));
            const auto part = [&] { return size * (float(random() % 200) / 200 - 0.5f); };
            touch.displacement = {part(), part(), part()};
            touch.d_max = 9 * size;
            touch.mode = round % 3 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
            touch.footprint = round % 5 == 0 ? Footprint::Geodesic : Footprint::Grid;
            ASSERT_TRUE(deform(state, table, touch).ok());
            if (round % 4 == 1) { ASSERT_TRUE(state.relax(0.01f, 50).ok()); }
            if (round % 11 == 7) state.release();
            if (round % 2 == 0) expect_right(state);
        }
        state.reset();
        expect_right(state);
    }
}

TEST(Normals, OpenSheetAllDiagonalsAlike) {
    poke_and_check(grid_chart(33, 21, sheet));
}
TEST(Normals, MixedDiagonals) {
    poke_and_check(with_diagonals(grid_chart(21, 37, sheet), 1));
}
TEST(Normals, SeamsAndTheirNodes) {
    poke_and_check(with_diagonals(grid_chart(25, 25, sheet, octahedral_seams(25)), 2));
    poke_and_check(grid_chart(20, 23, sheet, tube_seams(20, 23)));
}
TEST(Normals, FreeDomain) {
    poke_and_check(with_diagonals(free_chart(22, 19, sheet), 3));
    const std::uint32_t m = 14, n = 12, grid = m * n;
    SeamPairs seams;
    for (std::uint32_t k = 0; k < m; ++k) seams.push_back({grid + k, grid + (m - 1) + (n - 1) + (m - 1 - k)});
    poke_and_check(free_chart(m, n, sheet, seams));
}
TEST(Normals, SmallGrids) {
    poke_and_check(grid_chart(2, 2, sheet));
    poke_and_check(grid_chart(3, 3, sheet));
    poke_and_check(grid_chart(2, 30, sheet));
    poke_and_check(grid_chart(30, 4, sheet));
}
TEST(Normals, TinyAndHugeSurfaces) {
    for (const double size : {1e-9, 1e-14, 1e7, 1e12}) {
        SCOPED_TRACE(size);
        poke_and_check(grid_chart(14, 17,
                                  [&](double i, double j) {
                                      const Point p = sheet(i, j);
                                      return Point{static_cast<float>(size * double{p[0]}),
                                                   static_cast<float>(size * double{p[1]}),
                                                   static_cast<float>(size * double{p[2]})};
                                  }),
                       static_cast<float>(size));
    }
}
// Squares of area vectors overflow a float here, in every variant of the loops.
TEST(Normals, SamplesPulledFarBeyondTheirSurface) {
    const ChartSpec chart = grid_chart(21, 19, sheet);
    for (const bool plain : {true, false}) {
        State state = make(chart, plain);
        KernelOptions kernel;
        kernel.reach = 1;
        const DeformTable table = DeformTable::create(kernel).value();
        const Vec3 pulls[] = {{1e15f, 0, 0}, {0, 1e15f, 0}, {0, 0, -1e15f}};
        for (std::uint32_t k = 0; k < 3; ++k) {
            Touch touch;
            touch.sample = 19 * (9 + k) + 9 + k % 2;
            touch.displacement = pulls[k];
            touch.d_max = 1e15f;
            touch.mode = DeformMode::Plastic;
            ASSERT_TRUE(deform(state, table, touch).ok());
        }
        expect_right(state);
    }
}
TEST(Normals, SamplesWithoutArea) {
    State state = make_state(grid_chart(12, 12, [](double i, double) { return Point{float(i), 0, 0}; }));
    state.update_normals();
    for (std::uint32_t s = 0; s < 144; ++s) {
        EXPECT_EQ(state.normals()[s], (Vec3{0, 0, 0}));
        EXPECT_EQ(state.normal(s), (Vec3{0, 0, 0}));
    }
}

TEST(Normals, VectorAndPlainLoopsAgree) {
    const ChartSpec chart = with_diagonals(grid_chart(61, 53, sheet, tube_seams(61, 53)), 9);
    State plain = make(chart, true), fast = make(chart, false);
    EXPECT_STREQ(plain.loops(), "plain");
    KernelOptions kernel;
    kernel.reach = 13;
    kernel.sigma = 40;
    const DeformTable table = DeformTable::create(kernel).value();
    for (std::uint32_t k = 0; k < 40; ++k) {
        Touch touch;
        touch.sample = k * 79 % (61 * 53);
        touch.displacement = {0.1f, -0.2f, 0.7f};
        touch.d_max = 1;
        for (State* s : {&plain, &fast}) {
            ASSERT_TRUE(deform(*s, table, touch).ok());
            ASSERT_TRUE(s->relax(0.001f, 30).ok());
        }
    }
    plain.update_normals();
    fast.update_normals();
    for (std::uint32_t s = 0; s < 61 * 53; ++s) {
        ASSERT_TRUE(same_bits(plain.positions()[s], fast.positions()[s])) << s;
        const Vec3 d = plain.normals()[s] - fast.normals()[s];
        ASSERT_LT(std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)}), 4e-6f) << s;
    }
}

}  // namespace
}  // namespace dgm::test
