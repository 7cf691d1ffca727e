// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/mesh_formats_test.cpp
// One solid in a file of every format that a folder search takes: what comes back is compared corner by corner. The
// exporter of assimp writes most of them, so the test carries no binary; it has none for OFF and LWO.
#include "mesh/mesh_formats.h"

#include <gtest/gtest.h>

#include <assimp/scene.h>
#include <assimp/Exporter.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>

#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "test_maps.h"

namespace {

namespace codes = dgm::model::codes;
using dgm::formats::check_map_name;
using dgm::formats::has_mesh_extension;
using dgm::formats::mesh_rank;
using dgm::formats::read_mesh;
using dgm::formats::why_left_out;
using dgm::model::Vec3d;
using dgm::test::read_bytes;
using dgm::test::TempFolder;
using dgm::test::write_bytes;

/// A tetrahedron with legs of 3, 2 and 1 along the axes: no turn or mirror maps it to itself.
constexpr std::array<std::array<float, 3>, 4> kCorners{{{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}}};
constexpr std::array<std::array<unsigned, 3>, 4> kFaces{{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

std::unique_ptr<aiScene> tetrahedron() {
    auto scene = std::make_unique<aiScene>();
    scene->mNumMaterials = 1;
    scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
    auto* mesh = new aiMesh;
    mesh->mName = aiString("solid");
    mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
    mesh->mNumVertices = 4;
    mesh->mVertices = new aiVector3D[4];
    for (std::size_t k = 0; k < 4; ++k) mesh->mVertices[k] = {kCorners[k][0], kCorners[k][1], kCorners[k][2]};
    mesh->mNumFaces = 4;
    mesh->mFaces = new aiFace[4];
    for (std::size_t k = 0; k < 4; ++k) {
        mesh->mFaces[k].mNumIndices = 3;
        mesh->mFaces[k].mIndices = new unsigned[3]{kFaces[k][0], kFaces[k][1], kFaces[k][2]};
    }
    scene->mNumMeshes = 1;
    scene->mMeshes = new aiMesh* [1] { mesh };
    scene->mRootNode = new aiNode("root");
    auto* child = new aiNode("solid");  // 3MF is written of the root's children alone
    child->mNumMeshes = 1;
    child->mMeshes = new unsigned[1]{0};
    scene->mRootNode->addChildren(1, &child);
    return scene;
}

void write_off(const std::filesystem::path& path) {
    std::ofstream out(path);
    out << "OFF\n4 4 6\n";
    for (const auto& p : kCorners) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    for (const auto& f : kFaces) out << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
}

std::string big_endian(std::uint32_t value, int bytes) {
    std::string out;
    for (int k = bytes - 1; k >= 0; --k) out += static_cast<char>((value >> (8 * k)) & 0xFFU);
    return out;
}
std::string big_endian(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return big_endian(bits, 4);
}
std::string chunk(const std::string& id, const std::string& body) {
    return id + big_endian(static_cast<std::uint32_t>(body.size()), 4) + body + std::string(body.size() % 2, '\0');
}

/// LightWave objects are left-handed and their faces go clockwise.
void write_lwo(const std::filesystem::path& path) {
    std::string points, faces = "FACE", tags = "SURF";
    for (const auto& p : kCorners) points += big_endian(p[0]) + big_endian(p[1]) + big_endian(-p[2]);
    for (std::uint32_t k = 0; k < 4; ++k) {
        faces += big_endian(3, 2);
        for (const unsigned v : {kFaces[k][0], kFaces[k][2], kFaces[k][1]}) faces += big_endian(v, 2);
        tags += big_endian(k, 2) + big_endian(0, 2);
    }
    const std::string body = "LWO2" + chunk("TAGS", std::string("m\0", 2)) + chunk("LAYR", std::string(18, '\0')) +
                             chunk("PNTS", points) + chunk("POLS", faces) + chunk("PTAG", tags) +
                             chunk("SURF", std::string("m\0\0\0", 4));
    write_bytes(path, chunk("FORM", body));
}

/// Each face from its least corner on, so that two sets are equal if and only if the oriented surfaces are.
std::set<std::array<std::array<double, 3>, 3>> faces_of(const dgm::model::TriMesh& mesh) {
    std::set<std::array<std::array<double, 3>, 3>> out;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        std::array<std::array<double, 3>, 3> face;
        const auto corners = mesh.corners(f);
        for (std::size_t k = 0; k < 3; ++k)
            for (int c = 0; c < 3; ++c)
                face[k][static_cast<std::size_t>(c)] = std::round(corners[k][c] * 1e5) / 1e5 + 0.0;
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
        out.insert(face);
    }
    return out;
}

dgm::model::TriMesh expected(double scale, bool z_up) {
    dgm::model::TriMesh mesh;
    for (const auto& p : kCorners) {
        const Vec3d v{scale * static_cast<double>(p[0]), scale * static_cast<double>(p[1]),
                      scale * static_cast<double>(p[2])};
        mesh.positions.push_back(z_up ? Vec3d{v.x, v.z, -v.y} : v);
    }
    for (const auto& f : kFaces) mesh.faces.push_back({f[0], f[1], f[2]});
    return mesh;
}

void expect_solid(const std::filesystem::path& path, double scale = 1, bool z_up = false) {
    dgm::formats::ImportedMesh in;
    try {
        in = read_mesh(path);
    } catch (const dgm::model::Error& error) { FAIL() << path << ": " << error.what(); }
    EXPECT_EQ(faces_of(in.mesh), faces_of(expected(scale, z_up))) << path;
    EXPECT_TRUE(in.dropped.empty() && in.warnings.empty()) << path;
}

void export_to(const char* format, const std::filesystem::path& path) {
    Assimp::Exporter exporter;
    ASSERT_EQ(exporter.Export(tetrahedron().get(), format, path.string()), aiReturn_SUCCESS)
        << exporter.GetErrorString();
}

TEST(MeshFormats, EachThatAFolderSearchTakesComesInRight) {
    const TempFolder folder;
    struct Row {
        const char *file, *exporter;
    };
    constexpr std::array kRows{Row{"a.obj", "obj"},     Row{"a.3ds", "3ds"},    Row{"a.ply", "ply"},
                               Row{"b.ply", "plyb"},    Row{"a.stl", "stl"},    Row{"b.stl", "stlb"},
                               Row{"a.dae", "collada"}, Row{"a.gltf", "gltf2"}, Row{"a.glb", "glb2"},
                               Row{"a.x3d", "x3d"},     Row{"a.3mf", "3mf"}};
    std::set<std::string> seen;
    for (const Row& row : kRows) {
        export_to(row.exporter, folder / row.file);
        const std::string extension = std::filesystem::path(row.file).extension().string();
        expect_solid(folder / row.file, 1, extension == ".3ds");
        seen.insert(extension);
    }
    write_off(folder / "a.off");
    expect_solid(folder / "a.off");
    write_lwo(folder / "a.lwo");
    expect_solid(folder / "a.lwo");
    export_to("fbxa", folder / "a.fbx");
    expect_solid(folder / "a.fbx", 0.01);
    seen.insert({".off", ".lwo", ".fbx"});
    for (const std::string& extension : seen) EXPECT_TRUE(has_mesh_extension("x" + extension)) << extension;
    EXPECT_EQ(mesh_rank("x.none"), seen.size()) << "a format is taken and not in this test";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

TEST(MeshFormats, FbxComesInMetresWithYUp) {
    const TempFolder folder;
    export_to("fbxa", folder / "cm.fbx");
    const std::string text = read_bytes(folder / "cm.fbx");
    EXPECT_EQ(read_mesh(folder / "cm.fbx").remarks,
              std::vector<std::string>{"FBX unit of 1 cm: scaled by 0.01 to metres"});
    const std::string unit = R"("UnitScaleFactor", "double", "Number", "", )";
    write_bytes(folder / "m.fbx", replaced(text, unit + "1", unit + "100"));
    expect_solid(folder / "m.fbx");
    EXPECT_TRUE(read_mesh(folder / "m.fbx").remarks.empty());
    write_bytes(folder / "inch.fbx", replaced(text, unit + "1", unit + "2.54"));
    expect_solid(folder / "inch.fbx", 0.0254);
    const auto axis = [](const std::string& name, const std::string& value) {
        return "\"" + name + R"(", "int", "Integer", "", )" + value;
    };
    std::string z_up = replaced(text, axis("UpAxis", "1"), axis("UpAxis", "2"));
    z_up = replaced(z_up, axis("FrontAxis", "2"), axis("FrontAxis", "1"));
    z_up = replaced(z_up, axis("FrontAxisSign", "1"), axis("FrontAxisSign", "-1"));
    write_bytes(folder / "z.fbx", z_up);
    expect_solid(folder / "z.fbx", 0.01, true);
    EXPECT_EQ(read_mesh(folder / "z.fbx").remarks.front(), "FBX with another axis up: turned to y up");
    // Two axes alike make no frame: the file is taken as it stands.
    write_bytes(folder / "odd.fbx", replaced(text, axis("FrontAxis", "2"), axis("FrontAxis", "1")));
    expect_solid(folder / "odd.fbx", 0.01);
}

TEST(MeshFormats, ColladaIsInMetresAsItStates) {
    const TempFolder folder;
    export_to("collada", folder / "m.dae");
    write_bytes(folder / "cm.dae", replaced(read_bytes(folder / "m.dae"), "meter=\"1\"", "meter=\"0.01\""));
    expect_solid(folder / "cm.dae", 0.01);
    write_bytes(folder / "z.dae", replaced(read_bytes(folder / "m.dae"), "Y_UP", "Z_UP"));
    expect_solid(folder / "z.dae", 1, true);
}

TEST(MeshFormats, WhatIsLeftOutHasAReason) {
    EXPECT_NE(why_left_out("a.MAX").find("there is no importer"), std::string_view::npos);
    EXPECT_NE(why_left_out("a.blend").find("Blender before 2.8"), std::string_view::npos);
    EXPECT_NE(why_left_out("a.md3").find("name the file"), std::string_view::npos);
    for (const char* name : {"a.obj", "a.png", "a.mtl", "a.dgm", "configure.ac", "a"})
        EXPECT_EQ(why_left_out(name), "");
}

TEST(MeshFormats, AMeshIsNoMap) {
    const TempFolder folder;
    const auto said = [](const std::filesystem::path& path) -> std::string {
        try {
            check_map_name(path);
        } catch (const dgm::model::Error& error) {
            return error.code().id() + " " + error.what() + " / " + error.hint();
        }
        return "nothing";
    };
    write_bytes(folder / "a.obj", "v 0 0 0\n");
    EXPECT_EQ(said(folder / "a.obj"), "DGM1001 this is a mesh, not a map: bake it first / dgm-bake " +
                                          (folder / "a.obj").string() + " -o a.dgm");
    EXPECT_EQ(said(folder / "gone.obj"), "nothing");  // the reader says that it is not there
    std::filesystem::create_directory(folder / "empty");
    EXPECT_EQ(said(folder / "empty").substr(0, 32), "DGM5001 the folder holds no maps");
    write_bytes(folder / "empty" / "a.dgm", "x");
    EXPECT_EQ(said(folder / "empty").substr(0, 24), "DGM5002 this is a folder");
    EXPECT_EQ(said(folder / "empty" / "a.dgm"), "nothing");
}

}  // namespace
