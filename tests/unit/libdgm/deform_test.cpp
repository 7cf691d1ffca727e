// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/deform_test.cpp
// Eq. 7 in the interior, the table, clamping, modes and refusals.
#include <gtest/gtest.h>

#include <dgm/deform.h>

#include <cmath>
#include <limits>
#include <vector>

#include "opened.h"

namespace dgm::test {
namespace {

Touch press(std::uint32_t sample, Vec3 d, float d_max = 10, DeformMode mode = DeformMode::Elastic) {
    Touch touch;
    touch.sample = sample;
    touch.displacement = d;
    touch.d_max = d_max;
    touch.footprint = Footprint::Grid;
    touch.mode = mode;
    return touch;
}

std::vector<Vec3> all(const PointView& p) {
    std::vector<Vec3> out;
    for (std::size_t k = 0; k < p.count; ++k) out.push_back(p[k]);
    return out;
}

TEST(Deform, Eq7OnThePapersGrid) {
    // 81 x 81, window 21 x 21 (b = 11), the paper's setting; z = 0 and d = 1 along z, so z is the weight.
    const auto flat = [](double i, double j) { return Point{static_cast<float>(i), static_cast<float>(j), 0}; };
    State state = make_state(grid_chart(81, 81, flat));
    const DeformTable table = make_table(25, 11);
    const auto done = deform(state, table, press(40 * 81 + 37, {0, 0, 1}));
    ASSERT_TRUE(done.ok());
    EXPECT_EQ(done.value().samples, 21u * 21u);
    EXPECT_FALSE(done.value().crossed_seam);
    const PointView p = state.positions();
    for (int i = 0; i < 81; ++i)
        for (int j = 0; j < 81; ++j) {
            const int di = i - 40, dj = j - 37;
            const double want = std::abs(di) < 11 && std::abs(dj) < 11 ? std::exp(-(di * di + dj * dj) / 25.0) : 0;
            ASSERT_NEAR(p.z[i * 81 + j], want, table.error_bound()) << i << " " << j;
        }
    // By hand: e^-1 at distance 5 and e^-(200/25) in the window's corner.
    EXPECT_NEAR(p.z[45 * 81 + 37], 0.36787944f, 1e-7);
    EXPECT_NEAR(p.z[43 * 81 + 41], 0.36787944f, 1e-7);
    EXPECT_NEAR(p.z[50 * 81 + 47], 3.3546263e-4f, 1e-9);
    EXPECT_EQ(p.z[51 * 81 + 37], 0.0f);
}

TEST(Deform, OpenBorderClipsTheWindow) {
    State state = make_state(grid_chart(20, 30, sheet));
    const DeformTable table = make_table(9, 6);
    ASSERT_TRUE(deform(state, table, press(1 * 30 + 28, {0, 0, 2})).ok());
    const PointView p = state.positions(), rest = state.rest_positions();
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 30; ++j) {
            const int di = i - 1, dj = j - 28;
            const double want = std::abs(di) < 6 && std::abs(dj) < 6 ? 2 * std::exp(-(di * di + dj * dj) / 9.0) : 0;
            ASSERT_NEAR(p.z[i * 30 + j] - rest.z[i * 30 + j], want, 1e-6);
        }
}

TEST(Deform, CompactKernelEndsSmoothly) {
    const float sigma = 40;
    const std::uint32_t b = 15;
    const DeformTable printed = make_table(sigma, b), compact = make_table(sigma, b, KernelEnd::Compact);
    const double R2 = double(b) * b / sigma, bound = std::exp(-R2) * (1 + R2);
    EXPECT_EQ(compact.weight(0, 0), 1.0f);
    EXPECT_EQ(compact.weight(15, 0), 0.0f);
    EXPECT_EQ(compact.weight(11, 11), 0.0f);  // inside the square, outside the disk
    EXPECT_NEAR(printed.weight(11, 11), std::exp(-242.0 / 40), 1e-8);
    for (int di = -14; di < 15; ++di)
        for (int dj = -14; dj < 15; ++dj) {
            const double r2 = (di * di + dj * dj) / double(sigma);
            const float w = compact.weight(float(di), float(dj));
            const double want = r2 < R2 ? (std::exp(-r2) - std::exp(-R2) * (1 + R2 - r2)) / (1 - bound) : 0;
            EXPECT_NEAR(w, want, compact.error_bound());
            EXPECT_LE(std::fabs(w - (r2 < R2 ? printed.weight(float(di), float(dj)) : 0)), bound);
        }
    const float slope = (compact.weight(14.999f, 0) - compact.weight(14.99f, 0)) / 0.009f;
    EXPECT_LT(std::fabs(slope), 2e-5f);
    EXPECT_GT(std::fabs((printed.weight(14.999f, 0) - printed.weight(14.99f, 0)) / 0.009f), 1e-3f);
    // A kernel that is nearly flat over its reach must not drown in cancellation: (1 - x)^2 for R -> 0.
    EXPECT_NEAR(make_table(1e12f, 4, KernelEnd::Compact).weight(2, 0), 0.5625f, 1e-6f);
}

TEST(Deform, PushAndPullAreOpposite) {
    State state = make_state(grid_chart(30, 30, [](double, double) { return Point{0, 0, 0}; }));
    const DeformTable table = make_table(9, 6);
    ASSERT_TRUE(deform(state, table, press(15 * 30 + 15, {0.5f, 0.25f, -1})).ok());
    const auto pushed = all(state.positions());
    state.release();
    ASSERT_TRUE(deform(state, table, press(15 * 30 + 15, {-0.5f, -0.25f, 1})).ok());
    const PointView p = state.positions();
    for (std::size_t k = 0; k < p.count; ++k) ASSERT_EQ(p[k] + pushed[k], (Vec3{0, 0, 0}));
}

TEST(Deform, LongDisplacementsAreShortenedToDMax) {
    State state = make_state(grid_chart(9, 9, [](double, double) { return Point{0, 0, 0}; }));
    const auto done = deform(state, make_table(4, 3), press(40, {30, 0, 40}, 5));
    ASSERT_TRUE(done.ok());
    EXPECT_NEAR(done.value().displacement.x, 3, 1e-6);
    EXPECT_NEAR(done.value().displacement.z, 4, 1e-6);
    EXPECT_NEAR(state.positions()[40].z, 4, 1e-6);
    // Also at the largest displacement there may be, and not beyond it.
    const auto huge = deform(state, make_table(4, 3), press(40, {kMaxCoordinate, 0, 0}, 1));
    ASSERT_TRUE(huge.ok());
    EXPECT_NEAR(huge.value().displacement.x, 1, 1e-6);
    const Touch beyond = press(40, {0, std::nextafter(-kMaxCoordinate, -INFINITY), 0}, 1);
    EXPECT_EQ(deform(state, make_table(4, 3), beyond).error().code, ErrorCode::BadArgument);
}

TEST(Deform, ElasticTouchesGoOnReleasePlasticOnesStay) {
    State state = make_state(grid_chart(40, 40, sheet, tube_seams(40, 40)));
    const DeformTable table = make_table(9, 6);
    const auto rest = all(state.rest_positions());
    EXPECT_EQ(all(state.positions()), rest);
    ASSERT_TRUE(deform(state, table, press(10 * 40 + 1, {0, 0, 1}, 2, DeformMode::Plastic)).ok());
    const auto dented = all(state.positions());
    EXPECT_NE(dented, rest);
    ASSERT_TRUE(deform(state, table, press(12 * 40 + 2, {1, 0, 0})).ok());
    ASSERT_TRUE(deform(state, table, press(30 * 40 + 30, {0, 1, 0})).ok());
    EXPECT_NE(all(state.positions()), dented);
    state.release();
    EXPECT_EQ(all(state.positions()), dented);
    ASSERT_TRUE(deform(state, table, press(10 * 40 + 1, {0, 0, 1}, 2, DeformMode::Plastic)).ok());
    EXPECT_NEAR(state.positions().z[10 * 40 + 1], rest[10 * 40 + 1].z + 2, 1e-6);
    state.reset();
    EXPECT_EQ(all(state.positions()), rest);
    EXPECT_EQ(all(state.rest_positions()), rest);
}

TEST(Deform, RefusalsChangeNothing) {
    State state = make_state(grid_chart(9, 9, sheet), 4);
    const DeformTable table = make_table(4, 3);
    const auto before = all(state.positions());
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const auto code = [&](const DeformTable& t, const Touch& touch) { return deform(state, t, touch).error().code; };
    EXPECT_EQ(code(table, press(81, {0, 0, 1})), ErrorCode::BadArgument);
    EXPECT_EQ(code(table, press(kNone, {0, 0, 1})), ErrorCode::BadArgument);
    EXPECT_EQ(code(table, press(40, {nan, 0, 1})), ErrorCode::BadArgument);
    EXPECT_EQ(code(table, press(40, {0, -infinity, 1})), ErrorCode::BadArgument);
    EXPECT_EQ(code(table, press(40, {0, 0, 1}, 0)), ErrorCode::BadArgument);
    EXPECT_EQ(code(table, press(40, {0, 0, 1}, nan)), ErrorCode::BadArgument);
    EXPECT_EQ(code(make_table(4, 5), press(40, {0, 0, 1})), ErrorCode::BadArgument);
    Touch odd = press(40, {0, 0, 1});
    odd.footprint = static_cast<Footprint>(7);
    EXPECT_EQ(code(table, odd), ErrorCode::Unsupported);
    EXPECT_EQ(all(state.positions()), before);
    KernelOptions options;
    options.sigma = 0;
    EXPECT_EQ(DeformTable::create(options).error().code, ErrorCode::BadArgument);
    options.sigma = nan;
    EXPECT_EQ(DeformTable::create(options).error().code, ErrorCode::BadArgument);
    options.sigma = 1;
    options.reach = 0;
    EXPECT_EQ(DeformTable::create(options).error().code, ErrorCode::BadArgument);
    options.reach = kMaxReach + 1;
    EXPECT_EQ(DeformTable::create(options).error().code, ErrorCode::BadArgument);
}

}  // namespace
}  // namespace dgm::test
