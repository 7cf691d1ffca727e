// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/gltf_test.cpp
#include "export/gltf_file.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "export/tangent_space.h"
#include "geometry/metrics/reconstruction.h"
#include "model/codes.h"
#include "model/half.h"
#include "sample_chart.h"

namespace dgm::exporter {
namespace {
using model::Chart;
using model::ElementType;
using model::Face;
using model::Vec2d;
using model::Vec3d;

/// The square 0..1 in the plane z = 0 as a viewer at +z sees its picture: x = v to the right, y = 1 - u upwards.
Chart plate(std::uint32_t m, std::uint32_t texels, double slope_x, double slope_y) {
    Chart chart;
    chart.rows = chart.cols = m;
    chart.bbox = {0, 0, 0, 1, 1, 0};
    std::vector<float> geometry;
    std::vector<std::uint16_t> heights;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < m; ++j)
            geometry.insert(geometry.end(), {static_cast<float>(j) / static_cast<float>(m - 1),
                                             1 - static_cast<float>(i) / static_cast<float>(m - 1), 0.0f});
    for (std::uint32_t i = 0; i < texels; ++i)
        for (std::uint32_t j = 0; j < texels; ++j)
            heights.push_back(
                model::half_bits(static_cast<float>((slope_x * j + slope_y * (texels - 1.0 - i)) / (texels - 1.0))));
    const std::vector<std::int16_t> normals(std::size_t{2} * m * m, 0);  // code (0, 0) is +z
    chart.layers.push_back(test::make_layer("geometry", ElementType::kF32, {m, m, 3}, geometry));
    chart.layers.push_back(test::make_layer("normal", ElementType::kI16, {m, m, 2}, normals));
    chart.layers.push_back(test::make_layer("bump", ElementType::kF16, {texels, texels}, heights));
    chart.layers.back().attributes["shading"] = std::vector<double>{1};
    return chart;
}

ChartMesh mesh_of(const bake::Reconstruction& surface) {
    ChartMesh mesh;
    mesh.positions = surface.mesh.positions;
    mesh.faces = surface.mesh.faces;
    mesh.normals.resize(mesh.positions.size());
    mesh.uvs.resize(mesh.positions.size());
    for (std::size_t c = 0; c < 3 * mesh.faces.size(); ++c) {
        const std::uint32_t v = mesh.faces[c / 3][c % 3];
        mesh.normals[v] = surface.mesh.corner_normals[c];
        mesh.uvs[v] = {surface.mesh.corner_uvs[c].y, surface.mesh.corner_uvs[c].x};
    }
    return mesh;
}

/// Components of all texels, which must agree.
Vec3d only_normal(const Chart& chart) {
    const bake::Reconstruction surface = bake::reconstruct(chart);
    const ChartMesh mesh = mesh_of(surface);
    const auto map = tangent_normal_map(chart, surface, mesh, vertex_tangents(mesh));
    if (!map) throw std::runtime_error("no map");
    for (const model::Rgba8& pixel : map->pixels)
        if (pixel != map->pixels[0]) throw std::runtime_error("texels differ");
    const model::Rgba8& p = map->pixels[0];
    EXPECT_EQ(p.a, 255);
    return {p.r / 127.5 - 1, p.g / 127.5 - 1, p.b / 127.5 - 1};
}

void expect_near(const Vec3d& found, const Vec3d& wanted) {
    EXPECT_NEAR(found.x, wanted.x, 0.5 / 127.5 + 1e-3);
    EXPECT_NEAR(found.y, wanted.y, 0.5 / 127.5 + 1e-3);
    EXPECT_NEAR(found.z, wanted.z, 0.5 / 127.5 + 1e-3);
}

TEST(Gltf, NormalMapOfRampsLeansAgainstTheRise) {
    // A surface z = a x + b y has the normal (-a, -b, 1); the plate's basis is x to the right, y up in the picture.
    const double l = std::sqrt(1.25), d = std::sqrt(1.0625 + 0.25);
    expect_near(only_normal(plate(9, 17, 0.5, 0)), {-0.5 / l, 0, 1 / l});
    expect_near(only_normal(plate(9, 17, 0, 0.5)), {0, -0.5 / l, 1 / l});
    expect_near(only_normal(plate(9, 33, -0.25, 0.5)), {0.25 / d, -0.5 / d, 1 / d});
    expect_near(only_normal(plate(17, 9, 0, -0.5)), {0, 0.5 / l, 1 / l});  // coarser than the grid
}

TEST(Gltf, FlatMapIsNeutral) {
    const Chart chart = plate(9, 17, 0, 0);
    const bake::Reconstruction surface = bake::reconstruct(chart);
    const ChartMesh mesh = mesh_of(surface);
    const auto map = tangent_normal_map(chart, surface, mesh, vertex_tangents(mesh));
    ASSERT_TRUE(map);
    for (const model::Rgba8& pixel : map->pixels) ASSERT_EQ(pixel, (model::Rgba8{128, 128, 255, 255}));
}

TEST(Gltf, TangentsFollowTheColumns) {
    const Chart chart = test::torus_chart(17, 33);
    const ChartMesh mesh = mesh_of(bake::reconstruct(chart));
    const std::vector<Vec3d> tangents = vertex_tangents(mesh);
    for (std::uint32_t i = 0; i < 17; ++i)
        for (std::uint32_t j = 0; j < 33; ++j) {
            const double b = 2 * std::numbers::pi * j / 32;
            const Vec3d& t = tangents[i * 33 + j];
            ASSERT_NEAR(length(t), 1, 1e-12);
            ASSERT_NEAR(dot(t, mesh.normals[i * 33 + j]), 0, 1e-12);
            // Around the y axis. On the borders only one side's faces count: half a step off.
            ASSERT_GT(dot(t, Vec3d{-std::sin(b), 0, std::cos(b)}), j == 0 || j == 32 ? 0.98 : 0.995) << i << " " << j;
        }
}

TEST(Gltf, TangentsExistWhereTheMapGivesNone) {
    ChartMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
    mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0.6, 0, 0.8}};
    mesh.uvs.assign(4, Vec2d{0.5, 0.5});
    mesh.faces = {{0, 1, 2}};
    const std::vector<Vec3d> tangents = vertex_tangents(mesh);
    for (std::size_t v = 0; v < 4; ++v) {
        EXPECT_NEAR(length(tangents[v]), 1, 1e-12);
        EXPECT_NEAR(dot(tangents[v], mesh.normals[v]), 0, 1e-12);
    }
}

