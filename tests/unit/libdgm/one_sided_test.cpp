// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/one_sided_test.cpp
// Surfaces with one side: seams whose two sides wind against each other. Copies keep one place, to the bit, and
// opposite normals, to the bit, whatever touches them; nothing is averaged away across the seam; there is no volume.
#include <gtest/gtest.h>

#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/dgm.h>
#include <dgm/tick.h>
#include <dgm/validate.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "opened.h"

namespace dgm::test {
namespace {

using Random = std::mt19937;
constexpr double kTurn = 2 * std::numbers::pi;

double uniform(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

struct OneSided {
    const char* name;
    ChartSpec chart;
    SeamPairs seams;
    std::vector<std::uint8_t> reversed;  ///< of each pair
};

OneSided one_sided(const char* name, std::uint32_t m, std::uint32_t n, const std::function<Point(double, double)>& f,
                   SeamPairs seams, std::vector<std::uint8_t> reversed) {
    OneSided out{name, grid_chart(m, n, f, seams), std::move(seams), std::move(reversed)};
    out.chart.add("reversed", ElementType::kU8, {out.reversed.size()}, out.reversed, layout::kLayerRequired);
    return out;
}

Point point(double x, double y, double z) {
    return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

/// Row i around the strip, column j across it; the last row lies on the first one, upside down.
Point on_strip(double i, double j, double rows, double cols) {
    const double a = kTurn * i / (rows - 1), w = 0.5 * (2 * j / (cols - 1) - 1), r = 1 + w * std::cos(a / 2);
    return point(r * std::cos(a), r * std::sin(a), w * std::sin(a / 2));
}
OneSided moebius(std::uint32_t m, std::uint32_t n) {
    SeamPairs seams;
    for (std::uint32_t j = 0; j < n; ++j) seams.push_back({j, m * n - 1 - j});
    return one_sided(
        "Moebius strip", m, n, [=](double i, double j) { return on_strip(i, j, m, n); }, seams,
        std::vector<std::uint8_t>(n, 1));
}

/// Immersed as a figure 8: columns meet as on a tube, rows upside down.
OneSided klein_bottle(std::uint32_t m, std::uint32_t n) {
    SeamPairs seams;
    std::vector<std::uint8_t> reversed;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint8_t r) {
        seams.push_back({a, b});
        reversed.push_back(r);
    };
    for (std::uint32_t i = 1; i + 1 < m; ++i) add(i * n, i * n + n - 1, 0);
    for (std::uint32_t j = 1; j + 1 < n; ++j) add(j, m * n - 1 - j, 1);
    add(0, n - 1, 0);
    add(0, (m - 1) * n, 1);
    add(0, m * n - 1, 1);
    return one_sided(
        "Klein bottle", m, n,
        [=](double i, double j) {
            const double u = kTurn * i / (m - 1), v = kTurn * j / (n - 1), x = std::sin(v), y = std::sin(2 * v);
            const double r = 3 + std::cos(u / 2) * x - std::sin(u / 2) * y;
            return point(r * std::cos(u), r * std::sin(u), std::sin(u / 2) * x + std::cos(u / 2) * y);
        },
        seams, reversed);
}

/// Boy's surface [Bryant, Kusner]: a square laid on the disk |w| <= 1, border points w and -w being one.
OneSided projective_plane(std::uint32_t n) {
    std::vector<std::uint32_t> cycle;
    for (std::uint32_t i = 0; i + 1 < n; ++i) cycle.push_back(i * n);
    for (std::uint32_t j = 0; j + 1 < n; ++j) cycle.push_back((n - 1) * n + j);
    for (std::uint32_t i = n - 1; i > 0; --i) cycle.push_back(i * n + n - 1);
    for (std::uint32_t j = n - 1; j > 0; --j) cycle.push_back(j);
    SeamPairs seams;
    const std::size_t half = cycle.size() / 2;
    for (std::size_t t = 0; t < half; ++t)
        seams.push_back({std::min(cycle[t], cycle[t + half]), std::max(cycle[t], cycle[t + half])});
    OneSided out = one_sided(
        "projective plane", n, n,
        [=](double i, double j) {
            const double x = 2 * i / (n - 1) - 1, y = 2 * j / (n - 1) - 1;
            const double largest = std::max(std::fabs(x), std::fabs(y)), length = std::hypot(x, y);
            const std::complex<double> w = length > 0 ? std::complex<double>(x, y) * (largest / length) : 0.0;
            const std::complex<double> w3 = w * w * w, below = w3 * w3 + std::sqrt(5.0) * w3 - 1.0;
            const double gx = -1.5 * (w * (1.0 - w3 * w) / below).imag(),
                         gy = -1.5 * (w * (1.0 + w3 * w) / below).real(), gz = ((1.0 + w3 * w3) / below).imag() - 0.5;
            const double squared = gx * gx + gy * gy + gz * gz;
            return point(gx / squared, gy / squared, gz / squared);
        },
        seams, std::vector<std::uint8_t>(half, 1));
    // With one triangle at each of two corners that are one point, these two would have the same corners.
    std::vector<std::uint8_t> diagonals(std::size_t{n - 1} * (n - 1), 0);
    diagonals[n - 2] = diagonals[std::size_t{n - 2} * (n - 1)] = 1;
    out.chart.add("diagonals", ElementType::kU8, {n - 1, n - 1}, diagonals);
    return out;
}

/// A Moebius strip of a free domain: the strip's border samples at the two ends are one, in opposite order.
OneSided free_moebius(std::uint32_t m, std::uint32_t n) {
    const auto f = [=](double i, double j) { return on_strip(i - 0.5, j - 0.5, m - 1, n - 1); };
    // Border samples in the order of free_chart(): m along j = 0.5, then n - 2 more to the corner at i = m - 1.5, ...
    const std::uint32_t first = m * n, end = first + m - 1;  // the corners (0.5, 0.5) and (m - 1.5, 0.5)
    const std::uint32_t count = 2 * (m - 1) + 2 * (n - 1);
    SeamPairs seams;
    std::vector<std::uint8_t> reversed;
    for (std::uint32_t k = 0; k < n; ++k) {
        // (0.5, k-th place) meets (m - 1.5, the k-th from the other end); both run over n places.
        const std::uint32_t near = k == 0 ? first : first + count - k, far = end + (n - 1 - k);
        seams.push_back({std::min(near, far), std::max(near, far)});
        reversed.push_back(1);
    }
    OneSided out{"free Moebius strip", free_chart(m, n, f, seams), seams, reversed};
    out.chart.add("reversed", ElementType::kU8, {reversed.size()}, reversed, layout::kLayerRequired);
    return out;
}

std::vector<OneSided> all_shapes() {
    std::vector<OneSided> out;
    out.push_back(moebius(33, 9));
    out.push_back(klein_bottle(33, 25));
    out.push_back(projective_plane(25));
    out.push_back(free_moebius(30, 9));
    return out;
}

bool opposite(Vec3 a, Vec3 b) {
    return a.x == -b.x && a.y == -b.y && a.z == -b.z;
}

/// The promise at each seam, and that no normal has vanished.
void expect_whole(const State& state, const OneSided& shape) {
    const PointView p = state.positions(), n = state.normals();
    for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
        if (!state.on_surface(s)) continue;
        ASSERT_TRUE(std::isfinite(p.x[s]) && std::isfinite(p.y[s]) && std::isfinite(p.z[s])) << "sample " << s;
        ASSERT_NEAR(dot(n[s], n[s]), 1, 1e-5) << "sample " << s;
        const Vec3 now = state.normal(s);
        ASSERT_LT(std::sqrt(dot(now - n[s], now - n[s])), 1e-5) << "sample " << s;
    }
    for (std::size_t k = 0; k < shape.seams.size(); ++k) {
        const auto [a, b] = shape.seams[k];
        ASSERT_TRUE(same_bits(p[a], p[b])) << "pair " << k;
        ASSERT_TRUE(shape.reversed[k] != 0 ? opposite(n[a], n[b]) : same_bits(n[a], n[b])) << "pair " << k;
        const Vec3 one = state.normal(a), other = state.normal(b);
        ASSERT_TRUE(shape.reversed[k] != 0 ? opposite(one, other) : same_bits(one, other)) << "pair " << k;
    }
}

TEST(OneSided, CopiesAtRestHaveOppositeNormalsOfFullLength) {
    for (const OneSided& shape : all_shapes()) {
        SCOPED_TRACE(shape.name);
        State state = make_state(shape.chart);
        state.update_normals();
        ASSERT_NO_FATAL_FAILURE(expect_whole(state, shape));
    }
}

/// The strip is smooth: across the seam the normal turns no more than between any two rows.
TEST(OneSided, NormalsGoOnSmoothlyThroughTheSeam) {
    const std::uint32_t m = 65, n = 9;
    State state = make_state(moebius(m, n).chart);
    state.update_normals();
    const PointView normals = state.normals();
    double inside = 0, at_seam = 0;
    for (std::uint32_t j = 1; j + 1 < n; ++j) {
        for (std::uint32_t i = 1; i + 2 < m; ++i)
            inside = std::max(inside, 1.0 - dot(normals[i * n + j], normals[(i + 1) * n + j]));
        at_seam = std::max(at_seam, 1.0 - dot(normals[j], normals[n + j]));
        at_seam = std::max(at_seam, 1.0 - dot(normals[(m - 1) * n + j], normals[(m - 2) * n + j]));
    }
    EXPECT_LT(at_seam, 1.5 * inside);
    EXPECT_GT(inside, 0);
}

Touch random_touch(Random& random, const State& state, const OneSided& shape) {
    Touch touch;
    do {  // half of them on the seam
        const auto& pair = shape.seams[random() % shape.seams.size()];
        touch.sample =
            random() % 2 == 0 ? pair[random() % 2] : static_cast<std::uint32_t>(random() % state.sample_count());
    } while (!state.on_surface(touch.sample));
    const float by = static_cast<float>(uniform(random, -2, 2)) * state.mean_step();
    touch.displacement = by * state.normal(touch.sample);
    touch.d_max = 3 * state.mean_step();
    touch.footprint = std::array{Footprint::Surface, Footprint::Geodesic, Footprint::Grid}[random() % 3];
    touch.mode = random() % 3 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
    return touch;
}

TEST(OneSided, CopiesStayOneThroughThousandsOfTouches) {
    Random random(5);
    for (const OneSided& shape : all_shapes()) {
        SCOPED_TRACE(shape.name);
        State state = make_state(shape.chart, 7);
        ContactSolver solver = ContactSolver::create(state).value();
        const DeformTable table = make_table(4, 7);
        for (int round = 0; round < 1000; ++round) {
            SCOPED_TRACE(round);
            if (random() % 5 == 0) {
                Obstacle ball;
                ball.kind = ObstacleKind::Sphere;
                const auto& pair = shape.seams[random() % shape.seams.size()];
                ball.point = state.positions()[pair[0]];
                ball.radius = 1.5f * state.mean_step();
                const auto report = resolve_contact(state, solver, ball);
                ASSERT_TRUE(report.ok()) << report.error().message;
                ASSERT_NE(report.value().status, ContactStatus::Contact) << "there is no volume to keep";
            } else {
                const Touch touch = random_touch(random, state, shape);
                const auto done = deform(state, table, touch);
                ASSERT_TRUE(done.ok()) << done.error().message;
            }
            if (round % 4 == 0) {
                state.update_normals();
                ASSERT_NO_FATAL_FAILURE(expect_whole(state, shape));
            }
            if (random() % 6 == 0) { ASSERT_TRUE(state.relax(0.01f, 30).ok()); }
            if (random() % 12 == 0) state.reset();
        }
    }
}

/// The quick way of a tick computes normals of its own.
TEST(OneSided, TicksAtTheSeamKeepCopiesOne) {
    Random random(7);
    for (const OneSided& shape : all_shapes()) {
        SCOPED_TRACE(shape.name);
        State state = make_state(shape.chart, 7);
        state.update_normals();
        const DeformTable table = make_table(4, 7);
        for (int stroke = 0; stroke < 40; ++stroke) {
            const auto& pair = shape.seams[random() % shape.seams.size()];
            const std::uint32_t sample = pair[0];
            ToolInput tool;
            tool.kind = ToolKind::Grasp;
            for (int step = 0; step < 12; ++step) {
                SCOPED_TRACE(std::to_string(stroke) + ", " + std::to_string(step));
                const float depth = 0.1f * static_cast<float>(step) * state.mean_step();
                tool.position = state.rest_positions()[sample] + depth * Vec3{0.3f, -0.5f, 0.8f};
                TickOptions options;
                options.d_max = 3 * state.mean_step();
                ASSERT_TRUE(tick(state, table, options, {&tool, 1}, {}).ok());
                ASSERT_NO_FATAL_FAILURE(expect_whole(state, shape));
            }
            tool.engaged = false;
            ASSERT_TRUE(tick(state, table, {}, {&tool, 1}, {}).ok());
        }
    }
}

TEST(OneSided, APushAtOneCopyIsAPushAtTheOther) {
    for (const OneSided& shape : all_shapes()) {
        SCOPED_TRACE(shape.name);
        State one = make_state(shape.chart, 7), other = make_state(shape.chart, 7);
        const DeformTable table = make_table(4, 7);
        for (const auto& [a, b] : shape.seams)
            for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic}) {
                Touch touch;
                touch.sample = a;
                touch.displacement = one.mean_step() * Vec3{0.2f, 0.5f, -0.7f};
                touch.d_max = 10 * one.mean_step();
                touch.footprint = footprint;
                const auto report = deform(one, table, touch);
                touch.sample = b;
                ASSERT_TRUE(report.ok() && deform(other, table, touch).ok());
                EXPECT_TRUE(report.value().crossed_seam);
                for (std::uint32_t s = 0; s < one.sample_count(); ++s)
                    ASSERT_TRUE(same_bits(one.positions()[s], other.positions()[s])) << s;
                one.release();
                other.release();
            }
    }
}

