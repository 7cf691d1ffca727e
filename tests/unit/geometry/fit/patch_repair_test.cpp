// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/patch_repair_test.cpp
#include "geometry/fit/patch_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/fit/fit.h"
#include "geometry/fit/fit_state.h"
#include "geometry/fit/local_repair.h"
#include "geometry/fit/search_repair.h"
#include "geometry/metrics/turned_faces.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"
#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

SampledChart square_chart(const TriMesh& mesh, std::uint32_t side) {
    const TriMesh component = repair(mesh).components.at(0);
    CutGraph cut(component);
    cut.cut_to_disk();
    const Disk disk = cut.open();
    return make_square_chart(disk, side, side, candidate_rotations(disk, side, side, 1).front(),
                             *make_stretch_parameterizer(5), {});
}

/// Turns the samples at most two edges from that of `centre` by 170 degrees about `axis` through it: the ring around
/// them shears through itself.
void twist(SampledChart& chart, std::uint32_t centre, const Vec3d& axis) {
    const WeldedGrid grid(chart);
    std::vector<char> near(grid.sample_of.size(), 0);
    near[grid.class_of[centre]] = 1;
    for (int ring = 0; ring < 2; ++ring) {
        std::vector<char> next = near;
        for (const auto& [a, b] : grid.edges) {
            next[a] |= near[b];
            next[b] |= near[a];
        }
        near.swap(next);
    }
    const Vec3d k = normalized(axis, Vec3d{}), origin = chart.positions[centre];
    const double angle = 2.967, cosine = std::cos(angle), sine = std::sin(angle);
    for (std::size_t s = 0; s < chart.positions.size(); ++s) {
        if (!near[grid.class_of[s]] || grid.on_border[grid.class_of[s]]) continue;
        const Vec3d v = chart.positions[s] - origin;
        chart.positions[s] = origin + v * cosine + cross(k, v) * sine + k * (dot(k, v) * (1 - cosine));
    }
}

struct Result {
    SampledChart chart;
    std::size_t start = 0, searched = 0, left = 0;  // turned faces: before, after a search of single samples, and after
    bool moved = false;
};

/// @param held  all classes, or the source's border alone
Result unfolded(const SampledChart& chart, bool held) {
    Result out{chart};
    const LinkedSurface source = link_source(*chart.disk);
    const ClosestPointIndex index(source.positions, source.faces);
    const auto turned = [&](const LinkedSurface& surface) {
        TriMesh mesh;
        mesh.positions = surface.positions;
        mesh.faces = surface.faces;
        return find_turned_faces(index, mesh, kTurnedTie);
    };
    WeldedGrid grid(chart), other(chart);
    Matches matches(chart, source, grid, 4000), other_matches(chart, source, other, 4000);
    matches.update(false);
    other_matches.update(false);
    const std::vector<char> fixed = held ? std::vector<char>(grid.sample_of.size(), 1) : grid.on_border;
    const std::vector<std::uint32_t> faces = turned(grid.surface);
    out.start = faces.size();
    SearchEffort tries;
    repair_by_search(source, index, other, other_matches, fixed, faces, tries);
    out.searched = turned(other.surface).size();
    std::size_t effort = 100'000;
    out.moved = repair_by_patch(source, index, source.normals, grid, matches, fixed, faces, effort);
    out.left = turned(grid.surface).size();
    grid.write_positions(out.chart);
    for (std::size_t c = 0; c < grid.sample_of.size(); ++c)
        EXPECT_LT(length(point_at(source, matches.classes[c].hit) - grid.surface.positions[c]), 1e-9) << c;
    return out;
}

/// A twist of the sheet `start` is laid flat: all faces of a flat sheet look its way and none overlap, so their areas
/// add up to the sheet's. The border stays.
Result expect_twist_laid_flat(const SampledChart& start, const SampledChart& twisted) {
    Result r = unfolded(twisted, false);
    EXPECT_GT(r.start, 8u);
    EXPECT_EQ(r.left, 0u);
    EXPECT_NEAR(surface_area(r.chart.surface()), surface_area(start.surface()), 1e-9);
    for (std::uint32_t k = 0; k < 17; ++k) EXPECT_EQ(r.chart.positions[k], start.positions[k]);
    return r;
}

