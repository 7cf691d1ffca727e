// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut/cut_graph_test.cpp
// Opening surfaces of every small topology into one disk, and the border of what comes out.
#include "geometry/cut/cut_graph.h"

#include <gtest/gtest.h>

#include <cmath>

#include <algorithm>
#include <numbers>
#include <random>
#include <string>

#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {
constexpr double kPi = std::numbers::pi;

const std::array<std::array<std::uint32_t, 2>, 5> kFiveHoles{{{1, 1}, {1, 7}, {7, 1}, {7, 7}, {4, 4}}};

TriMesh punctured_torus() {
    TriMesh mesh = test::torus(1, 0.4, 16, 10);
    mesh.faces.erase(mesh.faces.begin() + 40, mesh.faces.begin() + 42);
    return mesh;
}

TriMesh tetrahedron() {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    return mesh;
}

struct Surface {
    const char* name;
    TriMesh mesh;
    std::int64_t genus;
    std::size_t loops;
};
std::vector<Surface> surfaces() {
    return {{"ball", test::icosphere(2), 0, 0},
            {"tetrahedron", tetrahedron(), 0, 0},
            {"pillow", test::double_sided_quad(), 0, 0},
            {"torus", test::torus(1, 0.4, 24, 12), 1, 0},
            {"smallest torus of a lattice", test::torus(1, 0.4, 3, 3), 1, 0},
            {"genus 3", test::genus_plate(3), 3, 0},
            {"genus 5", test::genus_plate(5, 2), 5, 0},
            {"sheet", test::grid_sheet(5, 7), 0, 1},
            {"triangle", test::polygon_disk(3), 0, 1},
            {"annulus", test::annulus(1, 2, 20, 4), 0, 2},
            {"five holes", test::sheet_with_holes(9, kFiveHoles), 0, 6},
            {"torus with a hole", punctured_torus(), 1, 1},
            {"finger", test::finger(0.1, 2, 10, 20, 4), 0, 1}};
}

/// The same surface with its faces in another order, and vertices numbered as the faces come.
TriMesh shuffled(const TriMesh& mesh, std::uint32_t seed) {
    TriMesh out;
    out.faces = mesh.faces;
    std::mt19937 dice(seed);
    for (std::size_t k = out.faces.size(); k > 1; --k) std::swap(out.faces[k - 1], out.faces[dice() % k]);
    std::vector<std::uint32_t> id(mesh.positions.size(), kNone);
    for (Face& f : out.faces)
        for (std::uint32_t& v : f) {
            if (id[v] == kNone) {
                id[v] = static_cast<std::uint32_t>(out.positions.size());
                out.positions.push_back(mesh.positions[v]);
            }
            v = id[v];
        }
    return out;
}

constexpr std::array kStarts{CutStart::kLong, CutStart::kAside, CutStart::kShort};

CutGraph cut_from(const TriMesh& mesh, CutStart start) {
    CutGraph cut(mesh);
    cut.cut_to_disk(kNone, start);
    return cut;
}

/// Three limbs of unequal length, nothing symmetric.
TriMesh limbed_body() {
    TriMesh body = test::icosphere(4);
    for (Vec3d& p : body.positions)
        p = p *
            (1 + 0.9 * std::exp(8 * (dot(p, {0.6, 0.8, 0}) - 1)) + 0.8 * std::exp(8 * (dot(p, {-0.8, 0, 0.6}) - 1)) +
             0.7 * std::exp(8 * (dot(p, {0.1, -0.7, -0.7}) - 1)) + 0.05 * p.x + 0.03 * p.y + 0.01 * p.z);
    return body;
}

TEST(CutGraph, CutsABodyAlikeWhateverTheOrderOfItsFaces) {
    const TriMesh body = limbed_body();
    for (const CutStart start : kStarts) {
        const double first = cut_from(body, start).length();
        for (std::uint32_t seed = 1; seed <= 5; ++seed) {
            const TriMesh other = shuffled(body, seed);
            EXPECT_NEAR(cut_from(other, start).length(), first, 1e-9) << seed;
        }
    }
}