/// The same strip opened at another place: a touch where one chart has its seam lies inside the other chart.
TEST(OneSided, FootprintsCrossTheSeamAsIfItWereNotThere) {
    const std::uint32_t m = 65, n = 17, shift = 20;
    const OneSided here = moebius(m, n);
    const OneSided there = [&] {
        OneSided out = here;
        // Rows from `shift` on come first; those before it follow, beyond the seam of the other chart and so mirrored.
        const auto f = [&](double i, double j) {
            const double row = i + shift;
            return row < m ? on_strip(row, j, m, n) : on_strip(row - (m - 1), n - 1 - j, m, n);
        };
        out.chart = grid_chart(m, n, f, out.seams);
        return out;
    }();
    State a = make_state(here.chart, 9), b = make_state(there.chart, 9);
    const DeformTable table = make_table(9, 9);
    const auto in_b = [&](std::uint32_t i, std::uint32_t j) {
        return i >= shift ? (i - shift) * n + j : (i + m - 1 - shift) * n + (n - 1 - j);
    };
    for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic})
        for (const std::uint32_t j : {3u, 8u, 12u}) {
            Touch touch;
            touch.displacement = {0, 0, 1};
            touch.d_max = 1;
            touch.footprint = footprint;
            touch.sample = j;
            touch.step = a.mean_step();
            ASSERT_TRUE(deform(a, table, touch).ok());
            touch.sample = in_b(0, j);
            ASSERT_TRUE(deform(b, table, touch).ok());
            double largest = 0, moved_beyond = 0;
            for (std::uint32_t i = 0; i < m; ++i)
                for (std::uint32_t k = 0; k < n; ++k) {
                    const float da = a.positions().z[i * n + k] - a.rest_positions().z[i * n + k];
                    const float db = b.positions().z[in_b(i, k)] - b.rest_positions().z[in_b(i, k)];
                    largest = std::max(largest, double{std::fabs(da - db)});
                    if (i + 8 > m) moved_beyond = std::max(moved_beyond, double{da});
                }
            // The diagonals of the mirrored part run the other way, so ways over the surface differ a little.
            EXPECT_LT(largest, footprint == Footprint::Surface ? 0.06 : 0.02);
            EXPECT_GT(moved_beyond, 0.5) << "rows on the other side of the seam move";
            a.release();
            b.release();
        }
}