TEST(Unfold, LaysATwistInsideASheetFlat) {
    const SampledChart start = square_chart(test::grid_sheet(40, 40), 17);
    SampledChart twisted = start;
    twist(twisted, 8 * 17 + 8, {0, 0, 1});
    const Result r = expect_twist_laid_flat(start, twisted);
    EXPECT_TRUE(r.moved);
    EXPECT_EQ(unfolded(twisted, false).chart.positions, r.chart.positions);
    const Result held = unfolded(twisted, true);
    EXPECT_FALSE(held.moved);
    EXPECT_EQ(held.chart.positions, twisted.positions);
}

TEST(Unfold, LaysATwistBesideTheBorderFlatAndKeepsTheBorder) {
    const SampledChart start = square_chart(test::grid_sheet(40, 40), 17);
    SampledChart twisted = start;
    twist(twisted, 3 * 17 + 8, {0, 0, 1});
    expect_twist_laid_flat(start, twisted);
}

TEST(Unfold, CopiesOfASeamMoveAsOne) {
    SampledChart twisted = square_chart(test::icosphere(5), 33);
    std::uint32_t on_seam = 16;  // in the middle of a side
    ASSERT_NE(std::count(twisted.representative.begin(), twisted.representative.end(), twisted.representative[on_seam]),
              1);
    twist(twisted, on_seam, twisted.positions[on_seam]);
    const Result r = unfolded(twisted, false);
    EXPECT_GT(r.start, 8u);
    EXPECT_EQ(r.left, 0u);
    EXPECT_NE(r.chart.positions, twisted.positions);
    for (std::size_t s = 0; s < r.chart.positions.size(); ++s)
        EXPECT_EQ(r.chart.positions[s], r.chart.positions[r.chart.representative[s]]);
}

TEST(LocalRepair, MovesWhatIsHeldAtAPriceAlone) {
    const std::uint32_t moved = 8 * 17 + 8;
    const auto left = [&](bool at_a_price, double way) {
        SampledChart chart = square_chart(test::grid_sheet(40, 40), 17);
        chart.positions[moved] += (chart.positions[moved + 1] - chart.positions[moved]) * way;
        FitState fit(chart, l2_fit());
        std::fill(fit.fixed.begin(), fit.fixed.end(), 1);  // as the ears of a jagged border
        fit.matches.update(false);
        fit.keep();
        LocalRepair repair(fit);
        repair.repair();
        repair.repair_nearly();
        if (at_a_price) repair.repair_at_a_price();
        return fit.inverted.faces().size();
    };
    EXPECT_EQ(left(false, 0), 0u);
    EXPECT_GT(left(false, 2.3), 0u);
    EXPECT_EQ(left(true, 2.3), 0u);
}

TEST(PatchRepair, StopsOnceItsEffortIsSpent) {
    SampledChart twisted = square_chart(test::grid_sheet(40, 40), 17);
    twist(twisted, 8 * 17 + 8, {0, 0, 1});
    for (const std::size_t effort : {std::size_t{0}, kPatchEffort}) {
        fit_test::FitCase c(twisted);
        std::size_t left = effort;
        const std::vector<std::uint32_t> inverted = c.fit.inverted.faces();
        EXPECT_EQ(repair_by_patch(c.fit.source, c.fit.inverted.source_index(), c.fit.upward, c.fit.grid, c.fit.matches,
                                  c.fit.fixed, inverted, left, {}),
                  effort > 0);
        EXPECT_EQ(c.fit.inverted.faces().empty(), effort > 0);
        EXPECT_EQ(left<effort, effort> 0);
    }
}

TEST(Fit, LaysPatchesFlatThatNoSingleSampleCanMend) {
    SampledChart twisted = square_chart(test::grid_sheet(40, 40), 17);
    const double area = surface_area(twisted.surface());
    twist(twisted, 8 * 17 + 8, {0, 0, 1});
    EXPECT_GT(unfolded(twisted, false).searched, 0u);
    for (const FitOptions& options : {l2_fit(), best_fit()}) {
        SampledChart fitted = twisted;
        fit_chart(fitted, options, {});
        EXPECT_NEAR(surface_area(fitted.surface()), area, 1e-6 * area) << options.rounds;
    }
}

}  // namespace
}  // namespace dgm::bake
