// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/spherical_map_test.cpp
// Maps to the sphere cover it once, and the octahedra laid on it unfold onto the square.
#include "geometry/parameterize/spherical_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "geometry/chart/square_chart.h"
#include "geometry/cut_search/cut_search.h"
#include "geometry/cut_search/star_cut.h"
#include "model/codes.h"
#include "support/chart_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

constexpr double kPi = std::numbers::pi;

TriMesh ellipsoid(int levels, Vec3d axes) {
    TriMesh mesh = test::icosphere(levels);
    for (Vec3d& p : mesh.positions) p = {p.x * axes.x, p.y * axes.y, p.z * axes.z};
    return mesh;
}

/// [van Oosterom, Strackee 1983]
double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return 2 * std::atan2(dot(a, cross(b, c)), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

int number_of(const auto& body) {
    try {
        body();
    } catch (const model::Error& e) { return static_cast<int>(e.code().number); }
    return 0;
}

TEST(SurelyOutward, TellsTheSidesApart) {
    const Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    EXPECT_TRUE(surely_outward(x, y, z));
    EXPECT_TRUE(surely_outward(y, z, x));
    EXPECT_FALSE(surely_outward(y, x, z));
    const double r = std::sqrt(0.5);
    EXPECT_FALSE(surely_outward(x, {r, r, 0}, y)) << "on a great circle";
    EXPECT_FALSE(surely_outward(x, x, y));
    // Near each other: the determinant is 1e-14, of terms near 1.
    EXPECT_TRUE(surely_outward({1, 0, 0}, {1, 1e-7, 0}, {1, 0, 1e-7}));
    EXPECT_FALSE(surely_outward({1, 0, 0}, {1, 0, 1e-7}, {1, 1e-7, 0}));
}

TEST(SphericalMap, CoversTheSphereOnce) {
    for (const Vec3d axes : {Vec3d{1, 1, 1}, Vec3d{1, 1, 4}, Vec3d{0.2, 1, 2}}) {
        const TriMesh mesh = ellipsoid(3, axes);
        const std::vector<Vec3d> sphere = spherical_map(mesh, {}, {});
        ASSERT_EQ(sphere.size(), mesh.positions.size());
        for (const Vec3d& p : sphere) EXPECT_NEAR(length(p), 1, 1e-12);
        double total = 0;
        for (const Face& f : mesh.faces) {
            const double angle = solid_angle(sphere[f[0]], sphere[f[1]], sphere[f[2]]);
            EXPECT_GT(angle, 0);
            total += angle;
        }
        EXPECT_NEAR(total, 4 * kPi, 1e-9);
    }
}

TEST(SphericalMap, SphereKeepsItsAreas) {
    const TriMesh mesh = test::icosphere(4);
    const std::vector<Vec3d> sphere = spherical_map(mesh, {}, {});
    for (const Face& f : mesh.faces) {
        const double share = solid_angle(sphere[f[0]], sphere[f[1]], sphere[f[2]]) /
                             solid_angle(mesh.positions[f[0]], mesh.positions[f[1]], mesh.positions[f[2]]);
        EXPECT_GT(share, 0.8);
        EXPECT_LT(share, 1.25);
    }
}

TEST(SphericalMap, IsTheSameTwice) {
    const TriMesh mesh = ellipsoid(3, {1, 2, 3});
    EXPECT_EQ(spherical_map(mesh, {}, {}), spherical_map(mesh, {}, {}));
}

TEST(SphericalMap, TetrahedronIsTheBase) {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const std::vector<Vec3d> sphere = spherical_map(mesh, {}, {});
    for (const Face& f : mesh.faces) EXPECT_TRUE(surely_outward(sphere[f[0]], sphere[f[1]], sphere[f[2]]));
}

TEST(SphericalMap, RefusesWhatIsNoSphere) {
    const int unsuited = static_cast<int>(model::codes::kMethodUnsuited.number);
    EXPECT_EQ(number_of([] { (void)spherical_map(test::torus(2, 1, 16, 12), {}, {}); }), unsuited);
    EXPECT_EQ(number_of([] { (void)spherical_map(test::grid_sheet(4, 4), {}, {}); }), unsuited);
}

TEST(StarCuts, FourArmsAQuarterRoundEach) {
    const TriMesh mesh = test::icosphere(4);
    const std::vector<CutGraph> cuts = star_cuts(mesh, 6, {});
    ASSERT_EQ(cuts.size(), 6u);
    for (const CutGraph& cut : cuts) {
        const std::vector<BorderPath> paths = cut.open().paths();
        ASSERT_EQ(paths.size(), 8u);
        for (std::size_t p = 0; p < 8; ++p) {
            EXPECT_EQ(paths[paths[p].mate].mate, p);
            EXPECT_TRUE(paths[p].mate == (p + 1) % 8 || paths[p].mate == (p + 7) % 8);
            // The octahedron's edge, and what a way along edges is longer.
            EXPECT_GT(paths[p].length, 0.85 * kPi / 2);
            EXPECT_LT(paths[p].length, 1.3 * kPi / 2);
        }
    }
}

TEST(EqualArms, EachSideFoldsAtItsMiddle) {
    const TriMesh mesh = ellipsoid(3, {1, 1, 2});
    const std::uint32_t m = 33, n = 17;
    Disk disk = star_cuts(mesh, 1, {}).at(0).open();
    const SquareBorder border = lay_square_border(disk, m, n, 0, BorderShares::kEqualArms);
    const BorderGrid grid{m, n};
    const auto class_of = [&](std::uint32_t t) { return border.samples[t % grid.count()].same_as; };
    std::set<std::uint32_t> classes;
    for (int k = 0; k < 4; ++k) {
        EXPECT_EQ(class_of(grid.corner(k)), class_of(0));
        const std::uint32_t intervals = k % 2 == 0 ? m - 1 : n - 1;
        for (std::uint32_t q = 0; q <= intervals; ++q)
            EXPECT_EQ(class_of(grid.corner(k) + q), class_of(grid.corner(k) + intervals - q));
        for (std::uint32_t q = 1; q <= intervals / 2; ++q) classes.insert(class_of(grid.corner(k) + q));
    }
    // Nothing else is joined: the arms' samples and the middle.
    EXPECT_EQ(classes.size(), m - 1 + n - 1u);
}

TEST(EqualArms, NeedAMiddleAndAStar) {
    const int unsuited = static_cast<int>(model::codes::kMethodUnsuited.number);
    const TriMesh mesh = test::icosphere(3);
    const CutGraph star = star_cuts(mesh, 1, {}).at(0);
    for (const auto& [m, n] : {std::pair{32u, 33u}, std::pair{33u, 32u}})
        EXPECT_EQ(number_of([&, rows = m, cols = n] {
                      Disk disk = star.open();
                      (void)lay_square_border(disk, rows, cols, 0, BorderShares::kEqualArms);
                  }),
                  unsuited);
    CutGraph path(mesh);
    path.cut_to_disk();
    Disk disk = path.open();
    EXPECT_EQ(number_of([&] { (void)lay_square_border(disk, 33, 33, 0, BorderShares::kEqualArms); }), unsuited);
}

TEST(OnlyStars, MakeAWholeChart) {
    CutSearchOptions options;
    options.m = options.n = 33;
    options.stars = 4;
    options.only_stars = true;
    for (const int levels : {3, 5}) {  // searched as it is, and simplified
        const TriMesh mesh = ellipsoid(levels, Vec3d{1, 0.7, 1.5} * 0.25);
        const CutSearchResult cut = search_cut(mesh, options, {});
        ASSERT_EQ(cut.shares, BorderShares::kEqualArms);
        const SampledChart chart =
            make_square_chart(cut.disk, 33, 33, cut.rotation, *make_stretch_parameterizer(4), {}, cut.shares);
        test::expect_bijective(chart);
        test::expect_classes(chart);
        test::expect_topology(chart, mesh);
        EXPECT_EQ(count_folded(chart), 0u);
    }
}

TEST(OnlyStars, RefuseOtherSurfacesAndGrids) {
    const int unsuited = static_cast<int>(model::codes::kMethodUnsuited.number);
    CutSearchOptions options;
    options.m = options.n = 33;
    options.stars = 2;
    options.only_stars = true;
    EXPECT_EQ(number_of([&] { (void)search_cut(test::torus(2, 1, 16, 12), options, {}); }), unsuited);
    EXPECT_EQ(number_of([&] { (void)search_cut(test::grid_sheet(4, 4), options, {}); }), unsuited);
    options.n = 32;
    EXPECT_EQ(number_of([&] { (void)search_cut(test::icosphere(3), options, {}); }), unsuited);
}

TEST(CountFolded, SeesTrianglesThatLookAgainstTheSurface) {
    const TriMesh sheet = test::grid_sheet(4, 4);
    CutGraph cut(sheet);
    cut.cut_to_disk();
    SampledChart chart = make_square_chart(cut.open(), 9, 9, 0, *make_stretch_parameterizer(2), {});
    EXPECT_EQ(count_folded(chart), 0u);
    // One inner sample pushed over to beyond its neighbour turns the triangles between them.
    chart.positions[4 * 9 + 4] = chart.positions[4 * 9 + 6] * 1.5 - chart.positions[4 * 9 + 4] * 0.5;
    EXPECT_GT(count_folded(chart), 0u);
    EXPECT_LE(count_folded(chart), 8u);
}

}  // namespace
}  // namespace dgm::bake
