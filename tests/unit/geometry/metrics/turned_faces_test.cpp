// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/turned_faces_test.cpp
#include "geometry/metrics/turned_faces.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "test_meshes.h"

namespace dgm::bake {
namespace {
using model::Face;
using model::TriMesh;
using model::Vec3d;

TriMesh reversed(TriMesh mesh) {
    for (Face& f : mesh.faces) std::swap(f[1], f[2]);
    return mesh;
}

TEST(TurnedFaces, NoneOnTheSourceItselfAllOnItsReverse) {
    const TriMesh sphere = test::sphere(1, 12), finer = test::sphere(1.01, 17);
    EXPECT_EQ(count_turned_faces(sphere, sphere), 0u);
    EXPECT_EQ(count_turned_faces(sphere, finer), 0u);
    EXPECT_EQ(count_turned_faces(sphere, reversed(sphere)), sphere.faces.size());
    EXPECT_EQ(count_turned_faces(sphere, reversed(finer)), finer.faces.size());
}

TEST(TurnedFaces, AreTheFoldsOfASheet) {
    const TriMesh sheet = test::square(1, 0, 4);
    TriMesh folded = sheet;
    folded.positions[2 * 5 + 2] = {0.9, 0.55, 0};
    // Seen from above, a face of the flat sheet is turned if it runs clockwise.
    std::vector<std::uint32_t> clockwise;
    for (std::uint32_t f = 0; f < folded.faces.size(); ++f) {
        const auto [a, b, c] = folded.corners(f);
        if ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0) clockwise.push_back(f);
    }
    ASSERT_GE(clockwise.size(), 2u);
    const ClosestPointIndex index(sheet.positions, sheet.faces);
    EXPECT_EQ(find_turned_faces(index, folded, 1e-5), clockwise);
    EXPECT_EQ(count_turned_faces(sheet, folded), clockwise.size());
}

/// A split beside a corner leaves a face whose normal is what rounding made of it: it vouches for nothing.
TEST(TurnedFaces, FacesThatRoundingMadeHaveNoSide) {
    for (const double height : {1e-17, 1e-3}) {
        TriMesh source, map;
        source.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {-0.5, 0, 0}, {0.5, 0, 0}, {0, -height, 0}};
        source.faces = {{0, 1, 2}, {3, 4, 5}};  // one looks up, the low one down
        map.positions = {{-0.1, 0, 0}, {0.1, 0, 0}, {0, -height, 0}};
        map.faces = {{0, 1, 2}};
        EXPECT_EQ(count_turned_faces(source, map), height < 1e-13 ? 1u : 0u) << height;
        const ClosestPointIndex index(source.positions, source.faces);
        EXPECT_EQ(index.unit_normal(1), height < 1e-13 ? Vec3d{} : (Vec3d{0, 0, -1}));
    }
}

/// Two sheets that look away from each other, `gap` apart; the map is the upper one, `below` the middle between them.
std::size_t turned_between_sheets(double gap, double below) {
    TriMesh sheets = test::square(1, gap / 2, 3);
    const TriMesh under = reversed(test::square(1, -gap / 2, 3));
    const auto base = static_cast<std::uint32_t>(sheets.positions.size());
    sheets.positions.insert(sheets.positions.end(), under.positions.begin(), under.positions.end());
    for (const Face& f : under.faces) sheets.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
    return count_turned_faces(sheets, test::square(1, -below, 2));
}

/// A component is a part of an asset's frame: its own size decides, so a part and the whole are measured alike.
TEST(TurnedFaces, TieIsRelativeToTheSource) {
    for (const double scale : {1.0, 1e-3, 1e3}) {
        TriMesh sheets = test::square(1, 0.0, 3), below = test::square(1, -3e-5, 2);
        const TriMesh under = reversed(test::square(1, -4e-5, 3));
        const auto base = static_cast<std::uint32_t>(sheets.positions.size());
        sheets.positions.insert(sheets.positions.end(), under.positions.begin(), under.positions.end());
        for (const Face& f : under.faces) sheets.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
        for (Vec3d& p : sheets.positions) p = p * scale;
        for (Vec3d& p : below.positions) p = p * scale;
        const ClosestPointIndex index(sheets.positions, sheets.faces);
        EXPECT_NEAR(index.diagonal(), std::sqrt(2.0) * scale, 1e-6 * scale);
        EXPECT_EQ(find_turned_faces(index, below, kTurnedTie).size(), below.faces.size()) << scale;
        EXPECT_TRUE(find_turned_faces(index, below, 3 * kTurnedTie).empty()) << scale;
    }
}

TEST(TurnedFaces, OfAThinSheetAreThoseThatHaveCrossedIt) {
    EXPECT_EQ(turned_between_sheets(0.1, -0.01), 0u);  // nearer to the side it looks like
    EXPECT_EQ(turned_between_sheets(0.1, 0.01), 8u);   // nearer to the other side
    EXPECT_EQ(turned_between_sheets(1e-6, 1e-7), 0u);  // both sides are equally near, up to the tie
}

TEST(TurnedFaces, OnACreaseAnySideMaySpeak) {
    // A blade: two faces that meet at (., 0, 0) with an angle of 20 degrees between them, and a map triangle whose
    // centre lies on the edge and which agrees with the second face only.
    TriMesh blade;
    const double s = 0.173648;  // sin 10
    blade.positions = {{-1, 0, 0}, {1, 0, 0}, {0, -1, s}, {0, -1, -s}};
    blade.faces = {{0, 2, 1}, {0, 1, 3}};  // normals (0, s, 1) and (0, s, -1) but for their length
    TriMesh map;
    map.positions = {{-0.3, 0.1, -0.1}, {0.3, 0.1, -0.1}, {0, -0.2, 0.2}};
    map.faces = {{0, 1, 2}};  // normal (0, -1, -1) but for its length: the lower side's
    EXPECT_EQ(count_turned_faces(blade, map), 0u);
    EXPECT_EQ(count_turned_faces(blade, reversed(map)), 0u);
    // A step to the upper side's own ground, and only one of the two counts.
    for (Vec3d& p : map.positions) p += {0, -0.3, 0.2};
    EXPECT_EQ(count_turned_faces(blade, map), 1u);
    EXPECT_EQ(count_turned_faces(blade, reversed(map)), 0u);
}

TEST(TurnedFaces, FacesWithoutASideAreNotTurned) {
    const TriMesh sheet = test::square(1, 0, 2);
    TriMesh map;
    map.positions = {{0, 0, 0}, {1, 1, 0}, {0.5, 0.5, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}};
    map.faces = {{0, 1, 2}, {0, 1, 3}, {0, 0, 1}};
    EXPECT_EQ(count_turned_faces(sheet, map), 0u);
    EXPECT_EQ(count_turned_faces(TriMesh{}, sheet), 0u);
}

}  // namespace
}  // namespace dgm::bake
