// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/gltf_test.cpp
#include "export/gltf_file.h"

#include <gtest/gtest.h>

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
    const nlohmann::json json = json_of(encode_glb(maps, {}, render::UpAxis::kY));
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

TEST(Gltf, IndicesAreWideOnlyWhereTheyMustBe) {
    const auto component = [](std::uint32_t m) {
        model::MapSet maps;
        maps.charts = {plate(m, 2, 0, 0)};
        const nlohmann::json json = json_of(encode_glb(maps, {}, render::UpAxis::kY));
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
            static_cast<void>(encode_glb(maps, {}, render::UpAxis::kY));
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
