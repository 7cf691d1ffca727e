// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/linked_grid_test.cpp
// The surfaces of a fit, the matches between them, and what is computed of both: rows and diagonals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "geometry/fit/diagonals.h"
#include "geometry/fit/fit_rows.h"
#include "geometry/fit/linked_surface.h"
#include "geometry/fit/matches.h"
#include "geometry/fit/welded_grid.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"
#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

TEST(LinkedSurface, KnowsTheFaceAcrossEachEdgeOfACutBall) {
    const TriMesh ball = repair(test::icosphere(2)).components.at(0);
    CutGraph cut(ball);
    cut.cut_to_disk();
    const LinkedSurface source = link_source(cut.open());
    ASSERT_EQ(source.positions.size(), 162u) << "10 * 4^2 + 2, once the cut is closed";
    for (std::uint32_t f = 0; f < source.faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t other = source.neighbours[f][k];
            ASSERT_NE(other, kNone);
            const std::uint32_t a = source.faces[f][k], b = source.faces[f][(k + 1) % 3];
            bool back = false;
            for (std::uint32_t e = 0; e < 3; ++e)
                back |= source.neighbours[other][e] == f && source.faces[other][e] == b &&
                        source.faces[other][(e + 1) % 3] == a;
            EXPECT_TRUE(back) << f << ' ' << k;
        }
}

TEST(LinkedSurface, NormalsAtScaleLookPastASpike) {
    TriMesh mesh = test::grid_sheet(20, 20);
    const std::uint32_t tip = 10 * 21 + 10;
    mesh.positions[tip].z = 0.5;
    const LinkedSurface surface = link_source(CutGraph(mesh).open());
    const std::vector<Vec3d> own = normals_at_scale(surface, 0), wide = normals_at_scale(surface, 0.1);
    int steep = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
        EXPECT_EQ(own[f], surface.normals[f]) << "no face is smaller than nothing";
        EXPECT_NEAR(length(wide[f]), 1, 1e-12);
        EXPECT_GT(wide[f].z, 0.25) << f;
        steep += own[f].z < 0.2;
    }
    EXPECT_EQ(steep, 6) << "the sides of the spike";
}

/// A strip bent into a hairpin: legs at z = 0 and z = 1, ten long.
LinkedSurface hairpin() {
    constexpr std::uint32_t kAlong = 43, kAcross = 3;
    TriMesh strip;
    for (std::uint32_t i = 0; i < kAlong; ++i) {
        const double t = 21.0 * i / (kAlong - 1);
        const Vec3d at = t < 10 ? Vec3d{t, 0, 0} : t < 11 ? Vec3d{10, 0, t - 10} : Vec3d{21 - t, 0, 1};
        for (std::uint32_t j = 0; j < kAcross; ++j) strip.positions.push_back(at + Vec3d{0, 0.5 * j, 0});
    }
    strip.faces = test::lattice_faces(kAlong, kAcross);
    return link_source(CutGraph(strip).open());
}

TEST(NearbySearch, FindsTheOtherLegWhereAWalkStaysOnItsOwn) {
    const LinkedSurface surface = hairpin();
    std::uint32_t start = 0;
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f)
        if (const auto q = surface.corners(f); q[0].z == 0 && std::abs(q[0].x - 7) < 0.1) start = f;
    const Vec3d p{7, 0.4, 0.9};
    EXPECT_NEAR(walk_to_closest(surface, p, start).squared, 0.81, 1e-12);
    NearbySearch search(surface);
    EXPECT_NEAR(search.from(p, start).squared, 0.01, 1e-12);
    EXPECT_NEAR(search.from(p, start).squared, 0.01, 1e-12) << "time and again";
}

TEST(NearbyFaces, VisitsEachOnceAndFourHundredAtMost) {
    const auto visited = [](const LinkedSurface& surface, std::uint32_t start) {
        std::vector<std::uint32_t> out;
        NearbyFaces(surface).visit(start, [&](std::uint32_t f) { out.push_back(f); });
        EXPECT_EQ(out.front(), start);
        EXPECT_EQ(std::set(out.begin(), out.end()).size(), out.size());
        return out.size();
    };
    const LinkedSurface small = hairpin(), large = link_source(CutGraph(test::grid_sheet(20, 20)).open());
    EXPECT_EQ(visited(small, 5), small.faces.size());
    EXPECT_EQ(large.faces.size(), 800u);
    EXPECT_EQ(visited(large, 399), 400u);
}

