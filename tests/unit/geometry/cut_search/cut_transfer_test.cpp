// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut_search/cut_transfer_test.cpp
// Cuts found on a simplified mesh still open the fine one into a disk, and are hardly longer there.
#include "geometry/cut_search/cut_transfer.h"

#include <gtest/gtest.h>

#include "geometry/cut_search/cut_carry.h"
#include "geometry/cut_search/cut_search.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/simplify/simplify.h"
#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

struct Surface {
    const char* name;
    TriMesh mesh;
};
std::vector<Surface> surfaces() {
    return {{"ball", test::icosphere(5)},         {"torus", test::torus(1, 0.4, 96, 48)},
            {"genus 3", test::genus_plate(3, 8)}, {"annulus", test::annulus(1, 2, 120, 20)},
            {"comb", test::comb(3, 6, 5)},        {"finger", test::finger(0.2, 2, 40, 80, 12)}};
}

/// The mesh with an eighth of its faces, cut to a disk and on to two vertices more.
struct CoarseCut {
    explicit CoarseCut(const TriMesh& fine)
        : small(simplify(fine, fine.faces.size() / 8, {}, {})),
          mesh(compact(fine.positions, small.faces)),
          cut(mesh.mesh) {
        cut.cut_to_disk();
        cut.join(0);
        cut.join(static_cast<std::uint32_t>(mesh.mesh.positions.size() / 2));
    }
    Simplified small;
    CompactMesh mesh;
    CutGraph cut;
};

TEST(CutTransfer, OpensTheFineMeshAlongTheCoarseCut) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        CutGraph fine_cut(s.mesh);
        const CoarseCut coarse(s.mesh);
        ASSERT_TRUE(transfer_cut(coarse.cut, coarse.mesh.original, coarse.small, fine_cut));
        const Disk coarse_disk = coarse.cut.open(), fine_disk = fine_cut.open();
        test::expect_links(fine_disk);
        test::expect_disk(fine_disk);
        // Edges of the fine mesh zigzag about the coarse ones: at most by the 1.16 of a lattice of equilateral
        // triangles where the path may choose its way, a little more where its ends are near.
        EXPECT_LT(fine_cut.length(), 1.35 * coarse.cut.length());
        EXPECT_GT(fine_cut.length(), 0.7 * coarse.cut.length());
        EXPECT_EQ(fine_disk.paths().size(), coarse_disk.paths().size());
        const auto rotation = transfer_rotation(coarse_disk, 33, 33, 7, coarse.mesh.original, fine_disk, 65, 65);
        if (rotation) { EXPECT_LT(*rotation, (BorderGrid{65, 65}.count())); }
    }
}

TEST(CutCarry, TakesTheSameNetworkThroughTheCollapses) {
    for (const Surface& s : surfaces()) {
        SCOPED_TRACE(s.name);
        CutGraph fine_cut(s.mesh);
        const CoarseCut coarse(s.mesh);
        const std::vector<std::pair<std::uint32_t, std::uint32_t>> edges =
            carry_cut(coarse.cut, coarse.mesh.original, coarse.small, fine_cut);
        const VertexGraph& graph = fine_cut.graph();
        for (const auto& [a, b] : edges) {
            bool found = false;
            for (std::uint32_t k = graph.first[a]; k < graph.first[a + 1]; ++k)
                if (graph.arcs[k].to == b) {
                    fine_cut.mark(graph.arcs[k].half_edge, true);
                    found = true;
                }
            ASSERT_TRUE(found) << a << " and " << b << " are no neighbours";
        }
        const Disk coarse_disk = coarse.cut.open(), fine_disk = fine_cut.open();
        test::expect_links(fine_disk);
        test::expect_disk(fine_disk);
        // Nodes of more than three paths may part, and each one more is one pair of mates more.
        EXPECT_GE(fine_disk.paths().size(), coarse_disk.paths().size());
        EXPECT_LT(fine_cut.length(), 2 * coarse.cut.length());
    }
}

TEST(CutTransfer, KeepsWhereTheBorderStarts) {
    // The cut of a closed ball is one path from a to b: with the start of the coarse border on sample 0 the same end of
    // the fine cut must lie there.
    const TriMesh ball = test::icosphere(5);
    const Simplified small = simplify(ball, 2000, {}, {});
    const CompactMesh coarse = compact(ball.positions, small.faces);
    CutGraph coarse_cut(coarse.mesh), fine_cut(ball);
    coarse_cut.cut_to_disk();
    ASSERT_TRUE(transfer_cut(coarse_cut, coarse.original, small, fine_cut));
    const Disk coarse_disk = coarse_cut.open();
    Disk fine_disk = fine_cut.open();
    const std::vector<BorderPath> coarse_paths = coarse_disk.paths();
    const std::uint32_t start =
        coarse.original[coarse_disk.weld[origin(coarse_disk.mesh.faces, coarse_paths[0].half_edges[0])]];
    const auto rotation = transfer_rotation(coarse_disk, 33, 33, 8, coarse.original, fine_disk, 65, 65);
    ASSERT_TRUE(rotation);
    const SquareBorder border = lay_square_border(fine_disk, 65, 65, *rotation);
    const SurfaceSample& at = border.samples[16].at;  // 8 of 128 is 16 of 256
    const Vec3d where = fine_disk.mesh.positions[fine_disk.mesh.faces[at.face][0]] * at.b[0] +
                        fine_disk.mesh.positions[fine_disk.mesh.faces[at.face][1]] * at.b[1] +
                        fine_disk.mesh.positions[fine_disk.mesh.faces[at.face][2]] * at.b[2];
    EXPECT_LT(length(where - ball.positions[start]), 1e-12);
}

TEST(CutSearch, FindsOnASimplifiedMeshWhatTheWholeOneNeeds) {
    // 20 480 faces: searched in simplified form; a body with three teeth cannot do without cuts along them.
    TriMesh comb = test::comb(3, 5, 10);
    for (Vec3d& p : comb.positions) p = p / 10.0;
    ASSERT_GT(comb.faces.size(), 7500u);
    CutSearchOptions options;
    options.m = options.n = 65;
    const CutSearchResult found = search_cut(comb, options, {});
    test::expect_links(found.disk);
    test::expect_disk(found.disk);
    EXPECT_GE(found.disk.paths().size(), 4u) << "more than the one path that a closed body needs";
    EXPECT_LT(found.rotation, (BorderGrid{65, 65}.count()));
}

TEST(CutSearch, TakesTheWantedGridWhereASmallerOnesBorderHasNoRoom) {
    // 64 holes with four corners each: their paths need more intervals than the border of a trial's grid has.
    std::vector<std::array<std::uint32_t, 2>> holes;
    for (std::uint32_t i = 0; i < 8; ++i)
        for (std::uint32_t j = 0; j < 8; ++j) holes.push_back({6 + 9 * i, 6 + 9 * j});
    const TriMesh plate = test::sheet_with_holes(80, holes);
    ASSERT_GT(plate.faces.size(), 7500u) << "searched simplified";
    CutSearchOptions options;
    options.m = options.n = 129;
    options.only_simplified = true;
    const CutSearchResult found = search_cut(plate, options, {});
    test::expect_links(found.disk);
    test::expect_disk(found.disk);
    EXPECT_GE(found.disk.paths().size(), 64u * 6);
    EXPECT_LT(found.rotation, (BorderGrid{129, 129}.count()));
}

}  // namespace
}  // namespace dgm::bake
