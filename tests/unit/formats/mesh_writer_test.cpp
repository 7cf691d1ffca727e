// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/mesh_writer_test.cpp
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "image/image.h"
#include "mesh/mesh_reader.h"
#include "mesh/mesh_writer.h"
#include "model/codes.h"
#include "test_maps.h"

namespace {

namespace codes = dgm::model::codes;
using dgm::formats::read_mesh;
using dgm::formats::write_obj;
using dgm::formats::write_ply;
using dgm::model::TriMesh;
using dgm::model::Vec3d;
using dgm::test::read_bytes;
using dgm::test::TempFolder;

TriMesh random_mesh() {
    dgm::test::Random random(3);
    TriMesh mesh;
    for (int k = 0; k < 50; ++k)
        mesh.positions.push_back({1e7 + random.unit(), (random.unit() - 0.5) * 1e-200, random.unit() * 1e200});
    for (int f = 0; f < 80; ++f) {
        mesh.faces.push_back({static_cast<std::uint32_t>(random.below(50)),
                              static_cast<std::uint32_t>(random.below(50)),
                              static_cast<std::uint32_t>(random.below(50))});
        mesh.face_materials.push_back(static_cast<std::uint32_t>(f / 40));
        for (int k = 0; k < 3; ++k) {
            mesh.corner_uvs.push_back({random.unit(), random.unit()});
            mesh.corner_normals.push_back(k == 0 ? Vec3d{0, 0, 1} : Vec3d{0.6, 0, 0.8});
        }
    }
    mesh.materials.resize(2);
    mesh.materials[0].name = "skin";
    mesh.materials[0].diffuse = {10, 20, 30, 40};
    mesh.materials[0].diffuse_map.path = "skin.png";
    mesh.materials[1].name = "cloth";
    mesh.materials[1].bump_map.path = "cloth_height.png";
    mesh.materials[1].bump_scale = 0.125;
    return mesh;
}

TEST(ObjWriter, ReadsBackToTheBit) {
    const TempFolder folder;
    TriMesh mesh = random_mesh();
    for (const char* name : {"skin.png", "cloth_height.png"}) write_png(folder / name, dgm::formats::Image{1, 1, {{}}});
    write_obj(folder / "a.obj", mesh, {.write_mtl = true});
    const auto in = read_mesh(folder / "a.obj");
    EXPECT_TRUE(in.warnings.empty());
    EXPECT_EQ(in.mesh.positions, mesh.positions);
    EXPECT_EQ(in.mesh.faces, mesh.faces);
    EXPECT_EQ(in.mesh.corner_uvs, mesh.corner_uvs);
    ASSERT_EQ(in.mesh.corner_normals.size(), mesh.corner_normals.size());
    for (std::size_t k = 0; k < mesh.corner_normals.size(); ++k)
        EXPECT_LT(length(in.mesh.corner_normals[k] - mesh.corner_normals[k]), 1e-15);
    EXPECT_EQ(in.mesh.face_materials, mesh.face_materials);
    mesh.materials[0].diffuse_map.path = folder / "skin.png";
    mesh.materials[1].bump_map.path = folder / "cloth_height.png";
    EXPECT_EQ(in.mesh.materials, mesh.materials);
}

TEST(ObjWriter, WritesWhatItSays) {
    const TempFolder folder;
    TriMesh mesh;
    mesh.positions = {{0, 0.1, -2.5}, {1, 0, 0}, {1e22, 1, 0}};
    mesh.faces = {{0, 1, 2}};
    write_obj(folder / "plain.obj", mesh);
    EXPECT_EQ(read_bytes(folder / "plain.obj"), "v 0 0.1 -2.5\nv 1 0 0\nv 1e+22 1 0\nf 1 2 3\n");
    mesh.corner_uvs = {{0, 0}, {1, 0}, {0, 0}};
    write_obj(folder / "t.obj", mesh, {.texture = "t.png"});
    EXPECT_EQ(read_bytes(folder / "t.obj"),
              "mtllib t.mtl\nv 0 0.1 -2.5\nv 1 0 0\nv 1e+22 1 0\nvt 0 0\nvt 1 0\nusemtl surface\nf 1/1 2/2 3/1\n");
    EXPECT_EQ(read_bytes(folder / "t.mtl"), "newmtl surface\nKd 1 1 1\nd 1\nmap_Kd t.png\n");
}

TEST(ObjWriter, ObjectsAndNormalMaps) {
    const TempFolder folder;
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}, {2, 1, 0}, {1, 2, 0}};
    mesh.face_materials = {0, 0, 1};
    mesh.materials.resize(2);
    mesh.materials[0] = {"left sleeve", {}, {}, {"sleeve_normal.png"}, true, 1};
    mesh.materials[1] = {"collar", {}, {}, {"bumps.png"}, true, 1};
    write_obj(folder / "a.obj", mesh,
              {.write_mtl = true, .objects = {{"left sleeve", 0}, {"collar", 2}}, .comment = "the end"});
    EXPECT_EQ(read_bytes(folder / "a.obj"),
              "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no left_sleeve\nusemtl left_sleeve\nf 1 2 3\nf 3 2 1\n"
              "o collar\nusemtl collar\nf 2 3 1\n# the end\n");
    // Readers of map_Bump look for heights in it, unless the name says otherwise.
    EXPECT_EQ(read_bytes(folder / "a.mtl"),
              "newmtl left_sleeve\nKd 1 1 1\nd 1\nmap_Bump sleeve_normal.png\nnorm sleeve_normal.png\n"
              "newmtl collar\nKd 1 1 1\nd 1\nnorm bumps.png\n");
    for (const char* name : {"sleeve_normal.png", "bumps.png"})
        write_png(folder / name, dgm::formats::Image{1, 1, {{}}});
    const auto in = read_mesh(folder / "a.obj");
    ASSERT_EQ(in.mesh.materials.size(), 2u);
    for (const auto& material : in.mesh.materials) EXPECT_TRUE(material.bump_is_normal_map) << material.name;
}

