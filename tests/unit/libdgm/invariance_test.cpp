// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/invariance_test.cpp
// One surface, two charts: another cut through it, and other samples on it, must not show in what a touch or a contact
// does.
#include <dgm/deform.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "contact_shapes.h"

namespace dgm::test {
namespace {

using Double3 = std::array<double, 3>;
constexpr std::uint32_t kSide = 129;

double dot(const Double3& a, const Double3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Unit sphere whose octahedral cut is turned so that `from` comes to lie at `to` (both unit, not opposite).
ChartSpec turned_sphere(const Double3& from, const Double3& to) {
    const Double3 axis = cross(from, to);
    const double cosine = dot(from, to);
    return closed_chart(kSide, [=](std::array<double, 3> n) {
        const Double3 turned = cross(axis, n);  // Rodrigues
        const double along = dot(axis, n) / (1 + cosine);
        return Double3{cosine * n[0] + turned[0] + along * axis[0], cosine * n[1] + turned[1] + along * axis[1],
                       cosine * n[2] + turned[2] + along * axis[2]};
    });
}

Double3 wide(Vec3 p) {
    return {p.x, p.y, p.z};
}

/// Displacement of `state` where the ray from the origin through `direction` meets its rest surface.
Double3 displacement_at(const State& state, const std::vector<std::uint32_t>& triangles, const Double3& direction) {
    const PointView now = state.positions(), rest = state.rest_positions();
    for (std::size_t k = 0; k < triangles.size(); k += 3) {
        const Double3 a = wide(rest[triangles[k]]), b = wide(rest[triangles[k + 1]]), c = wide(rest[triangles[k + 2]]);
        if (dot(a, direction) < 0.85) continue;
        const double u = dot(direction, cross(b, c)), v = dot(direction, cross(c, a)), w = dot(direction, cross(a, b));
        const double sum = u + v + w, slack = -1e-9 * std::fabs(sum);
        if (sum == 0 || u / sum < slack || v / sum < slack || w / sum < slack) continue;
        Double3 out{};
        for (int c3 = 0; c3 < 3; ++c3) {
            const auto corner = [&](std::size_t e) {
                const Vec3 moved = now[triangles[k + e]] - rest[triangles[k + e]];
                return wide(moved)[static_cast<std::size_t>(c3)];
            };
            out[static_cast<std::size_t>(c3)] = (u * corner(0) + v * corner(1) + w * corner(2)) / sum;
        }
        return out;
    }
    ADD_FAILURE() << "no triangle of the sphere lies there";
    return {};
}

struct TwoCuts {
    // Inside one side of the cut in one chart; where four ends of the cut meet in the other.
    std::uint32_t inside = 40 * kSide + 70, corner = 0;
    Double3 place = octahedral(40.0 / (kSide - 1), 70.0 / (kSide - 1));
    State a = make_state(sphere_chart(kSide), 100);
    State b = make_state(turned_sphere(octahedral(0, 0), place), 100);
    Triangles triangles{a};
};

TEST(Invariance, TouchesDoNotSeeTheCut) {
    TwoCuts s;
    ASSERT_NEAR(dot(wide(s.b.positions()[s.corner]), s.place), 1, 1e-6);
    KernelOptions kernel;
    kernel.end = KernelEnd::Compact;
    kernel.reach = 20;
    kernel.sigma = 80;
    const DeformTable table = DeformTable::create(kernel).value();
    Touch touch;
    touch.displacement = {0.02f, -0.05f, 0.08f};
    touch.d_max = 1;
    touch.footprint = Footprint::Geodesic;
    touch.step = 0.02f;  // reaches 0.4 of the radius
    touch.sample = s.inside;
    ASSERT_FALSE(deform(s.a, table, touch).value().crossed_seam);
    touch.sample = s.corner;
    ASSERT_TRUE(deform(s.b, table, touch).value().crossed_seam);
    const double peak = std::sqrt(0.02 * 0.02 + 0.05 * 0.05 + 0.08 * 0.08);
    const PointView now = s.b.positions(), rest = s.b.rest_positions();
    double worst = 0;
    int moved = 0;
    for (std::uint32_t k = 0; k < now.count; ++k) {
        const Double3 direction = wide(rest[k]), here = wide(now[k] - rest[k]);
        if (dot(direction, s.place) < std::cos(0.42)) {
            ASSERT_EQ(dot(here, here), 0.0);
            continue;
        }
        const Double3 there = displacement_at(s.a, s.triangles.indices, direction);
        for (std::size_t c = 0; c < 3; ++c) worst = std::max(worst, std::fabs(here[c] - there[c]) / peak);
        moved += dot(here, here) > 0 ? 1 : 0;
    }
    EXPECT_GT(moved, 300);
    EXPECT_LT(worst, 0.02);
    EXPECT_GT(worst, 1e-7) << "the same samples after all";
}

TEST(Invariance, ContactsDoNotSeeTheCut) {
    TwoCuts s;
    Obstacle plane;
    for (std::size_t c = 0; c < 3; ++c) {
        const float v = static_cast<float>(s.place[c]);
        (c == 0 ? plane.normal.x : c == 1 ? plane.normal.y : plane.normal.z) = -v;
        (c == 0 ? plane.point.x : c == 1 ? plane.point.y : plane.point.z) = 0.93f * v;
    }
    ContactReport reports[2];
    for (State* state : {&s.a, &s.b}) {
        const ContactSolver solver = ContactSolver::create(*state).value();
        ContactReport& r = reports[state == &s.b];
        r = resolve_contact(*state, solver, plane).value();
        EXPECT_EQ(r.status, ContactStatus::Contact);
        EXPECT_TRUE(r.volume_kept);
    }
    EXPECT_NEAR(reports[0].deepest, 0.07, 1e-6);
    EXPECT_NEAR(reports[1].deepest, 0.07, 1e-6);
    EXPECT_NE(reports[0].samples, reports[1].samples);
    EXPECT_NEAR(reports[0].removed, reports[1].removed, 0.02 * reports[0].removed);
    EXPECT_NEAR(reports[0].beta, reports[1].beta, 0.05 * reports[0].beta);
    const PointView now = s.b.positions(), rest = s.b.rest_positions();
    double worst = 0;
    for (std::uint32_t k = 0; k < now.count; k += 3) {
        const Double3 direction = wide(rest[k]), here = wide(now[k] - rest[k]);
        // Where the contact ends and the bulge begins, samples a step apart stand on either side of a jump.
        const double along = dot(direction, s.place);
        if (along < 0.905 || std::fabs(along - 0.93) < 0.015) continue;
        const Double3 there = displacement_at(s.a, s.triangles.indices, direction);
        for (std::size_t c = 0; c < 3; ++c) worst = std::max(worst, std::fabs(here[c] - there[c]) / 0.07);
    }
    EXPECT_LT(worst, 0.05);
}

}  // namespace
}  // namespace dgm::test
