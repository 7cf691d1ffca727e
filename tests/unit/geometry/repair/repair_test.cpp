// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/repair/repair_test.cpp
// Each rule of repair.h on meshes whose right answer is known by counting.
#include "geometry/repair/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>

#include "geometry/mesh/half_edges.h"
#include "geometry/metrics/map_metrics.h"
#include "model/codes.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {
namespace codes = model::codes;
using model::Face;
using model::TriMesh;
using model::Vec2d;
using model::Vec3d;

std::uint64_t count(const RepairedMesh& mesh, const std::string& what) {
    for (const auto& [name, n] : mesh.counts)
        if (name == what) return n;
    return 0;
}

/// Checks the promises of the header for every component, and its topology.
void expect_component(const RepairedMesh& repaired, std::size_t c, std::uint64_t loops, std::int64_t genus) {
    ASSERT_LT(c, repaired.components.size());
    const TriMesh& mesh = repaired.components[c];
    EXPECT_EQ(measure_topology(mesh.positions.size(), mesh.faces), (Topology{1, loops, genus, true, true, 0}));
    std::vector<char> used(mesh.positions.size(), 0);
    Vec3d lo{9, 9, 9}, hi{-9, -9, -9};
    for (const Face& f : mesh.faces)
        for (std::uint32_t v : f) used[v] = 1;
    for (const Vec3d& p : mesh.positions)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0);
    EXPECT_LE(length(hi - lo), 1 + 1e-12);
}

int code_of(const TriMesh& mesh) {
    try {
        (void)repair(mesh);
    } catch (const model::Error& e) { return e.code().number; }
    return 0;
}

TEST(Repair, SoundMeshesComeBackUntouched) {
    struct Case {
        TriMesh mesh;
        std::uint64_t loops;
        std::int64_t genus;
    };
    const std::array<std::array<std::uint32_t, 2>, 5> holes{{{1, 1}, {1, 6}, {6, 1}, {6, 6}, {4, 4}}};
    const Case cases[] = {{test::icosphere(2), 0, 0},
                          {test::torus(2, 0.7, 12, 8), 0, 1},
                          {test::genus_plate(3), 0, 3},
                          {test::annulus(1, 2, 12, 3), 2, 0},
                          {test::grid_sheet(4, 6), 1, 0},
                          {test::finger(0.1, 2, 8, 10, 3), 1, 0},
                          {test::sheet_with_holes(9, holes), 6, 0},
                          {test::comb(4, 3), 0, 0},
                          {test::polygon_disk(3), 1, 0}};
    for (const Case& c : cases) {
        const RepairedMesh out = repair(c.mesh);
        ASSERT_EQ(out.components.size(), 1u);
        expect_component(out, 0, c.loops, c.genus);
        const TriMesh& mesh = out.components[0];
        ASSERT_EQ(mesh.faces.size(), c.mesh.faces.size());
        for (const auto& [name, n] : out.counts) EXPECT_EQ(name, "unused vertices left out") << n;
        // p_source = centre + diagonal * p, corner by corner and in the same order.
        for (std::size_t f = 0; f < mesh.faces.size(); ++f)
            for (int k = 0; k < 3; ++k) {
                const Vec3d back = out.frame.centre + mesh.positions[mesh.faces[f][k]] * out.frame.diagonal;
                ASSERT_LT(length(back - c.mesh.positions[c.mesh.faces[f][k]]), 1e-13);
            }
    }
}

TEST(Repair, FrameOfAKnownBox) {
    TriMesh sheet = test::grid_sheet(3, 4, 6, 8);
    for (Vec3d& p : sheet.positions) p += Vec3d{100, 200, 300};
    const RepairedMesh out = repair(sheet);
    EXPECT_DOUBLE_EQ(out.frame.diagonal, 10);
    EXPECT_EQ(out.frame.centre, (Vec3d{103, 204, 300}));
}