/// Counts of a triangulated disk of 9 x 9 samples by Euler's formula, and what each list promises of the others.
TEST(WeldedGrid, ListsAgreeWithEachOther) {
    const SampledChart chart = fit_test::flat_chart(9, 12);
    const WeldedGrid grid(chart);
    const std::size_t classes = 81, faces = 128;
    EXPECT_EQ(grid.surface.positions.size(), classes);
    ASSERT_EQ(grid.surface.faces.size(), faces);
    ASSERT_EQ(grid.edges.size(), classes + faces - 1);
    EXPECT_TRUE(std::is_sorted(grid.edges.begin(), grid.edges.end()));
    EXPECT_EQ(std::adjacent_find(grid.edges.begin(), grid.edges.end()), grid.edges.end());
    EXPECT_EQ(std::count(grid.on_border.begin(), grid.on_border.end(), 1), 4 * 8);
    for (std::uint32_t f = 0; f < faces; ++f) {
        EXPECT_EQ(grid.face_of_quad[f / 2], f - f % 2);
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = grid.surface.faces[f][k], b = grid.surface.faces[f][(k + 1) % 3];
            EXPECT_EQ(grid.edges[grid.edge_of[f][k]], std::pair(std::min(a, b), std::max(a, b)));
        }
    }
    const WeldedGrid::Rings rings = grid.rings();
    ASSERT_EQ(rings.first.size(), classes + 1);
    EXPECT_EQ(rings.first.back(), 3 * faces);
    for (std::uint32_t c = 0; c < classes; ++c)
        for (std::uint32_t k = rings.first[c]; k < rings.first[c + 1]; ++k) {
            const Face& face = grid.surface.faces[rings.faces[k]];
            EXPECT_NE(std::find(face.begin(), face.end(), c), face.end());
        }
}

/// The last column is the first: a tube, whose Euler characteristic is 0 and whose border is two rims.
TEST(WeldedGrid, CopiesAreOneClassAndMoveAsOne) {
    SampledChart chart = fit_test::flat_chart(9, 12);
    for (std::uint32_t i = 0; i < 9; ++i) chart.representative[i * 9 + 8] = i * 9;
    WeldedGrid grid(chart);
    EXPECT_EQ(grid.surface.positions.size(), 72u);
    EXPECT_EQ(grid.edges.size(), 72u + 128u);
    EXPECT_EQ(std::count(grid.on_border.begin(), grid.on_border.end(), 1), 2 * 8);
    const std::uint32_t c = grid.class_of[4 * 9];
    EXPECT_EQ(grid.class_of[4 * 9 + 8], c);
    EXPECT_EQ(grid.sample_of[c], 4u * 9);
    grid.surface.positions[c] = {7, 8, 9};
    grid.write_positions(chart);
    EXPECT_EQ(chart.positions[4 * 9], (Vec3d{7, 8, 9}));
    EXPECT_EQ(chart.positions[4 * 9 + 8], (Vec3d{7, 8, 9}));
    EXPECT_EQ(chart.positions[4 * 9 + 4].x, 0.5);
}

TEST(Matches, OfALiftedGridAreAllAsFarAsItWasLifted) {
    const SampledChart chart = fit_test::flat_chart(9, 12);
    const LinkedSurface source = link_source(*chart.disk);
    WeldedGrid grid(chart);
    Matches matches(chart, source, grid, 500);
    EXPECT_EQ(matches.area_points, 500u);
    EXPECT_EQ(matches.points.size(), 500u + 13 * 13) << "and the vertices of the source";
    EXPECT_NE(matches.source_index(), nullptr) << "288 faces above a grid of 128";
    matches.update(true);
    EXPECT_NEAR(matches.largest, 0, 1e-12);
    for (Vec3d& p : grid.surface.positions) p.z += 0.03;
    grid.surface.update_normals();
    matches.update(true);
    EXPECT_NEAR(matches.rms, 0.03, 1e-9);
    EXPECT_NEAR(matches.largest, 0.03, 1e-9);
    EXPECT_EQ(matches.faces_beyond(0.0299).size(), 128u);
    EXPECT_TRUE(matches.faces_beyond(0.0301).empty());
    double weight = 0;
    for (const auto* list : {&matches.classes, &matches.middles})
        for (const Match& m : *list) weight += m.weight;
    EXPECT_NEAR(weight, 100, 1e-9) << "a fifth of the source's 500 points";
}

TEST(Matches, AMiddleIsLookedUpAgainByItself) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    const Face face = c.fit.grid.surface.faces[40];
    c.position(face[1]) += Vec3d{0, 0, 0.06};
    c.fit.matches.update_middle(40);
    const auto q = c.fit.grid.surface.corners(40);
    EXPECT_NEAR(length(c.fit.matches.middles[40].position - (q[0] + q[1] + q[2]) / 3), 0, 1e-15);
    EXPECT_NEAR(c.fit.matches.middles[40].hit.squared, 0.02 * 0.02, 1e-12);
    EXPECT_NEAR(c.fit.matches.middles[41].hit.squared, 0, 1e-12);
}

