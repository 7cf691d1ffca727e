// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/contact_test.cpp
// A closed shape against a plane: what is projected, what comes out again as a bulge, and when it is taken back.
#include <gtest/gtest.h>

#include "contact_shapes.h"

namespace dgm::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A tilted plane that cuts `depth` off the unit sphere.
Obstacle tilted_plane(double depth) {
    const double n[3] = {0.3 / std::sqrt(1.54), -0.5 / std::sqrt(1.54), 1.0957 / std::sqrt(1.54)};
    Obstacle plane;
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    plane.normal = {float(n[0]), float(n[1]), float(n[2])};
    const double at = -(1 - depth) / length;
    plane.point = {float(at * n[0]), float(at * n[1]), float(at * n[2])};
    return plane;
}

double height(const Obstacle& plane, Vec3 p) {
    const double n[3] = {plane.normal.x, plane.normal.y, plane.normal.z};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return (n[0] * (double(p.x) - plane.point.x) + n[1] * (double(p.y) - plane.point.y) +
            n[2] * (double(p.z) - plane.point.z)) /
           length;
}

class SphereOnPlane : public testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(SphereOnPlane, KeepsItsVolume) {
    const auto [depth, plain] = GetParam();
    StateOptions options;
    options.plain_loops = plain;
    State state = State::create(Opened(build({sphere_chart(129)})).chart(), options).value();
    const ContactSolver solver = ContactSolver::create(state).value();
    ASSERT_TRUE(solver.closed());
    const Triangles triangles(state);
    const double before = triangles.volume(state);
    EXPECT_NEAR(solver.volume(state), before, 1e-12);
    EXPECT_NEAR(before, 4 * kPi / 3, 4e-3);  // an inscribed polyhedron
    const Obstacle plane = tilted_plane(depth);
    const PointView p = state.positions(), rest = state.rest_positions();
    std::uint32_t beyond = 0;
    double sum = 0, deepest = 0;
    for (std::uint32_t k = 0; k < p.count; ++k) {
        const double h = height(plane, p[k]);
        const std::uint32_t id = state.class_of(k);
        if (h >= 0 || (id != kNone && state.class_members(id)[0] != k)) continue;
        ++beyond;
        sum -= h;
        deepest = std::max(deepest, -h);
    }
    const auto done = resolve_contact(state, solver, plane);
    ASSERT_TRUE(done.ok()) << done.error().message;
    const ContactReport& r = done.value();
    EXPECT_EQ(r.status, ContactStatus::Contact);
    EXPECT_EQ(r.samples, beyond);
    EXPECT_NEAR(r.total, sum, 1e-5 * sum);
    EXPECT_NEAR(r.deepest, deepest, 1e-6);
    // The cap of a sphere.
    EXPECT_NEAR(r.removed, kPi * depth * depth * (3 - depth) / 3, 0.02 * r.removed) << depth;
    EXPECT_TRUE(r.volume_kept);
    const double after = triangles.volume(state);
    EXPECT_LE(std::fabs(after - before), 1e-6 * r.removed) << r.passes << " passes, beta " << r.beta;
    EXPECT_NEAR(r.volume_error, (after - before) / r.removed, 1e-8);
    EXPECT_LT(std::fabs(r.first_order_error), 0.12);
    EXPECT_GT(r.paper_error, 1.0) << "a length times a count of samples is no bulge";
    EXPECT_GT(r.beta, 0);
    std::uint32_t bulged = 0;
    for (std::uint32_t k = 0; k < p.count; ++k) {
        ASSERT_GE(height(plane, p[k]), -3e-7) << k;
        const Vec3 moved = p[k] - rest[k];
        if (height(plane, rest[k]) >= 0 && dot(moved, moved) > 0) ++bulged;
    }
    EXPECT_GT(bulged, beyond / 4);
    expect_closed_seams(state);
    state.release();
    for (std::uint32_t k = 0; k < p.count; ++k) ASSERT_TRUE(same_bits(p[k], rest[k]));
}
INSTANTIATE_TEST_SUITE_P(Depths, SphereOnPlane,
                         testing::Combine(testing::Values(0.01, 0.05, 0.1, 0.2), testing::Bool()));

