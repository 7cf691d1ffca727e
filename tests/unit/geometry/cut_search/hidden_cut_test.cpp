// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut_search/hidden_cut_test.cpp
// Seams on bodies of which it is plain where they are hidden.
#include "geometry/cut_search/hidden_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/cut_search/cut_search.h"
#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {
constexpr double kPi = std::numbers::pi;

/// A long melon with one groove, from pole to pole at the angle 0: poles first, then rings of `sides` vertices, the
/// first of a ring at the bottom of the groove.
TriMesh grooved_body(std::uint32_t rings, std::uint32_t sides, double depth) {
    TriMesh mesh;
    mesh.positions = {{0, 0, -2}, {0, 0, 2}};
    for (std::uint32_t i = 1; i <= rings; ++i)
        for (std::uint32_t j = 0; j < sides; ++j) {
            const double down = kPi * i / (rings + 1), turn = 2 * kPi * j / sides;
            const double off = std::min(turn, 2 * kPi - turn) / 0.3;
            const double radius = std::sin(down) * (1 - depth * std::exp(-off * off));
            mesh.positions.push_back({radius * std::cos(turn), radius * std::sin(turn), -2 * std::cos(down)});
        }
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return 2 + i * sides + j % sides; };
    for (std::uint32_t j = 0; j < sides; ++j) {
        mesh.faces.push_back({0, at(0, j + 1), at(0, j)});
        mesh.faces.push_back({1, at(rings - 1, j), at(rings - 1, j + 1)});
        for (std::uint32_t i = 0; i + 1 < rings; ++i) {
            mesh.faces.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
            mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        }
    }
    return mesh;
}

/// Largest angle from the groove's bottom of a cut vertex that is not near a pole.
double farthest_from_groove(const CutGraph& cut) {
    double most = 0;
    for (std::uint32_t h = 0; h < cut.opposite().size(); ++h) {
        if (!cut.is_cut(h)) continue;
        const Vec3d p = cut.mesh().positions[origin(cut.mesh().faces, h)];
        if (std::abs(p.z) < 1.5) most = std::max(most, std::abs(std::atan2(p.y, p.x)));
    }
    return most;
}

CutGraph weighed(CutGraph cut) {
    cut.weigh(hiding_factors(cut.mesh(), cut.opposite()));
    return cut;
}

double cost(const CutGraph& cut) {
    double sum = 0;
    for (std::uint32_t h = 0; h < cut.opposite().size(); ++h)
        if (cut.is_cut(h) && h < cut.opposite()[h]) sum += cut.edge_cost(h);
    return sum;
}

CutGraph hide_cut(CutGraph cut) {
    for (const CutWay& way : hideable_ways(cut)) hide_way(cut, way);
    return cut;
}

TEST(HiddenCut, ASeamBetweenTwoTipsRunsInTheGroove) {
    constexpr std::uint32_t kRings = 30, kSides = 40;
    const TriMesh body = grooved_body(kRings, kSides, 0.5);
    CutGraph cut(body);
    // From pole to pole on the far side, where the way is as straight as can be.
    for (std::uint32_t i = 0; i + 1 < kRings; ++i) {
        const std::uint32_t a = 2 + i * kSides + kSides / 2, b = a + kSides;
        for (std::uint32_t h = 0; h < cut.opposite().size(); ++h)
            if (origin(body.faces, h) == a && target(body.faces, h) == b) cut.mark(h, true);
    }
    cut.join(0);
    cut.join(1);
    ASSERT_NEAR(farthest_from_groove(cut), kPi, 1e-12);
    const CutGraph before = weighed(cut), hidden = hide_cut(before);
    test::expect_disk(hidden.open());
    EXPECT_LT(farthest_from_groove(hidden), 0.3);
    EXPECT_LT(seam_exposure(hidden.open(), body), 0.75 * seam_exposure(cut.open(), body));
    const std::vector<CutWay> ways = hideable_ways(before);
    ASSERT_EQ(ways.size(), 1u);
    EXPECT_NEAR(ways[0].cost - ways[0].saved, cost(hidden), 1e-12);
    const std::vector<char> tips = hidden.tips();
    EXPECT_TRUE(tips[0] && tips[1]);
    EXPECT_EQ(std::count(tips.begin(), tips.end(), 1), 2);
}

