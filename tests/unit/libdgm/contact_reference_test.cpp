// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/contact_reference_test.cpp
// Contacts against slow ones written out apart from the library's: every sample asked, distances from the rim in closed
// form, the bulge found by halving, its volume by all triangles in double.
#include <gtest/gtest.h>

#include <algorithm>

#include "contact_shapes.h"

namespace dgm::test {
namespace {

using Point3 = std::array<double, 3>;

Point3 wide(Vec3 v) {
    return {v.x, v.y, v.z};
}
double dot3(const Point3& a, const Point3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point3 along(const Point3& a, double t, const Point3& b) {
    return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]};
}
double distance(const Point3& a, const Point3& b) {
    const Point3 d = along(a, -1, b);
    return std::sqrt(dot3(d, d));
}

double volume_of(const Triangles& triangles, const std::vector<Point3>& p) {
    double six = 0;
    for (std::size_t k = 0; k < triangles.indices.size(); k += 3) {
        const Point3 &a = p[triangles.indices[k]], &b = p[triangles.indices[k + 1]], &c = p[triangles.indices[k + 2]];
        six += dot3(a, {b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]});
    }
    return six / 6;
}

class SlowBulge : public testing::TestWithParam<std::tuple<std::uint32_t, bool>> {};

TEST_P(SlowBulge, IsTheSame) {
    const auto [side, plain] = GetParam();
    StateOptions state_options;
    state_options.plain_loops = plain;
    State state = State::create(Opened(build({sphere_chart(side)})).chart(), state_options).value();
    const ContactSolver solver = ContactSolver::create(state).value();
    const Triangles triangles(state);
    state.update_normals();
    const double reach = 0.4, sigma = 0.04, depth = 0.1, up = -(1 - depth);
    const double length = std::sqrt(1.54);
    const Point3 n{0.3 / length, -0.5 / length, std::sqrt(1.2) / length};
    std::vector<Point3> rest, projected;
    std::vector<Point3> normals;
    std::vector<double> weights;
    const double end = std::exp(-reach * reach / sigma), slope = reach * reach / sigma, rim = std::acos(1 - depth);
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        rest.push_back(wide(state.positions()[k]));
        normals.push_back(wide(state.normals()[k]));
        const double height = dot3(n, rest[k]) - up;
        projected.push_back(height < 0 ? along(rest[k], -height, n) : rest[k]);
        // The chord to the nearest point of the rim, a circle.
        const double s = 2 * std::sin((std::acos(std::clamp(-dot3(n, rest[k]), -1.0, 1.0)) - rim) / 2);
        const double x = s * s / sigma;
        weights.push_back(height < 0 || s >= reach ? 0
                                                   : (std::exp(-x) - end * (1 + slope - x)) / (1 - end * (1 + slope)));
    }
    const auto bulged = [&](double beta) {
        std::vector<Point3> p = projected;
        for (std::size_t k = 0; k < p.size(); ++k) {
            if (weights[k] == 0) continue;
            p[k] = along(rest[k], beta * weights[k], normals[k]);
            p[k] = along(p[k], -std::min(0.0, dot3(n, p[k]) - up), n);
        }
        return p;
    };
    const double before = volume_of(triangles, rest);
    double low = 0, high = 1;
    for (int k = 0; k < 40; ++k) {
        const double middle = (low + high) / 2;
        (volume_of(triangles, bulged(middle)) < before ? low : high) = middle;
    }
    const std::vector<Point3> expected = bulged(low);

    Obstacle plane;
    plane.normal = {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
    plane.point = static_cast<float>(up) * plane.normal;
    const RingSize rings[] = {{1e9f, static_cast<float>(reach), static_cast<float>(sigma)}};
    ContactOptions options;
    options.rings = rings;
    const auto r = resolve_contact(state, solver, plane, options).value();
    EXPECT_TRUE(r.volume_kept);
    EXPECT_NEAR(r.removed, before - volume_of(triangles, projected), 1e-6 * r.removed);
    // Points of the rim are up to a grid step apart, so s is up to half a step long; the kernel's slope is at most
    // sqrt(2 / sigma) exp(-1/2).
    const double off = 0.5 * static_cast<double>(state.mean_step()) * std::sqrt(2 / sigma) * std::exp(-0.5);
    EXPECT_NEAR(r.beta, low, off * low);
    double worst = 0;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        worst = std::max(worst, distance(wide(state.positions()[k]), expected[k]));
    EXPECT_LT(worst, off * low);
}
// Narrow rings are walked sample by sample, wide ones by every fourth.
INSTANTIATE_TEST_SUITE_P(Sides, SlowBulge, testing::Combine(testing::Values(65u, 225u), testing::Bool()));

