// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/repairs_test.cpp
// Inverted faces: found, repaired sample by sample, and kept away while positions are rounded.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/fit/inverted_faces.h"
#include "geometry/fit/lattice_snap.h"
#include "geometry/fit/local_repair.h"
#include "geometry/fit/vertex_repair.h"
#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

/// Against a flat source a face is inverted if it looks down.
TEST(InvertedFaces, AreThoseThatLookDownOnAFlatSource) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    InvertedFaces& inverted = c.fit.inverted;
    EXPECT_TRUE(inverted.faces().empty());
    const Vec3d before = c.position(c.class_at(4, 4));
    c.invert_at(4, 4);
    const std::vector<std::uint32_t> down = fit_test::faces_upside_down(c.fit.grid.surface);
    ASSERT_GE(down.size(), 2u);
    EXPECT_EQ(inverted.faces(), down);
    EXPECT_EQ(inverted.doubtful_faces(c.fit.matches, 0.02), down);
    const std::vector<std::uint32_t> nearly = inverted.faces({}, true);
    EXPECT_TRUE(std::includes(nearly.begin(), nearly.end(), down.begin(), down.end()));
    std::vector<char> among(c.fit.grid.surface.faces.size(), 0);
    among[down[1]] = 1;
    EXPECT_EQ(inverted.faces(among), std::vector<std::uint32_t>{down[1]});
    c.position(c.class_at(4, 4)) = before;
    EXPECT_TRUE(inverted.faces().empty()) << "what it remembers is of faces that have moved since";
}

TEST(VertexRepair, MovesSamplesUntilNoFaceLooksDown) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    c.invert_at(4, 4);
    const std::vector<Vec3d> before = c.fit.grid.surface.positions;
    const std::vector<char> none_free(before.size(), 1);
    EXPECT_FALSE(repair_by_vertex(c.fit.source, c.fit.grid, c.fit.matches, none_free, 0.02));
    EXPECT_EQ(c.fit.grid.surface.positions, before);
    EXPECT_TRUE(repair_by_vertex(c.fit.source, c.fit.grid, c.fit.matches, c.fit.fixed, 0.02));
    EXPECT_TRUE(fit_test::faces_upside_down(c.fit.grid.surface).empty());
    for (std::size_t k = 0; k < before.size(); ++k) {
        EXPECT_NEAR(c.fit.grid.surface.positions[k].z, 0, 1e-12) << "places on the source";
        if (c.fit.fixed[k]) { EXPECT_EQ(c.fit.grid.surface.positions[k], before[k]); }
    }
}

TEST(VertexRepair, OfNamedFacesTriesTheirCornersAlone) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    c.invert_at(4, 4);
    const std::vector<std::uint32_t> down = fit_test::faces_upside_down(c.fit.grid.surface);
    const std::vector<Vec3d> before = c.fit.grid.surface.positions;
    EXPECT_TRUE(repair_by_vertex(c.fit.source, c.fit.grid, c.fit.matches, c.fit.fixed, down));
    EXPECT_LT(fit_test::faces_upside_down(c.fit.grid.surface).size(), down.size());
    std::vector<char> corner(before.size(), 0);
    for (const std::uint32_t f : down)
        for (const std::uint32_t v : c.fit.grid.surface.faces[f]) corner[v] = 1;
    for (std::size_t k = 0; k < before.size(); ++k)
        if (!corner[k]) { EXPECT_EQ(c.fit.grid.surface.positions[k], before[k]) << k; }
}

TEST(LocalRepair, LeavesNoInvertedFaceAndKeepsThatState) {
    for (const bool holds_largest : {false, true}) {
        fit_test::FitCase c(
            fit_test::sheet_chart(17, 24, [](double x, double y) { return 0.2 * std::sin(3 * x) * std::cos(2 * y); }));
        c.invert_at(4, 4);
        c.invert_at(11, 9);
        c.fit.keep();
        const double broken_rms = c.fit.kept.rms;
        ASSERT_FALSE(c.fit.inverted.faces().empty());
        c.fit.holds_largest = holds_largest;
        LocalRepair repair(c.fit);
        repair.repair();
        EXPECT_TRUE(c.fit.inverted.faces().empty());
        EXPECT_EQ(c.fit.kept.positions, c.fit.grid.surface.positions);
        EXPECT_LT(c.fit.kept.rms, broken_rms);
        EXPECT_NEAR(c.fit.kept.rms, c.fit.matches.rms, 1e-12);
        const std::vector<Vec3d> repaired = c.fit.grid.surface.positions;
        repair.repair();
        EXPECT_EQ(c.fit.grid.surface.positions, repaired) << "nothing is left to do";
        repair.repair_nearly();
        EXPECT_TRUE(c.fit.inverted.faces({}, true).empty()) << "not even by rounding";
    }
}

/// Rounding with a view to the rows cannot be worse than rounding each coordinate by itself.
TEST(LatticeSnap, PutsSamplesOnTheLatticeAndLosesLessThanRounding) {
    const Lattice lattice{{-0.501, -0.502, -0.503}, 0.004};
    fit_test::FitCase c(fit_test::sheet_chart(17, 24, [](double x, double y) { return 0.3 * x * x + 0.2 * x * y; }));
    NormalEquations equations(c.fit.grid);
    c.fit.rows.assemble(equations, false);
    const std::vector<Vec3d> start = c.fit.grid.surface.positions;
    for (Vec3d& p : c.fit.grid.surface.positions) p = lattice.nearest(p);
    c.look();
    const double rounded = c.fit.matches.rms;
    c.fit.grid.surface.positions = start;
    c.look();
    const std::vector<Freedom> freedom(start.size(), Freedom::kFree);
    snap_to_lattice(lattice, equations, freedom, c.chart.grid_count(), c.fit.source, c.fit.grid, c.fit.matches,
                    c.fit.inverted);
    EXPECT_LT(c.fit.matches.rms, 0.9 * rounded);
    EXPECT_TRUE(c.fit.inverted.faces().empty());
    for (std::size_t k = 0; k < start.size(); ++k) {
        EXPECT_TRUE(lattice.holds(c.fit.grid.surface.positions[k])) << k;
        EXPECT_LT(length(c.fit.grid.surface.positions[k] - start[k]), 4 * lattice.step) << k;
    }
}

/// Border samples of a free chart, beyond the grid's, are stored as they are.
TEST(LatticeSnap, LeavesSamplesBeyondTheGridAlone) {
    const Lattice lattice{{-0.501, -0.502, -0.503}, 0.004};
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    NormalEquations equations(c.fit.grid);
    c.fit.rows.assemble(equations, false);
    const std::vector<Vec3d> start = c.fit.grid.surface.positions;
    const std::vector<Freedom> freedom(start.size(), Freedom::kFree);
    snap_to_lattice(lattice, equations, freedom, 40, c.fit.source, c.fit.grid, c.fit.matches, c.fit.inverted);
    for (std::size_t k = 0; k < start.size(); ++k) {
        if (c.fit.grid.sample_of[k] < 40)
            EXPECT_TRUE(lattice.holds(c.fit.grid.surface.positions[k])) << k;
        else
            EXPECT_EQ(c.fit.grid.surface.positions[k], start[k]) << k;
    }
}

}  // namespace
}  // namespace dgm::bake