TEST(Contact, LimitsTakeItBackWhole) {
    State state = make_state(sphere_chart(65));
    const ContactSolver solver = ContactSolver::create(state).value();
    const PointView p = state.positions(), rest = state.rest_positions();
    const auto free = resolve_contact(state, solver, tilted_plane(0.1)).value();
    state.release();
    ContactOptions o;
    for (const bool single : {true, false}) {
        o = {};
        (single ? o.max_depth : o.max_total) = 0.999f * (single ? free.deepest : free.total);
        const auto r = resolve_contact(state, solver, tilted_plane(0.1), o);
        ASSERT_TRUE(r.ok());
        EXPECT_EQ(r.value().status, ContactStatus::Restored);
        EXPECT_EQ(r.value().deepest, free.deepest);
        for (std::uint32_t k = 0; k < p.count; ++k) ASSERT_TRUE(same_bits(p[k], rest[k]));
        (single ? o.max_depth : o.max_total) = 1.001f * (single ? free.deepest : free.total);
        EXPECT_EQ(resolve_contact(state, solver, tilted_plane(0.1), o).value().status, ContactStatus::Contact);
        state.release();
    }
}

TEST(Contact, FarAwayAndRestingIsNone) {
    State state = make_state(sphere_chart(65));
    const ContactSolver solver = ContactSolver::create(state).value();
    EXPECT_EQ(resolve_contact(state, solver, tilted_plane(-0.001)).value().status, ContactStatus::Clear);
    ContactOptions o;
    o.mode = DeformMode::Plastic;
    EXPECT_EQ(resolve_contact(state, solver, tilted_plane(0.1), o).value().status, ContactStatus::Contact);
    const Vec3 at = state.positions()[65 * 32 + 1];
    EXPECT_EQ(resolve_contact(state, solver, tilted_plane(0.1), o).value().status, ContactStatus::Clear);
    state.release();
    EXPECT_TRUE(same_bits(state.positions()[65 * 32 + 1], at)) << "plastic contacts stay";
    EXPECT_FALSE(same_bits(state.positions()[0], state.rest_positions()[0]) &&
                 same_bits(state.positions()[65 * 32 + 32], state.rest_positions()[65 * 32 + 32]));
}

TEST(Contact, PaperFormIsEquation11) {
    State state = make_state(sphere_chart(129));
    const ContactSolver solver = ContactSolver::create(state).value();
    const Obstacle plane = tilted_plane(0.05);
    const RingSize rings[] = {{0.5f, 0.1f, 0.01f}, {1e9f, 0.4f, 0.05f}};
    ContactOptions o;
    o.bulge = Bulge::Paper;
    o.rings = rings;
    state.update_normals();
    std::vector<Vec3> normals;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) normals.push_back(state.normals()[k]);
    const auto r = resolve_contact(state, solver, plane, o).value();
    ASSERT_GT(r.total, 0.5f);
    EXPECT_EQ(r.ring_reach, 0.4f);
    EXPECT_EQ(r.beta, r.total);
    EXPECT_FALSE(r.volume_kept);
    // On the sphere the distance from the rim is an angle: s = theta - theta_rim.
    const double rim = std::acos(0.95);
    const PointView p = state.positions(), rest = state.rest_positions();
    std::uint32_t seen = 0;
    double worst = 0;
    for (std::uint32_t k = 0; k < p.count; ++k) {
        const double h = height(plane, rest[k]);
        if (h < 0) continue;
        const double s = std::acos(std::clamp(0.95 - h, -1.0, 1.0)) - rim;
        if (s > 0.39) continue;
        const double expected = std::exp(-s * s / 0.05) * r.total;
        const Vec3 moved = p[k] - rest[k];
        worst = std::max(worst, std::fabs(dot(moved, normals[k]) / r.total - expected / r.total));
        ++seen;
    }
    EXPECT_GT(seen, 200u);
    // Points of the rim are up to a grid step apart, so s is up to half a step long; the kernel's slope is at most
    // this.
    EXPECT_LT(worst, 0.5 * state.mean_step() * std::sqrt(2 / 0.05) * std::exp(-0.5));
    EXPECT_NEAR(r.volume_error, r.paper_error, 1e-3 * r.paper_error);
}

TEST(Contact, HundredThousandContactsDoNotDrift) {
    State state = make_state(sphere_chart(17));
    const ContactSolver solver = ContactSolver::create(state).value();
    const double before = solver.volume(state);
    double worst = 0;
    for (int k = 0; k < 100000; ++k) {
        state.release();
        const auto r = resolve_contact(state, solver, tilted_plane(0.1 + 0.05 * std::sin(0.01 * k)));
        ASSERT_TRUE(r.ok());
        worst = std::max(worst, std::fabs(solver.volume(state) - before) / r.value().removed);
    }
    EXPECT_LT(worst, 1e-6);
    state.release();
    EXPECT_EQ(solver.volume(state), before);
}