/// The least-squares step of a lifted grid puts it back, and nothing asks it to move sideways.
TEST(FitRows, AskALiftedGridToComeDown) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    for (Vec3d& p : c.fit.grid.surface.positions) p.z += 0.02;
    c.look();
    const std::vector<Freedom> freedom(81, Freedom::kFree);
    for (const bool worst_only : {false, true}) {
        NormalEquations equations(c.fit.grid);
        c.fit.rows.assemble(equations, worst_only);
        for (const Vec3d& step : equations.solve(freedom, {}, 1e-9, 200)) {
            EXPECT_NEAR(step.z, -0.02, 1e-3);  // solved to a hundredth: the next round does the rest
            EXPECT_NEAR(std::hypot(step.x, step.y), 0, 1e-3);
        }
    }
}

/// Rows of a part of the grid are enough to put that part back.
TEST(FitRows, OfAFewFacesBringTheirCornersDown) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    for (Vec3d& p : c.fit.grid.surface.positions) p.z += 0.02;
    c.look();
    std::vector<char> near(128, 0), corner(81, 0);
    near[60] = near[61] = 1;
    for (const std::uint32_t f : {60U, 61U})
        for (const std::uint32_t v : c.fit.grid.surface.faces[f]) corner[v] = 1;
    NormalEquations equations(c.fit.grid);
    c.fit.rows.assemble(equations, false, near);
    std::vector<Freedom> freedom(81, Freedom::kHeld);
    for (std::size_t v = 0; v < freedom.size(); ++v)
        if (corner[v]) freedom[v] = Freedom::kFree;
    const std::vector<Vec3d> step = equations.solve(freedom, {}, 1e-9, 200);
    for (std::size_t v = 0; v < step.size(); ++v) EXPECT_NEAR(step[v].z, corner[v] ? -0.02 : 0, 1e-3) << v;
}

/// A roof with its ridge on x = y: quads on it must be split along it, at the border as well.
TEST(FitDiagonals, FollowARidge) {
    SampledChart chart = fit_test::sheet_chart(9, 8, [](double x, double y) { return 0.5 * std::abs(x - y); });
    chart.diagonals.assign(64, 1);
    fit_test::FitCase c(std::move(chart));
    ASSERT_GT(c.fit.matches.largest, 0.01);
    const std::vector<char> changed = fit_diagonals(c.chart, c.fit.grid, c.fit.matches, c.fit.source);
    for (std::uint32_t i = 0; i < 8; ++i) {
        EXPECT_EQ(c.chart.diagonals[i * 8 + i], 0) << i;
        EXPECT_TRUE(changed[c.fit.grid.face_of_quad[i * 8 + i]]) << i;
    }
}

/// A quad whose fourth corner has moved across the diagonal: an arrowhead, which the other diagonal splits soundly.
TEST(FlipDiagonals, SplitAnArrowheadTheOtherWay) {
    for (const bool measured : {false, true}) {
        fit_test::FitCase c(fit_test::flat_chart(9, 12));
        const Vec3d a = c.position(c.class_at(3, 3)), b = c.position(c.class_at(4, 3)),
                    far = c.position(c.class_at(4, 4));
        c.position(c.class_at(3, 4)) = a * 0.25 + b * 0.5 + far * 0.25;
        c.look();
        const std::uint32_t quad = 3 * 8 + 3, face = c.fit.grid.face_of_quad[quad];
        EXPECT_EQ(fit_test::faces_upside_down(c.fit.grid.surface).front(), face + 1);
        const std::array<std::uint32_t, 1> asked{face + 1};
        const ClosestPointIndex* index = measured ? &c.fit.inverted.source_index() : nullptr;
        EXPECT_TRUE(flip_diagonals(c.chart, c.fit.grid, asked, index));
        EXPECT_EQ(c.chart.diagonals[quad], 1);
        EXPECT_EQ(std::count(c.chart.diagonals.begin(), c.chart.diagonals.end(), 1), 1);
        c.fit.relink();
        const std::vector<std::uint32_t> left = fit_test::faces_upside_down(c.fit.grid.surface);
        EXPECT_FALSE(std::binary_search(left.begin(), left.end(), face));
        EXPECT_FALSE(std::binary_search(left.begin(), left.end(), face + 1));
        EXPECT_FALSE(flip_diagonals(c.chart, c.fit.grid, asked, index)) << "it is sound now";
    }
}

}  // namespace
}  // namespace dgm::bake