TEST(Contact, SmallestOnesKeepTheirVolume) {
    // A surface of an organ's size in centimetres, away from the origin: one unit in the last place of a coordinate,
    // times the area around a sample, is not small against the volume taken here.
    State state = make_state(closed_chart(129, [](const std::array<double, 3>& n) {
        return std::array<double, 3>{8 + 6 * n[0], -11 + 6 * n[1], 3 + 6 * n[2]};
    }));
    const ContactSolver solver = ContactSolver::create(state).value();
    const Triangles triangles(state);
    const double before = triangles.volume(state);
    std::uint32_t fewest = ~0u;
    for (const double depth : {0.003, 0.005, 0.01, 0.02, 0.04})
        for (const double turn : {0.1, 0.7, 1.3, 2.9, 4.4}) {
            const Point3 n{0.8 * std::cos(turn), 0.8 * std::sin(turn), 0.6};
            Obstacle plane;
            plane.normal = {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
            const Point3 at = along({8, -11, 3}, depth - 6, n);
            plane.point = {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])};
            const auto r = resolve_contact(state, solver, plane).value();
            if (r.status == ContactStatus::Contact) {
                fewest = std::min(fewest, r.samples);
                EXPECT_TRUE(r.volume_kept) << r.samples << " samples, error " << r.volume_error;
                EXPECT_NEAR(triangles.volume(state), before, 1e-6 * r.removed) << r.samples << " samples";
            }
            state.release();
        }
    EXPECT_LE(fewest, 12u);
}

TEST(Contact, OpenSheetMatchesASlowSmoothing) {
    constexpr std::uint32_t kSide = 41;
    constexpr double kRadius = 8;
    const Point3 centre{20.2, 19.7, -6};
    State state = make_state(grid_chart(kSide, kSide, [](double i, double j) { return Point{float(i), float(j), 0}; }));
    const ContactSolver solver = ContactSolver::create(state).value();
    const Obstacle ball{.kind = ObstacleKind::Sphere, .point = {20.2f, 19.7f, -6}, .radius = 8};
    std::vector<Point3> rest;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) rest.push_back(wide(state.positions()[k]));
    const auto outside = [&](Point3 p) {
        const double d = distance(p, centre);
        return d < kRadius ? along(centre, kRadius / d, along(p, -1, centre)) : p;
    };
    const auto r = resolve_contact(state, solver, ball).value();
    std::vector<Point3> moved(rest.size(), Point3{});
    std::vector<char> member(rest.size(), 0);
    const double rim = std::sqrt(kRadius * kRadius - 36);  // the ball cuts a circle out of the sheet
    for (std::size_t k = 0; k < rest.size(); ++k) {
        moved[k] = along(outside(rest[k]), -1, rest[k]);
        member[k] = std::hypot(rest[k][0] - centre[0], rest[k][1] - centre[1]) - rim < r.ring_reach;
    }
    for (std::uint32_t round = 0; round < ContactOptions{}.smoothing; ++round) {
        std::vector<Point3> next(rest.size(), Point3{});
        for (std::size_t k = 0; k < rest.size(); ++k) {
            const std::size_t i = k / kSide, j = k % kSide;
            if (!member[k]) continue;
            Point3 sum{};
            double count = 0;
            const auto add = [&](std::size_t other) {
                sum = along(sum, 1, moved[other]);
                ++count;
            };
            if (i > 0) add(k - kSide);
            if (j > 0) add(k - 1);
            if (j + 1 < kSide) add(k + 1);
            if (i + 1 < kSide) add(k + kSide);
            next[k] = along(along({}, 0.5, moved[k]), 0.5 / count, sum);
            next[k] = along(outside(along(rest[k], 1, next[k])), -1, rest[k]);
        }
        moved = next;
    }
    double worst = 0;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        worst = std::max(worst, distance(wide(state.positions()[k]), along(rest[k], 1, moved[k])));
    // A sample may be in the ring of one and just beyond that of the other, where all but nothing is left to move.
    EXPECT_LT(worst, 0.02 * static_cast<double>(r.deepest));
    EXPECT_GT(r.deepest, 1.9f);
}

}  // namespace
}  // namespace dgm::test