nlohmann::json json_of(const std::vector<std::byte>& glb) {
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    return nlohmann::json::parse(reinterpret_cast<const char*>(glb.data()) + 20,
                                 reinterpret_cast<const char*>(glb.data()) + 20 + length);
}

TEST(Gltf, FarChartsKeepTheirDigitsByTheirNode) {
    model::MapSet maps;
    maps.source_name = "far.obj";
    maps.charts = {plate(9, 17, 0, 0), test::torus_chart(17, 33)};
    maps.charts[0].offset = {1e7, -2e7, 0.1};
    const nlohmann::json json = json_of(encode_glb(maps));
    EXPECT_EQ(json["nodes"][0]["name"], "far");
    EXPECT_FALSE(json["nodes"][0].contains("matrix"));
    EXPECT_EQ(json["nodes"][1]["translation"].get<std::vector<double>>(), (std::vector<double>{1e7, -2e7, 0.1}));
    EXPECT_FALSE(json["nodes"][2].contains("translation"));
    const nlohmann::json& position =
        json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
    EXPECT_EQ(position["max"], (std::vector<double>{1, 1, 0}));
    // The plate is open; the torus meets itself at its seams, and its bump has another size than its texture.
    EXPECT_EQ(json["materials"][0].value("doubleSided", false), true);
    EXPECT_EQ(json["materials"][1].value("doubleSided", false), false);
    EXPECT_FALSE(json["materials"][0]["normalTexture"].contains("texCoord"));
    EXPECT_EQ(json["materials"][1]["normalTexture"]["texCoord"], 1);
}

TEST(Gltf, OneChartIsOneNodeWithTheAssetsName) {
    model::MapSet maps;
    maps.source_name = "robe.obj";
    maps.charts = {plate(9, 17, 0, 0)};
    maps.charts[0].offset = {1, 2, 3};
    nlohmann::json json = json_of(encode_glb(maps));
    ASSERT_EQ(json["nodes"].size(), 1u);
    EXPECT_EQ(json["scenes"][0]["nodes"], (std::vector<int>{0}));
    for (const char* list : {"nodes", "meshes", "materials"}) EXPECT_EQ(json[list][0]["name"], "robe") << list;
    GlbOptions turned;
    turned.up = render::UpAxis::kZ;
    json = json_of(encode_glb(maps, turned));
    EXPECT_EQ(json["nodes"][0]["matrix"], (std::vector<double>{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 1, 3, -2, 1}));
    maps.charts.push_back(maps.charts[0]);
    json = json_of(encode_glb(maps));
    EXPECT_EQ(json["nodes"][0]["name"], "robe");
    EXPECT_EQ(json["nodes"][0]["children"], (std::vector<int>{1, 2}));
    EXPECT_EQ(json["nodes"][2]["name"], "robe_chart1");
    EXPECT_EQ(json["materials"][1]["name"], "robe_chart1");
}