/// The limbs are where two points are farthest apart: the other starts begin beside the path between them.
TEST(CutGraph, OtherStartsBeginFarFromTheFirst) {
    const TriMesh body = limbed_body();
    const CutGraph first = cut_from(body, CutStart::kLong);
    const CutGraph aside = cut_from(body, CutStart::kAside), half = cut_from(body, CutStart::kShort);
    const std::vector<double> away = first.distance_to_cut();
    const auto farthest = static_cast<std::uint32_t>(std::max_element(away.begin(), away.end()) - away.begin());
    for (const CutGraph* cut : {&aside, &half}) { EXPECT_EQ(cut->distance_to_cut()[farthest], 0) << "on the path"; }
    EXPECT_LT(aside.length(), first.length());
    EXPECT_LT(half.length(), aside.length());
    // As far as half of all vertices are from where it begins: straight ones, which edges do not beat.
    std::vector<double> straight;
    for (const Vec3d& p : body.positions) straight.push_back(length(p - body.positions[farthest]));
    std::nth_element(straight.begin(), straight.begin() + static_cast<std::ptrdiff_t>(straight.size() / 2),
                     straight.end());
    EXPECT_GE(half.length(), straight[straight.size() / 2]);
    EXPECT_LE(half.length(), std::numbers::pi / 2 * 1.2 * straight[straight.size() / 2]) << "about a half circle";
    for (const CutStart start : kStarts) {
        const Disk disk = cut_from(body, start).open();
        ASSERT_NO_FATAL_FAILURE(test::expect_links(disk));
        test::expect_disk(disk);
    }
}

TEST(CutGraph, SurfacesThatAreNotClosedHaveOneStart) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        const CutGraph first = cut_from(s.mesh, CutStart::kLong);
        for (const CutStart start : {CutStart::kAside, CutStart::kShort}) {
            const CutGraph other = cut_from(s.mesh, start);
            if (s.genus > 0 || s.loops > 0) { EXPECT_EQ(other.length(), first.length()); }
            test::expect_disk(other.open());
        }
    }
}

TEST(CutGraph, OpensEverySurfaceIntoOneDisk) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        CutGraph cut(s.mesh);
        EXPECT_EQ(cut.genus(), s.genus);
        EXPECT_EQ(cut.boundary_loop_count(), s.loops);
        EXPECT_EQ(cut.length(), 0);
        cut.cut_to_disk();
        EXPECT_EQ(cut.length() > 0, !(s.genus == 0 && s.loops == 1)) << "a disk is left as it is";
        const Disk disk = cut.open();
        ASSERT_NO_FATAL_FAILURE(test::expect_links(disk));
        test::expect_disk(disk);
        // Welding the disk restores the component, face by face.
        ASSERT_EQ(disk.weld_count, s.mesh.positions.size());
        ASSERT_EQ(disk.mesh.faces.size(), s.mesh.faces.size());
        for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t v = disk.mesh.faces[f][k];
                ASSERT_EQ(disk.weld[v], s.mesh.faces[f][k]);
                ASSERT_EQ(disk.mesh.positions[v], s.mesh.positions[disk.weld[v]]);
            }
        // Cut edges and mates are the same edges; their length is the cut's.
        double mated = 0;
        for (std::uint32_t h = 0; h < disk.mate.size(); ++h) {
            ASSERT_EQ(disk.mate[h] != kNone, cut.is_cut(h));
            if (disk.mate[h] != kNone)
                mated += length(disk.mesh.positions[origin(disk.mesh.faces, h)] -
                                disk.mesh.positions[target(disk.mesh.faces, h)]);
        }
        EXPECT_NEAR(mated / 2, cut.length(), 1e-12);
    }
}

