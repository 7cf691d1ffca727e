// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/mesh/assimp_reader_test.cpp
// 3DS files are made with assimp's own exporter, so the test carries no binary.
#include <gtest/gtest.h>

#include <assimp/material.h>
#include <assimp/scene.h>
#include <assimp/Exporter.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>

#include "image/image.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "unit/formats/test_maps.h"

namespace {

namespace codes = dgm::model::codes;
using dgm::formats::read_mesh;
using dgm::model::Vec3d;
using dgm::test::read_bytes;
using dgm::test::TempFolder;
using dgm::test::write_bytes;

/// Two triangles in two meshes with a material each; the second hangs on a moved and mirrored node where asked.
std::unique_ptr<aiScene> two_triangles(bool with_node) {
    auto scene = std::make_unique<aiScene>();
    scene->mNumMaterials = 2;
    scene->mMaterials = new aiMaterial*[2];
    scene->mNumMeshes = 2;
    scene->mMeshes = new aiMesh*[2];
    const char* names[] = {"red", "blue"};
    for (unsigned k = 0; k < 2; ++k) {
        auto* material = new aiMaterial;
        const aiString name(names[k]);
        material->AddProperty(&name, AI_MATKEY_NAME);
        const aiColor3D colour = k == 0 ? aiColor3D(1, 0, 0) : aiColor3D(0, 0, 1);
        material->AddProperty(&colour, 1, AI_MATKEY_COLOR_DIFFUSE);
        const aiString texture("Tex.PNG");
        if (k == 0) material->AddProperty(&texture, AI_MATKEY_TEXTURE_DIFFUSE(0));
        scene->mMaterials[k] = material;

        auto* mesh = new aiMesh;
        mesh->mName = aiString(names[k]);
        mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
        mesh->mMaterialIndex = k;
        mesh->mNumVertices = 3;
        mesh->mVertices = new aiVector3D[3]{{0, 0, 0}, {1, 0, 0}, {0, 2, static_cast<float>(k)}};
        mesh->mTextureCoords[0] = new aiVector3D[3]{{0.25f, 0.5f, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh->mNumUVComponents[0] = 2;
        mesh->mNumFaces = 1;
        mesh->mFaces = new aiFace[1];
        mesh->mFaces[0].mNumIndices = 3;
        mesh->mFaces[0].mIndices = new unsigned[3]{0, 1, 2};
        scene->mMeshes[k] = mesh;
    }
    scene->mRootNode = new aiNode("root");
    scene->mRootNode->mNumMeshes = with_node ? 1 : 2;
    scene->mRootNode->mMeshes = with_node ? new unsigned[1]{0} : new unsigned[2]{0, 1};
    if (with_node) {
        auto* child = new aiNode("child");
        child->mNumMeshes = 1;
        child->mMeshes = new unsigned[1]{1};
        child->mTransformation = aiMatrix4x4(-2, 0, 0, 10, 0, 1, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1);
        scene->mRootNode->addChildren(1, &child);
    }
    return scene;
}

void export_scene(const aiScene& scene, const char* format, const std::filesystem::path& path) {
    Assimp::Exporter exporter;
    ASSERT_EQ(exporter.Export(&scene, format, path.string()), aiReturn_SUCCESS) << exporter.GetErrorString();
}

double area(const dgm::model::TriMesh& mesh, std::size_t f) {
    const auto [a, b, c] = mesh.corners(f);
    return length(cross(b - a, c - a)) / 2;
}

TEST(Import3ds, FacesMaterialsAndTexture) {
    const TempFolder folder;
    export_scene(*two_triangles(false), "3ds", folder / "a.3ds");
    write_png(folder / "tex.png", dgm::formats::Image{1, 1, {{}}});
    const auto in = read_mesh(folder / "a.3ds");
    ASSERT_EQ(in.mesh.faces.size(), 2u);
    ASSERT_EQ(in.mesh.face_materials.size(), 2u);
    ASSERT_EQ(in.mesh.corner_uvs.size(), 6u);
    // Areas survive whatever way assimp turns the axes: |(1,0,0) x (0,2,k)| / 2.
    std::vector<double> areas{area(in.mesh, 0), area(in.mesh, 1)};
    std::sort(areas.begin(), areas.end());
    EXPECT_NEAR(areas[0], 1, 1e-6);
    EXPECT_NEAR(areas[1], std::sqrt(5.0) / 2, 1e-6);
    for (std::size_t f = 0; f < 2; ++f) {
        const auto& material = in.mesh.materials[in.mesh.face_materials[f]];
        const bool is_red = std::abs(area(in.mesh, f) - 1) < 1e-6;
        EXPECT_EQ(material.diffuse, is_red ? (dgm::model::Rgba8{255, 0, 0, 255}) : (dgm::model::Rgba8{0, 0, 255, 255}));
        EXPECT_EQ(material.diffuse_map.empty(), !is_red);
        if (is_red) {  // in another case than the file says
            EXPECT_EQ(material.diffuse_map.path, folder / "tex.png");
        }
    }
    EXPECT_EQ(in.dependencies, (std::vector<std::filesystem::path>{folder / "tex.png"}));
}

TEST(Import3ds, MissingTextureIsAWarning) {
    const TempFolder folder;
    export_scene(*two_triangles(false), "3ds", folder / "a.3ds");
    const auto in = read_mesh(folder / "a.3ds");
    ASSERT_EQ(in.warnings.size(), 1u);
    EXPECT_EQ(in.warnings[0].substr(0, 27), "DGM3012: texture missing: T") << in.warnings[0];
    ASSERT_EQ(in.missing.size(), 1u);
    EXPECT_EQ(in.missing[0].substr(0, 1), "T");
}

/// Gives the scene a picture inside its file, which its first material names.
void embed_picture(aiScene& scene, const std::string& png) {
    auto* picture = new aiTexture;
    picture->mWidth = static_cast<unsigned>(png.size());
    picture->mHeight = 0;
    picture->pcData = reinterpret_cast<aiTexel*>(new char[png.size() + sizeof(aiTexel)]);
    std::memcpy(static_cast<void*>(picture->pcData), png.data(), png.size());
    std::memcpy(picture->achFormatHint, "png", 4);
    scene.mNumTextures = 1;
    scene.mTextures = new aiTexture* [1] { picture };
    const aiString name("*0");
    scene.mMaterials[0]->RemoveProperty(AI_MATKEY_TEXTURE_DIFFUSE(0));
    scene.mMaterials[0]->AddProperty(&name, AI_MATKEY_TEXTURE_DIFFUSE(0));
}

TEST(ImportAssimp, APictureInsideTheFileComesWithIt) {
    const TempFolder folder;
    const dgm::formats::Image image{2, 1, {{10, 20, 30, 255}, {200, 100, 50, 255}}};
    write_png(folder / "tex.png", image);
    const auto scene = two_triangles(false);
    embed_picture(*scene, read_bytes(folder / "tex.png"));
    export_scene(*scene, "glb2", folder / "a.glb");
    std::filesystem::remove(folder / "tex.png");
    const auto in = read_mesh(folder / "a.glb");
    EXPECT_TRUE(in.warnings.empty());
    EXPECT_TRUE(in.dependencies.empty());
    std::size_t pictures = 0;
    for (const dgm::model::Material& material : in.mesh.materials) {
        if (material.diffuse_map.empty()) continue;
        ++pictures;
        EXPECT_EQ(material.diffuse_map.name(), "picture 1 in a.glb");
        EXPECT_EQ(dgm::formats::read_image(material.diffuse_map), image);
        dgm::model::PictureFile damaged{material.diffuse_map.path, std::make_shared<const std::string>("no picture")};
        EXPECT_EQ(dgm::test::code_of([&] { (void)dgm::formats::read_image(damaged); }), codes::kImageUnreadable.number);
    }
    EXPECT_EQ(pictures, 1U);
}

TEST(ImportAssimp, NodesArePlacedAndMirroredFacesTurned) {
    const TempFolder folder;
    export_scene(*two_triangles(true), "collada", folder / "a.dae");
    const auto in = read_mesh(folder / "a.dae");
    ASSERT_EQ(in.mesh.faces.size(), 2u);
    // Vertex (1, 0, 0) of the second mesh goes to (-2 + 10, 20, 30).
    const auto& p = in.mesh.positions;
    const auto near = [&](const Vec3d& wanted) {
        return std::any_of(p.begin(), p.end(), [&](const Vec3d& q) { return length(q - wanted) < 1e-5; });
    };
    EXPECT_TRUE(near({8, 20, 30}));
    EXPECT_TRUE(near({10, 20, 30}));
    EXPECT_TRUE(near({10, 22, 31}));
    // The mirror keeps the outside outside: normal (0, -1, 2) of the original has x mirrored, so it is unchanged here.
    const auto [a, b, c] = in.mesh.corners(1);
    const Vec3d normal = normalized(cross(b - a, c - a));
    EXPECT_NEAR(normal.y, -1 / std::sqrt(5.0), 1e-6);
    EXPECT_NEAR(normal.z, 2 / std::sqrt(5.0), 1e-6);
}

TEST(ImportAssimp, GarbageIsRefused) {
    const TempFolder folder;
    const auto code_of = [&](const std::string& name, const std::string& bytes) {
        write_bytes(folder / name, bytes);
        try {
            (void)read_mesh(folder / name);
        } catch (const dgm::model::Error& error) {
            EXPECT_NE(error.place().find(name), std::string::npos);
            return error.code().number;
        }
        return 0;
    };
    EXPECT_EQ(code_of("a.3ds", ""), codes::kNoFaces.number);
    EXPECT_EQ(code_of("a.3ds", "this is no 3DS file"), codes::kImportFailed.number);
    EXPECT_EQ(code_of("a.ply", "ply\nformat ascii 1.0\nelement vertex 9\n"), codes::kImportFailed.number);
    EXPECT_EQ(code_of("a.xyz", "1 2 3 4"), codes::kImportFailed.number);
    EXPECT_THROW((void)read_mesh(folder / "none.3ds"), dgm::model::Error);
    EXPECT_THROW((void)read_mesh(folder.path()), dgm::model::Error);
}

TEST(ImportAssimp, ContentDecidesWithoutExtension) {
    const TempFolder folder;
    export_scene(*two_triangles(false), "3ds", folder / "a.3ds");
    write_bytes(folder / "plain", read_bytes(folder / "a.3ds"));
    EXPECT_EQ(read_mesh(folder / "plain").mesh.faces.size(), 2u);
}

TEST(ImportAssimp, FaceLimitHolds) {
    const TempFolder folder;
    export_scene(*two_triangles(false), "3ds", folder / "a.3ds");
    try {
        (void)read_mesh(folder / "a.3ds", {.max_faces = 1});
        FAIL();
    } catch (const dgm::model::Error& error) { EXPECT_EQ(error.code().number, codes::kTooLarge.number); }
}

}  // namespace