TEST(Repair, SoupOfABallIsWeldedIntoAClosedBall) {
    for (int level = 0; level <= 3; ++level) {
        const RepairedMesh out = repair(test::soup(test::icosphere(level, 3)));
        const std::size_t quads = std::size_t{1} << (2 * level), v = 10 * quads + 2, f = 20 * quads;
        ASSERT_EQ(out.components.size(), 1u);
        expect_component(out, 0, 0, 0);
        EXPECT_EQ(out.components[0].positions.size(), v);
        EXPECT_EQ(out.components[0].faces.size(), f);
        EXPECT_EQ(count(out, "open vertices welded"), 3 * f - v);
        EXPECT_EQ(out.counts.size(), 1u);
        EXPECT_GT(test::volume(out.components[0]), 0);
    }
}

TEST(Repair, MinusZeroIsZero) {
    TriMesh soup = test::soup(test::grid_sheet(2, 2));
    for (std::size_t v = 0; v < soup.positions.size(); v += 2) soup.positions[v].z = -0.0;
    const RepairedMesh out = repair(soup);
    ASSERT_EQ(out.components.size(), 1u);
    EXPECT_EQ(out.components[0].positions.size(), 9u);
}

/// The tolerance is 1e-6 of the diagonal, and a thousandth of the shortest open edge where that is less.
TEST(Repair, NearVerticesAreWeldedWithinTheTolerance) {
    const auto components = [](double cells, double gap) {
        const auto n = static_cast<std::uint32_t>(cells);
        const TriMesh left = test::grid_sheet(n, n);
        TriMesh right = left;
        for (Vec3d& p : right.positions) p.x += 1 + gap;
        const RepairedMesh out = repair(test::joined(left, right));
        EXPECT_EQ(count(out, "nearly coincident open vertices welded"), out.components.size() == 1 ? n + 1 : 0u);
        return out.components.size();
    };
    const double diagonal = std::sqrt(5.0);
    EXPECT_EQ(components(4, 0.5e-6 * diagonal), 1u);
    EXPECT_EQ(components(4, 2e-6 * diagonal), 2u);
    // Edges of 1/4000: a thousandth of them, 2.5e-7, is less than the 2.2e-6 that the diagonal would allow.
    TriMesh fine = test::grid_sheet(1, 4000), copy = fine;
    for (Vec3d& p : copy.positions) p.x += 1 + 0.5e-6 * diagonal;
    EXPECT_EQ(repair(test::joined(fine, copy)).components.size(), 2u);
    for (Vec3d& p : copy.positions) p.x -= 0.4e-6 * diagonal;
    EXPECT_EQ(repair(test::joined(fine, copy)).components.size(), 1u);
}

TEST(Repair, CoincidentClosedSurfacesStayTwo) {
    const RepairedMesh out = repair(test::joined(test::icosphere(1), test::icosphere(1)));
    ASSERT_EQ(out.components.size(), 2u);
    expect_component(out, 0, 0, 0);
    expect_component(out, 1, 0, 0);
    EXPECT_TRUE(out.counts.empty());
}

