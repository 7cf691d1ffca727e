// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/obstacle_motion_test.cpp
// How far the material of obstacles has come between two steps, against motions written out here.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "contact/scene.h"
#include "contact_shapes.h"

namespace dgm::detail {
namespace {

void expect_near(Double3 a, Double3 b) {
    EXPECT_NEAR(a.x, b.x, 1e-6);
    EXPECT_NEAR(a.y, b.y, 1e-6);
    EXPECT_NEAR(a.z, b.z, 1e-6);
}
Shape shape_of(const Obstacle& o) {
    auto made = make_shape(o);
    EXPECT_TRUE(made.ok());
    return made.value();
}
Double3 way_of(const Shape& before, const Shape& now, Double3 at) {
    return way_come(before, now, at, probe(now, at));
}
/// Turned around z by an angle, about the origin.
Vec3 around_z(Vec3 v, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {float(c * double{v.x} - s * double{v.y}), float(s * double{v.x} + c * double{v.y}), v.z};
}

TEST(ObstacleMotion, BoxesTurnWithTheirFrames) {
    Obstacle before{.kind = ObstacleKind::Box, .point = {0.5f, 0, 0}, .half = {1, 2, 0.5f}}, now = before;
    constexpr double kAngle = 0.3;
    const float turn[9] = {float(std::cos(kAngle)),
                           float(-std::sin(kAngle)),
                           0,
                           float(std::sin(kAngle)),
                           float(std::cos(kAngle)),
                           0,
                           0,
                           0,
                           1};
    std::copy_n(turn, 9, now.rotation);
    now.point = around_z(before.point, kAngle) + Vec3{0, 0, 0.25f};
    for (const Vec3 was : {Vec3{1, 1, 0.5f}, Vec3{-0.3f, 0.7f, -0.5f}, Vec3{0.5f, 0, 0}}) {
        const Vec3 is = around_z(was, kAngle) + Vec3{0, 0, 0.25f};
        expect_near(way_of(shape_of(before), shape_of(now), widen(is)), widen(is) - widen(was));
    }
}

TEST(ObstacleMotion, PlanesTurnWithTheirNormals) {
    // Tilted around the z axis: what was at (0, y, z) of the plane x = 0 is turned about the origin.
    constexpr double kAngle = 0.2;
    const Obstacle before{.kind = ObstacleKind::Plane, .point = {}, .normal = {2, 0, 0}};
    Obstacle now = before;
    now.normal = around_z({1, 0, 0}, kAngle);
    for (const Vec3 was : {Vec3{0, 1, 0}, Vec3{0, -2, 3}, Vec3{0, 0, 0}}) {
        const Vec3 is = around_z(was, kAngle);
        expect_near(way_of(shape_of(before), shape_of(now), widen(is)), widen(is) - widen(was));
    }
    now = before;
    now.point = {0, 0.5f, -0.25f};
    expect_near(way_of(shape_of(before), shape_of(now), {0, 7, 7}), {0, 0.5, -0.25});
    now.normal = {-2, 0, 0};  // turned over: about which axis nobody knows
    expect_near(way_of(shape_of(before), shape_of(now), {0, 7, 7}), {0, 0.5, -0.25});
}

TEST(ObstacleMotion, BallsShiftAndCapsulesFollowTheirEnds) {
    const Obstacle ball{.kind = ObstacleKind::Sphere, .point = {1, 2, 3}, .radius = 0.5f};
    Obstacle moved = ball;
    moved.point = {1.5f, 2, 2};
    expect_near(way_of(shape_of(ball), shape_of(moved), {1.5, 2.5, 2}), {0.5, 0, -1});
    const Obstacle arm{.kind = ObstacleKind::Capsule, .point = {0, 0, 0}, .end = {4, 0, 0}, .radius = 0.5f};
    Obstacle bent = arm;
    bent.end = {4, 1, 0};
    const Shape before = shape_of(arm), now = shape_of(bent);
    expect_near(way_of(before, now, {-0.5, 0, 0}), {0, 0, 0});
    expect_near(way_of(before, now, {4, 1, 0.5}), {0, 1, 0});
    expect_near(way_of(before, now, {2, 0.5, 0.5}), {0, 0.5, 0});
}

TEST(ObstacleMotion, GoesAlongInParts) {
    Obstacle before{.kind = ObstacleKind::Box, .point = {1, 0, 0}, .half = {1, 2, 0.5f}}, now = before;
    const float quarter[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    std::copy_n(quarter, 9, now.rotation);
    now.point = {1, 4, 0};
    const Shape from = shape_of(before), to = shape_of(now), half = between(from, to, 0.5);
    expect_near(half.point, {1, 2, 0});
    const double s = std::sqrt(0.5);  // an eighth of a turn
    expect_near(half.axis[0], {s, s, 0});
    expect_near(half.axis[1], {-s, s, 0});
    expect_near(half.axis[2], {0, 0, 1});
    const Shape end = between(from, to, 1);
    EXPECT_EQ(std::memcmp(end.axis, to.axis, sizeof end.axis), 0);
    expect_near(end.point, to.point);
    // Steps add up to the way of the whole.
    Double3 at = widen(Vec3{1.5f, 0.5f, 0.25f});
    Shape last = from;
    for (int k = 1; k <= 1000; ++k) {
        const Shape next = between(from, to, k / 1000.0);
        at = at + way_of(last, next, at + way_of(last, next, at));
        last = next;
    }
    EXPECT_NEAR(at.x, 0.5, 1e-2);
    EXPECT_NEAR(at.y, 4.5, 1e-2);
    // A frame that has turned over has no way between.
    const float over[9] = {-1, 0, 0, 0, -1, 0, 0, 0, 1};
    std::copy_n(over, 9, now.rotation);
    expect_near(between(from, shape_of(now), 0.5).axis[0], {-1, 0, 0});
    const Obstacle floor{.kind = ObstacleKind::Plane, .point = {0, 0, 1}, .normal = {0, 0, 1}};
    Obstacle wall{.kind = ObstacleKind::Plane, .point = {0, 0, 3}, .normal = {0, 1, 0}};
    const Shape tilted = between(shape_of(floor), shape_of(wall), 0.5);
    expect_near(tilted.normal, {0, s, s});
    EXPECT_NEAR(probe(tilted, {5, 0, 2 + 2 * s}).distance, 1, 1e-6);
    wall.normal = {0, 0, -1};
    expect_near(between(shape_of(floor), shape_of(wall), 0.5).normal, {0, 0, -1});
}

TEST(ObstacleMotion, SkinsGoAPartOfTheirWay) {
    // A ball that turns by 0.1 rad, moves, and becomes longer by 5 %, in a frame that turns by itself.
    const auto led = [](std::array<double, 3> n) -> std::array<double, 3> {
        const double c = std::cos(0.1), s = std::sin(0.1);
        return {c * n[0] - s * n[1] + 0.05, s * n[0] + c * n[1], 1.05 * n[2] - 0.1};
    };
    constexpr double kPart = 0.3;
    const State was = test::make_state(test::sphere_chart(33));
    State now = test::make_state(test::closed_chart(33, led));
    State direct = test::make_state(test::closed_chart(33, [&](std::array<double, 3> n) -> std::array<double, 3> {
        const auto to = led(n);
        std::array<double, 3> out;
        for (std::size_t k = 0; k < 3; ++k) out[k] = n[k] + kPart * (to[k] - n[k]);
        return out;
    }));
    Obstacle skin{.kind = ObstacleKind::Surface, .point = {0.5f, 0, 0}};
    const float turn[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    std::copy_n(turn, 9, skin.rotation);
    Obstacle reference = skin;
    skin.surface = &now;
    skin.before = was.positions();
    reference.surface = &direct;
    Shape moving = shape_of(skin);
    const Shape there = shape_of(reference);
    EXPECT_NEAR(farthest_way(moving), 0.2, 0.03);
    moving.ahead = 1 - kPart;
    int same = 0;
    for (int k = 0; k < 4000; ++k) {  // a spiral around the ball, inside and outside of it
        const double z = -1 + (k + 0.5) / 2000, r = std::sqrt(1 - z * z), off = 1 + 0.02 * std::sin(0.37 * k);
        const Double3 x{0.5 + off * r * std::cos(2.4 * k), off * r * std::sin(2.4 * k), off * z};
        const Probe a = probe_underway(moving, x), b = probe(there, x);
        // The way stretches by 5 %, and with it what lies off the surface.
        EXPECT_NEAR(a.distance, b.distance, 2e-5 + 0.04 * std::fabs(b.distance)) << k;
        if (moving.hint != there.hint) continue;  // facets meet at up to 0.3 rad
        ++same;
        if (std::fabs(b.distance) < 0.005) continue;
        EXPECT_GT(dot(normal_at(moving, a, x), normal_at(there, b, x)), 0.995) << k;
    }
    EXPECT_GT(same, 3600);
    // With nothing ahead it is where it is.
    moving.ahead = 0;
    EXPECT_EQ(probe_underway(moving, {1, 0.5, 0.7}).distance, probe(moving, {1, 0.5, 0.7}).distance);
}

TEST(ObstacleMotion, IsThatOfTheSameObstacle) {
    Scene before, now;
    const auto add = [](Scene& scene, std::uint32_t id, const Obstacle& o) {
        scene.shapes[scene.count] = shape_of(o);
        scene.ids[scene.count++] = id;
    };
    const Obstacle ball{.kind = ObstacleKind::Sphere, .point = {1, 0, 0}, .radius = 1};
    Obstacle other = ball;
    other.point = {2, 0, 0};
    add(before, 3, ball);
    add(before, Scene::kMost, other);
    add(before, Scene::kMost + 1, ball);
    add(now, Scene::kMost, ball);  // the tool has gone, and all places in the list are other ones
    add(now, Scene::kMost + 1, ball);
    add(now, Scene::kMost + 2, ball);
    EXPECT_EQ(was_at(before, now, 0), &before.shapes[1]);
    EXPECT_FALSE(has_stayed(before, now, 0));
    EXPECT_EQ(was_at(before, now, 1), &before.shapes[2]);
    EXPECT_TRUE(has_stayed(before, now, 1));
    EXPECT_EQ(was_at(before, now, 2), nullptr);
    EXPECT_FALSE(has_stayed(before, now, 2));
    now.shapes[1] = shape_of({.kind = ObstacleKind::Plane});
    EXPECT_EQ(was_at(before, now, 1), nullptr) << "another kind of body has its number";
}

}  // namespace
}  // namespace dgm::detail
