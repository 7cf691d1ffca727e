// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/simplify/simplify_test.cpp
// Half-edge collapses keep the topology, stay near the surface and can be taken back.
#include "geometry/simplify/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/metrics/map_metrics.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

const std::array<std::array<std::uint32_t, 2>, 3> kThreeHoles{{{2, 2}, {2, 9}, {8, 5}}};

struct Surface {
    const char* name;
    TriMesh mesh;
};
std::vector<Surface> surfaces() {
    return {{"ball", test::icosphere(4)},
            {"torus", test::torus(1, 0.4, 60, 30)},
            {"genus 3", test::genus_plate(3, 6)},
            {"comb", test::comb(3, 6, 4)},
            {"sheet", test::grid_sheet(30, 20)},
            {"annulus", test::annulus(1, 2, 60, 10)},
            {"three holes", test::sheet_with_holes(12, kThreeHoles)},
            {"finger", test::finger(0.1, 2, 16, 40, 6)}};
}

Face from_lowest(Face f) {
    while (f[0] > f[1] || f[0] > f[2]) f = {f[1], f[2], f[0]};
    return f;
}

TEST(Simplify, KeepsTopologyDownToTheLastAllowedCollapse) {
    for (const Surface& s : surfaces())
        for (const std::size_t wanted : {s.mesh.faces.size() / 3, s.mesh.faces.size() / 20, std::size_t{0}}) {
            SCOPED_TRACE(std::string(s.name) + " to " + std::to_string(wanted));
            const Simplified out = simplify(s.mesh, wanted, {}, {});
            const Topology before = measure_topology(s.mesh.positions.size(), s.mesh.faces);
            const Topology after = measure_topology(s.mesh.positions.size(), out.faces);
            EXPECT_TRUE(after.manifold);
            EXPECT_TRUE(after.oriented);
            EXPECT_EQ(after.degenerate_faces, 0u);
            EXPECT_EQ(after.components, before.components);
            EXPECT_EQ(after.genus, before.genus);
            EXPECT_EQ(after.boundary_loops, before.boundary_loops);
            EXPECT_LT(out.faces.size(), s.mesh.faces.size() / 2);
            if (wanted * 4 > s.mesh.faces.size()) { EXPECT_LE(out.faces.size(), wanted); }
        }
}

/// A disk of `rim` faces around one vertex, wavy so that its faces turn.
TriMesh fan(std::uint32_t rim) {
    TriMesh mesh;
    mesh.positions.push_back({0, 0, 0});
    for (std::uint32_t k = 0; k < rim; ++k) {
        const double angle = 6.28318530717958 * k / rim;
        mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.1 * std::sin(40 * angle)});
        mesh.faces.push_back({0, k + 1, (k + 1) % rim + 1});
    }
    return mesh;
}

