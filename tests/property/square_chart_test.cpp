// SPDX-License-Identifier: GPL-3.0-or-later
// tests/property/square_chart_test.cpp
// Laws of a square chart of any surface: one to one, watertight, of the source's topology, better when finer.
#include "geometry/chart/square_chart.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <string>

#include "geometry/cut/cut_graph.h"
#include "geometry/cut_search/cut_search.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/repair/repair.h"
#include "model/codes.h"
#include "support/chart_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

TriMesh component(const TriMesh& mesh) {
    return repair(mesh).components.at(0);
}

SampledChart chart_of(const TriMesh& mesh, std::uint32_t m, std::uint32_t n, std::size_t newton_steps = 0,
                      std::size_t which_rotation = 0) {
    CutGraph cut(mesh);
    cut.cut_to_disk();
    const Disk disk = cut.open();
    const std::vector<std::uint32_t> rotations = candidate_rotations(disk, m, n, 4);
    return make_square_chart(disk, m, n, rotations[which_rotation % rotations.size()],
                             *make_stretch_parameterizer(newton_steps), {});
}

struct Named {
    const char* name;
    TriMesh mesh;
};
void PrintTo(const Named& named, std::ostream* out) {
    *out << named.name;
}

std::vector<Named> surfaces() {
    const std::array<std::array<std::uint32_t, 2>, 5> holes{{{1, 1}, {1, 9}, {9, 1}, {9, 9}, {5, 5}}};
    TriMesh punctured = test::torus(1, 0.4, 32, 16);
    punctured.faces.erase(punctured.faces.begin() + 100, punctured.faces.begin() + 102);
    return {{"ball", test::icosphere(3)},
            {"tetrahedral_ball", test::icosphere(0)},
            {"torus", test::torus(1, 0.4, 32, 16)},
            {"genus_3", test::genus_plate(3, 2)},
            {"annulus", test::annulus(1, 2, 40, 8)},
            {"sheet", test::grid_sheet(12, 9, 2, 1)},
            {"triangle", test::polygon_disk(3)},
            {"round_disk", test::polygon_disk(24)},
            {"five_holes", test::sheet_with_holes(11, holes)},
            {"torus_with_a_hole", punctured},
            {"finger", test::finger(0.3, 1, 16, 12, 6)},
            {"pillow", test::double_sided_quad()},
            {"slit", test::slit_sheet(10, 0.001)}};
}

TEST(LaidDisk, GivesTheChartsOfADiskLaidForEach) {
    const TriMesh mesh = component(test::torus(1, 0.4, 32, 16));
    CutGraph cut(mesh);
    cut.cut_to_disk();
    const Disk disk = cut.open();
    const LaidDisk laid = lay_disk(disk, 33, 33, 2);
    for (const Levelling levelling : {Levelling::kCurvature, Levelling::kDirections}) {
        const auto method = make_stretch_parameterizer(8, levelling);
        const SampledChart shared = make_square_chart(laid, *method, {}),
                           own = make_square_chart(disk, 33, 33, 2, *method, {});
        EXPECT_EQ(&*shared.disk, &*laid.disk);
        EXPECT_EQ(shared.uv, own.uv);
        EXPECT_EQ(shared.positions, own.positions);
        EXPECT_EQ(shared.representative, own.representative);
    }
}

class SquareChart : public testing::TestWithParam<Named> {};

