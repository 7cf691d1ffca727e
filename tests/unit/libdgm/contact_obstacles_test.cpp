// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/contact_obstacles_test.cpp
// Every kind of obstacle: distances against formulas written out here, contacts that keep volume, open surfaces.
#include <gtest/gtest.h>

#include <random>

#include "contact_shapes.h"

namespace dgm::test {
namespace {

constexpr float kTurn[9] = {0.8f, -0.6f, 0, 0.6f, 0.8f, 0, 0, 0, 1};

std::vector<Vec3> random_points(int count, float size) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> u(-size, size);
    std::vector<Vec3> points;
    for (int k = 0; k < count; ++k) points.push_back({u(random), u(random), u(random)});
    return points;
}

TEST(Obstacle, RoundAndBoxedDistances) {
    Obstacle sphere{.kind = ObstacleKind::Sphere, .point = {1, 2, 3}, .radius = 0.5f};
    Obstacle capsule{.kind = ObstacleKind::Capsule, .point = {-1, 0, 0}, .end = {1, 0, 0}, .radius = 0.5f};
    Obstacle box{.kind = ObstacleKind::Box, .point = {0.5f, 0, 0}, .half = {1, 2, 0.5f}};
    std::copy_n(kTurn, 9, box.rotation);
    for (const Vec3 p : random_points(500, 3)) {
        const double to_centre = std::hypot(double(p.x) - 1, double(p.y) - 2, double(p.z) - 3);
        EXPECT_NEAR(obstacle_distance(sphere, p).value().distance, to_centre - 0.5, 1e-5);
        const double along = std::clamp(double(p.x), -1.0, 1.0);
        EXPECT_NEAR(obstacle_distance(capsule, p).value().distance, std::hypot(p.x - along, p.y, p.z) - 0.5, 1e-5);
        // Into the box's frame: the transpose of the turn.
        const double x = p.x - 0.5, y = p.y;
        const double q[3] = {0.8 * x + 0.6 * y, -0.6 * x + 0.8 * y, p.z}, h[3] = {1, 2, 0.5};
        double out = 0, in = -1e9;
        for (int k = 0; k < 3; ++k) {
            out += std::pow(std::max(std::fabs(q[k]) - h[k], 0.0), 2);
            in = std::max(in, std::fabs(q[k]) - h[k]);
        }
        const auto d = obstacle_distance(box, p).value();
        EXPECT_NEAR(d.distance, out > 0 ? std::sqrt(out) : in, 1e-5);
        const Vec3 way = p - d.nearest;
        EXPECT_NEAR(std::sqrt(double(dot(way, way))), std::fabs(d.distance), 1e-5);
        EXPECT_NEAR(obstacle_distance(box, d.nearest).value().distance, 0, 1e-5);
    }
}

/// Nearest triangle by trying all, sign by the winding number (solid angles).
double slow_distance(const State& s, const Triangles& t, Vec3 at) {
    const PointView p = s.positions();
    double nearest = 1e300, angle = 0;
    const auto sub = [](Vec3 a, Vec3 b) {
        return std::array<double, 3>{double(a.x) - b.x, double(a.y) - b.y, double(a.z) - b.z};
    };
    const auto in = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    for (std::size_t k = 0; k < t.indices.size(); k += 3) {
        const Vec3 v[3] = {p[t.indices[k]], p[t.indices[k + 1]], p[t.indices[k + 2]]};
        const auto a = sub(v[0], at), b = sub(v[1], at), c = sub(v[2], at);
        const double la = std::sqrt(in(a, a)), lb = std::sqrt(in(b, b)), lc = std::sqrt(in(c, c));
        const double det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                           a[2] * (b[0] * c[1] - b[1] * c[0]);
        angle += 2 * std::atan2(det, la * lb * lc + in(a, b) * lc + in(b, c) * la + in(c, a) * lb);
        // The plane's foot if it lies inside, else the edges.
        const auto e = sub(v[1], v[0]), f = sub(v[2], v[0]);
        const double ee = in(e, e), ff = in(f, f), ef = in(e, f), ae = -in(a, e), af = -in(a, f);
        const double d = ee * ff - ef * ef;
        if (d > 0) {
            const double x = (ff * ae - ef * af) / d, y = (ee * af - ef * ae) / d;
            if (x >= 0 && y >= 0 && x + y <= 1) nearest = std::min(nearest, std::fabs(det) / std::sqrt(d));
        }
        for (int k0 = 0; k0 < 3; ++k0) {
            const auto o = sub(v[k0], at), w = sub(v[(k0 + 1) % 3], v[k0]);
            const double ww = in(w, w), s0 = ww > 0 ? std::clamp(-in(o, w) / ww, 0.0, 1.0) : 0;
            const std::array<double, 3> q{o[0] + s0 * w[0], o[1] + s0 * w[1], o[2] + s0 * w[2]};
            nearest = std::min(nearest, std::sqrt(in(q, q)));
        }
    }
    return angle > 2 * 3.14159265 ? -nearest : nearest;
}

/// A body with a waist and sharp ridges, so that edges and corners are often nearest.
ChartSpec body_chart(std::uint32_t side) {
    return closed_chart(side, [](std::array<double, 3> n) {
        const double r = 0.6 + 0.4 * n[0] * n[0] + 0.15 * std::fabs(std::sin(5 * n[1]));
        return std::array<double, 3>{r * n[0], r * n[1], r * n[2]};
    });
}

TEST(Obstacle, SurfaceDistanceIsExact) {
    State body = make_state(body_chart(33));
    const Triangles triangles(body);
    Obstacle o{.kind = ObstacleKind::Surface, .surface = &body};
    int inside = 0;
    for (const bool dented : {false, true}) {
        if (dented) {
            Touch touch;
            touch.sample = 33 * 16 + 16;
            touch.displacement = {0, 0, -0.4f};
            touch.d_max = 1;
            ASSERT_TRUE(deform(body, DeformTable::create({}).value(), touch).ok());
        }
        for (const Vec3 p : random_points(400, 1.1f)) {
            const double slow = slow_distance(body, triangles, p);
            ASSERT_NEAR(obstacle_distance(o, p).value().distance, slow, 2e-6) << p.x << ' ' << p.y << ' ' << p.z;
            inside += slow < 0 ? 1 : 0;
        }
    }
    EXPECT_GT(inside, 100);
}

/// A flat body with eight long points, needles of two sheets: near their ends a corner is nearest to much of the space.
ChartSpec star_chart(std::uint32_t side, bool is_free) {
    const auto place = [](std::array<double, 3> n) {
        const double around = std::atan2(n[1], n[0]);
        const double r = 0.25 + 0.9 * std::pow(std::fabs(std::cos(4 * around + 0.3)), 12) * (1 - n[2] * n[2]);
        return std::array<double, 3>{r * n[0], r * n[1], 0.15 * r * n[2] + 0.1 * n[0] * n[1]};
    };
    if (!is_free) return closed_chart(side, place);
    return closed_free_chart(side, [&](const std::array<double, 3>& n) {
        const std::array<double, 3> p = place(n);
        return Point{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
    });
}

TEST(Obstacle, NeedlesHaveNoInsideBeyondTheirPoints) {
    for (const bool is_free : {false, true}) {
        SCOPED_TRACE(is_free);
        State body = make_state(star_chart(41, is_free));
        const Triangles triangles(body);
        const Obstacle o{.kind = ObstacleKind::Surface, .surface = &body};
        int inside = 0;
        std::vector<Vec3> points = random_points(1500, 1.6f);
        for (const Vec3 p : random_points(1500, 0.4f)) points.push_back({2 * p.x, 2 * p.y, 0.3f * p.z});
        for (const Vec3 p : points) {
            const double slow = slow_distance(body, triangles, p);
            ASSERT_NEAR(obstacle_distance(o, p).value().distance, slow, 2e-6) << p.x << ' ' << p.y << ' ' << p.z;
            inside += slow < 0 ? 1 : 0;
        }
        EXPECT_GT(inside, 50);
    }
}

TEST(Obstacle, PosedSurfaceTurnsWithItsFrame) {
    State body = make_state(body_chart(33));
    Obstacle own{.kind = ObstacleKind::Surface, .surface = &body}, posed = own;
    posed.point = {3, -1, 2};
    std::copy_n(kTurn, 9, posed.rotation);
    for (const Vec3 p : random_points(100, 1.1f)) {
        const Vec3 there{3 + 0.8f * p.x - 0.6f * p.y, -1 + 0.6f * p.x + 0.8f * p.y, 2 + p.z};
        EXPECT_NEAR(obstacle_distance(posed, there).value().distance, obstacle_distance(own, p).value().distance, 2e-6);
    }
}

/// A unit sphere pressed against each kind of obstacle keeps its volume, stays outside, and its seams closed.
class SphereAgainst : public testing::TestWithParam<ObstacleKind> {};

TEST_P(SphereAgainst, KeepsItsVolumeOutside) {
    State state = make_state(sphere_chart(65)), body = make_state(body_chart(33));
    const ContactSolver solver = ContactSolver::create(state).value();
    const Triangles triangles(state);
    const double before = triangles.volume(state);
    Obstacle o{.kind = GetParam()};
    switch (GetParam()) {
        case ObstacleKind::Plane:
            o.point = {0, 0, -0.9f};
            break;
        case ObstacleKind::Sphere:
            o.point = {1.3f, 0.2f, 0.1f};
            o.radius = 0.45f;
            break;
        case ObstacleKind::Capsule:
            o.point = {-1, 1.05f, -0.4f};
            o.end = {1, 1.05f, 0.2f};
            o.radius = 0.2f;
            break;
        case ObstacleKind::Box:
            o.point = {0, 0, 1.2f};
            o.half = {0.5f, 0.4f, 0.3f};
            std::copy_n(kTurn, 9, o.rotation);
            break;
        case ObstacleKind::Surface:
            o.point = {0, 0, 1.4f};
            o.surface = &body;
            break;
    }
    const auto done = resolve_contact(state, solver, o);
    ASSERT_TRUE(done.ok()) << done.error().message;
    const ContactReport& r = done.value();
    EXPECT_EQ(r.status, ContactStatus::Contact);
    EXPECT_GT(r.samples, 20u);
    EXPECT_GT(r.removed, 1e-4);
    EXPECT_LE(std::fabs(triangles.volume(state) - before), 1e-6 * r.removed) << r.passes;
    EXPECT_TRUE(r.volume_kept);
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        ASSERT_GT(obstacle_distance(o, state.positions()[k]).value().distance, -2e-6) << k;
    expect_closed_seams(state);
    State far_away = make_state(sphere_chart(33));
    o.point = o.point + Vec3{0, 0, -50};
    o.end = o.end + Vec3{0, 0, -50};
    EXPECT_EQ(resolve_contact(state, solver, o).value().status, ContactStatus::Clear);
}
INSTANTIATE_TEST_SUITE_P(Kinds, SphereAgainst,
                         testing::Values(ObstacleKind::Plane, ObstacleKind::Sphere, ObstacleKind::Capsule,
                                         ObstacleKind::Box, ObstacleKind::Surface));

TEST(Contact, OpenSheetIsSmoothedAndSaysSo) {
    for (const bool is_free : {false, true}) {
        SCOPED_TRACE(is_free);
        const auto flat = [](double i, double j) { return Point{float(i), float(j), 0}; };
        State state = make_state(is_free ? free_chart(41, 41, flat) : grid_chart(41, 41, flat));
        const ContactSolver solver = ContactSolver::create(state).value();
        EXPECT_FALSE(solver.closed());
        const Obstacle ball{.kind = ObstacleKind::Sphere, .point = {20.2f, 19.7f, -6}, .radius = 8};
        ContactOptions plain;
        plain.smoothing = 0;
        const auto bend = [&] {  // largest change of slope along a row
            double most = 0;
            const PointView p = state.positions();
            for (std::uint32_t j = 2; j < 39; ++j) {
                const std::uint32_t k = 20 * 41 + j;
                most = std::max(most, std::fabs(double(p.z[k - 1]) - 2 * p.z[k] + p.z[k + 1]));
            }
            return most;
        };
        EXPECT_EQ(resolve_contact(state, solver, ball, plain).value().status, ContactStatus::Open);
        const double sharp = bend();
        state.release();
        const auto r = resolve_contact(state, solver, ball).value();
        EXPECT_EQ(r.status, ContactStatus::Open);
        EXPECT_FALSE(r.volume_kept);
        EXPECT_EQ(r.removed, 0);
        EXPECT_LT(bend(), 0.7 * sharp);
        for (std::uint32_t k = 0; k < state.sample_count(); ++k)
            if (state.on_surface(k)) {
                ASSERT_GT(obstacle_distance(ball, state.positions()[k]).value().distance, -2e-6) << k;
            }
    }
}

TEST(Contact, CoverEndsOutsideTheBodyUnderIt) {
    State body = make_state(body_chart(33));
    // Waves about the body's surface: half of the cover is sunk.
    const auto waves = [](double i, double j) {
        const double x = (i - 24) / 48, y = (j - 24) / 48, length = std::sqrt(x * x + y * y + 1);
        const double nx = x / length, ny = y / length;
        const double r = 0.6 + 0.4 * nx * nx + 0.15 * std::fabs(std::sin(5 * ny)) + 0.02 * std::sin(19 * x + 8 * y);
        return Point{static_cast<float>(r * nx), static_cast<float>(r * ny), static_cast<float>(r / length)};
    };
    State cover = make_state(grid_chart(49, 49, waves));
    const ContactSolver solver = ContactSolver::create(cover).value();
    const Obstacle o{.kind = ObstacleKind::Surface, .point = {0.01f, 0, 0}, .surface = &body};
    for (const std::uint32_t rounds : {1u, 2u, 24u}) {
        cover.release();
        ContactOptions options;
        options.smoothing = rounds;
        const auto r = resolve_contact(cover, solver, o, options).value();
        EXPECT_EQ(r.status, ContactStatus::Open);
        EXPECT_GT(r.samples, 700u);
        EXPECT_LT(r.samples, 1700u);
        for (std::uint32_t k = 0; k < cover.sample_count(); ++k)
            ASSERT_GT(obstacle_distance(o, cover.positions()[k]).value().distance, -2e-6) << rounds << ' ' << k;
    }
}

ChartSpec free_sphere(std::uint32_t side) {
    return closed_free_chart(side, [](const std::array<double, 3>& n) {
        return Point{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
    });
}

TEST(Contact, OnlyWeldedSurfacesAreClosed) {
    EXPECT_FALSE(ContactSolver::create(make_state(free_chart(17, 17, sheet))).value().closed());
    EXPECT_FALSE(ContactSolver::create(make_state(grid_chart(17, 17, sheet, tube_seams(17, 17)))).value().closed());
    EXPECT_TRUE(ContactSolver::create(make_state(sphere_chart(17))).value().closed());
    EXPECT_TRUE(ContactSolver::create(make_state(free_sphere(17))).value().closed());
}

TEST(Contact, ClosedFreeChartKeepsVolume) {
    State state = make_state(free_sphere(65));
    const ContactSolver solver = ContactSolver::create(state).value();
    ASSERT_TRUE(solver.closed());
    const Triangles triangles(state);
    const double before = triangles.volume(state);
    EXPECT_NEAR(before, 4.18879, 0.03);
    EXPECT_NEAR(solver.volume(state), before, 1e-12);
    const PointView p = state.positions(), rest = state.rest_positions();
    // The border loop runs through the south pole and up to four points of the equator: planes from below meet it
    // first, those from the side meet one of its ends.
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{-1, 0, 0}, Vec3{0.6f, 0, -0.8f}})
        for (const float depth : {0.03f, 0.15f}) {
            Obstacle plane;
            plane.normal = normal;
            plane.point = (depth - 1) * normal;
            const auto r = resolve_contact(state, solver, plane);
            ASSERT_TRUE(r.ok()) << r.error().message;
            EXPECT_EQ(r.value().status, ContactStatus::Contact);
            EXPECT_TRUE(r.value().volume_kept) << r.value().volume_error;
            EXPECT_NEAR(r.value().removed, 3.14159265 * depth * depth * (3 - depth) / 3, 0.05 * r.value().removed);
            EXPECT_LE(std::fabs(triangles.volume(state) - before), 1e-6 * r.value().removed);
            for (std::uint32_t k = 0; k < p.count; ++k) {
                if (state.on_surface(k)) { ASSERT_GE(dot(normal, p[k]), depth - 1 - 3e-7f) << k; }
            }
            expect_closed_seams(state);
            state.release();
            for (std::uint32_t k = 0; k < p.count; ++k) ASSERT_TRUE(same_bits(p[k], rest[k]));
        }
}

TEST(Contact, SharedSearchesFindWhatSingleOnesDo) {
    // A cover about as far from the body as the body's waves are high: tiles that are clear of it, cross it, sink.
    const auto rest = [](double i, double j) {
        const double x = (i - 40) / 50, y = (j - 40) / 50, length = std::sqrt(x * x + y * y + 1);
        const double r = 1 + 0.03 * std::sin(9 * x + 4 * y);
        return Point{static_cast<float>(r * x / length), static_cast<float>(r * y / length),
                     static_cast<float>(r / length)};
    };
    for (const bool is_free : {false, true})
        for (const bool turned : {false, true}) {
            SCOPED_TRACE(testing::Message() << is_free << ' ' << turned);
            State body = make_state(is_free ? free_sphere(65) : sphere_chart(97));
            State cover = make_state(grid_chart(81, 81, rest));
            const ContactSolver solver = ContactSolver::create(cover).value();
            Obstacle o{.kind = ObstacleKind::Surface, .point = {0.01f, 0, 0.004f}, .surface = &body};
            if (turned) std::copy_n(kTurn, 9, o.rotation);
            std::uint32_t sunk = 0;
            double total = 0, deepest = 0;
            for (std::uint32_t k = 0; k < cover.sample_count(); ++k) {
                const double d = obstacle_distance(o, cover.positions()[k]).value().distance;
                if (d >= -3e-7) continue;
                ++sunk;
                total -= d;
                deepest = std::max(deepest, -d);
            }
            const auto r = resolve_contact(cover, solver, o).value();
            EXPECT_NEAR(r.samples, sunk, 1 + sunk / 1000);  // single precision decides about a few at the rim
            EXPECT_GT(sunk, 1000u);
            EXPECT_LT(sunk, cover.sample_count() - 1000);
            EXPECT_NEAR(r.total, total, 1e-5 * total);
            EXPECT_NEAR(r.deepest, deepest, 1e-6);
            for (std::uint32_t k = 0; k < cover.sample_count(); ++k)
                ASSERT_GT(obstacle_distance(o, cover.positions()[k]).value().distance, -2e-6) << k;
        }
}

}  // namespace
}  // namespace dgm::test
