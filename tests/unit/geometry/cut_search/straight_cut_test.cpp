// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut_search/straight_cut_test.cpp
// Cuts that run across faces open the same surface, and are as short as a straight line where that is known.
#include "geometry/cut_search/straight_cut.h"

#include <gtest/gtest.h>

#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

double cut_length(const Disk& disk) {
    double sum = 0;
    for (const BorderPath& path : disk.paths())
        if (path.mate != kNone) sum += 0.5 * path.length;
    return sum;
}

/// The vertex of `mesh` nearest to `to`.
std::uint32_t nearest(const TriMesh& mesh, const Vec3d& to) {
    std::uint32_t best = 0;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
        if (length(mesh.positions[v] - to) < length(mesh.positions[best] - to)) best = v;
    return best;
}

TEST(StraightCut, IsAStraightLineInThePlane) {
    // Vertices of the annulus lie on rays and circles, so edges lead from (1, 0) to (2 cos 0.5, 2 sin 0.5) by detours.
    const TriMesh mesh = test::annulus(1, 2, 120, 20);
    const std::uint32_t from = nearest(mesh, {1, 0, 0}), to = nearest(mesh, {2 * std::cos(0.5), 2 * std::sin(0.5), 0});
    CutGraph cut(mesh);
    ASSERT_TRUE(std::isfinite(cut.connect(from, to)));
    const double line = length(mesh.positions[to] - mesh.positions[from]);
    ASSERT_GT(cut.length(), 1.04 * line);
    const Disk disk = open_straight(cut, 3);
    test::expect_links(disk);
    test::expect_disk(disk);
    EXPECT_LT(cut_length(disk), 1.001 * line);
    EXPECT_GE(cut_length(disk), (1 - 1e-12) * line);
}

TEST(StraightCut, OpensTheSameSurfaceByNoMore) {
    const std::pair<const char*, TriMesh> surfaces[] = {
        {"ball", test::icosphere(4)},         {"torus", test::torus(1, 0.4, 48, 24)},
        {"genus 3", test::genus_plate(3, 6)}, {"annulus", test::annulus(1, 2, 60, 10)},
        {"comb", test::comb(3, 6, 3)},        {"finger", test::finger(0.2, 2, 20, 40, 8)}};
    for (const auto& [name, mesh] : surfaces) {
        SCOPED_TRACE(name);
        CutGraph cut(mesh);
        cut.cut_to_disk();
        cut.join(0);
        cut.join(static_cast<std::uint32_t>(mesh.positions.size() / 2));
        cut.join(static_cast<std::uint32_t>(mesh.positions.size() / 3));
        const Disk jagged = cut.open(), straight = open_straight(cut, 1);
        test::expect_links(straight);
        test::expect_disk(straight);
        EXPECT_EQ(straight.paths().size(), jagged.paths().size()) << "nodes stay, and none comes";
        EXPECT_LE(cut_length(straight), cut_length(jagged) * (1 + 1e-12));
        double area = 0, before = 0;
        for (std::size_t f = 0; f < straight.mesh.faces.size(); ++f) area += face_area(straight.mesh.corners(f));
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) before += face_area(mesh.corners(f));
        EXPECT_NEAR(area, before, 1e-9 * before);
        std::vector<char> seen(mesh.positions.size(), 0);
        for (std::size_t v = 0; v < straight.weld.size(); ++v)
            if (const std::uint32_t point = straight.weld[v]; point < mesh.positions.size()) {
                EXPECT_EQ(straight.mesh.positions[v], mesh.positions[point]);
                seen[point] = 1;
            }
        EXPECT_EQ(std::count(seen.begin(), seen.end(), 0), 0) << "every vertex is still there";
        const std::vector<std::uint32_t> opposite = opposite_half_edges(straight.mesh.faces);
        EXPECT_EQ(opposite, straight.opposite);
    }
}

TEST(StraightCut, StaysWhereItsEdgesAreCheap) {
    const TriMesh mesh = test::annulus(1, 2, 120, 20);
    CutGraph cut(mesh);
    cut.connect(nearest(mesh, {1, 0, 0}), nearest(mesh, {2 * std::cos(0.5), 2 * std::sin(0.5), 0}));
    std::vector<double> factors(cut.opposite().size(), 1.0);
    for (std::uint32_t h = 0; h < factors.size(); ++h)
        if (cut.is_cut(h)) factors[h] = 0.1;
    const double along_edges = cut.length();
    cut.weigh(factors);
    const Disk disk = open_straight(cut, 3);
    EXPECT_EQ(disk.mesh.faces.size(), mesh.faces.size());
    EXPECT_DOUBLE_EQ(cut_length(disk), along_edges);
}

}  // namespace
}  // namespace dgm::bake
