// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/reconstruction_test.cpp
// A 3 x 3 chart by hand: both diagonals, a mask, a border strip, a seam; then everything that can be wrong with it.
#include "geometry/metrics/reconstruction.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "geometry/metrics/map_metrics.h"
#include "model/codes.h"
#include "test_charts.h"

namespace dgm::bake {
namespace {
using model::Chart;
using model::ElementType;
using model::Face;
using model::Vec2d;
using model::Vec3d;
using test::make_layer;

/// A sheet folded shut: columns 0 and 2 are the same line, sample (i, j) stands at height i.
Chart folded_strip() {
    Chart chart;
    chart.rows = chart.cols = 3;
    chart.offset = {10, 20, 30};
    std::vector<float> xyz;
    for (int i = 0; i < 3; ++i)
        for (const auto& [x, y] : {std::pair{0.f, 0.f}, std::pair{1.f, 0.5f}, std::pair{0.f, 0.f}})
            xyz.insert(xyz.end(), {x, y, static_cast<float>(i)});
    chart.layers.push_back(make_layer<float>("geometry", ElementType::kF32, {3, 3, 3}, xyz));
    chart.layers.push_back(make_layer<std::uint8_t>("diagonals", ElementType::kU8, {2, 2}, {0, 1, 1, 0}));
    chart.layers.push_back(make_layer<std::uint32_t>("seams", ElementType::kU32, {3, 2}, {0, 2, 3, 5, 6, 8}));
    return chart;
}

TEST(Reconstruction, BothDiagonalsInRowMajorOrder) {
    const Reconstruction r = reconstruct(folded_strip());
    // Corners of quad (i, j), counter-clockwise in (u, v): (i,j) (i+1,j) (i+1,j+1) (i,j+1).
    const std::vector<Face> want{{0, 3, 4}, {0, 4, 1},   // quad (0, 0): 0-4
                                 {1, 4, 2}, {4, 5, 2},   // quad (0, 1): 4-2
                                 {3, 6, 4}, {6, 7, 4},   // quad (1, 0): 6-4
                                 {4, 7, 8}, {4, 8, 5}};  // quad (1, 1): 4-8
    EXPECT_EQ(r.mesh.faces, want);
    EXPECT_EQ(r.mesh.positions[4], (Vec3d{11, 20.5, 31}));
    EXPECT_EQ(r.mesh.positions[8], (Vec3d{10, 20, 32}));
    EXPECT_EQ(r.mesh.corner_uvs.size(), 24u);
    EXPECT_EQ(r.mesh.corner_uvs[1], (Vec2d{0, 0.5}));  // sample 3 = (1, 0): v = 0, u = 1/2
    EXPECT_TRUE(r.mesh.corner_normals.empty());
}

TEST(Reconstruction, SeamWeldsCopies) {
    const Reconstruction r = reconstruct(folded_strip());
    EXPECT_EQ(r.weld, (std::vector<std::uint32_t>{0, 1, 0, 3, 4, 3, 6, 7, 6}));
    EXPECT_EQ(r.welded_faces[2], (Face{1, 4, 0}));
    EXPECT_EQ(r.seam_gap, 0);

    Chart torn = folded_strip();
    test::poke<float>(*torn.find("geometry"), 3 * 5 + 1, 0.125f);
    EXPECT_EQ(reconstruct(torn).seam_gap, 0.125);
    test::poke<float>(*torn.find("geometry"), 3 * 5 + 1, std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(reconstruct(torn).seam_gap, std::numeric_limits<double>::infinity());
}

TEST(Reconstruction, WithoutDiagonalsAllAreZero) {
    Chart chart = folded_strip();
    std::erase_if(chart.layers, [](const auto& l) { return l.name == "diagonals"; });
    const Reconstruction r = reconstruct(chart);
    EXPECT_EQ(r.mesh.faces[2], (Face{1, 4, 5}));
    EXPECT_EQ(r.mesh.faces[3], (Face{1, 5, 2}));
}

TEST(Reconstruction, QuantisedPositionsAndNormals) {
    Chart chart;
    chart.rows = chart.cols = 2;
    chart.offset = {-1, 0, 5};
    chart.scale = {0.5, 2, 1};
    chart.layers.push_back(
        make_layer<std::uint16_t>("geometry", ElementType::kU16, {2, 2, 3}, {0, 0, 0, 65535, 1, 2, 3, 4, 5, 6, 7, 8}));
    // Octahedral codes of +z, +x, -x, +y.
    chart.layers.push_back(
        make_layer<std::int16_t>("normal", ElementType::kI16, {2, 2, 2}, {0, 0, 32767, 0, -32767, 0, 0, 32767}));
    const Reconstruction r = reconstruct(chart);
    EXPECT_EQ(r.mesh.positions[1], (Vec3d{-1 + 0.5 * 65535, 2, 7}));
    ASSERT_EQ(r.mesh.corner_normals.size(), 6u);
    EXPECT_EQ(r.mesh.faces[0], (Face{0, 2, 3}));
    EXPECT_EQ(r.mesh.corner_normals[0], (Vec3d{0, 0, 1}));
    EXPECT_EQ(r.mesh.corner_normals[1], (Vec3d{-1, 0, 0}));
    EXPECT_EQ(r.mesh.corner_normals[2], (Vec3d{0, 1, 0}));
}

/// 3 x 3 grid with corner (2, 2) off the surface; the notch is closed by one border sample and two faces.
Chart free_chart() {
    Chart chart;
    chart.rows = chart.cols = 3;
    chart.domain = model::Domain::kFree;
    std::vector<float> xyz;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) xyz.insert(xyz.end(), {static_cast<float>(i), static_cast<float>(j), 0.f});
    chart.layers.push_back(make_layer<float>("geometry", ElementType::kF32, {3, 3, 3}, xyz));
    chart.layers.push_back(make_layer<std::uint8_t>("mask", ElementType::kU8, {3, 3}, {1, 1, 1, 1, 1, 1, 1, 1, 0}));
    chart.layers.push_back(make_layer<float>("border_uv", ElementType::kF32, {1, 2}, {0.875f, 0.75f}));
    chart.layers.push_back(make_layer<float>("border_geometry", ElementType::kF32, {1, 3}, {1.75f, 1.5f, 0.f}));
    chart.layers.push_back(make_layer<std::uint32_t>("border_faces", ElementType::kU32, {2, 3}, {4, 7, 9, 4, 9, 5}));
    return chart;
}

TEST(Reconstruction, MaskAndBorderStrip) {
    const Reconstruction r = reconstruct(free_chart());
    ASSERT_EQ(r.mesh.faces.size(), 8u);
    EXPECT_EQ(r.mesh.faces[6], (Face{4, 7, 9}));
    EXPECT_EQ(r.mesh.faces[7], (Face{4, 9, 5}));
    EXPECT_EQ(r.mesh.positions[9], (Vec3d{1.75, 1.5, 0}));
    EXPECT_EQ(r.mesh.corner_uvs[3 * 6 + 2], (Vec2d{0.75, 0.875}));
    const Topology t = measure_topology(r.mesh.positions.size(), r.welded_faces);
    EXPECT_EQ(t, (Topology{1, 1, 0, true, true, 0}));
}

/// Every way to break a chart ends in the code that says so.
TEST(Reconstruction, RefusesWhatDoesNotFit) {
    using Break = std::function<void(Chart&)>;
    const auto code_of = [](Chart chart, const Break& change) -> int {
        change(chart);
        try {
            (void)reconstruct(chart);
        } catch (const model::Error& error) { return error.code().number; }
        return 0;
    };
    const auto reshape = [](const char* name, std::vector<std::uint64_t> shape) {
        return [=](Chart& c) { c.find(name)->shape = shape; };
    };
    const int shape = model::codes::kBadLayerShape.number, seam = model::codes::kBadSeamTable.number;
    EXPECT_EQ(code_of(folded_strip(), [](Chart&) {}), 0);
    EXPECT_EQ(code_of(folded_strip(), [](Chart& c) { c.layers.erase(c.layers.begin()); }),
              model::codes::kMissingLayer.number);
    EXPECT_EQ(code_of(folded_strip(), [](Chart& c) { c.rows = 4; }), shape);
    EXPECT_EQ(code_of(folded_strip(), [](Chart& c) { c.rows = 1; }), shape);
    EXPECT_EQ(code_of(folded_strip(), reshape("geometry", {3, 3})), shape);
    EXPECT_EQ(code_of(folded_strip(), reshape("geometry", {})), shape);
    EXPECT_EQ(code_of(folded_strip(), [](Chart& c) { c.find("geometry")->type = ElementType::kU16; }), shape);
    EXPECT_EQ(code_of(folded_strip(), [](Chart& c) { c.find("geometry")->bytes.pop_back(); }), shape);
    EXPECT_EQ(code_of(folded_strip(), reshape("diagonals", {3, 3})), shape);
    EXPECT_EQ(code_of(folded_strip(), reshape("seams", {std::uint64_t{1} << 62, 2})), shape);
    EXPECT_EQ(code_of(folded_strip(), reshape("seams", {4, 2})), shape);
    const auto seams = [](std::size_t index, std::uint32_t value) {
        return [=](Chart& c) { test::poke<std::uint32_t>(*c.find("seams"), index, value); };
    };
    EXPECT_EQ(code_of(folded_strip(), seams(1, 9)), seam);  // out of range
    EXPECT_EQ(code_of(folded_strip(), seams(0, 2)), seam);  // not below its copy
    EXPECT_EQ(code_of(folded_strip(), seams(3, 2)), seam);  // 2 is a copy twice (and 3 not below it)
    EXPECT_EQ(code_of(folded_strip(), seams(5, 5)), seam);  // 5 is a copy twice
    EXPECT_EQ(code_of(folded_strip(), seams(4, 5)), seam);  // representative 5 is a copy
    EXPECT_EQ(code_of(free_chart(), [](Chart& c) { test::poke<std::uint32_t>(*c.find("border_faces"), 5, 10); }),
              model::codes::kBadValue.number);
    EXPECT_EQ(code_of(free_chart(), reshape("border_uv", {2, 1})), shape);
    EXPECT_EQ(code_of(free_chart(), reshape("border_geometry", {std::uint64_t{1} << 60, 3})), shape);
}

}  // namespace
}  // namespace dgm::bake
