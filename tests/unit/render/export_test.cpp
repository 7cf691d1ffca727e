// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/export_test.cpp
#include "export/export_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "dgm/dgm_writer.h"
#include "export/chart_pictures.h"
#include "export/map_stamp.h"
#include "exr/exr_writer.h"
#include "geometry/metrics/reconstruction.h"
#include "image/image.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "sample_chart.h"

namespace dgm::exporter {
namespace {
using model::MapSet;
using std::filesystem::path;

class Export : public testing::Test {
 protected:
    void SetUp() override {
        folder_ = path(testing::TempDir()) /
                  (std::string("dgm_export_") + testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void write(const MapSet& maps, const std::string& name, const ExportOptions& options = {}) const {
        export_maps(maps, folder_ / name, options, [](const std::string&) {});
    }
    const model::Code* failure(const MapSet& maps, const std::string& name, const ExportOptions& options = {}) const {
        try {
            write(maps, name, options);
        } catch (const model::Error& error) { return &error.code(); }
        return nullptr;
    }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
    }
    std::string bytes(const std::string& name) const {
        std::ifstream file(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    path folder_;
};

MapSet two_tori() {
    MapSet maps;
    maps.generator = "test";
    maps.source_name = "torus.obj";
    maps.report_json = "{}";
    maps.charts = {test::torus_chart(17, 33), test::torus_chart(9, 9)};
    return maps;
}

TEST_F(Export, ObjReadsBackAsTheReconstructionToTheBit) {
    const MapSet maps = two_tori();
    write(maps, "torus.obj");
    const model::TriMesh mesh = formats::read_mesh(folder_ / "torus.obj").mesh;
    const auto first = bake::reconstruct(maps.charts[0]).mesh, second = bake::reconstruct(maps.charts[1]).mesh;
    ASSERT_EQ(mesh.positions.size(), first.positions.size() + second.positions.size());
    ASSERT_EQ(mesh.faces.size(), first.faces.size() + second.faces.size());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        ASSERT_EQ(mesh.positions[v], v < 17 * 33 ? first.positions[v] : second.positions[v - 17 * 33]) << v;
    EXPECT_EQ(mesh.faces[100], first.faces[100]);
    ASSERT_EQ(mesh.materials.size(), 2u);

    // The texture that the file names, looked up at the corners as any OBJ reader would, is the layer's texel.
    const formats::Image texture = formats::read_image(mesh.materials[mesh.face_materials[0]].diffuse_map);
    const model::Layer& layer = *maps.charts[0].find("texture");
    for (std::size_t c = 0; c < 3 * first.faces.size(); ++c) {
        const auto x = static_cast<std::uint32_t>(mesh.corner_uvs[c].x * texture.width);
        const auto y = static_cast<std::uint32_t>((1 - mesh.corner_uvs[c].y) * texture.height);
        const std::uint32_t sample = mesh.faces[c / 3][c % 3], i = sample / 33, j = sample % 33;
        const std::size_t texel = 4 * (std::size_t{2 * i} * 65 + 2 * j);
        ASSERT_EQ(texture.at(x, y).r, std::to_integer<std::uint8_t>(layer.bytes[texel]));
        ASSERT_EQ(texture.at(x, y).g, std::to_integer<std::uint8_t>(layer.bytes[texel + 1]));
    }
    EXPECT_EQ(files(), 6u);  // torus.obj, torus.mtl, two textures, two normal maps
}

TEST_F(Export, ObjNamesChartsByTheAsset) {
    write(two_tori(), "out.obj");
    const std::string obj = bytes("out.obj"), mtl = bytes("out.mtl");
    for (const char* line : {"\no torus_chart0\nusemtl torus_chart0\n", "\no torus_chart1\nusemtl torus_chart1\n"})
        EXPECT_NE(obj.find(line), std::string::npos) << line;
    EXPECT_NE(mtl.find("newmtl torus_chart1\n"), std::string::npos);
    for (const char* line :
         {"map_Kd out_chart0_texture.png\n", "norm out_chart0_normal.png\n", "map_Bump out_chart0_normal.png\n"})
        EXPECT_NE(mtl.find(line), std::string::npos) << line;
    ExportOptions second;
    second.chart = 1;  // the same chart has the same name alone
    write(two_tori(), "one.obj", second);
    EXPECT_NE(bytes("one.obj").find("\no torus_chart1\n"), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "one_chart1_normal.png"));
    MapSet one = two_tori();
    one.charts.pop_back();
    one.source_name = "my torus.fbx";
    write(one, "alone.obj");
    EXPECT_NE(bytes("alone.obj").find("\no my_torus\n"), std::string::npos);
    EXPECT_NE(bytes("alone.mtl").find("newmtl my_torus\n"), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "alone_texture.png"));
    const auto back = formats::read_mesh(folder_ / "alone.obj");
    EXPECT_TRUE(back.warnings.empty());
    ASSERT_EQ(back.mesh.materials.size(), 1u);
    EXPECT_TRUE(back.mesh.materials[0].bump_is_normal_map);
}

MapSet one_disc() {
    MapSet maps;
    maps.source_name = "disc.obj";
    maps.charts = {test::disc_chart(17)};
    return maps;
}

TEST_F(Export, MeshesHoldOnlyVerticesWithFaces) {
    const MapSet maps = one_disc();
    const model::TriMesh full = bake::reconstruct(maps.charts[0]).mesh;
    std::set<std::uint32_t> used;
    for (const model::Face& face : full.faces) used.insert(face.begin(), face.end());
    ASSERT_LT(used.size(), full.positions.size());
    for (const char* name : {"disc.obj", "disc.ply"}) {
        write(maps, name);
        const model::TriMesh mesh = formats::read_mesh(folder_ / name).mesh;
        ASSERT_EQ(mesh.positions.size(), used.size()) << name;
        ASSERT_EQ(mesh.faces.size(), full.faces.size()) << name;
        for (std::size_t f = 0; f < full.faces.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k)
                ASSERT_EQ(mesh.positions[mesh.faces[f][k]], full.positions[full.faces[f][k]]) << name;
    }
    EXPECT_EQ(bytes("disc.ply").find("red"), std::string::npos);  // it has no texture
}

TEST_F(Export, PowersOfTwoKeepWhatTextureCoordinatesShow) {
    for (const auto& [side, power] : {std::pair{1u, 1u},
                                      {2u, 2u},
                                      {3u, 4u},
                                      {5u, 4u},
                                      {6u, 8u},
                                      {65u, 64u},
                                      {90u, 64u},
                                      {91u, 128u},
                                      {16384u, 16384u}})
        EXPECT_EQ(nearest_power_of_two(side), power) << side;
    formats::Image ramp{9, 3, std::vector<model::Rgba8>(27)};
    for (std::uint32_t k = 0; k < 27; ++k) ramp.pixels[k] = {static_cast<std::uint8_t>(20 * (k % 9)), 7, 0, 255};
    for (const std::uint32_t width : {8u, 16u}) {
        const formats::Image out = resized(ramp, width, 4, Texels::kColour);
        ASSERT_EQ(out.pixels.size(), width * 4);
        for (std::uint32_t x = 0; x < width; ++x)  // a ramp stays the same ramp, but for a wider filter's unevenness
            EXPECT_NEAR(out.at(x, 2).r, 160.0 * x / (width - 1), x % (width - 1) == 0 ? 3 : 1.5) << x;
        EXPECT_EQ(out.at(1, 3).g, 7);
    }
    ExportOptions powers;
    powers.power_of_two = true;
    powers.chart = 0;
    write(two_tori(), "p.obj", powers);
    const formats::Image texture = formats::read_image({folder_ / "p_chart0_texture.png"});
    EXPECT_EQ(texture.width, 64u);  // of 65 x 33
    EXPECT_EQ(texture.height, 32u);
    EXPECT_EQ(formats::read_image({folder_ / "p_chart0_normal.png"}).width, 64u);
    const model::TriMesh mesh = formats::read_mesh(folder_ / "p.obj").mesh;
    double low = 1;
    for (const model::Vec2d& uv : mesh.corner_uvs) low = std::min(low, uv.x);
    EXPECT_DOUBLE_EQ(low, 0.5 / 64);
    EXPECT_EQ(failure(two_tori(), "p.exr", powers), &model::codes::kUsage);
}

TEST_F(Export, StampsTellWhichMapAMeshCameFrom) {
    MapSet maps = two_tori(), other = maps;
    other.settings_hash[3] = 1;
    EXPECT_NE(map_stamp(maps), map_stamp(other));
    EXPECT_NE(map_stamp(maps), map_stamp(maps, "quantize;"));
    maps.charts.pop_back();  // one chart: a PLY with a texture
    for (const char* name : {"m.obj", "m.ply", "m.glb"}) {
        write(maps, name);
        const path file = folder_ / name;
        EXPECT_TRUE(carries_stamp(file, map_stamp(maps))) << name;
        EXPECT_FALSE(carries_stamp(file, map_stamp(other))) << name;
        const std::string whole = bytes(name);
        std::ofstream(file, std::ios::binary) << whole.substr(0, whole.size() - 1);
        EXPECT_FALSE(carries_stamp(file, map_stamp(maps))) << name << " cut short";
        std::ofstream(file, std::ios::binary) << whole;
        EXPECT_TRUE(carries_stamp(file, map_stamp(maps))) << name;
    }
    std::filesystem::remove(folder_ / "m_texture.png");
    EXPECT_FALSE(carries_stamp(folder_ / "m.obj", map_stamp(maps)));
    EXPECT_FALSE(carries_stamp(folder_ / "m.ply", map_stamp(maps)));
    EXPECT_TRUE(carries_stamp(folder_ / "m.glb", map_stamp(maps)));
    EXPECT_FALSE(carries_stamp(folder_ / "none.glb", map_stamp(maps)));
    ExportOptions small;
    small.quantize = true;
    write(maps, "m.glb", small);
    EXPECT_FALSE(carries_stamp(folder_ / "m.glb", map_stamp(maps)));
}

TEST_F(Export, OneChartAlone) {
    ExportOptions options;
    options.chart = 1;
    write(two_tori(), "one.obj", options);
    EXPECT_EQ(formats::read_mesh(folder_ / "one.obj").mesh.positions.size(), 81u);
    options.chart = 2;
    EXPECT_EQ(failure(two_tori(), "two.obj", options), &model::codes::kUsage);
}

TEST_F(Export, PlyHoldsVerticesAndTheirColours) {
    write(two_tori(), "torus.ply");
    const std::string ply = bytes("torus.ply");
    EXPECT_EQ(ply.substr(0, 4), "ply\n");
    EXPECT_NE(ply.find("property uchar red"), std::string::npos);
    EXPECT_NE(ply.find("element face 1152"), std::string::npos);
    EXPECT_NE(ply.find("property float s\nproperty float t\n"), std::string::npos);
    EXPECT_EQ(ply.find("TextureFile"), std::string::npos);  // there are two
    EXPECT_EQ(files(), 1u);
    ExportOptions first;
    first.chart = 0;
    write(two_tori(), "one.ply", first);
    EXPECT_NE(bytes("one.ply").find("\ncomment TextureFile one_chart0_texture.png\n"), std::string::npos);
    EXPECT_EQ(formats::read_image({folder_ / "one_chart0_texture.png"}).width, 65u);
}

TEST_F(Export, DgmToExrAndBackGivesTheSameBytes) {
    const MapSet maps = two_tori();
    formats::write_dgm(maps, folder_ / "a.dgm");
    write(read_maps(folder_ / "a.dgm"), "b.exr");
    write(read_maps(folder_ / "b.exr"), "c.dgm");
    EXPECT_EQ(read_maps(folder_ / "b.exr"), maps);
    EXPECT_EQ(bytes("a.dgm"), bytes("c.dgm"));
    ExportOptions multipart;
    multipart.multipart = true;
    write(maps, "d.exr", multipart);
    EXPECT_NE(bytes("d.exr"), bytes("b.exr"));
    EXPECT_EQ(read_maps(folder_ / "d.exr"), maps);
}

TEST_F(Export, LayerPictureOfAllChartsSideBySide) {
    ExportOptions options;
    options.layer = "geometry";
    write(two_tori(), "geometry.png", options);
    const formats::Image image = formats::read_image({folder_ / "geometry.png"});
    EXPECT_EQ(image.width, 33u + 8 + 9);
    EXPECT_EQ(image.height, 17u);
    EXPECT_EQ(image.at(0, 0), (model::Rgba8{255, 128, 128, 255}));
    EXPECT_EQ(image.at(33 + 8, 0), (model::Rgba8{255, 128, 128, 255}));
}

TEST_F(Export, ShadedViewsAndSheets) {
    ExportOptions options;
    options.width = 400;
    options.height = 200;
    write(two_tori(), "view.png", options);
    EXPECT_EQ(formats::read_image({folder_ / "view.png"}).width, 400u);
    const std::string once = bytes("view.png");
    write(two_tori(), "view.png", options);
    EXPECT_EQ(bytes("view.png"), once);
    options.sheet = true;
    options.chart = 0;
    write(two_tori(), "sheet.png", options);
    EXPECT_GT(formats::read_image({folder_ / "sheet.png"}).height, 200u);
    options.sheet = false;
    write(two_tori(), "source.obj");
    options.source = folder_ / "source.obj";
    write(two_tori(), "both.png", options);
    EXPECT_NE(bytes("both.png"), once);
}

TEST_F(Export, LevelOfDetailKeepsBordersAndAttributes) {
    const MapSet maps = two_tori();
    ExportOptions lod;
    lod.chart = 0;  // the tori stand in the same place
    write(maps, "full.obj", lod);
    lod.lods = {4};
    write(maps, "thin.obj", lod);
    const model::TriMesh thin = formats::read_mesh(folder_ / "thin.obj").mesh;
    const model::TriMesh full = formats::read_mesh(folder_ / "full.obj").mesh;
    // 4 x 8 blocks, of which the inner 2 x 6 are two triangles; those at the border keep 4 or 7 more corners there.
    EXPECT_LT(thin.faces.size(), full.faces.size() / 4);
    EXPECT_GE(thin.faces.size(), 4u * 8 * 2);
    const auto corners = [](const model::TriMesh& mesh, std::size_t f, std::size_t k) {
        const model::Vec3d p = mesh.positions[mesh.faces[f][k]];
        return std::array<double, 5>{p.x, p.y, p.z, mesh.corner_uvs[3 * f + k].x, mesh.corner_uvs[3 * f + k].y};
    };
    std::set<std::array<double, 5>> known;
    for (std::size_t f = 0; f < full.faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) known.insert(corners(full, f, k));
    std::vector<bool> used(thin.positions.size(), false);
    for (std::size_t f = 0; f < thin.faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_TRUE(known.count(corners(thin, f, k))) << "a vertex keeps its place and its texel";
            used[thin.faces[f][k]] = true;
        }
    EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);