TEST(Repair, UnusableFacesAreDroppedAndCounted) {
    TriMesh mesh = test::icosphere(1);
    const std::size_t faces = mesh.faces.size();
    mesh.faces.push_back({0, 1, 4'000'000'000u});
    mesh.faces.push_back({3, 3, 5});
    mesh.faces.push_back(mesh.faces[7]);                                           // twice
    mesh.faces.push_back({mesh.faces[9][1], mesh.faces[9][0], mesh.faces[9][2]});  // and turned over
    mesh.positions.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
    mesh.positions.push_back({0, -std::numeric_limits<double>::infinity(), 0});
    const auto v = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.faces.push_back({0, 1, v - 2});
    mesh.faces.push_back({v - 1, 1, 2});
    const RepairedMesh out = repair(mesh);
    ASSERT_EQ(out.components.size(), 1u);
    expect_component(out, 0, 0, 0);
    EXPECT_EQ(out.components[0].faces.size(), faces);
    EXPECT_EQ(count(out, "faces with a corner out of range dropped"), 1u);
    EXPECT_EQ(count(out, "faces with a non-finite corner dropped"), 2u);
    EXPECT_EQ(count(out, "faces that repeat a corner dropped"), 1u);
    EXPECT_EQ(count(out, "faces that stand twice dropped"), 2u);
    EXPECT_EQ(count(out, "unused vertices left out"), 2u);
}

TEST(Repair, NothingLeftIsRefused) {
    EXPECT_EQ(code_of({}), codes::kNoFaces.number);
    TriMesh mesh = test::polygon_disk(3);
    for (Vec3d& p : mesh.positions) p.z = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(code_of(mesh), codes::kNoFaces.number);
    for (Vec3d& p : mesh.positions) p = {5, 5, 5};
    EXPECT_EQ(code_of(mesh), codes::kNoFaces.number);
    mesh = test::polygon_disk(3);
    mesh.faces = {{0, 0, 1}, {2, 1, 2}};
    EXPECT_EQ(code_of(mesh), codes::kNoFaces.number);
    mesh.faces = {{7, 8, 9}};
    EXPECT_EQ(code_of(mesh), codes::kNoFaces.number);
    TriMesh line;  // three corners apart, but no area
    line.positions = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
    line.faces = {{0, 1, 2}, {1, 3, 2}};
    EXPECT_EQ(code_of(line), codes::kNoFaces.number);
}

/// Length of the curve along which a component was opened, in its normalised frame.
double length_of_opening(const TriMesh& component) {
    const std::vector<std::uint32_t> opposite = opposite_half_edges(component.faces);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    double length_twice = 0;
    const auto key = [&](std::uint32_t h) {
        return std::pair{component.points[origin(component.faces, h)], component.points[target(component.faces, h)]};
    };
    for (std::uint32_t h = 0; h < opposite.size(); ++h)
        if (opposite[h] == kNone) ++sides[key(h)];
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        if (opposite[h] != kNone || sides[key(h)] < 2) continue;
        EXPECT_EQ(sides[key(h)], 2) << "an edge of the opening is known by its points";
        EXPECT_EQ(component.positions[origin(component.faces, h)],
                  component.positions[component.points[origin(component.faces, h)]]);
        length_twice +=
            length(component.positions[target(component.faces, h)] - component.positions[origin(component.faces, h)]);
    }
    return length_twice / 2;
}

/// Opens to a surface with two sides, and keeps which vertices are one.
void expect_opened(const TriMesh& source, std::uint64_t loops, std::int64_t crosscaps, double most) {
    const RepairedMesh out = repair(source);
    ASSERT_EQ(out.components.size(), 1u);
    const TriMesh& component = out.components[0];
    ASSERT_EQ(component.points.size(), component.positions.size());
    EXPECT_EQ(component.faces.size(), source.faces.size());
    const Topology opened = measure_topology(component.positions.size(), component.faces);
    EXPECT_TRUE(opened.manifold && opened.oriented);
    EXPECT_EQ(opened.components, 1u);
    const Topology whole = measure_topology(component);
    EXPECT_TRUE(whole.manifold);
    EXPECT_FALSE(whole.oriented);
    EXPECT_EQ(whole.components, 1u);
    EXPECT_EQ(whole.boundary_loops, loops);
    EXPECT_EQ(whole.genus, crosscaps);
    EXPECT_LE(length_of_opening(component) * out.frame.diagonal, most);
    EXPECT_EQ(count(out, "vertices split where surfaces only touch"), 0u) << "the opening is not a repair";
}

TEST(Repair, OneSidedSurfacesAreOpenedAlongAShortCurve) {
    // Across the strip, 0.6 wide; about the tube of the bottle; the equator of Boy's surface is about 7 long.
    for (std::uint32_t around : {5u, 8u, 30u}) expect_opened(test::moebius(around, 3), 1, 1, 0.6001);
    expect_opened(test::klein_bottle(16, 12), 0, 2, 10.5);
    expect_opened(test::soup(test::klein_bottle(16, 12)), 0, 2, 10.5);
    expect_opened(test::projective_plane(8, 24), 0, 1, 7);
}

TEST(Repair, ComponentsWithTwoSidesBesideOthersAreLeftAlone) {
    const RepairedMesh out = repair(test::joined(test::icosphere(1), test::moebius(9, 2)));
    ASSERT_EQ(out.components.size(), 2u);
    EXPECT_TRUE(out.components[0].points.empty());
    EXPECT_FALSE(out.components[1].points.empty());
    EXPECT_TRUE(measure_topology(out.components[0]).oriented);
    EXPECT_FALSE(measure_topology(out.components[1]).oriented);
}

TEST(Repair, ATinyProjectivePlaneGetsVerticesInItsOpening) {
    // Six vertices, each joined to all others: every edge of the opening has the points of another edge.
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0.1}, {0.3, 1, 0.2}, {-0.8, 0.6, 0.9}, {-0.9, -0.5, 0.4}, {0.4, -1, -0.3}};
    for (std::uint32_t k = 0; k < 5; ++k) {
        const auto rim = [&](std::uint32_t i) { return 1 + (k + i) % 5; };
        mesh.faces.push_back({0, rim(0), rim(1)});
        mesh.faces.push_back({rim(0), rim(1), rim(3)});
    }
    const RepairedMesh out = repair(mesh);
    ASSERT_EQ(out.components.size(), 1u);
    const Topology whole = measure_topology(out.components[0]);
    EXPECT_TRUE(whole.manifold);
    EXPECT_EQ(whole.genus, 1);
    EXPECT_EQ(whole.boundary_loops, 0u);
    EXPECT_GT(length_of_opening(out.components[0]), 0);
}