TEST(OneSided, VolumeIsRefusedByName) {
    for (const OneSided& shape : all_shapes()) {
        SCOPED_TRACE(shape.name);
        State state = make_state(shape.chart);
        const ContactSolver solver = ContactSolver::create(state).value();
        EXPECT_FALSE(solver.closed());
        EXPECT_EQ(solver.volume(state), 0);
        const auto volume = solver.enclosed_volume(state);
        ASSERT_FALSE(volume.ok());
        EXPECT_EQ(volume.error().code, ErrorCode::Unsupported);
        EXPECT_STREQ(volume.error().message, "the surface has one side, so it encloses no volume");
    }
    State open = make_state(grid_chart(5, 5, sheet));
    const auto volume = ContactSolver::create(open).value().enclosed_volume(open);
    ASSERT_FALSE(volume.ok());
    EXPECT_STREQ(volume.error().message, "the surface has a border, so it encloses no volume");
}

TEST(OneSided, TheCInterfaceRefusesTheVolumeToo) {
    const Bytes bytes = build({klein_bottle(17, 13).chart}).bytes;
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    dgm_contact_solver* solver = nullptr;
    ASSERT_EQ(dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, nullptr, &asset, nullptr), DGM_OK);
    ASSERT_EQ(dgm_state_create(asset, 0, nullptr, nullptr, &state, nullptr), DGM_OK);
    ASSERT_EQ(dgm_contact_solver_create(state, nullptr, &solver, nullptr), DGM_OK);
    EXPECT_EQ(dgm_contact_solver_closed(solver), 0u);
    dgm_error error{};
    error.struct_size = sizeof error;
    double volume = 7;
    EXPECT_EQ(dgm_contact_solver_enclosed_volume(solver, state, &volume, &error), DGM_UNSUPPORTED);
    EXPECT_STREQ(error.message, "the surface has one side, so it encloses no volume");
    EXPECT_EQ(volume, 7);
    EXPECT_EQ(dgm_contact_solver_enclosed_volume(solver, state, nullptr, nullptr), DGM_BAD_ARGUMENT);
    dgm_contact_solver_destroy(solver);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
}

