// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/chart_surface_test.cpp
#include "render/chart_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/metrics/reconstruction.h"
#include "sample_chart.h"

namespace dgm::render {
namespace {

TEST(ChartSurface, JoinsChartsAndKeepsTheirVerticesApart) {
    const std::vector<model::Chart> charts{test::torus_chart(17, 33), test::torus_chart(9, 9)};
    const ChartSurface surface = chart_surface(charts);
    ASSERT_EQ(surface.mesh.positions.size(), 17u * 33 + 9 * 9);
    ASSERT_EQ(surface.mesh.faces.size(), 2u * 16 * 32 + 2 * 8 * 8);
    EXPECT_EQ(surface.mesh.faces.back()[0] >= 17 * 33, true);
    EXPECT_EQ(surface.mesh.face_materials.front(), 0u);
    EXPECT_EQ(surface.mesh.face_materials.back(), 1u);
    EXPECT_EQ(surface.mesh.corner_normals.size(), 3 * surface.mesh.faces.size());
    const auto second = bake::reconstruct(charts[1]).mesh;
    EXPECT_EQ(surface.mesh.positions[17 * 33 + 40], second.positions[40]);
    EXPECT_EQ(surface.seam_gap, 0);
}

TEST(ChartSurface, TextureCoordinatesHitTexelCentres) {
    const model::Chart chart = test::torus_chart(17, 33);
    const ChartSurface surface = chart_surface({&chart, 1});
    ASSERT_EQ(surface.textures[0].width, 65u);
    ASSERT_EQ(surface.textures[0].height, 33u);
    for (std::size_t c = 0; c < 3 * surface.mesh.faces.size(); ++c) {
        const std::uint32_t sample = surface.mesh.faces[c / 3][c % 3], i = sample / 33, j = sample % 33;
        EXPECT_NEAR(surface.mesh.corner_uvs[c].x * 65, 2 * j + 0.5, 1e-9);        // column 2j of the picture
        EXPECT_NEAR((1 - surface.mesh.corner_uvs[c].y) * 33, 2 * i + 0.5, 1e-9);  // row 2i from the top
    }
}

TEST(ChartSurface, BorderEdgesAreSeamsWhereTheyMeet) {
    const model::Chart torus = test::torus_chart(17, 33), disc = test::disc_chart(33);
    const ChartSurface closed = chart_surface({&torus, 1}), open = chart_surface({&disc, 1});
    EXPECT_EQ(closed.seams.size(), 2u * 16 + 2 * 32);
    EXPECT_TRUE(closed.borders.empty());
    EXPECT_TRUE(open.seams.empty());
    EXPECT_GT(open.borders.size(), 50u);
    EXPECT_TRUE(open.mesh.corner_normals.empty());
}

TEST(ChartSurface, GridLinesAreThinnedToAboutThirtyTwo) {
    const model::Chart fine = test::torus_chart(129, 65);
    // 33 lines of 64 steps along v, and 33 of 128 along u.
    EXPECT_EQ(chart_surface({&fine, 1}).grid.size(), 33u * 64 + 33 * 128);
}

}  // namespace
}  // namespace dgm::render