TEST_P(SquareChart, IsOneToOneAndWatertight) {
    const TriMesh mesh = component(GetParam().mesh);
    for (const auto& [m, n] : {std::pair{33u, 33u}, {65u, 33u}, {48u, 51u}})
        for (std::size_t rotation : {0u, 1u}) {
            SCOPED_TRACE(std::to_string(m) + "x" + std::to_string(n) + ", rotation " + std::to_string(rotation));
            const SampledChart chart = chart_of(mesh, m, n, rotation == 0 ? 0 : 3, rotation);
            EXPECT_EQ(chart.m, m);
            EXPECT_EQ(chart.n, n);
            ASSERT_EQ(chart.samples.size(), std::size_t{m} * n);
            EXPECT_TRUE(chart.mask.empty()) << "all samples are on the surface";
            ASSERT_NO_FATAL_FAILURE(test::expect_bijective(chart));
            ASSERT_NO_FATAL_FAILURE(test::expect_classes(chart));
            ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
            // Only border samples have copies.
            for (std::uint32_t s = 0; s < chart.representative.size(); ++s) {
                const std::uint32_t i = s / n, j = s % n;
                if (i > 0 && j > 0 && i < m - 1 && j < n - 1) { ASSERT_EQ(chart.representative[s], s); }
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Surfaces, SquareChart, testing::ValuesIn(surfaces()),
                         [](const auto& at) { return at.param.name; });

/// A tube about the z axis, bent along a spiral of three turns.
TriMesh bent_tube(double radius, std::uint32_t around, std::uint32_t along) {
    TriMesh mesh = test::tube(1, 1, 1, around, along);
    for (Vec3d& p : mesh.positions) {
        const double turn = 6 * std::numbers::pi * p.z, out = 3 + radius * p.x;
        p = {out * std::cos(turn), out * std::sin(turn), 8 * p.z + radius * p.y};
    }
    return mesh;
}

std::vector<Named> rings() {
    TriMesh hat = test::annulus(0.1, 2, 48, 24);
    for (Vec3d& p : hat.positions) p.z = 1.2 * std::exp(-std::pow(dot(p, p), 2));
    return {{"annulus", test::annulus(1, 2, 40, 8)},   {"pinhole", test::annulus(1e-4, 1, 40, 20)},
            {"tube", test::tube(1, 1, 2, 24, 10)},     {"long_tube", test::tube(1, 1, 500, 12, 300)},
            {"band", test::tube(1, 1, 0.02, 60, 1)},   {"pinched", test::tube(1, 1e-5, 3, 24, 20)},
            {"triangular", test::tube(1, 2, 1, 3, 1)}, {"hat", hat},
            {"three_turns", bent_tube(0.8, 20, 120)}};
}

class RingChart : public testing::TestWithParam<Named> {};

/// Loops on opposite sides, their cut on the others: copies lie in one line of the grid and nowhere else.
TEST_P(RingChart, IsOneToOneAndWatertight) {
    const TriMesh mesh = component(GetParam().mesh);
    for (const auto& [m, n] : {std::pair{33u, 33u}, {65u, 17u}, {16u, 51u}}) {
        SCOPED_TRACE(std::to_string(m) + "x" + std::to_string(n));
        CutSearchOptions options;
        options.m = m;
        options.n = n;
        options.rings = 3;
        const CutSearchResult cut = search_cut(mesh, options, {});
        ASSERT_TRUE(faces_loops(cut.shares));
        const SampledChart chart =
            make_square_chart(cut.disk, m, n, cut.rotation, *make_stretch_parameterizer(3), {}, cut.shares);
        ASSERT_NO_FATAL_FAILURE(test::expect_bijective(chart));
        ASSERT_NO_FATAL_FAILURE(test::expect_classes(chart));
        ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
        const bool on_m = cut.shares == BorderShares::kLoopsOnM;
        for (std::uint32_t s = 0; s < chart.representative.size(); ++s) {
            const std::uint32_t i = s / n, j = s % n;
            const bool second = on_m ? i == m - 1 : j == n - 1;
            ASSERT_EQ(chart.representative[s], !second ? s : on_m ? j : i * n) << i << ", " << j;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Rings, RingChart, testing::ValuesIn(rings()), [](const auto& at) { return at.param.name; });

/// The error of a piecewise linear surface falls with the square of the step: 12 dB a doubling where the map is smooth.
TEST(SquareChartError, FallsWhenTheGridIsDoubled) {
    for (const Named& named : {Named{"ball", test::icosphere(5)}, Named{"torus", test::torus(1, 0.4, 128, 64)}}) {
        const TriMesh mesh = component(named.mesh);
        double last = 0;
        for (std::uint32_t side : {17u, 33u, 65u}) {
            const double psnr = quick_error(mesh, chart_of(mesh, side, side, 3), 20'000).psnr();
            if (last > 0) { EXPECT_GE(psnr, last + 8.5) << named.name << " at " << side; }
            last = psnr;
        }
        EXPECT_GT(last, 45) << named.name;
    }
}

TEST(SquareChartError, AFlatSheetIsReproducedExactly) {
    const TriMesh mesh = component(test::grid_sheet(7, 5, 3, 2));
    EXPECT_LT(quick_error(mesh, chart_of(mesh, 17, 17), 5'000).hausdorff, 1e-12);
}

TEST(SquareChartError, TooSmallAGridIsRefusedNotBroken) {
    const TriMesh mesh = component(test::genus_plate(5));
    try {
        const SampledChart chart = chart_of(mesh, 5, 5);
        FAIL() << "24 of 16 intervals";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kGridTooSmall.number); }
}

/// A limb must be cut to be seen: a long finger is a disk already, but its tip shrinks to nothing until it is joined to
/// the border.
TEST(CutSearch, CutsALongFingerOpen) {
    const TriMesh mesh = component(test::finger(0.2, 2, 24, 40, 8));
    CutSearchOptions options;
    options.m = options.n = 49;
    options.samples = 4000;
    options.max_extremities = 12;
    const CutSearchResult found = search_cut(mesh, options, {});
    test::expect_links(found.disk);
    test::expect_disk(found.disk);
    const SampledChart chart =
        make_square_chart(found.disk, 49, 49, found.rotation, *make_stretch_parameterizer(0), {});
    test::expect_topology(chart, mesh);
    const double first = quick_error(mesh, chart_of(mesh, 49, 49), 20'000).rms,
                 best = quick_error(mesh, chart, 20'000).rms;
    EXPECT_LT(best, 0.6 * first);  // uncut, the tip is small but no longer lost
    EXPECT_NEAR(best, found.rms, 0.3 * best) << "the error that it predicts is about the error that is there";
    EXPECT_GT(found.cut_length, 0);
    EXPECT_GT(found.trials, 1);
}

TEST(CutSearch, StopsWhenAskedTo) {
    const std::atomic<bool> cancelled = true;
    model::Progress progress;
    progress.cancelled = &cancelled;
    try {
        (void)search_cut(component(test::icosphere(2)), {}, progress);
        FAIL() << "ran on";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kInterrupted.number); }
}

TEST(CutSearch, LeavesADiskAlone) {
    CutSearchOptions options;
    options.m = options.n = 33;
    options.samples = 2000;
    const CutSearchResult found = search_cut(component(test::grid_sheet(8, 8)), options, {});
    EXPECT_EQ(found.cut_length, 0);
    EXPECT_LT(found.rms, 1e-12);
}

}  // namespace
}  // namespace dgm::bake
