// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/geodesic_test.cpp
// Exact footprints on surfaces of flat faces, whose distances follow from unfolding them by hand, and on hostile ones.
#include <gtest/gtest.h>

#include <dgm/deform.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "opened.h"

namespace dgm::test {
namespace {
constexpr double kPi = std::numbers::pi;

/// Largest difference between the weights of a touch at `contact` and the kernel at distance(sample).
double worst_weight(State& state, const DeformTable& table, std::uint32_t contact,
                    const std::function<double(std::uint32_t)>& distance) {
    state.reset();
    Touch touch;
    touch.sample = contact;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Geodesic;
    touch.step = 1;
    const auto done = deform(state, table, touch);
    EXPECT_TRUE(done.ok()) << done.error().message;
    double worst = 0;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        if (!state.on_surface(k)) continue;
        const double got = double{state.positions().z[k]} - state.rest_positions().z[k];
        worst = std::max(worst, std::fabs(got - double{table.profile(static_cast<float>(distance(k)))}));
    }
    return worst;
}

/// Flat triangles around a tip, `turn` between the rays of neighbouring columns; sample (i, j) is i from the tip.
struct Cone {
    std::uint32_t columns;
    double turn;
    std::function<Point(double, double)> place;
    [[nodiscard]] double distance(double r, double j, double s, double k) const {
        double steps = std::fabs(j - k);
        steps = std::min(steps, columns - steps);
        const double angle = steps * turn;
        return angle < kPi ? std::sqrt(r * r + s * s - 2 * r * s * std::cos(angle)) : r + s;
    }
};
/// Rays at `rise` to the plane, up and down by turns if zigzag.
Cone cone(std::uint32_t columns, double rise, bool zigzag) {
    const double step = 2 * kPi / columns, c = std::cos(rise), s = std::sin(rise);
    const auto place = [=](double i, double j) {
        const double up = zigzag && std::lround(j) % 2 == 1 ? -s : s;
        return Point{static_cast<float>(i * c * std::cos(j * step)), static_cast<float>(i * c * std::sin(j * step)),
                     static_cast<float>(i * up)};
    };
    return {columns, std::acos(c * c * std::cos(step) + (zigzag ? -s * s : s * s)), place};
}

TEST(Geodesic, AroundTheTipOfACone) {
    const std::uint32_t m = 16;
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    struct Case {
        Cone cone;
        bool saddle;
    };
    for (const Case& tip : {Case{cone(16, 0.9, false), false}, Case{cone(16, 0.3, true), true},
                            Case{cone(16, 0.08, true), true}, Case{cone(8, 0.6, true), true}}) {
        const Cone& c = tip.cone;
        const std::uint32_t n = c.columns + 1;
        ASSERT_EQ(c.turn * c.columns > 2 * kPi, tip.saddle);
        SeamPairs seams;
        for (std::uint32_t i = 1; i < m; ++i) seams.push_back({i * n, i * n + n - 1});
        for (std::uint32_t j = 1; j < n; ++j) seams.push_back({0, j});
        State state = make_state(grid_chart(m, n, c.place, seams));
        for (const auto& at : {std::array{3, 2}, {1, 0}, {5, 7}, {0, 0}, {2, 5}, {4, 1}}) {
            const int i = at[0], j = at[1];
            EXPECT_LT(worst_weight(state, table, static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j),
                                   [&](std::uint32_t k) { return c.distance(i, j, k / n, k % n); }),
                      0.012)
                << c.turn * c.columns << ": " << i << ' ' << j;
        }
    }
}

/// One and a half turns of the plane around a point, which lies on the border: ways bend around it on either side.
TEST(Geodesic, AroundATipOnTheBorder) {
    const std::uint32_t m = 16, n = 33;
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    const auto angle = [](double i, double j) {
        const double shift = j > 0 && j < n - 1 ? 0.4 * std::sin(1.7 * i) : 0;  // ways to the point are no edges
        return 3 * kPi * (j + shift) / (n - 1);
    };
    SeamPairs seams;
    for (std::uint32_t j = 1; j < n; ++j) seams.push_back({0, j});
    State state = make_state(grid_chart(
        m, n,
        [&](double i, double j) {
            return Point{static_cast<float>(i * std::cos(angle(i, j))), static_cast<float>(i * std::sin(angle(i, j))),
                         0};
        },
        seams));
    for (const auto& [i, j] : {std::array{3, 16}, {1, 16}, {2, 15}, {4, 17}, {3, 3}, {1, 30}, {0, 0}}) {
        const auto distance = [&](std::uint32_t k) {
            const double turn = std::fabs(angle(k / n, k % n) - angle(i, j)), r = k / n;
            return turn < kPi ? std::sqrt(r * r + i * i - 2 * r * i * std::cos(turn)) : r + i;
        };
        const std::uint32_t contact = static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j);
        EXPECT_LT(worst_weight(state, table, contact, distance), 0.012) << i << ' ' << j;
    }
}