TEST(PlyWriter, TextureCoordinatesSplitVertices) {
    const TempFolder folder;
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2.5, 0}, {1, 1, 0}};
    mesh.faces = {{0, 1, 2}, {1, 3, 2}};
    mesh.corner_uvs = {{0, 0.25}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0.5, 1}};
    write_ply(folder / "a.ply", mesh, {.texture = "a.png", .comment = "map 7"});
    const std::string bytes = read_bytes(folder / "a.ply");
    const std::string header =
        "ply\nformat binary_little_endian 1.0\ncomment map 7 126\ncomment TextureFile a.png\nelement vertex 5\n"
        "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
        "element face 2\nproperty list uchar uint vertex_indices\nend_header\n";
    ASSERT_EQ(bytes.substr(0, header.size()), header);
    ASSERT_EQ(bytes.size(), header.size() + 126);
    float first[5], last[5];
    std::memcpy(first, bytes.data() + header.size(), sizeof first);
    std::memcpy(last, bytes.data() + header.size() + 4 * 20, sizeof last);
    EXPECT_EQ(std::vector<float>(first, first + 5), (std::vector<float>{0, 0, 0, 0, 0.25}));
    EXPECT_EQ(std::vector<float>(last, last + 5), (std::vector<float>{0, 2.5, 0, 0.5, 1}));
}

TEST(PlyWriter, BytesAreThoseOfTheFormat) {
    const TempFolder folder;
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2.5, 0}, {1, 1, 0}};
    mesh.faces = {{0, 1, 2}, {1, 3, 2}};
    mesh.corner_normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 1, 0}};
    mesh.corner_colours.assign(6, {1, 2, 3, 4});
    write_ply(folder / "a.ply", mesh);
    const std::string bytes = read_bytes(folder / "a.ply");
    const std::string header =
        "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nproperty uchar alpha\nelement face 2\nproperty list uchar uint "
        "vertex_indices\nend_header\n";
    ASSERT_EQ(bytes.substr(0, header.size()), header);
    ASSERT_EQ(bytes.size(), header.size() + 5 * 28 + 2 * 13);
    float last[6];  // the copy of vertex 2 that the second face's last corner sees
    std::memcpy(last, bytes.data() + header.size() + 4 * 28, sizeof last);
    EXPECT_EQ(std::vector<float>(last, last + 6), (std::vector<float>{0, 2.5, 0, 0, 1, 0}));
    EXPECT_EQ(bytes.substr(header.size() + 24, 4), std::string("\1\2\3\4"));
    std::uint32_t face[3];
    std::memcpy(face, bytes.data() + header.size() + 5 * 28 + 14, sizeof face);
    EXPECT_EQ(std::vector<std::uint32_t>(face, face + 3), (std::vector<std::uint32_t>{1, 3, 4}));
}

TEST(PlyWriter, OtherProgramsReadIt) {
    const TempFolder folder;
    TriMesh mesh;
    mesh.positions = {{0.125, -3, 7}, {1, 0, 0}, {0, 2.5, 0}};
    mesh.faces = {{0, 1, 2}};
    mesh.corner_colours = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 51}};
    write_ply(folder / "a.ply", mesh);
    const auto in = read_mesh(folder / "a.ply");
    EXPECT_EQ(in.mesh.positions, mesh.positions);
    EXPECT_EQ(in.mesh.faces, mesh.faces);
    EXPECT_EQ(in.mesh.corner_colours, mesh.corner_colours);
}

TEST(MeshWriters, RefuseWhatDoesNotFit) {
    const TempFolder folder;
    const auto code_of = [](const std::function<void()>& action) {
        try {
            action();
        } catch (const dgm::model::Error& error) { return error.code().number; }
        return 0;
    };
    TriMesh mesh = random_mesh();
    EXPECT_EQ(code_of([&] { write_obj(folder / "none/a.obj", mesh); }), codes::kWriteFailed.number);
    EXPECT_EQ(code_of([&] { write_ply(folder / "none/a.ply", mesh); }), codes::kWriteFailed.number);
    EXPECT_EQ(code_of([&] { write_obj(folder.path(), mesh); }), codes::kWriteFailed.number);
    EXPECT_TRUE(std::filesystem::is_directory(folder.path()));
    mesh.faces[0][0] = 50;
    EXPECT_EQ(code_of([&] { write_obj(folder / "a.obj", mesh); }), codes::kInternal.number);
    EXPECT_EQ(code_of([&] { write_ply(folder / "a.ply", mesh); }), codes::kInternal.number);
}

}  // namespace
