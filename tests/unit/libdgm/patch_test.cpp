// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/patch_test.cpp
// Footprints by distance on the surface that are kept from tick to tick: surfaces that unroll, where straight lines
// through space mislead, and ticks beside touches one by one.
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/tick.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "opened.h"

namespace dgm::test {
namespace {
constexpr double kPi = std::numbers::pi;

/// Weights of all samples after a touch at `sample`.
std::vector<double> weights(State& state, const DeformTable& table, Footprint footprint, std::uint32_t sample) {
    state.reset();
    Touch touch;
    touch.sample = sample;
    touch.displacement = {0, 0, 64};
    touch.d_max = 64;
    touch.footprint = footprint;
    touch.step = 1;
    const auto done = deform(state, table, touch);
    EXPECT_TRUE(done.ok()) << done.error().message;
    EXPECT_FALSE(done.value().truncated);
    std::vector<double> w;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        w.push_back((double{state.positions().z[k]} - state.rest_positions().z[k]) / 64);
    return w;
}

struct Unrolled {
    const char* name;
    std::function<Point(double, double)> place;
    std::function<double(double, double, double, double)> distance;  ///< on the surface, of (i, j) and (i', j')
};

double flat_distance(double i, double j, double a, double b) {
    return std::hypot(i - a, j - b);
}

/// A sheet bent along its rows: (x, z) of row i, which runs at unit speed.
Unrolled bent(const char* name, const std::function<std::array<double, 2>(double)>& profile) {
    return {name,
            [profile](double i, double j) {
                const auto [x, z] = profile(i);
                return Point{static_cast<float>(x), static_cast<float>(j), static_cast<float>(z)};
            },
            flat_distance};
}

std::vector<Unrolled> developable_sheets() {
    return {
        bent("plane",
             [](double i) {
                 return std::array{i, 0.0};
             }),
        bent("fold by 30 degrees",
             [](double i) {
                 const double t = kPi / 6;
                 return i <= 20 ? std::array{i, 0.0} : std::array{20 + (i - 20) * std::cos(t), (i - 20) * std::sin(t)};
             }),
        bent("fold by 90 degrees",
             [](double i) {
                 return i <= 20 ? std::array{i, 0.0} : std::array{20.0, i - 20};
             }),
        bent("fold by 180 degrees",
             [](double i) {
                 return i <= 20 ? std::array{i, 0.0} : std::array{40 - i, 0.001 * (i - 20)};
             }),
        bent("pleats",  // up and down by 45 degrees each row: normals of samples all point up
             [](double i) {
                 const double rest = i - 2 * std::floor(i / 2);
                 return std::array{i * std::sqrt(0.5), std::sqrt(0.5) * (rest < 1 ? rest : 2 - rest)};
             }),
        bent("finger",  // a round end of radius 3
             [](double i) {
                 const double r = 3, a = (i - 20) / r;
                 if (a < -kPi / 2) return std::array{i - 20 + r * kPi / 2, r};
                 if (a > kPi / 2) return std::array{20 - i + r * kPi / 2, -r};
                 return std::array{r * std::cos(a), -r * std::sin(a)};
             }),
    };
}

TEST(Patch, IsRightWhereTheSheetUnrolls) {
    const std::uint32_t n = 41;
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    for (const Unrolled& sheet : developable_sheets()) {
        SCOPED_TRACE(sheet.name);
        State state = make_state(grid_chart(n, n, sheet.place));
        for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic})
            for (const auto& [i, j] : {std::array{20, 20}, {17, 20}, {14, 3}, {25, 38}, {8, 20}, {0, 0}, {40, 17}}) {
                const auto w =
                    weights(state, table, footprint, static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j));
                double worst = 0;
                for (std::uint32_t k = 0; k < n * n; ++k) {
                    const double d = sheet.distance(i, j, k / n, k % n);
                    worst = std::max(worst, std::fabs(w[k] - double{table.profile(static_cast<float>(d))}));
                    if (d > 1.25 * table.reach()) { ASSERT_EQ(w[k], 0) << k / n << ' ' << k % n; }
                }
                EXPECT_LT(worst, footprint == Footprint::Surface ? 0.06 : 0.02) << i << ' ' << j;
            }
    }
}