TEST(Contact, MovesSteadilyWithTheObstacle) {
    State state = make_state(sphere_chart(65));
    const ContactSolver solver = ContactSolver::create(state).value();
    const PointView p = state.positions(), rest = state.rest_positions();
    std::vector<Vec3> last;
    float last_beta = 0;
    double worst = 0, crossing = 0;
    for (int step = 0; step < 200; ++step) {
        state.release();
        const Obstacle plane = tilted_plane(0.08 + 1e-5 * step), before = tilted_plane(0.08 + 1e-5 * (step - 1));
        const auto r = resolve_contact(state, solver, plane);
        ASSERT_TRUE(r.ok());
        for (std::uint32_t k = 0; k < p.count && !last.empty(); ++k) {
            const Vec3 d = p[k] - last[k];
            const bool crosses = (height(plane, rest[k]) < 0) != (height(before, rest[k]) < 0);
            double& most = crosses ? crossing : worst;
            most = std::max(most, std::sqrt(double(dot(d, d))));
        }
        if (!last.empty()) { EXPECT_NEAR(r.value().beta, last_beta, 0.02 * last_beta); }
        last_beta = r.value().beta;
        last.clear();
        for (std::uint32_t k = 0; k < p.count; ++k) last.push_back(p[k]);
    }
    // The plane moves by 1e-5 a step. A sample that the rim passes slides along the plane as far as the bulge is high
    // there, less than half a grid step; beside it points of the rim come and go.
    EXPECT_LT(worst, 0.15 * state.mean_step());
    EXPECT_LT(crossing, 0.5 * state.mean_step());
    EXPECT_GT(crossing, 0);
}

TEST(Contact, AttachedSamplesStay) {
    ChartSpec chart = sphere_chart(65);
    std::vector<float> values;
    for (int k = 0; k < 65 * 65; ++k) values.insert(values.end(), {1.0f, 0.0f});
    chart.add("contact", ElementType::kF32, {65, 65, 2}, values);
    State state = make_state(chart);
    const ContactSolver solver = ContactSolver::create(state).value();
    const auto r = resolve_contact(state, solver, tilted_plane(0.1)).value();
    EXPECT_TRUE(r.sunk);
    EXPECT_EQ(r.deepest, 0);
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        ASSERT_TRUE(same_bits(state.positions()[k], state.rest_positions()[k]));
}

TEST(Contact, RefusesNonsenseUnchanged) {
    State state = make_state(sphere_chart(33)), other = make_state(sphere_chart(17));
    const ContactSolver solver = ContactSolver::create(state).value();
    const float nan = std::nanf(""), inf = INFINITY;
    const auto refused = [&](const Obstacle& o, const ContactOptions& options = {}) {
        const auto r = resolve_contact(state, solver, o, options);
        EXPECT_FALSE(r.ok());
        for (std::uint32_t k = 0; k < state.sample_count(); ++k)
            ASSERT_TRUE(same_bits(state.positions()[k], state.rest_positions()[k]));
    };
    for (const float bad : {nan, inf}) {
        refused({.point = {bad, 0, 0}});
        refused({.normal = {0, bad, 1}});
        refused({.kind = ObstacleKind::Sphere, .radius = bad});
        refused({.kind = ObstacleKind::Capsule, .end = {0, 0, bad}, .radius = 1});
        refused({.kind = ObstacleKind::Box, .half = {1, bad, 1}});
        refused({.kind = ObstacleKind::Surface, .surface = &other, .reach = bad});
    }
    refused({.normal = {0, 0, 0}});
    refused({.kind = ObstacleKind::Sphere});
    refused({.kind = ObstacleKind::Box, .half = {1, 1, 1}, .rotation = {1, 0, 0, 0, 2, 0, 0, 0, 1}});
    refused({.kind = ObstacleKind::Surface});
    refused({.kind = ObstacleKind::Surface, .surface = &state});
    refused({.kind = static_cast<ObstacleKind>(9)});
    ContactOptions o;
    o.max_depth = nan;
    refused(tilted_plane(0.1), o);
    const RingSize ring[] = {{1, 0, 1}};
    o = {};
    o.rings = ring;
    refused(tilted_plane(0.1), o);
    EXPECT_FALSE(resolve_contact(other, solver, tilted_plane(0.1)).ok()) << "made for another state";
}

}  // namespace
}  // namespace dgm::test