TEST(CutGraph, GraphHasEveryEdgeOnceAtBothEnds) {
    const TriMesh mesh = test::annulus(1, 2, 8, 2);
    const CutGraph cut(mesh);
    const VertexGraph& graph = cut.graph();
    EXPECT_EQ(graph.arcs.size(), 2u * (24 + 16 + 16));  // three rings of 8, 16 spokes, 16 diagonals
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
        for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
            const auto& arc = graph.arcs[a];
            EXPECT_DOUBLE_EQ(arc.length, length(mesh.positions[v] - mesh.positions[arc.to]));
            const std::uint32_t p = origin(mesh.faces, arc.half_edge), q = target(mesh.faces, arc.half_edge);
            EXPECT_TRUE((p == v && q == arc.to) || (p == arc.to && q == v));
        }
}

/// The shortest pair of loops that opens a torus: once around the tube, and the inner equator.
TEST(CutGraph, LoopsOfATorusAreShort) {
    const std::uint32_t a = 48, b = 24;
    const double ring = 1, tube = 0.3;
    const TriMesh mesh = test::torus(ring, tube, a, b);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    const double around_tube = b * 2 * tube * std::sin(kPi / b), equator = a * 2 * (ring - tube) * std::sin(kPi / a);
    EXPECT_GE(cut.length(), around_tube + equator - 1e-9);
    EXPECT_LE(cut.length(), 1.5 * (around_tube + equator));
}

/// A closed ball is opened between two far points: at least as far apart as its poles are for straight lines.
TEST(CutGraph, BallIsOpenedBetweenFarPoints) {
    const TriMesh mesh = test::icosphere(3);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    EXPECT_GT(cut.length(), 0.9 * kPi);
    EXPECT_LT(cut.length(), 1.3 * kPi);
    const std::vector<BorderPath> paths = cut.open().paths();
    EXPECT_EQ(paths.size(), 2u);  // one path without branches, both its ends leaves
}

TEST(CutGraph, AnnulusIsCutStraightAcross) {
    const TriMesh mesh = test::annulus(1, 2, 20, 4);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    EXPECT_NEAR(cut.length(), 1, 1e-12);
}

TEST(CutGraph, JoinReachesTheVertexByAShortestPath) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        CutGraph cut(s.mesh);
        cut.cut_to_disk();
        std::mt19937 random(4);
        std::vector<double> followed = cut.distance_to_cut();
        for (int k = 0; k < 6; ++k) {
            const auto v = static_cast<std::uint32_t>(random() % s.mesh.positions.size());
            const double before = cut.length(), far = cut.distance_to_cut()[v], added = cut.join(v);
            EXPECT_DOUBLE_EQ(added, far);
            EXPECT_NEAR(cut.length(), before + added, 1e-12);
            EXPECT_EQ(cut.distance_to_cut()[v], 0);
            cut.follow_cut(followed);
            EXPECT_EQ(followed, cut.distance_to_cut());
            EXPECT_EQ(cut.join(v), 0);
            const Disk disk = cut.open();
            ASSERT_NO_FATAL_FAILURE(test::expect_links(disk));
            test::expect_disk(disk);
            const std::vector<std::uint32_t> border = disk.border();
            EXPECT_TRUE(std::any_of(border.begin(), border.end(),
                                    [&](std::uint32_t h) { return disk.weld[origin(disk.mesh.faces, h)] == v; }));
        }
    }
}

/// On a sheet the only border is the rim: distances along lattice edges are known.
TEST(CutGraph, DistanceToTheRimOfASheet) {
    const TriMesh mesh = test::grid_sheet(8, 8, 8, 8);
    const CutGraph cut(mesh);
    const std::vector<double> distance = cut.distance_to_cut();
    for (int i = 0; i <= 8; ++i)
        for (int j = 0; j <= 8; ++j)
            EXPECT_DOUBLE_EQ(distance[i * 9 + j], std::min(std::min(i, 8 - i), std::min(j, 8 - j)));
}