/// A cube of side 16 without its bottom: squares around the middle of the top, then down the sides.
TEST(Geodesic, OverTheEdgesOfACube) {
    const double half = 8;
    const std::uint32_t top = 8, m = 2 * top + 1, n = 65;
    const auto place = [&](double i, double j) {
        // Once around the square from its corner (1, -1).
        const double along = 8 * j / (n - 1), side = std::floor(along / 2), t = along - 2 * side - 1;
        const double corners[5][2] = {{1, t}, {-t, 1}, {-1, -t}, {t, -1}, {1, t}};
        const double* p = corners[static_cast<int>(side)];
        const double out = std::min(i / top, 1.0), down = std::max(i - top, 0.0);
        return Point{static_cast<float>(half * out * p[0]), static_cast<float>(half * out * p[1]),
                     static_cast<float>(half - down)};
    };
    SeamPairs seams;
    for (std::uint32_t i = 1; i < m; ++i) seams.push_back({i * n, i * n + n - 1});
    for (std::uint32_t j = 1; j < n; ++j) seams.push_back({0, j});
    State state = make_state(grid_chart(m, n, place, seams));
    const DeformTable table = make_table(12, 9, KernelEnd::Compact);
    const PointView rest = state.rest_positions();
    // From (x, y) on the top to a point: on the top, on a side, on a side by way of the sides beside it. On a convex
    // surface no unfolding is shorter than the shortest way.
    const auto distance = [&](Vec3 from, Vec3 to) {
        if (to.z > 7.9999f) return std::hypot(double{from.x} - to.x, double{from.y} - to.y);
        double best = 1e9;
        for (int turn = 0; turn < 4; ++turn) {  // the side x = half
            const auto turned = [&](Vec3 p) {
                for (int k = 0; k < turn; ++k) p = {p.y, -p.x, p.z};
                return p;
            };
            const Vec3 a = turned(from), b = turned(to);
            const double depth = half - b.z;
            if (b.x > 7.9999f) best = std::min(best, std::hypot(half - a.x + depth, double{a.y} - b.y));
            // Down this side, then around its edge to the sides y = +-half.
            if (b.y > 7.9999f) best = std::min(best, std::hypot(half - a.x + depth, half - a.y + half - b.x));
            if (b.y < -7.9999f) best = std::min(best, std::hypot(half - a.x + depth, half + a.y + half - b.x));
        }
        return best;
    };
    for (const std::uint32_t contact :
         {0u, 3 * n + 5, 7 * n + 1, 6 * n + 16, 7 * n + 63, 8 * n + 16, 8 * n + 21, 5 * n + 30})
        EXPECT_LT(
            worst_weight(state, table, contact, [&](std::uint32_t k) { return distance(rest[contact], rest[k]); }),
            0.012)
            << contact / n << ' ' << contact % n;
}

/// Two arms around an open notch x < 0, y < 0: columns run along both, mitred at row 20.
TEST(Geodesic, BendsAtTheCornerOfANotch) {
    const std::uint32_t m = 41, n = 11;
    const auto place = [](double i, double j) {
        const double out = i <= 20 ? -20 + (20 + j) * i / 20 : -20 + (20 + j) * (40 - i) / 20;
        return i <= 20 ? Point{static_cast<float>(out), static_cast<float>(j), 0}
                       : Point{static_cast<float>(j), static_cast<float>(out), 0};
    };
    State state = make_state(grid_chart(m, n, place));
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    const PointView rest = state.rest_positions();
    const auto distance = [](Vec3 a, Vec3 b) {
        // The line from a to b passes the notch's corner on its inner side.
        const bool apart = std::min(a.x, b.x) < 0 && std::min(a.y, b.y) < 0;
        const double side = double{a.x} * b.y - double{a.y} * b.x;
        const bool cut = apart && (a.x < b.x ? side : -side) > 0;
        return cut ? std::hypot(a.x, a.y) + std::hypot(b.x, b.y) : std::hypot(double{a.x} - b.x, double{a.y} - b.y);
    };
    for (const auto& [i, j] :
         {std::array{16, 0}, {14, 1}, {18, 0}, {20, 0}, {17, 3}, {24, 0}, {27, 2}, {20, 5}, {0, 0}}) {
        const std::uint32_t contact = static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j);
        EXPECT_LT(
            worst_weight(state, table, contact, [&](std::uint32_t k) { return distance(rest[contact], rest[k]); }),
            0.012)
            << i << ' ' << j;
    }
}