TEST(Simplify, AVertexOfThousandsOfFacesIsNotLookedThroughEachTime) {
    // Each collapse along the rim is one beside the vertex of all faces: one look at each of its faces each time would
    // be 10^11 of them.
    const TriMesh mesh = fan(300'000);
    const Simplified out = simplify(mesh, 1000, {}, {});
    EXPECT_LE(out.faces.size(), 1000u);
    const Topology after = measure_topology(mesh.positions.size(), out.faces);
    EXPECT_TRUE(after.manifold && after.oriented);
    EXPECT_EQ(after.boundary_loops, 1u);
}

TEST(Simplify, TurnsNoFaceOver) {
    // Seen from the centre every face of a ball is counter-clockwise, however coarse.
    const TriMesh ball = test::icosphere(4);
    for (const Face& f : simplify(ball, 200, {}, {}).faces) {
        const auto& p = ball.positions;
        EXPECT_GT(dot(p[f[0]], cross(p[f[1]], p[f[2]])), 0);
    }
}

TEST(Simplify, StaysNearTheSurface) {
    // 640 faces of equal area on the unit ball have edges of 0.213 and are 0.0076 off in the middle; twice that for
    // vertices that were not free to move.
    const TriMesh ball = test::icosphere(5);
    const Simplified out = simplify(ball, 640, {}, {});
    ASSERT_LE(out.faces.size(), 640u);
    for (const Face& f : out.faces) {
        const Vec3d middle = (ball.positions[f[0]] + ball.positions[f[1]] + ball.positions[f[2]]) / 3;
        EXPECT_LT(1 - length(middle), 0.03);
    }
    EXPECT_NEAR(test::surface_area(ball.positions, out.faces), test::surface_area(ball), 0.015 * 4 * 3.14159);
}

TEST(Simplify, FlatPiecesLoseNothing) {
    // A cube of 12 x 12 squares a side needs its 8 corners only.
    const TriMesh box = test::cubes(std::array<std::array<int, 3>, 1>{{{0, 0, 0}}}, 12);
    const Simplified out = simplify(box, 60, {}, {});
    ASSERT_LE(out.faces.size(), 60u);
    EXPECT_NEAR(test::surface_area(box.positions, out.faces), 6, 1e-9);
    TriMesh coarse = box;
    coarse.faces = out.faces;
    EXPECT_NEAR(test::volume(coarse), 1, 1e-9);
}

/// A plate with a post in its middle. Around it, lines of the grid lie in pairs 0.02 cells apart, as where a plane cuts
/// marching cubes near their corners: many faces are slivers.
TriMesh post_on_slivers(double height) {
    constexpr int kPairs = 30;
    constexpr double kCell = 0.1, kApart = 0.02 * kCell;
    std::vector<double> lines;
    for (int k = 0; k < kPairs; ++k) {
        lines.push_back(-1 - kCell * (kPairs - k));
        lines.push_back(lines.back() + kApart);
    }
    for (int k = 0; k <= 40; ++k) lines.push_back(-1 + 0.05 * k);
    for (int k = kPairs - 1; k >= 0; --k) {
        lines.push_back(1 + kCell * (kPairs - k) - kApart);
        lines.push_back(lines.back() + kApart);
    }
    TriMesh mesh;
    const auto n = static_cast<std::uint32_t>(lines.size());
    for (const double y : lines)
        for (const double x : lines) mesh.positions.push_back({x, y, std::hypot(x, y) < 0.5 ? height : 0});
    for (std::uint32_t i = 0; i + 1 < n; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::uint32_t a = i * n + j;
            mesh.faces.push_back({a, a + 1, a + n + 1});
            mesh.faces.push_back({a, a + n + 1, a + n});
        }
    return mesh;
}

TEST(Simplify, SliversDoNotCostLimbs) {
    // The slivers of the plate are in nobody's way; while they were kept, all of the post went for them.
    constexpr double kHeight = 2;
    const TriMesh mesh = post_on_slivers(kHeight);
    SimplifyOptions options;
    options.regularity = 1e-3;
    const Simplified out = simplify(mesh, 3000, options, {});
    EXPECT_LE(out.faces.size(), 3000u);
    const auto area_on_top = [&](const std::vector<Face>& faces) {
        std::vector<Face> top;
        for (const Face& f : faces)
            if (std::ranges::all_of(f, [&](std::uint32_t v) { return mesh.positions[v].z == kHeight; }))
                top.push_back(f);
        return test::surface_area(mesh.positions, top);
    };
    EXPECT_NEAR(area_on_top(mesh.faces), 0.7, 0.08);
    EXPECT_GT(area_on_top(out.faces), 0.8 * area_on_top(mesh.faces));
}

TEST(Simplify, BordersStayInPlace) {
    const TriMesh sheet = test::grid_sheet(24, 24);
    const Simplified out = simplify(sheet, 40, {}, {});
    ASSERT_LE(out.faces.size(), 40u);
    EXPECT_NEAR(test::surface_area(sheet.positions, out.faces), 1, 1e-9);
}

TEST(Simplify, CollapsesCanBeTakenBack) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        const Simplified out = simplify(s.mesh, s.mesh.faces.size() / 10, {}, {});
        ASSERT_FALSE(out.collapses.empty());
        std::multiset<Face> faces;
        for (const Face& f : out.faces) faces.insert(from_lowest(f));
        for (std::size_t k = out.collapses.size(); k-- > 0;) {
            const Collapse& c = out.collapses[k];
            const auto link = out.link(c);
            EXPECT_NE(std::find(link.begin(), link.end(), c.kept), link.end());
            const std::size_t wedges = c.closed ? link.size() : link.size() - 1;
            for (std::size_t j = 0; j < wedges; ++j) {
                const std::uint32_t a = link[j], b = link[(j + 1) % link.size()];
                if (a != c.kept && b != c.kept) {
                    const auto it = faces.find(from_lowest({c.kept, a, b}));
                    ASSERT_NE(it, faces.end());
                    faces.erase(it);
                }
                faces.insert(from_lowest({c.removed, a, b}));
            }
        }
        std::multiset<Face> source;
        for (const Face& f : s.mesh.faces) source.insert(from_lowest(f));
        EXPECT_EQ(faces, source);
    }
}