TEST(CutGraph, MarkCutsAndHealsBothSides) {
    const TriMesh mesh = test::grid_sheet(4, 4);
    CutGraph cut(mesh);
    std::uint32_t inner = kNone;  // the edge from (2,0) on the rim to (2,1)
    for (std::uint32_t h = 0; h < 3 * mesh.faces.size(); ++h)
        if (origin(mesh.faces, h) == 10 && target(mesh.faces, h) == 11) inner = h;
    ASSERT_NE(inner, kNone);
    cut.mark(inner, true);
    EXPECT_DOUBLE_EQ(cut.length(), 0.25);
    Disk disk = cut.open();
    test::expect_links(disk);
    test::expect_disk(disk);
    EXPECT_EQ(disk.mesh.positions.size(), mesh.positions.size() + 1) << "the rim vertex is doubled, the leaf is not";
    cut.mark(inner, false);
    EXPECT_EQ(cut.length(), 0);
    EXPECT_EQ(cut.open().mesh.positions.size(), mesh.positions.size());
}

// ---- paths() ----

void expect_paths(const Disk& disk, const std::vector<BorderPath>& paths) {
    std::vector<std::uint32_t> all;
    for (std::uint32_t p = 0; p < paths.size(); ++p) {
        const BorderPath& path = paths[p];
        ASSERT_FALSE(path.half_edges.empty());
        double sum = 0;
        for (std::uint32_t h : path.half_edges) {
            sum += length(disk.mesh.positions[origin(disk.mesh.faces, h)] -
                          disk.mesh.positions[target(disk.mesh.faces, h)]);
            all.push_back(h);
        }
        EXPECT_NEAR(path.length, sum, 1e-12);
        EXPECT_EQ(path.is_loop, disk.weld[origin(disk.mesh.faces, path.half_edges.front())] ==
                                    disk.weld[target(disk.mesh.faces, path.half_edges.back())]);
        if (path.mate == kNone) {
            for (std::uint32_t h : path.half_edges) EXPECT_EQ(disk.mate[h], kNone);
            continue;
        }
        ASSERT_LT(path.mate, paths.size());
        const BorderPath& mate = paths[path.mate];
        EXPECT_NE(path.mate, p);
        EXPECT_EQ(mate.mate, p);
        EXPECT_NEAR(mate.length, path.length, 1e-12);
        ASSERT_EQ(mate.half_edges.size(), path.half_edges.size());
        for (std::size_t k = 0; k < path.half_edges.size(); ++k)
            EXPECT_EQ(disk.mate[path.half_edges[k]], mate.half_edges[mate.half_edges.size() - 1 - k]);
    }
    // Together they are the border cycle, turned to a node.
    std::vector<std::uint32_t> border = disk.border();
    const auto at = std::find(border.begin(), border.end(), all.front());
    ASSERT_NE(at, border.end());
    std::rotate(border.begin(), at, border.end());
    EXPECT_EQ(all, border);
}

TEST(BorderPaths, MatesRunBackwardsOnEverySurface) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        CutGraph cut(s.mesh);
        cut.cut_to_disk();
        for (int k = 0; k < 3; ++k) {
            const Disk disk = cut.open();
            ASSERT_NO_FATAL_FAILURE(expect_paths(disk, disk.paths()));
            cut.join(static_cast<std::uint32_t>((7 + 31 * k) % s.mesh.positions.size()));
        }
    }
}