/// Folded up and down by 45 degrees along every row of the plane (u, v).
Point pleated(double u, double v, double width) {
    const double pleats = u / width, rest = pleats - 2 * std::floor(pleats / 2), h = std::sqrt(0.5);
    return {static_cast<float>(u * h), static_cast<float>(v),
            static_cast<float>(width * h * (rest < 1 ? rest : 2 - rest))};
}

TEST(Geodesic, SliversOfOneToFifty) {
    const std::uint32_t m = 9, n = 301;
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    for (const double shear : {0.0, 2.0, 5.0}) {
        const auto u = [](double i) { return 7 * i; };
        const auto v = [&](double i, double j) { return j / 7 + shear * i; };
        State state = make_state(grid_chart(m, n, [&](double i, double j) { return pleated(u(i), v(i, j), 7); }));
        for (const auto& at : {std::array{4, 150}, {3, 90}, {5, 210}}) {
            const int i = at[0], j = at[1];
            const auto flat = [&](std::uint32_t k) { return std::hypot(u(k / n) - u(i), v(k / n, k % n) - v(i, j)); };
            EXPECT_LT(
                worst_weight(state, table, static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j), flat),
                0.012)
                << shear << ": " << i << ' ' << j;
        }
    }
}

/// Distances from `contact` of samples in the xy plane.
std::function<double(std::uint32_t)> in_plane(const PointView& rest, std::uint32_t contact) {
    return [=](std::uint32_t k) {
        return std::hypot(double{rest[k].x} - rest[contact].x, double{rest[k].y} - rest[contact].y);
    };
}

/// A flat sheet in which a sample lies on its neighbour, or nearly so: triangles there have no width, and edges no
/// direction.
TEST(Geodesic, BesideSamplesInOnePlace) {
    const std::uint32_t n = 25, middle = 12;
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    for (const double gap : {0.0, 1e-7, 1e-5, 1e-3})
        for (const auto& [di, dj] : {std::array{0, 1}, {1, 0}, {1, 1}}) {
            const auto place = [&](double i, double j) {
                const bool moved = std::lround(i) == middle && std::lround(j) == middle;
                const double share = moved ? 1 - gap : 0;
                return Point{static_cast<float>(i + share * di), static_cast<float>(j + share * dj), 0};
            };
            State state = make_state(grid_chart(n, n, place));
            const PointView rest = state.rest_positions();
            for (const auto& [i, j] : {std::array{12, 12}, {12 + di, 12 + dj}, {11, 12}, {12, 10}, {15, 14}, {6, 12}}) {
                const std::uint32_t contact = static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j);
                EXPECT_LT(worst_weight(state, table, contact, in_plane(rest, contact)), 0.02)
                    << gap << ' ' << di << dj << ": " << i << ' ' << j;
            }
        }
}

/// The same in the strip of a free domain, where the edge may be the first side of one triangle and another of the
/// next: a dent of the border, which no way from the contact bends around.
TEST(Geodesic, BesideABorderSampleOnTheGrid) {
    const std::uint32_t n = 17;
    const auto flat = [](double i, double j) { return Point{static_cast<float>(i), static_cast<float>(j), 0}; };
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    for (const std::size_t turn : {0, 1, 2})
        for (const float gap : {0.0f, 1e-7f, 1e-5f, 1e-3f}) {
            ChartSpec chart = free_chart(n, n, flat);
            const std::uint32_t dented = 8;  // beside (8, 1)
            const float point[3] = {8, 1 - gap, 0};
            std::memcpy(chart.layer("border_geometry").bytes.data() + sizeof point * dented, point, sizeof point);
            std::vector<std::byte>& faces = chart.layer("border_faces").bytes;
            for (std::size_t f = 0; f < faces.size() / 12; f += 2)  // every second triangle begins at another corner
                std::rotate(faces.begin() + 12 * f, faces.begin() + 12 * f + 4 * turn, faces.begin() + 12 * f + 12);
            State state = make_state(chart);
            const PointView rest = state.rest_positions();
            for (const auto& [i, j] : {std::array{8, 3}, {8, 1}, {7, 2}, {9, 4}}) {
                const std::uint32_t contact = static_cast<std::uint32_t>(i) * n + static_cast<std::uint32_t>(j);
                EXPECT_LT(worst_weight(state, table, contact, in_plane(rest, contact)), 0.02)
                    << turn << ' ' << gap << ": " << i << ' ' << j;
            }
        }
}

