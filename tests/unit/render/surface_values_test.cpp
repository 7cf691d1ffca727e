// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/surface_values.h"

#include <gtest/gtest.h>

#include "charts.h"
#include "render/chart_colours.h"

namespace dgm::render {
namespace {

SurfaceValues values_against(const model::Chart& chart, const model::Chart& source) {
    const bake::Reconstruction of_source = bake::reconstruct(source);
    const bake::ClosestPointIndex index(of_source.mesh.positions, of_source.mesh.faces);
    return surface_values(chart, bake::reconstruct(chart), index);
}

model::Chart sheet_at(double z, double wide = 1) {
    return chart_of(9, 9, [=](double i, double j) { return model::Vec3d{i, wide * j, z}; });
}

TEST(SurfaceValues, DistanceIsPositiveOutside) {
    for (const double z : {0.25, -0.25})  // faces look up
        for (const double d : values_against(sheet_at(z), sheet_at(0)).distance) EXPECT_DOUBLE_EQ(d, z);
}

TEST(SurfaceValues, TheSourceTellsTheSameFromItsSide) {
    const bake::Reconstruction up = bake::reconstruct(sheet_at(0.25)), level = bake::reconstruct(sheet_at(0));
    for (const double d : source_distances(level.mesh, up.mesh)) EXPECT_DOUBLE_EQ(d, 0.25);
    for (const double d : source_distances(up.mesh, level.mesh)) EXPECT_DOUBLE_EQ(d, -0.25);
}

TEST(SurfaceValues, WhatTheMapLeavesOutShowsOnTheSource) {
    model::TriMesh source = bake::reconstruct(sheet_at(0)).mesh;
    source.positions[40].z = 3;  // a spike in the middle
    const std::vector<double> d = source_distances(source, bake::reconstruct(sheet_at(0)).mesh);
    EXPECT_DOUBLE_EQ(d[40], -3);
    EXPECT_DOUBLE_EQ(d[0], 0);
}

TEST(SurfaceValues, AStretchedSheet) {
    const SurfaceValues values = values_against(sheet_at(0, 4), sheet_at(0, 4));
    for (std::size_t v = 0; v < 81; ++v) {
        EXPECT_NEAR(values.angle[v], 2, 1e-12);  // s1 / s2 = 4
        EXPECT_NEAR(values.area[v], 0, 1e-12);   // the same everywhere
    }
}

TEST(SurfaceValues, AreaIsAgainstTheMean) {
    // Rows 0..4 are one apart, rows 4..8 three apart: the mean is 2.
    const model::Chart chart = chart_of(9, 9, [](double i, double j) {
        return model::Vec3d{i <= 4 ? i : 4 + 3 * (i - 4), j, 0};
    });
    const SurfaceValues values = values_against(chart, chart);
    EXPECT_NEAR(values.area[0], -1, 1e-12);
    EXPECT_NEAR(values.area[80], std::log2(1.5), 1e-12);
}

TEST(ChartColours, BlueIsInside) {
    const model::Chart chart = sheet_at(-0.25);
    const SurfaceValues values = values_against(chart, sheet_at(0));
    const Scales scales = scales_of({&values, 1}, {});
    EXPECT_DOUBLE_EQ(scales.distance, 0.25);
    EXPECT_DOUBLE_EQ(scales.worst, 0.25);
    const formats::Image picture = grid_picture(chart, values, Quantity::kDistance, scales);
    EXPECT_EQ(picture.width, 9U);
    EXPECT_GT(picture.at(4, 4).b, picture.at(4, 4).r + 50);
    EXPECT_EQ(table_place(Quantity::kDistance, 0, scales), 0.5);
    EXPECT_EQ(table_place(Quantity::kDistance, 9, scales), 1);
    EXPECT_EQ(table_place(Quantity::kAngle, 0, scales), 0);
}

}  // namespace
}  // namespace dgm::render