TEST(Repair, MixedWindingsAreMadeToAgreeAndClosedBodiesFaceOutward) {
    std::mt19937 random(3);
    for (const TriMesh& body :
         {test::icosphere(2), test::torus(2, 0.6, 16, 9), test::genus_plate(2), test::comb(3, 2)}) {
        const double outward = test::volume(body);
        ASSERT_GT(outward, 0);
        for (int share : {15, 50, 85}) {
            TriMesh mixed = body;
            for (Face& f : mixed.faces)
                if (static_cast<int>(random() % 100) < share) std::swap(f[0], f[1]);
            const RepairedMesh out = repair(mixed);
            ASSERT_EQ(out.components.size(), 1u);
            const double d = out.frame.diagonal;
            EXPECT_NEAR(test::volume(out.components[0]) * d * d * d, outward, 1e-9 * outward) << share << " % turned";
            EXPECT_GT(count(out, "faces turned to agree with their neighbours"), 0u);
        }
        TriMesh inward = body;  // a room seen from inside: all agree, so it stays as it is
        for (Face& f : inward.faces) std::swap(f[0], f[1]);
        const RepairedMesh room = repair(inward);
        EXPECT_LT(test::volume(room.components[0]), 0);
        EXPECT_TRUE(room.counts.empty());
    }
}

TEST(Repair, AFewTurnedFacesOfAnOpenSurfaceFollowTheMajority) {
    TriMesh sheet = test::grid_sheet(5, 5);
    for (std::uint32_t f : {3u, 17u, 18u, 40u}) std::swap(sheet.faces[f][1], sheet.faces[f][2]);
    const RepairedMesh out = repair(sheet);
    EXPECT_EQ(count(out, "faces turned to agree with their neighbours"), 4u);
    for (std::size_t f = 0; f < out.components[0].faces.size(); ++f) {
        const auto q = out.components[0].corners(f);
        EXPECT_GT(cross(q[1] - q[0], q[2] - q[0]).z, 0);
    }
}