TEST(Geodesic, AcrossTheSeamOfATube) {
    // Twelve flat sides of width 1.
    const std::uint32_t m = 31, n = 13;
    const double r = 0.5 / std::sin(kPi / 12);
    const auto tube = [&](double i, double j) {
        const double a = 2 * kPi * j / 12;
        return Point{static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i)};
    };
    State state = make_state(grid_chart(m, n, tube, tube_seams(m, n)));
    const DeformTable table = make_table(16, 11, KernelEnd::Compact);
    for (const int jc : {0, 1, 6, 11, 12}) {
        const auto rolled = [&](std::uint32_t k) {
            const double dj = std::fabs(static_cast<double>(k % n) - jc);
            return std::hypot(k / n - 15.0, std::min(dj, 12 - dj));
        };
        EXPECT_LT(worst_weight(state, table, 15 * n + static_cast<std::uint32_t>(jc), rolled), 0.012) << jc;
        for (std::uint32_t i = 0; i < m; ++i)
            ASSERT_TRUE(same_bits(state.positions()[i * n], state.positions()[i * n + 12]));
    }
}

TEST(Geodesic, FreeDomainWithItsStrip) {
    const std::uint32_t m = 26, n = 22;
    State state = make_state(free_chart(m, n, [](double i, double j) { return pleated(i, j, 1); }));
    const DeformTable table = make_table(10, 8, KernelEnd::Compact);
    // The plane (u, v) of a sample: v is y, and u is x over the pleats' slope.
    const auto at = [&](std::uint32_t k) {
        const Vec3 p = state.rest_positions()[k];
        return std::array{double{p.x} * std::sqrt(2.0), double{p.y}};
    };
    for (const std::uint32_t contact :
         {12 * n + 10, 1 * n + 1, 2 * n + 9, m * n, m * n + 17, m * n + 40, 24 * n + 20}) {
        ASSERT_TRUE(state.on_surface(contact));
        const auto flat = [&](std::uint32_t k) {
            return std::hypot(at(k)[0] - at(contact)[0], at(k)[1] - at(contact)[1]);
        };
        EXPECT_LT(worst_weight(state, table, contact, flat), 0.012) << contact;
    }
}

/// No distance to compare with: ends in time, weights lie in 0 .. 1, copies move alike.
void survives(const ChartSpec& chart) {
    State state = make_state(chart);
    const DeformTable table = make_table(60, 22, KernelEnd::Compact);
    Touch touch;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Geodesic;
    for (const float step : {0.0f, 0.3f, 1e-6f, kMaxStep, kMinStep})
        for (std::uint32_t k = 0; k < state.sample_count(); k += 37) {
            state.reset();
            touch.sample = k;
            touch.step = step;
            if (!state.on_surface(k)) continue;
            ASSERT_TRUE(deform(state, table, touch).ok());
            for (std::uint32_t v = 0; v < state.sample_count(); ++v) {
                const float before = state.rest_positions().z[v], after = state.positions().z[v];
                ASSERT_TRUE(after >= before && after <= before + 1.001f) << v;
            }
            for (std::uint32_t id = 0; id < state.class_count(); ++id)
                for (const std::uint32_t copy : state.class_members(id))
                    ASSERT_TRUE(same_bits(state.positions()[copy], state.positions()[state.class_members(id)[0]]));
        }
}

TEST(Geodesic, SurvivesHostileSurfaces) {
    const std::uint32_t side = 25;
    std::mt19937 random(3);
    const auto noise = [&] { return std::uniform_real_distribution<float>(-1, 1)(random); };
    const auto rough = [&](double i, double j) {
        return Point{static_cast<float>(i) + 5 * noise(), static_cast<float>(j) + 5 * noise(), 5 * noise()};
    };
    const auto wild = [&](double, double) {
        return Point{1e18f * noise(), 1e18f * noise(), random() % 2 == 0 ? 1e18f * noise() : 1e-18f * noise()};
    };
    const auto spikes = [&](double i, double j) {
        return Point{static_cast<float>(i), static_cast<float>(j), random() % 9 == 0 ? 1e18f : 0};
    };
    const auto lumps = [](double i, double j) {  // of coincident samples
        return Point{static_cast<float>(std::floor(i / 3)), static_cast<float>(std::floor(j / 4)), 0};
    };
    const auto line = [](double i, double j) { return Point{static_cast<float>(i + j), 0, 0}; };
    const auto point = [](double, double) { return Point{}; };
    // Three sides are one edge: edges with three faces, and a fan of 75 at corner 0.
    SeamPairs three;
    for (std::uint32_t k = 1; k < side; ++k) {
        three.push_back({k, k * side});
        if (k + 1 < side) three.push_back({k, (side - 1) * side + k});
    }
    for (const std::function<Point(double, double)>& f :
         {std::function<Point(double, double)>(rough), {wild}, {spikes}, {lumps}, {line}, {point}}) {
        survives(grid_chart(side, side, f));
        survives(grid_chart(side, side, f, octahedral_seams(side)));
        survives(grid_chart(side, side, f, three));
        survives(free_chart(side, side, f));
    }
}

}  // namespace
}  // namespace dgm::test