/// A flat ring sector with a gap, bent as far as `turn` of a whole turn: what lies across the gap is far on the
/// surface.
TEST(Patch, GoesAroundOpenBorders) {
    const std::uint32_t m = 121, n = 13;
    const double inner = 20, turn = 0.995;
    const auto place = [&](double i, double j) {
        const double a = 2 * kPi * turn * i / (m - 1), r = inner + j;
        return Point{static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), 0};
    };
    State state = make_state(grid_chart(m, n, place));
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic}) {
        const auto w = weights(state, table, footprint, 2 * n + 6);
        for (std::uint32_t i = 60; i < m; ++i)
            for (std::uint32_t j = 0; j < n; ++j) ASSERT_EQ(w[i * n + j], 0) << i << ' ' << j;
        EXPECT_GT(w[4 * n + 6], 0.5);
    }
    // Around the inner border of a half turn with radius 2: the straight line leaves the surface.
    const auto narrow = [](double i, double j) {
        const double a = kPi * i / 40, r = 2 + 0.25 * j;
        return Point{static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), 0};
    };
    State horseshoe = make_state(grid_chart(41, 9, narrow));
    for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic}) {
        const auto w = weights(horseshoe, table, footprint, 0);
        // Half way around the inner border: 2 pi / 2 = pi, where the line is 2 sqrt(2) = 2.83.
        EXPECT_NEAR(w[20 * 9], double{table.profile(static_cast<float>(kPi))}, 0.02);
        EXPECT_NEAR(w[40 * 9], double{table.profile(static_cast<float>(2 * kPi))}, 0.02);
    }
}

/// Chart with mixed diagonals, soft and half attached places.
ChartSpec uneven(ChartSpec chart, bool layers) {
    const std::uint32_t m = chart.rows, n = chart.cols;
    std::mt19937 random(7);
    std::vector<std::uint8_t> diagonals((m - 1) * (n - 1));
    for (std::uint8_t& d : diagonals) d = random() & 1;
    chart.add("diagonals", ElementType::kU8, {m - 1, n - 1}, diagonals);
    if (!layers) return chart;
    std::vector<float> soft, contact;
    for (std::uint32_t k = 0; k < m * n; ++k) {
        soft.insert(soft.end(), {1, 0, 1, k % 5 == 0 ? 0.5f : 1.0f});
        contact.insert(contact.end(), {1, k % 7 == 0 ? 0.25f : 1.0f});
    }
    chart.add("deformation", ElementType::kF32, {m, n, 4}, soft);
    chart.add("contact", ElementType::kF32, {m, n, 2}, contact);
    return chart;
}

std::vector<ChartSpec> charts() {
    const auto tube = [](double i, double j) {
        const double a = 2 * kPi * j / 40, r = 6.4 + 0.5 * std::sin(i / 4);
        return Point{static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i)};
    };
    const auto hill = [](double i, double j) {
        return Point{static_cast<float>(i), static_cast<float>(j),
                     static_cast<float>(3 * std::exp(-((i - 16) * (i - 16) + (j - 16) * (j - 16)) / 60))};
    };
    return {uneven(grid_chart(41, 41, hill), false),
            uneven(grid_chart(41, 41, hill), true),
            uneven(grid_chart(41, 41, tube, tube_seams(41, 41)), false),
            uneven(grid_chart(41, 41, tube, tube_seams(41, 41)), true),
            uneven(grid_chart(33, 33, sheet, octahedral_seams(33)), true),
            grid_chart(37, 33, hill),
            grid_chart(9, 6, hill),
            free_chart(30, 26, hill),
            grid_chart(2, 3, hill)};
}

