// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/topology_test.cpp
// Counts of surfaces from the textbook.
#include <gtest/gtest.h>

#include <random>

#include "geometry/metrics/map_metrics.h"
#include "test_meshes.h"

namespace dgm::bake {
namespace {
using model::Face;
using test::grid_faces;

Topology expect_manifold(std::uint64_t components, std::uint64_t loops, std::int64_t genus) {
    return {components, loops, genus, true, true, 0};
}
std::ostream& print(std::ostream& out, const Topology& t) {
    return out << "components " << t.components << " loops " << t.boundary_loops << " genus " << t.genus << " manifold "
               << t.manifold << " oriented " << t.oriented << " degenerate " << t.degenerate_faces;
}
testing::AssertionResult same(const Topology& is, const Topology& want) {
    if (is == want) return testing::AssertionSuccess();
    auto failure = testing::AssertionFailure() << "is ";
    std::ostringstream text;
    print(text, is) << ", want ";
    print(text, want);
    return failure << text.str();
}

TEST(Topology, TextbookSurfaces) {
    EXPECT_TRUE(same(measure_topology(3, std::vector<Face>{{0, 1, 2}}), expect_manifold(1, 1, 0)));
    EXPECT_TRUE(same(measure_topology(20, grid_faces(4, 5)), expect_manifold(1, 1, 0)));               // disk
    EXPECT_TRUE(same(measure_topology(20, grid_faces(4, 5, false, true)), expect_manifold(1, 2, 0)));  // cylinder
    EXPECT_TRUE(same(measure_topology(20, grid_faces(4, 5, true, true)), expect_manifold(1, 0, 1)));   // torus
    const auto ball = test::sphere(1, 6);
    EXPECT_TRUE(same(measure_topology(ball.positions.size(), ball.faces), expect_manifold(1, 0, 0)));
    EXPECT_TRUE(same(measure_topology(7, {}), expect_manifold(0, 0, 0)));
}

TEST(Topology, UnusedVerticesAndFaceOrderDoNotCount) {
    std::vector<Face> faces = grid_faces(9, 7, true, true);
    std::mt19937 random(5);
    std::shuffle(faces.begin(), faces.end(), random);
    for (Face& f : faces) std::rotate(f.begin(), f.begin() + random() % 3, f.end());
    for (Face& f : faces)
        for (auto& v : f) v += 100;
    EXPECT_TRUE(same(measure_topology(1000, faces), expect_manifold(1, 0, 1)));
}

TEST(Topology, TwoComponentsAndHoles) {
    std::vector<Face> faces = grid_faces(6, 6);  // a disk with one quad missing in the middle: an annulus
    faces.erase(faces.begin() + 2 * 12, faces.begin() + 2 * 12 + 2);
    const auto torus = grid_faces(5, 5, true, true);
    for (Face f : torus) faces.push_back({f[0] + 36, f[1] + 36, f[2] + 36});
    EXPECT_TRUE(same(measure_topology(61, faces), expect_manifold(2, 2, 1)));
}

/// A torus with one handle more: two tori, each with a quad cut out, glued along the four edges.
TEST(Topology, GenusTwo) {
    std::vector<Face> faces = grid_faces(5, 5, true, true);
    faces.erase(faces.begin(), faces.begin() + 2);  // the quad of vertices 0, 5, 6, 1
    const std::size_t half = faces.size();
    const auto glued = [](std::uint32_t v) { return v == 0 || v == 5 || v == 6 || v == 1 ? v : v + 25; };
    for (std::size_t f = 0; f < half; ++f)
        faces.push_back({glued(faces[f][0]), glued(faces[f][2]), glued(faces[f][1])});
    EXPECT_TRUE(same(measure_topology(50, faces), expect_manifold(1, 0, 2)));
}

TEST(Topology, MoebiusStripIsNotOriented) {
    std::vector<Face> faces = grid_faces(6, 2);
    faces.push_back({10, 1, 0});  // the last rung joined with a half turn
    faces.push_back({10, 0, 11});
    // One of the two new faces must disagree with a neighbour whatever their winding; the border is one loop.
    const Topology t = measure_topology(12, faces);
    EXPECT_TRUE(t.manifold);
    EXPECT_FALSE(t.oriented);
    EXPECT_EQ(t.boundary_loops, 1u);
    EXPECT_EQ(t.components, 1u);
}

TEST(Topology, FlippedFaceIsNotOriented) {
    std::vector<Face> faces = grid_faces(4, 4);
    std::swap(faces[7][0], faces[7][1]);
    const Topology t = measure_topology(16, faces);
    EXPECT_TRUE(t.manifold);
    EXPECT_FALSE(t.oriented);
}

TEST(Topology, NonManifoldEdgeAndVertex) {
    const std::vector<Face> book{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
    EXPECT_FALSE(measure_topology(5, book).manifold);
    const std::vector<Face> bow_tie{{0, 1, 2}, {2, 3, 4}};
    const Topology t = measure_topology(5, bow_tie);
    EXPECT_FALSE(t.manifold);
    EXPECT_EQ(t.boundary_loops, 2u);
    EXPECT_EQ(t.components, 1u);
}

TEST(Topology, DegenerateAndForeignFacesAreCountedAndLeftOut) {
    const std::vector<Face> faces{{0, 1, 2}, {1, 1, 2}, {0, 2, 9}};
    Topology want = expect_manifold(1, 1, 0);
    want.degenerate_faces = 2;
    EXPECT_TRUE(same(measure_topology(3, faces), want));
}

}  // namespace
}  // namespace dgm::bake