TEST(Repair, CornerAttributesStayWithTheirCorners) {
    std::mt19937 random(11);
    TriMesh mesh = test::icosphere(2);
    for (Vec3d& p : mesh.positions) p = p * 7.0 + Vec3d{1, 2, 3};
    for (Face& f : mesh.faces)
        if (random() % 100 < 30) std::swap(f[1], f[2]);
    mesh.materials.resize(5);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        mesh.face_materials.push_back(static_cast<std::uint32_t>(random() % 5));
    test::paint_positions(mesh);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto q = mesh.corners(f);
        const Vec3d normal = normalized(cross(q[1] - q[0], q[2] - q[0]));
        for (int k = 0; k < 3; ++k) {
            mesh.corner_normals.push_back(normal);  // of the winding: must turn with it
            mesh.corner_colours.push_back(
                {static_cast<std::uint8_t>(mesh.faces[f][k]), static_cast<std::uint8_t>(f), 7, 9});
        }
    }
    const RepairedMesh out = repair(mesh);
    ASSERT_EQ(out.components.size(), 1u);
    const TriMesh& got = out.components[0];
    ASSERT_EQ(got.faces.size(), mesh.faces.size());
    ASSERT_EQ(got.corner_uvs.size(), 3 * got.faces.size());
    ASSERT_EQ(got.corner_normals.size(), 3 * got.faces.size());
    ASSERT_EQ(got.corner_colours.size(), 3 * got.faces.size());
    EXPECT_EQ(got.face_materials, mesh.face_materials);
    EXPECT_EQ(got.materials.size(), 5u);
    for (std::size_t f = 0; f < got.faces.size(); ++f) {
        const auto q = got.corners(f);
        const Vec3d normal = normalized(cross(q[1] - q[0], q[2] - q[0]));
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = out.frame.centre + q[k] * out.frame.diagonal;
            const Vec2d uv = got.corner_uvs[3 * f + k];
            ASSERT_NEAR(uv.x, p.x, 1e-12);
            ASSERT_NEAR(uv.y, p.y, 1e-12);
            ASSERT_LT(length(got.corner_normals[3 * f + k] - normal), 1e-9);
            const std::uint8_t vertex = got.corner_colours[3 * f + k].r;
            bool same = false;  // the colour names the source vertex modulo 256
            for (std::size_t v = vertex; v < mesh.positions.size(); v += 256)
                same |= length(mesh.positions[v] - p) < 1e-12;
            ASSERT_TRUE(same);
            ASSERT_EQ(got.corner_colours[3 * f + k].g, static_cast<std::uint8_t>(f));
        }
    }
}

TEST(Repair, TouchingCubesComeApart) {
    for (const TriMesh& pair : {test::cubes_touching_at_edge(), test::soup(test::cubes_touching_at_edge())}) {
        const RepairedMesh out = repair(pair);
        ASSERT_EQ(out.components.size(), 2u);
        for (std::size_t c = 0; c < 2; ++c) {
            expect_component(out, c, 0, 0);
            EXPECT_EQ(out.components[c].positions.size(), 8u);
            EXPECT_EQ(out.components[c].faces.size(), 12u);
            const double d = out.frame.diagonal;
            EXPECT_NEAR(test::volume(out.components[c]) * d * d * d, 1, 1e-12)
                << "a cube each, not two L-shaped halves";
        }
        EXPECT_EQ(count(out, "non-manifold edges taken apart"), 1u);
        EXPECT_EQ(count(out, "vertices split where surfaces only touch"), 2u);
    }
    const RepairedMesh out = repair(test::cubes_touching_at_vertex());
    ASSERT_EQ(out.components.size(), 2u);
    expect_component(out, 0, 0, 0);
    expect_component(out, 1, 0, 0);
    EXPECT_EQ(count(out, "vertices split where surfaces only touch"), 1u);
    EXPECT_EQ(count(out, "non-manifold edges taken apart"), 0u);
}

TEST(Repair, CubesInARowOfEdgesComeApart) {
    const std::array<std::array<int, 3>, 4> cells{{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 1, 0}}};
    const RepairedMesh out = repair(test::cubes(cells, 2));
    ASSERT_EQ(out.components.size(), 4u);
    for (std::size_t c = 0; c < 4; ++c) expect_component(out, c, 0, 0);
    EXPECT_EQ(count(out, "non-manifold edges taken apart"), 6u);  // three edges, two pieces each
}

TEST(Repair, BowTieComesApart) {
    const RepairedMesh out = repair(test::bow_tie());
    ASSERT_EQ(out.components.size(), 2u);
    expect_component(out, 0, 1, 0);
    expect_component(out, 1, 1, 0);
    EXPECT_EQ(count(out, "vertices split where surfaces only touch"), 1u);
}

/// An edge of k pages becomes pairs; an odd one out stays a page of its own.
TEST(Repair, BooksComeApartIntoPairs) {
    for (std::uint32_t pages : {3u, 4u, 5u, 8u}) {
        const RepairedMesh out = repair(test::book(pages));
        ASSERT_EQ(out.components.size(), pages - pages / 2) << pages << " pages";
        std::size_t faces = 0;
        for (std::size_t c = 0; c < out.components.size(); ++c) {
            expect_component(out, c, 1, 0);
            faces += out.components[c].faces.size();
        }
        EXPECT_EQ(faces, 2 * pages);
        EXPECT_EQ(count(out, "non-manifold edges taken apart"), 1u);
    }
}