    // A closed torus: after welding by position every edge has two faces.
    std::map<std::array<double, 3>, int> weld;
    const auto id = [&](std::size_t f, std::size_t k) {
        const model::Vec3d p = thin.positions[thin.faces[f][k]];
        return weld.try_emplace({p.x, p.y, p.z}, static_cast<int>(weld.size())).first->second;
    };
    std::map<std::pair<int, int>, int> edges;
    for (std::size_t f = 0; f < thin.faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax({id(f, k), id(f, (k + 1) % 3)})];
    for (const auto& [edge, faces] : edges) ASSERT_EQ(faces, 2) << edge.first << "-" << edge.second;

    lod.lods = {1};
    write(maps, "one.obj", lod);
    EXPECT_EQ(formats::read_mesh(folder_ / "one.obj").mesh.positions, full.positions);
}

TEST_F(Export, WhatCannotBeDoneIsRefusedAndLeavesNothing) {
    const MapSet maps = two_tori();
    EXPECT_EQ(failure(maps, "x.gltf"), &model::codes::kUnsupported);
    EXPECT_EQ(failure(maps, "x.docx"), &model::codes::kUsage);
    std::ofstream(folder_ / "file") << "x";
    EXPECT_EQ(failure(maps, "file/x.obj"), &model::codes::kWriteFailed);
    std::filesystem::remove(folder_ / "file");
    ExportOptions lod;
    lod.lods = {2};
    EXPECT_EQ(failure(maps, "x.png", lod), &model::codes::kUsage);
    lod.lods = {0};
    EXPECT_EQ(failure(maps, "x.obj", lod), &model::codes::kUsage);
    for (const std::vector<std::uint32_t>& levels :
         std::vector<std::vector<std::uint32_t>>{{}, {1, 1}, {4, 2}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
        lod.lods = levels;
        EXPECT_EQ(failure(maps, "x.glb", lod), &model::codes::kUsage);
    }
    lod.lods = {1, 4};
    EXPECT_EQ(failure(maps, "x.obj", lod), &model::codes::kUsage);
    ExportOptions small;
    small.quantize = true;
    EXPECT_EQ(failure(maps, "x.ply", small), &model::codes::kUsage);
    ExportOptions layer;
    layer.layer = "mask";
    EXPECT_EQ(failure(maps, "x.png", layer), &model::codes::kMissingLayer);
    EXPECT_EQ(failure(maps, "x.obj", layer), &model::codes::kUsage);
    layer.sheet = true;
    EXPECT_EQ(failure(maps, "x.png", layer), &model::codes::kUsage);
    ExportOptions source;
    source.source = folder_ / "missing.obj";
    EXPECT_EQ(failure(maps, "x.png", source), &model::codes::kFileMissing);
    MapSet broken = maps;
    broken.charts[0].find("geometry")->bytes.pop_back();
    EXPECT_EQ(failure(broken, "x.obj"), &model::codes::kBadLayerShape);
    EXPECT_EQ(files(), 0u);
}

TEST_F(Export, AFailureKeepsTheOldFile) {
    std::ofstream(folder_ / "x.png") << "old";
    ExportOptions options;
    options.layer = "mask";
    EXPECT_EQ(failure(two_tori(), "x.png", options), &model::codes::kMissingLayer);
    EXPECT_EQ(bytes("x.png"), "old");
}

TEST_F(Export, ReadingSaysWhatAFileIsNot) {
    const auto code_of = [&](const char* name) {
        try {
            static_cast<void>(read_maps(folder_ / name));
        } catch (const model::Error& error) { return &error.code(); }
        return static_cast<const model::Code*>(nullptr);
    };
    EXPECT_EQ(code_of("missing.dgm"), &model::codes::kFileMissing);
    std::ofstream(folder_ / "text.dgm") << "hello, this is no geometry map";
    EXPECT_EQ(code_of("text.dgm"), &model::codes::kNotDgm);
    std::ofstream(folder_ / "short.exr") << "\x76\x2f\x31\x01";
    EXPECT_EQ(code_of("short.exr"), &model::codes::kExrUnreadable);
}

}  // namespace
}  // namespace dgm::exporter