TEST(Simplify, LockedVerticesStay) {
    const TriMesh ball = test::icosphere(3);
    std::vector<char> locked(ball.positions.size(), 0);
    locked[5] = locked[77] = locked[300] = 1;
    const Simplified out = simplify(ball, 60, {.locked = locked}, {});
    std::set<std::uint32_t> named;
    for (const Face& f : out.faces) named.insert(f.begin(), f.end());
    for (std::uint32_t v : {5u, 77u, 300u}) EXPECT_TRUE(named.count(v)) << v;
}

TEST(Simplify, ChordsCanBeForbidden) {
    const TriMesh sheet = test::grid_sheet(20, 20);
    std::vector<char> border(sheet.positions.size(), 0);
    const std::vector<std::uint32_t> opposite = opposite_half_edges(sheet.faces);
    for (std::uint32_t h = 0; h < opposite.size(); ++h)
        if (opposite[h] == kNone) border[origin(sheet.faces, h)] = 1;
    const auto chords = [&](const std::vector<Face>& faces) {
        const std::vector<std::uint32_t> across = opposite_half_edges(faces);
        std::size_t count = 0;
        for (std::uint32_t h = 0; h < across.size(); ++h)
            count += across[h] != kNone && border[origin(faces, h)] && border[target(faces, h)];
        return count;
    };
    ASSERT_EQ(chords(sheet.faces), 4u);  // two corners, both half-edges
    SimplifyOptions options;
    options.locked = border;
    EXPECT_GT(chords(simplify(sheet, 100, options, {}).faces), 4u);
    options.allow_chords = false;
    const Simplified out = simplify(sheet, 100, options, {});
    EXPECT_LT(out.faces.size(), 300u);
    EXPECT_EQ(chords(out.faces), 4u);
}

TEST(Simplify, SameInputSameResult) {
    const TriMesh mesh = test::genus_plate(3, 6);
    const Simplified a = simplify(mesh, 300, {}, {}), b = simplify(mesh, 300, {}, {});
    EXPECT_EQ(a.faces, b.faces);
    EXPECT_EQ(a.links, b.links);
}

TEST(Simplify, SmallestClosedSurfacesAreLeftAlone) {
    TriMesh tetrahedron;
    tetrahedron.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    tetrahedron.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    EXPECT_EQ(simplify(tetrahedron, 0, {}, {}).faces, tetrahedron.faces);
    const TriMesh triangle = test::polygon_disk(3);
    EXPECT_GE(simplify(triangle, 0, {}, {}).faces.size(), 1u);
}

TEST(Simplify, CompactNumbersTheUsedVerticesInOrder) {
    const TriMesh ball = test::icosphere(3);
    const Simplified out = simplify(ball, 100, {}, {});
    const CompactMesh small = compact(ball.positions, out.faces);
    ASSERT_EQ(small.mesh.faces.size(), out.faces.size());
    EXPECT_TRUE(std::is_sorted(small.original.begin(), small.original.end()));
    EXPECT_EQ(small.original.size(), small.mesh.positions.size());
    EXPECT_EQ(small.original.size(), 2 + small.mesh.faces.size() / 2);  // Euler: all are used, none twice
    for (std::size_t f = 0; f < out.faces.size(); ++f)
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(small.original[small.mesh.faces[f][k]], out.faces[f][k]);
            EXPECT_EQ(small.mesh.positions[small.mesh.faces[f][k]], ball.positions[out.faces[f][k]]);
        }
}

}  // namespace
}  // namespace dgm::bake