TEST(Gltf, LevelsShareTheirVertices) {
    model::MapSet maps;
    maps.source_name = "robe.obj";
    maps.charts = {plate(9, 17, 0, 0), plate(9, 17, 0, 0)};
    const std::vector<Face> corner{{0, 9, 10}};
    GlbOptions options;
    options.levels = {{1, {}}, {4, {corner, corner}}};
    nlohmann::json json = json_of(encode_glb(maps, options));
    ASSERT_EQ(json["nodes"].size(), 5u);  // root, and two a chart
    EXPECT_EQ(json["nodes"][0]["children"], (std::vector<int>{1, 3}));
    EXPECT_EQ(json["nodes"][1]["extensions"]["MSFT_lod"]["ids"], (std::vector<int>{2}));
    EXPECT_EQ(json["nodes"][4]["name"], "robe_chart1_lod4");
    EXPECT_EQ(json["extensionsUsed"], (std::vector<std::string>{"MSFT_lod"}));
    EXPECT_FALSE(json.contains("extensionsRequired"));
    const nlohmann::json& fine = json["meshes"][0]["primitives"][0];
    const nlohmann::json& coarse = json["meshes"][1]["primitives"][0];
    EXPECT_EQ(fine["attributes"], coarse["attributes"]);
    EXPECT_EQ(json["accessors"][coarse["indices"].get<std::size_t>()]["count"], 3);
    const nlohmann::json& coverage = json["nodes"][1]["extras"]["MSFT_screencoverage"];
    ASSERT_EQ(coverage.size(), 2u);
    EXPECT_DOUBLE_EQ(coverage[0].get<double>(), 4.0 / 1080 * 8 / 4);
    options.lod_mode = LodMode::kNodes;
    json = json_of(encode_glb(maps, options));
    EXPECT_EQ(json["nodes"][0]["children"], (std::vector<int>{1, 2, 3, 4}));
    EXPECT_FALSE(json.contains("extensionsUsed"));
}

TEST(Gltf, QuantizedPositionsAreNearAndMeetAtSeams) {
    model::MapSet maps;
    maps.charts = {test::torus_chart(17, 33)};
    maps.charts[0].offset = {100, 0, -7};
    GlbOptions options;
    options.quantize = true;
    const std::vector<std::byte> glb = encode_glb(maps, options);
    const nlohmann::json json = json_of(glb);
    EXPECT_EQ(json["extensionsRequired"], (std::vector<std::string>{"KHR_mesh_quantization"}));
    const nlohmann::json& attributes = json["meshes"][0]["primitives"][0]["attributes"];
    const nlohmann::json& accessor = json["accessors"][attributes["POSITION"].get<std::size_t>()];
    EXPECT_EQ(accessor["componentType"], 5123);
    EXPECT_EQ(accessor["normalized"], true);
    EXPECT_EQ(json["accessors"][attributes["NORMAL"].get<std::size_t>()]["componentType"], 5120);
    const nlohmann::json& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    EXPECT_EQ(view["byteStride"], 8);
    const std::size_t start = glb.size() - (json["buffers"][0]["byteLength"].get<std::size_t>() + 3) / 4 * 4 +
                              view["byteOffset"].get<std::size_t>();
    const model::TriMesh exact = bake::reconstruct(maps.charts[0]).mesh;
    const double scale = json["nodes"][0]["scale"][0].get<double>();
    EXPECT_NEAR(scale, 2.8, 1e-6);
    for (std::size_t v = 0; v < exact.positions.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint16_t code = 0;
            std::memcpy(&code, glb.data() + start + 8 * v + 2 * c, 2);
            const double found = json["nodes"][0]["translation"][c].get<double>() + scale * code / 65535;
            ASSERT_NEAR(found, exact.positions[v][static_cast<int>(c)], scale / 131070 + 1e-12) << v;
        }
}