TEST(OneSided, ALayerOfAnotherLengthThanTheSeamsIsRefused) {
    OneSided strip = moebius(9, 5);
    LayerSpec& layer = strip.chart.layer("reversed");
    layer.shape = {4};
    layer.bytes.resize(4);
    const Opened opened(build({strip.chart}));
    const auto valid = validate_chart(opened.chart());
    ASSERT_FALSE(valid.ok());
    EXPECT_EQ(valid.error().code, ErrorCode::BadSeamTable);
    EXPECT_EQ(State::create(opened.chart()).error().code, ErrorCode::BadSeamTable);
}

/// Seams that join alike on both sides are as before: the layer may be there, and say so.
TEST(OneSided, ALayerOfZerosChangesNothing) {
    SeamPairs seams;
    const std::uint32_t m = 12, n = 13;
    for (std::uint32_t i = 0; i < m; ++i) seams.push_back({i * n, i * n + n - 1});
    const auto tube = [=](double i, double j) {
        return point(std::cos(kTurn * j / (n - 1)), std::sin(kTurn * j / (n - 1)), i);
    };
    const ChartSpec plain = grid_chart(m, n, tube, seams);
    ChartSpec told = plain;
    told.add("reversed", ElementType::kU8, {seams.size()}, std::vector<std::uint8_t>(seams.size(), 0));
    State a = make_state(plain), b = make_state(told);
    for (std::uint32_t s = 0; s < m * n; ++s) ASSERT_TRUE(same_bits(a.normals()[s], b.normals()[s]));
}

}  // namespace
}  // namespace dgm::test