TEST(Patch, TicksAreTouchesOneByOne) {
    for (const ChartSpec& chart : charts())
        for (const bool plain : {false, true}) {
            SCOPED_TRACE(std::to_string(chart.rows) + "x" + std::to_string(chart.cols) + (plain ? " plain" : ""));
            StateOptions options;
            options.plain_loops = plain;
            const Opened opened(build({chart}));
            State ticked = State::create(opened.chart(), options).value(),
                  touched = State::create(opened.chart()).value();
            const DeformTable tables[2] = {make_table(9, 7, KernelEnd::Compact), make_table(5, 4, KernelEnd::Compact)};
            std::mt19937 random(3);
            TickOptions o;
            o.d_max = 1.5f;
            o.settle_time = 0;
            std::uint32_t contact = 0;
            float worst = 0;
            for (int k = 0; k < 600; ++k) {
                if (k % 4 == 0) do
                        contact = random() % ticked.sample_count();
                    while (!ticked.on_surface(contact));
                const DeformTable& table = tables[random() % 8 == 0];
                ToolInput in;
                in.kind = ToolKind::Grasp;
                in.engaged = k % 4 != 0;
                in.position = ticked.rest_positions()[contact];
                if (k % 4 > 1) in.position = in.position + Vec3{0.3f, -0.2f, 0.4f * static_cast<float>(k % 4)};
                o.footprint = random() % 3 == 0 ? Footprint::Geodesic : Footprint::Surface;
                ToolOutput out;
                const auto done = tick(ticked, table, o, {&in, 1}, {&out, 1});
                ASSERT_TRUE(done.ok()) << done.error().message;
                touched.release();
                if (out.contact != kNone && out.displacement != Vec3{}) {
                    Touch touch;
                    touch.sample = out.contact;
                    touch.displacement = out.displacement;
                    touch.d_max = o.d_max;
                    touch.footprint = o.footprint;
                    const auto one = deform(touched, table, touch);
                    ASSERT_TRUE(one.ok());
                    ASSERT_EQ(one.value().samples, done.value().samples);
                    ASSERT_EQ(one.value().crossed_seam, done.value().crossed_seam);
                }
                touched.update_normals();
                for (std::uint32_t s = 0; s < ticked.sample_count(); ++s) {
                    ASSERT_TRUE(same_bits(ticked.positions()[s], touched.positions()[s])) << k << ' ' << s;
                    const Vec3 d = ticked.normals()[s] - touched.normals()[s];
                    worst = std::max(worst, std::sqrt(dot(d, d)));
                }
                for (std::uint32_t id = 0; id < ticked.class_count(); ++id)
                    for (const std::uint32_t copy : ticked.class_members(id)) {
                        const std::uint32_t first = ticked.class_members(id)[0];
                        ASSERT_TRUE(same_bits(ticked.positions()[copy], ticked.positions()[first]));
                        ASSERT_TRUE(same_bits(ticked.normals()[copy], ticked.normals()[first]));
                    }
                if (k % 90 == 89) {  // permanent: what is kept of normals has to be made anew
                    Touch dent;
                    dent.sample = contact;
                    dent.displacement = {0.1f, 0, -0.2f};
                    dent.d_max = 1;
                    dent.mode = DeformMode::Plastic;
                    for (State* s : {&ticked, &touched}) {
                        s->release();
                        ASSERT_TRUE(deform(*s, table, dent).ok());
                    }
                }
            }
            EXPECT_LT(worst, 1e-4f);  // 2e-5 but for the closed sheet, whose seams close triangles as long as itself
            ticked.release();
            ticked.update_normals();
            for (std::uint32_t s = 0; s < ticked.sample_count(); ++s)
                ASSERT_TRUE(same_bits(ticked.normals()[s], ticked.normal(s))) << s;
        }
}

TEST(Patch, DoesNotDependOnWhatWasTouchedBefore) {
    // Other contacts, kernels and steps in between must leave nothing behind in the scratch or the patches kept.
    for (const ChartSpec& chart : charts()) {
        SCOPED_TRACE(std::to_string(chart.rows) + "x" + std::to_string(chart.cols));
        State used = make_state(chart);
        const DeformTable tables[3] = {make_table(9, 7, KernelEnd::Compact), make_table(5, 4, KernelEnd::Compact),
                                       make_table(20, 12, KernelEnd::Compact)};
        std::mt19937 random(11);
        for (int k = 0; k < 200; ++k) {
            const std::uint32_t sample = random() % used.sample_count();
            if (!used.on_surface(sample)) continue;
            const DeformTable& table = tables[random() % 3];
            Touch touch;
            touch.sample = sample;
            touch.displacement = {0, 0.5f, 1};
            touch.d_max = 2;
            touch.footprint = static_cast<Footprint>(random() % 4);
            touch.step = random() % 2 == 0 ? 0 : 0.7f;
            used.reset();
            const auto again = deform(used, table, touch);
            State fresh = make_state(chart);
            const auto first = deform(fresh, table, touch);
            ASSERT_TRUE(again.ok() && first.ok());
            ASSERT_EQ(again.value().samples, first.value().samples);
            for (std::uint32_t s = 0; s < used.sample_count(); ++s)
                ASSERT_TRUE(same_bits(used.positions()[s], fresh.positions()[s])) << k << ' ' << s;
        }
    }
}

TEST(Patch, EveryCopyOfAContactGivesTheSame) {
    const ChartSpec chart = uneven(grid_chart(33, 33, sheet, octahedral_seams(33)), true);
    State a = make_state(chart), b = make_state(chart);
    const DeformTable table = make_table(9, 7, KernelEnd::Compact);
    for (std::uint32_t id = 0; id < a.class_count(); ++id) {
        const auto wa = weights(a, table, Footprint::Surface, a.class_members(id).front());
        const auto wb = weights(b, table, Footprint::Surface, a.class_members(id).back());
        ASSERT_EQ(wa, wb);
    }
}

TEST(Patch, PlainAndVectorLoopsWeighAlike) {
    for (const ChartSpec& chart : charts()) {
        StateOptions options;
        options.plain_loops = true;
        const Opened opened(build({chart}));
        State plain = State::create(opened.chart(), options).value(), other = State::create(opened.chart()).value();
        const DeformTable table = make_table(12, 8, KernelEnd::Compact);
        for (std::uint32_t sample = 0; sample < plain.sample_count(); sample += 17) {
            if (!plain.on_surface(sample)) continue;
            ASSERT_EQ(weights(plain, table, Footprint::Surface, sample),
                      weights(other, table, Footprint::Surface, sample));
        }
    }
}

}  // namespace
}  // namespace dgm::test