/// The decoded bytes of a compressed view.
std::vector<unsigned char> decoded(const std::vector<std::byte>& glb, const nlohmann::json& json, std::size_t view) {
    const nlohmann::json& packed = json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"];
    const std::size_t chunk = glb.size() - (json["buffers"][0]["byteLength"].get<std::size_t>() + 3) / 4 * 4;
    const auto* bytes =
        reinterpret_cast<const unsigned char*>(glb.data()) + chunk + packed["byteOffset"].get<std::size_t>();
    const auto count = packed["count"].get<std::size_t>(), stride = packed["byteStride"].get<std::size_t>(),
               length = packed["byteLength"].get<std::size_t>();
    std::vector<unsigned char> out(count * stride);
    const int error = packed["mode"] == "ATTRIBUTES"
                          ? meshopt_decodeVertexBuffer(out.data(), count, stride, bytes, length)
                          : meshopt_decodeIndexBuffer(out.data(), count, stride, bytes, length);
    EXPECT_EQ(error, 0);
    EXPECT_EQ(bytes[0], packed["mode"] == "ATTRIBUTES" ? 0xa0 : 0xe1);  // the versions that the extension prescribes
    return out;
}

TEST(Gltf, CompressionLosesNothing) {
    model::MapSet maps;
    maps.charts = {test::torus_chart(17, 33)};
    for (const bool quantize : {false, true}) {
        GlbOptions options;
        options.quantize = quantize;
        const std::vector<std::byte> plain = encode_glb(maps, options);
        options.compress = true;
        const std::vector<std::byte> small = encode_glb(maps, options);
        EXPECT_LT(small.size(), plain.size());
        const nlohmann::json before = json_of(plain), json = json_of(small);
        EXPECT_EQ(json["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"], true);
        const std::size_t chunk = plain.size() - (before["buffers"][0]["byteLength"].get<std::size_t>() + 3) / 4 * 4;
        std::size_t compared = 0;
        for (std::size_t a = 0; a < json["accessors"].size(); ++a) {
            const std::size_t view = json["accessors"][a]["bufferView"].get<std::size_t>();
            const std::vector<unsigned char> found = decoded(small, json, view);
            const nlohmann::json& old = before["bufferViews"][before["accessors"][a]["bufferView"].get<std::size_t>()];
            ASSERT_EQ(found.size(), old["byteLength"].get<std::size_t>());
            const auto* wanted =
                reinterpret_cast<const unsigned char*>(plain.data()) + chunk + old["byteOffset"].get<std::size_t>();
            if (json["accessors"][a]["type"] != "SCALAR") {
                EXPECT_TRUE(std::equal(found.begin(), found.end(), wanted)) << a;
                ++compared;
                continue;
            }
            for (std::size_t f = 0; f < found.size(); f += 6) {  // triangles may be turned, not flipped
                std::array<std::uint16_t, 3> one{}, two{};
                std::memcpy(one.data(), &found[f], 6);
                std::memcpy(two.data(), wanted + f, 6);
                std::rotate(one.begin(), std::min_element(one.begin(), one.end()), one.end());
                std::rotate(two.begin(), std::min_element(two.begin(), two.end()), two.end());
                ASSERT_EQ(one, two) << f;
            }
        }
        EXPECT_GE(compared, 4u);
    }
}

TEST(Gltf, IndicesAreWideOnlyWhereTheyMustBe) {
    const auto component = [](std::uint32_t m) {
        model::MapSet maps;
        maps.charts = {plate(m, 2, 0, 0)};
        const nlohmann::json json = json_of(encode_glb(maps));
        return json["accessors"][json["meshes"][0]["primitives"][0]["indices"].get<std::size_t>()]["componentType"]
            .get<int>();
    };
    EXPECT_EQ(component(255), 5123);
    EXPECT_EQ(component(256), 5125);  // 65536 vertices
}

TEST(Gltf, WhatItCannotHoldIsRefused) {
    model::MapSet maps;
    maps.charts = {plate(9, 9, 0, 0)};
    const auto code = [&] {
        try {
            static_cast<void>(encode_glb(maps));
        } catch (const model::Error& error) { return &error.code(); }
        return static_cast<const model::Code*>(nullptr);
    };
    EXPECT_EQ(code(), nullptr);
    model::Layer& bump = *maps.charts[0].find("bump");
    bump.type = ElementType::kU8;  // half the bytes that its shape would ask for
    EXPECT_EQ(code(), &model::codes::kBadLayerShape);
    maps.charts = {plate(9, 9, 0, 0)};
    const float infinity = std::numeric_limits<float>::infinity();
    std::memcpy(maps.charts[0].find("geometry")->bytes.data(), &infinity, sizeof infinity);
    EXPECT_EQ(code(), &model::codes::kNotFinite);
}

}  // namespace
}  // namespace dgm::exporter
