// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/mesh_import_test.cpp
#include "process/mesh_import.h"

#include <gtest/gtest.h>

#include "model/codes.h"
#include "process/error_stream.h"

namespace dgm::bake {
namespace {

formats::ImportedMesh sample() {
    formats::ImportedMesh out;
    out.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    out.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    out.mesh.corner_normals.assign(6, {0, 0, 1});
    out.mesh.corner_uvs.assign(6, {0.25, 0.75});
    out.mesh.corner_colours.assign(6, {1, 2, 3, 4});
    out.mesh.face_materials = {1, 0};
    out.mesh.materials = {{"a \xff name",
                           {9, 8, 7, 6},
                           {"t.png", std::make_shared<const std::string>("a picture")},
                           {"b.png"},
                           true,
                           0.5},
                          {}};
    out.warnings = {"one", ""};
    out.dependencies = {"x/y.mtl"};
    out.dropped = {{"lines", 3}};
    return out;
}

TEST(MeshImport, AllComesBack) {
    const formats::ImportedMesh in = sample();
    const auto out = decode_import(encode_import(in));
    ASSERT_TRUE(out);
    EXPECT_EQ(out->mesh.positions, in.mesh.positions);
    EXPECT_EQ(out->mesh.faces, in.mesh.faces);
    EXPECT_EQ(out->mesh.corner_normals, in.mesh.corner_normals);
    EXPECT_EQ(out->mesh.corner_uvs, in.mesh.corner_uvs);
    EXPECT_EQ(out->mesh.corner_colours, in.mesh.corner_colours);
    EXPECT_EQ(out->mesh.face_materials, in.mesh.face_materials);
    EXPECT_EQ(out->mesh.materials, in.mesh.materials);
    EXPECT_EQ(out->warnings, in.warnings);
    EXPECT_EQ(out->dependencies, in.dependencies);
    EXPECT_EQ(out->dropped, in.dropped);
}

TEST(MeshImport, ErrorsComeBack) {
    try {
        (void)decode_import(encode_error(model::Error(model::codes::kNoFaces, "no faces", "a.obj:3:1")));
        FAIL();
    } catch (const model::Error& error) {
        EXPECT_EQ(error.code().number, model::codes::kNoFaces.number);
        EXPECT_STREQ(error.what(), "no faces");
        EXPECT_EQ(error.place(), "a.obj:3:1");
    }
}

TEST(MeshImport, WhatDoesNotFitIsNoMesh) {
    const std::string good = encode_import(sample());
    for (std::size_t size = 0; size < good.size(); ++size)
        EXPECT_FALSE(decode_import(std::string_view(good).substr(0, size))) << size;
    EXPECT_FALSE(decode_import(good + "x"));
    // A changed byte may be another number; it may not be an index or a count beyond what is there.
    for (std::size_t k = 1; k < good.size(); ++k) {
        std::string bad = good;
        bad[k] = static_cast<char>(0xFF);
        const auto out = decode_import(bad);
        if (!out) continue;
        for (const model::Face& face : out->mesh.faces)
            for (const std::uint32_t v : face) EXPECT_LT(v, out->mesh.positions.size()) << k;
        for (const std::uint32_t m : out->mesh.face_materials) EXPECT_LT(m, out->mesh.materials.size()) << k;
    }
    formats::ImportedMesh bad = sample();
    bad.mesh.faces[1][2] = 4;
    EXPECT_FALSE(decode_import(encode_import(bad)));
    bad = sample();
    bad.mesh.corner_uvs.pop_back();
    EXPECT_FALSE(decode_import(encode_import(bad)));
    bad = sample();
    bad.mesh.face_materials[0] = 2;
    EXPECT_FALSE(decode_import(encode_import(bad)));
}

}  // namespace
}  // namespace dgm::bake