TEST(HiddenCut, NothingIsHiddenOnAConvexBody) {
    const TriMesh ball = test::icosphere(3);
    CutGraph cut(ball);
    for (const double f : hiding_factors(ball, cut.opposite())) ASSERT_EQ(f, 1);
    cut.cut_to_disk();
    EXPECT_TRUE(hideable_ways(weighed(cut)).empty()) << "the path is the shortest one as it is";
    EXPECT_EQ(seam_exposure(cut.open(), ball), 1);
}

TEST(HiddenCut, CreasesThatLookInwardAreCheapAndOutwardOnesNot) {
    // A gutter: two planes that meet at a right angle along y, seen from inside; then the same as a roof.
    for (const double side : {1.0, -1.0}) {
        TriMesh mesh;
        mesh.positions = {{-1, 0, side}, {0, 0, 0}, {1, 0, side}, {-1, 1, side}, {0, 1, 0}, {1, 1, side}};
        mesh.faces = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
        const std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
        const std::vector<double> factors = hiding_factors(mesh, opposite);
        for (std::uint32_t h = 0; h < opposite.size(); ++h) {
            const std::uint32_t a = origin(mesh.faces, h), b = target(mesh.faces, h);
            if (std::min(a, b) != 1 || std::max(a, b) != 4 || opposite[h] < h) continue;
            if (side > 0)
                EXPECT_LT(factors[h], 0.5);
            else
                EXPECT_EQ(factors[h], 1);
        }
    }
}

TEST(HiddenCut, EveryTopologyStaysOneDisk) {
    for (const TriMesh& mesh :
         {test::icosphere(3), test::torus(1, 0.4, 24, 12), test::genus_plate(3), test::genus_plate(5, 2),
          test::annulus(1, 2, 20, 4), test::finger(0.2, 2, 12, 20, 4), grooved_body(20, 24, 0.4)}) {
        CutGraph cut(mesh);
        cut.cut_to_disk();
        const std::size_t step = mesh.positions.size() / 7 + 1;
        for (std::size_t v = 1; v < mesh.positions.size(); v += step) cut.join(static_cast<std::uint32_t>(v));
        const CutGraph before = weighed(cut), hidden = hide_cut(before);
        test::expect_links(hidden.open());
        test::expect_disk(hidden.open());
        EXPECT_LE(cost(hidden), cost(before));
    }
}

/// Six deep grooves that wind a quarter turn from pole to pole: the straight way crosses ridges.
TriMesh wound_body() {
    TriMesh mesh = grooved_body(44, 60, 0);
    for (Vec3d& p : mesh.positions) {
        const double turn = std::atan2(p.y, p.x) - kPi / 8 * p.z;
        const double radius = 0.75 + 0.25 * std::cos(6 * turn);
        p = {p.x * radius, p.y * radius, 1.5 * p.z};
    }
    return mesh;
}

TEST(HiddenCut, TheSearchGivesNoMoreErrorForItThanItMay) {
    const TriMesh body = wound_body();
    CutSearchOptions options;
    options.m = options.n = 49;
    const CutSearchResult hidden = search_cut(body, options, {});
    options.given_to_hide = 0;
    const CutSearchResult plain = search_cut(body, options, {});
    EXPECT_LE(hidden.rms, 1.01 * plain.rms);
    options.given_to_hide = 2;
    const CutSearchResult more = search_cut(body, options, {});
    EXPECT_LE(more.rms, 2 * plain.rms);
    EXPECT_LT(seam_exposure(more.disk, body), seam_exposure(plain.disk, body) - 0.02);
}

}  // namespace
}  // namespace dgm::bake