TEST(Repair, DoubleSidedQuadIsAClosedFlatBall) {
    const RepairedMesh out = repair(test::double_sided_quad());
    ASSERT_EQ(out.components.size(), 1u);
    expect_component(out, 0, 0, 0);
    EXPECT_EQ(out.components[0].faces.size(), 4u);
}

/// 2 over 0-1, 3 under it; between them a face 1-0-4 of no height.
TEST(Repair, ZeroHeightCapIsFlippedAway) {
    for (const double height : {0.0, 1e-12}) {
        TriMesh mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}, {0.25, -height, 0}};
        mesh.faces = {{0, 1, 2}, {1, 0, 4}, {0, 3, 4}, {3, 1, 4}};
        test::paint_positions(mesh);
        const RepairedMesh out = repair(mesh);
        ASSERT_EQ(out.components.size(), 1u);
        expect_component(out, 0, 1, 0);
        EXPECT_EQ(count(out, "zero-height faces flipped away"), 1u);
        const TriMesh& got = out.components[0];
        ASSERT_EQ(got.faces.size(), 4u);
        const double d = out.frame.diagonal;
        EXPECT_NEAR(test::surface_area(got) * d * d, 1, 1e-11);
        for (std::size_t f = 0; f < 4; ++f) {
            const auto q = got.corners(f);
            EXPECT_GT(cross(q[1] - q[0], q[2] - q[0]).z * d * d, 0.2);
            for (int k = 0; k < 3; ++k) {
                const Vec3d p = out.frame.centre + q[k] * d;
                EXPECT_NEAR(got.corner_uvs[3 * f + k].x, p.x, 1e-11);
                EXPECT_NEAR(got.corner_uvs[3 * f + k].y, p.y, 1e-11);
            }
        }
    }
}

/// Two quads in the plane, with a strip of n x m vertices between them whose points all lie on the line x = 1: no face
/// of the strip has height, and no neighbour of those in its middle has any either.
TEST(Repair, StripWithinALineIsCollapsed) {
    constexpr std::uint32_t kRows = 9, kColumns = 7;
    TriMesh mesh;
    for (std::uint32_t j = 0; j < kColumns; ++j)
        for (std::uint32_t i = 0; i < kRows; ++i) {
            const double x = j == 0 ? 0 : j + 1 == kColumns ? 2 : 1;
            mesh.positions.push_back({x, i / (kRows - 1.0), 0});
        }
    for (std::uint32_t j = 0; j + 1 < kColumns; ++j)
        for (std::uint32_t i = 0; i + 1 < kRows; ++i) {
            const std::uint32_t a = j * kRows + i, b = a + kRows;
            mesh.faces.push_back({a, b, b + 1});
            mesh.faces.push_back({a, b + 1, a + 1});
        }
    test::paint_positions(mesh);
    const RepairedMesh out = repair(mesh);
    ASSERT_EQ(out.components.size(), 1u);
    expect_component(out, 0, 1, 0);
    const TriMesh& got = out.components[0];
    const double d = out.frame.diagonal;
    EXPECT_NEAR(test::surface_area(got) * d * d, 2, 1e-12);
    std::size_t with_height = 0;
    for (std::size_t f = 0; f < got.faces.size(); ++f) {
        const auto q = got.corners(f);
        const double twice = cross(q[1] - q[0], q[2] - q[0]).z * d * d;
        EXPECT_GT(twice, -1e-12);
        if (twice < 1e-9) continue;
        ++with_height;
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = out.frame.centre + q[k] * d;
            EXPECT_NEAR(got.corner_uvs[3 * f + k].x, p.x, 1e-12);
            EXPECT_NEAR(got.corner_uvs[3 * f + k].y, p.y, 1e-12);
        }
    }
    EXPECT_GE(with_height, 4 * (kRows - 1));
    EXPECT_EQ(got.faces.size(), with_height);
    // The strip's ends are welded first: they lie on the border.
    EXPECT_EQ(count(out, "faces that repeat a corner dropped"), 2 * (kColumns - 3));
    EXPECT_EQ(got.faces.size() + count(out, "zero-height faces collapsed"), mesh.faces.size() - 2 * (kColumns - 3));
    EXPECT_GT(count(out, "zero-height faces collapsed"), 0u);
}