TEST(BorderPaths, CornersOfARealBorder) {
    const auto open = [](const TriMesh& mesh) { return CutGraph(mesh).open(); };
    const std::vector<BorderPath> square = open(test::grid_sheet(3, 5, 2, 7)).paths();
    ASSERT_EQ(square.size(), 4u);
    std::vector<double> lengths;
    for (const BorderPath& path : square) lengths.push_back(path.length);
    std::sort(lengths.begin(), lengths.end());
    EXPECT_NEAR(lengths[0], 2, 1e-12);
    EXPECT_NEAR(lengths[1], 2, 1e-12);
    EXPECT_NEAR(lengths[2], 7, 1e-12);
    EXPECT_NEAR(lengths[3], 7, 1e-12);
    // A regular n-gon turns by 360/n at each corner: 60 is a corner at 50 degrees, 45 is none.
    EXPECT_EQ(open(test::polygon_disk(6)).paths().size(), 6u);
    const std::vector<BorderPath> octagon = open(test::polygon_disk(8)).paths();
    ASSERT_EQ(octagon.size(), 1u);
    EXPECT_TRUE(octagon[0].is_loop);
    EXPECT_EQ(octagon[0].mate, kNone);
    EXPECT_EQ(open(test::polygon_disk(8)).paths(44).size(), 8u);
    EXPECT_EQ(open(test::polygon_disk(6)).paths(61).size(), 1u);
}

TEST(BorderPaths, AnnulusHasTwoLoopsAndACut) {
    const TriMesh mesh = test::annulus(1, 2, 20, 4);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    const std::vector<BorderPath> paths = cut.open().paths();
    ASSERT_EQ(paths.size(), 4u);
    int loops = 0, mated = 0;
    for (const BorderPath& path : paths) {
        loops += path.is_loop && path.mate == kNone;
        mated += path.mate != kNone && !path.is_loop;
    }
    EXPECT_EQ(loops, 2);
    EXPECT_EQ(mated, 2);
}

/// A T of cuts in a sheet, one leg on the rim: node in the middle, leaves at two ends.
TEST(BorderPaths, BranchesAndLeaves) {
    const TriMesh mesh = test::grid_sheet(8, 8);
    CutGraph cut(mesh);
    const auto mark = [&](std::uint32_t a, std::uint32_t b) {
        for (std::uint32_t h = 0; h < 3 * mesh.faces.size(); ++h)
            if (origin(mesh.faces, h) == a && target(mesh.faces, h) == b) return cut.mark(h, true);
        FAIL();
    };
    const auto at = [](std::uint32_t i, std::uint32_t j) { return i * 9 + j; };
    for (std::uint32_t i = 0; i < 4; ++i) mark(at(i, 4), at(i + 1, 4));  // from the rim to the middle
    for (std::uint32_t j = 2; j < 6; ++j) mark(at(4, j), at(4, j + 1));  // and a bar across
    const Disk disk = cut.open();
    test::expect_disk(disk);
    const std::vector<BorderPath> paths = disk.paths();
    ASSERT_NO_FATAL_FAILURE(expect_paths(disk, paths));
    // The rim: four sides, one of them in two; stem 2x; two arms 2x.
    ASSERT_EQ(paths.size(), 5u + 2u + 4u);
    int leaves = 0;
    for (std::size_t p = 0; p < paths.size(); ++p) {
        if (paths[p].mate != (p + 1) % paths.size()) continue;
        ++leaves;
        EXPECT_NEAR(paths[p].length, 0.25, 1e-12);
        const std::uint32_t end = disk.weld[target(disk.mesh.faces, paths[p].half_edges.back())];
        EXPECT_TRUE(end == at(4, 2) || end == at(4, 6)) << end;
    }
    EXPECT_EQ(leaves, 2);
}

/// Around a torus of 40 x 12 the shortest cut is one meridian and one longitude on the inside: no two loops that open
/// it can be shorter, and sliding exchanges must find it from whatever the tree gave.
TEST(CutGraph, HandlesAreCutAlongShortLoops) {
    const TriMesh mesh = test::torus(1, 0.4, 40, 12);
    CutGraph cut(mesh);
    cut.cut_to_disk();
    const double meridian = 12 * 2 * 0.4 * std::sin(M_PI / 12), inside = 40 * 2 * 0.6 * std::sin(M_PI / 40);
    EXPECT_LT(cut.length(), 1.02 * (meridian + inside));
    const Disk disk = cut.open();
    EXPECT_EQ(boundary_loops(disk.opposite).size(), 1u);
}

}  // namespace
}  // namespace dgm::bake