/// A ball with faces of no height about an edge of no length.
TEST(Repair, CoincidentNeighboursInsideASurfaceAreJoined) {
    TriMesh mesh;  // an octahedron whose top is two vertices at one place
    mesh.positions = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, -1}};
    mesh.faces = {{0, 1, 4}, {4, 1, 5}, {1, 2, 5}, {2, 3, 5}, {5, 3, 4},
                  {3, 0, 4}, {1, 0, 6}, {2, 1, 6}, {3, 2, 6}, {0, 3, 6}};
    const RepairedMesh out = repair(mesh);
    ASSERT_EQ(out.components.size(), 1u);
    expect_component(out, 0, 0, 0);
    EXPECT_EQ(count(out, "zero-height faces collapsed"), 2u);
    EXPECT_EQ(out.components[0].faces.size(), 8u);
    EXPECT_EQ(out.components[0].positions.size(), 6u);
}

TEST(Repair, ComponentWithinALineIsDroppedBesideOthers) {
    TriMesh stray;
    stray.positions = {{5, 0, 0}, {6, 0, 0}, {5.5, 0, 0}};
    stray.faces = {{0, 1, 2}};
    const RepairedMesh out = repair(test::joined(test::torus(2, 0.6, 20, 12), stray));
    ASSERT_EQ(out.components.size(), 1u);
    expect_component(out, 0, 0, 1);
    EXPECT_EQ(count(out, "zero-height faces apart from all others dropped"), 1u);
    EXPECT_EQ(code_of(stray), codes::kNoFaces.number);
}

TEST(Repair, ScaleAndOffsetChangeNothing) {
    std::mt19937 random(8);
    TriMesh mesh = test::soup(test::torus(2, 0.6, 20, 12));
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        if (random() % 10 < 3) std::swap(mesh.faces[f][0], mesh.faces[f][2]);
    const RepairedMesh plain = repair(mesh);
    ASSERT_EQ(plain.components.size(), 1u);
    expect_component(plain, 0, 0, 1);
    for (const double scale : {1e-9, 1e9, 0x1p-40, 0x1p40, 1e-150, 1e150}) {
        TriMesh scaled = mesh;
        for (Vec3d& p : scaled.positions) p *= scale;
        const RepairedMesh out = repair(scaled);
        EXPECT_EQ(out.counts, plain.counts) << scale;
        ASSERT_EQ(out.components.size(), 1u);
        EXPECT_EQ(out.components[0].faces, plain.components[0].faces) << scale;
        EXPECT_NEAR(out.frame.diagonal / scale, plain.frame.diagonal, 1e-12);
        for (std::size_t v = 0; v < plain.components[0].positions.size(); ++v)
            ASSERT_LT(length(out.components[0].positions[v] - plain.components[0].positions[v]), 1e-14);
    }
    for (Vec3d& p : mesh.positions) p += Vec3d{1e7, -1e7, 1e7};
    const RepairedMesh far = repair(mesh);
    EXPECT_EQ(far.counts, plain.counts);
    EXPECT_EQ(far.components[0].faces, plain.components[0].faces);
    for (std::size_t v = 0; v < plain.components[0].positions.size(); ++v)
        ASSERT_LT(length(far.components[0].positions[v] - plain.components[0].positions[v]), 2e-9);
}

TEST(Repair, ComponentsComeInTheOrderOfTheirFirstFace) {
    TriMesh mesh = test::joined(test::joined(test::grid_sheet(1, 1), test::icosphere(0)), test::torus(9, 1, 5, 4));
    std::rotate(mesh.faces.begin(), mesh.faces.begin() + 1, mesh.faces.end());  // the sheet's first face goes last
    const RepairedMesh out = repair(mesh);
    ASSERT_EQ(out.components.size(), 3u);
    EXPECT_EQ(out.components[0].faces.size(), 2u);
    EXPECT_EQ(out.components[1].faces.size(), 20u);
    EXPECT_EQ(out.components[2].faces.size(), 40u);
}

}  // namespace
}  // namespace dgm::bake
