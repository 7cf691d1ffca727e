// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/mesh/obj_reader_test.cpp
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "image/image.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "unit/formats/test_maps.h"

namespace {

namespace codes = dgm::model::codes;
namespace fs = std::filesystem;
using dgm::formats::ImportedMesh;
using dgm::formats::read_mesh;
using dgm::model::Error;
using dgm::model::Face;
using dgm::model::Rgba8;
using dgm::model::Vec2d;
using dgm::model::Vec3d;
using dgm::test::TempFolder;
using dgm::test::write_bytes;

ImportedMesh read_text(const std::string& text) {
    const TempFolder folder;
    write_bytes(folder / "a.obj", text);
    return read_mesh(folder / "a.obj");
}

std::uint64_t dropped(const ImportedMesh& in, const std::string& what) {
    for (const auto& [name, count] : in.dropped)
        if (name == what) return count;
    return 0;
}

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(Obj, KeepsDoubles) {
    const ImportedMesh in = read_text(
        "v 10000000.123456789 1e-200 -1.7976931348623157e308\n"
        "v .5 -0 +2.5E1\nv 0.1 1. 3\nf 1 2 3\n");
    EXPECT_EQ(in.mesh.positions,
              (std::vector<Vec3d>{{10000000.123456789, 1e-200, -1.7976931348623157e308}, {0.5, 0, 25}, {0.1, 1, 3}}));
    EXPECT_TRUE(in.mesh.corner_normals.empty() && in.mesh.corner_uvs.empty() && in.mesh.corner_colours.empty());
    EXPECT_TRUE(in.mesh.face_materials.empty() && in.mesh.materials.empty());
}

TEST(Obj, NumbersOfEverySpelling) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const ImportedMesh in = read_text(
        "v nan inf -inf\nv 1.#QNAN 1.#INF -1.#IND\nv 1e400 -1e400 1e-400\nv 0.1e999999999999 0e5 1,5\nv x 1\nf 1 2 "
        "3\nf 3 4 5\n");
    const auto& p = in.mesh.positions;
    ASSERT_EQ(p.size(), 5u);
    EXPECT_TRUE(std::isnan(p[0].x) && p[0].y == kInfinity && p[0].z == -kInfinity);
    EXPECT_TRUE(std::isnan(p[1].x) && p[1].y == kInfinity && std::isnan(p[1].z));
    EXPECT_EQ(p[2], (Vec3d{kInfinity, -kInfinity, 0}));
    EXPECT_EQ(p[3], (Vec3d{kInfinity, 0, 1.5}));
    EXPECT_TRUE(std::isnan(p[4].x) && p[4].y == 1 && std::isnan(p[4].z));
    ASSERT_FALSE(in.warnings.empty());
    EXPECT_NE(in.warnings[0].find("line 5"), std::string::npos) << in.warnings[0];
}

TEST(Obj, CornersOfEverySpelling) {
    const ImportedMesh in = read_text(kTriangle +
                                      "vt 0.25 0.5\nvt 1 1 0\nvn 0 0 2\nvn 0 3 4\n"
                                      "f 1 2 3\nf 1/1 2/2 3/1\nf 1//1 2//2 3//1\nf 1/2/2 2/1/1 3/2/2\n");
    ASSERT_EQ(in.mesh.faces.size(), 4u);
    ASSERT_EQ(in.mesh.corner_uvs.size(), 12u);
    ASSERT_EQ(in.mesh.corner_normals.size(), 12u);
    EXPECT_EQ(in.mesh.corner_uvs[0], (Vec2d{0, 0}));
    EXPECT_EQ(in.mesh.corner_uvs[3], (Vec2d{0.25, 0.5}));
    EXPECT_EQ(in.mesh.corner_uvs[9], (Vec2d{1, 1}));
    EXPECT_EQ(in.mesh.corner_normals[0], (Vec3d{0, 0, 0}));
    EXPECT_EQ(in.mesh.corner_normals[6], (Vec3d{0, 0, 1}));
    EXPECT_NEAR(in.mesh.corner_normals[7].y, 0.6, 1e-15);
    EXPECT_NEAR(in.mesh.corner_normals[7].z, 0.8, 1e-15);
}

TEST(Obj, NegativeAndForwardIndices) {
    const ImportedMesh in = read_text("f 1 2 3\n" + kTriangle + "f -3 -2 -1\nv 5 5 5\nf -1 1 2\n");
    EXPECT_EQ(in.mesh.faces, (std::vector<Face>{{0, 1, 2}, {0, 1, 2}, {3, 0, 1}}));
}

TEST(Obj, BadFacesAreCountedAndDropped) {
    const ImportedMesh in = read_text(kTriangle +
                                      "f 1 2 4\nf 0 1 2\nf -9 1 2\nf 1 2\nf 1 2 x\nf 1 2 99999999999999999999\n"
                                      "f 1/7/7 2 3\nl 1 2\np 1\ncurv 0 1 1 2\nf 1 2 3\n");
    EXPECT_EQ(in.mesh.faces, (std::vector<Face>{{0, 1, 2}, {0, 1, 2}}));
    EXPECT_EQ(dropped(in, "faces with vertices that do not exist"), 4u);
    EXPECT_EQ(dropped(in, "faces with fewer than three corners"), 1u);
    EXPECT_EQ(dropped(in, "face statements that cannot be read"), 1u);
    EXPECT_EQ(dropped(in, "texture coordinates that do not exist"), 1u);
    EXPECT_EQ(dropped(in, "normals that do not exist"), 1u);
    EXPECT_EQ(dropped(in, "line elements"), 1u);
    EXPECT_EQ(dropped(in, "point elements"), 1u);
    EXPECT_EQ(dropped(in, "free-form elements"), 1u);
}

TEST(Obj, LineEndsCommentsAndContinuations) {
    const std::vector<Face> faces{{0, 1, 2}};
    EXPECT_EQ(read_text("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n").mesh.faces, faces);
    EXPECT_EQ(read_text("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3").mesh.faces, faces);
    EXPECT_EQ(read_text("# C:\\models\\\n" + kTriangle + "\t f \t1 \\\n 2 \\\r\n3 # the end\n").mesh.faces, faces);
    EXPECT_EQ(read_text("v 0 0 0 # first\nv 1 0 0\nv 0 1 0\nf 1 2 3 #x").mesh.faces, faces);
    EXPECT_EQ(read_text("\xEF\xBB\xBF" + kTriangle + "fo 1 2 3").mesh.faces, faces);
}

TEST(Obj, Utf16OfBothKinds) {
    const std::string text = kTriangle + "usemtl \nf 1 2 3\n";
    for (const bool big : {false, true}) {
        std::string wide = big ? "\xFE\xFF" : "\xFF\xFE";
        for (const char c : text) {
            if (big) wide += '\0';
            wide += c;
            if (!big) wide += '\0';
        }
        EXPECT_EQ(read_text(wide).mesh.faces.size(), 1u);
    }
}

TEST(Obj, VertexColours) {
    const ImportedMesh units = read_text("v 0 0 0 1 0 0.5\nv 1 0 0 0 0 0 0.25\nv 0 1 0\nf 1 2 3\n");
    EXPECT_EQ(units.mesh.corner_colours, (std::vector<Rgba8>{{255, 0, 128, 255}, {0, 0, 0, 64}, {255, 255, 255, 255}}));
    const ImportedMesh bytes = read_text("v 0 0 0 255 0 128\nv 1 0 0 1 2 3\nv 0 1 0 0 0 0\nf 1 2 3\n");
    EXPECT_EQ(bytes.mesh.corner_colours, (std::vector<Rgba8>{{255, 0, 128, 255}, {1, 2, 3, 255}, {0, 0, 0, 255}}));
}

TEST(Obj, HomogeneousWeightDivides) {
    EXPECT_EQ(read_text("v 2 4 6 2\nv 1 0 0 1\nv 0 1 0 0\nf 1 2 3\n").mesh.positions,
              (std::vector<Vec3d>{{1, 2, 3}, {1, 0, 0}, {0, 1, 0}}));
}

TEST(Obj, ConcavePolygonsAndAttributesStayTogether) {
    // An L with six corners; texture coordinates equal positions, so every corner can be checked.
    const ImportedMesh in = read_text(
        "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n"
        "vt 0 0\nvt 2 0\nvt 2 1\nvt 1 1\nvt 1 2\nvt 0 2\nf 1/1 2/2 3/3 4/4 5/5 6/6\n");
    ASSERT_EQ(in.mesh.faces.size(), 4u);
    double area = 0;
    for (std::size_t f = 0; f < 4; ++f) {
        const auto [a, b, c] = in.mesh.corners(f);
        const double signed_area = cross(b - a, c - a).z / 2;
        EXPECT_GT(signed_area, 0);
        area += signed_area;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = in.mesh.positions[in.mesh.faces[f][k]];
            EXPECT_EQ(in.mesh.corner_uvs[3 * f + k], (Vec2d{p.x, p.y}));
        }
    }
    EXPECT_DOUBLE_EQ(area, 3);
}

TEST(Obj, RepeatedCornersOfPolygonsAreTakenOut) {
    const ImportedMesh in = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 2 3 4 1\nf 1 1 2\n");
    EXPECT_EQ(in.mesh.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {0, 0, 1}}));
    EXPECT_EQ(dropped(in, "repeated corners of polygons"), 2u);
}

class ObjMaterials : public testing::Test {
 protected:
    void picture(const std::string& name) {
        fs::create_directories((folder_ / name).parent_path());
        dgm::formats::write_png(folder_ / name, dgm::formats::Image{1, 1, {{}}});
    }
    ImportedMesh read(const std::string& obj, const std::string& mtl) {
        write_bytes(folder_ / "a.mtl", mtl);
        write_bytes(folder_ / "a.obj", obj);
        return read_mesh(folder_ / "a.obj");
    }
    TempFolder folder_;
    const std::string obj_ = "mtllib a.mtl\n" + kTriangle + "vt 0.5 0.25\nusemtl skin\nf 1/1 2/1 3/1\n";
};

TEST_F(ObjMaterials, ColourAlphaAndMaps) {
    picture("Skin Tex.PNG");
    picture("maps/bump.png");
    const ImportedMesh in =
        read(obj_,
             "# a comment\nnewmtl other\nKd 1 1 1\nnewmtl skin\nKd 1 0.5 0\nd 0.5\n"
             "map_Kd -blendu on -clamp off skin tex.png\nmap_Bump -bm 0.25 C:\\work\\maps\\bump.png\n");
    ASSERT_EQ(in.mesh.materials.size(), 1u);
    const auto& m = in.mesh.materials[0];
    EXPECT_EQ(m.name, "skin");
    EXPECT_EQ(m.diffuse, (Rgba8{255, 128, 0, 128}));
    EXPECT_EQ(m.diffuse_map.path, folder_ / "Skin Tex.PNG");
    EXPECT_EQ(m.bump_map.path, folder_ / "maps/bump.png");
    EXPECT_EQ(m.bump_scale, 0.25);
    EXPECT_FALSE(m.bump_is_normal_map);
    EXPECT_EQ(in.mesh.face_materials, (std::vector<std::uint32_t>{0}));
    EXPECT_EQ(in.dependencies,
              (std::vector<fs::path>{folder_ / "Skin Tex.PNG", folder_ / "a.mtl", folder_ / "maps/bump.png"}));
    EXPECT_TRUE(in.warnings.empty());
}

TEST_F(ObjMaterials, TransparencyIsOneMinusTrAndOneIsNotBelieved) {
    EXPECT_EQ(read(obj_, "newmtl skin\nTr 0.25\n").mesh.materials[0].diffuse.a, 191);
    EXPECT_EQ(read(obj_, "newmtl skin\nTr 1\n").mesh.materials[0].diffuse.a, 255);
    EXPECT_EQ(read(obj_, "newmtl skin\nTr 0.25\nd 1\n").mesh.materials[0].diffuse.a, 255);
    EXPECT_EQ(read(obj_, "newmtl skin\nd -halo 0\n").mesh.materials[0].diffuse.a, 0);
}

TEST_F(ObjMaterials, ScaleAndOffsetMoveTheCoordinates) {
    picture("t.png");
    EXPECT_EQ(read(obj_, "newmtl skin\nmap_Kd -s 2 4 1 -o 0.5 0 0 t.png\n").mesh.corner_uvs[0], (Vec2d{1.5, 1}));
    EXPECT_EQ(read(obj_, "newmtl skin\nmap_Kd -o 0.5 t.png\n").mesh.corner_uvs[0], (Vec2d{1, 0.25}));
    EXPECT_EQ(read(obj_, "newmtl skin\nmap_Kd t.png\n").mesh.corner_uvs[0], (Vec2d{0.5, 0.25}));
}

TEST_F(ObjMaterials, NormalMapsAreToldFromHeights) {
    picture("n.png");
    picture("skin_normal.png");
    picture("h.png");
    EXPECT_TRUE(read(obj_, "newmtl skin\nnorm n.png\n").mesh.materials[0].bump_is_normal_map);
    EXPECT_TRUE(read(obj_, "newmtl skin\nbump skin_normal.png\n").mesh.materials[0].bump_is_normal_map);
    const auto both = read(obj_, "newmtl skin\nbump h.png\nnorm n.png\n").mesh.materials[0];
    EXPECT_EQ(both.bump_map.path, folder_ / "h.png");
    EXPECT_FALSE(both.bump_is_normal_map);
}

TEST_F(ObjMaterials, MissingThingsAreWarnings) {
    const ImportedMesh in = read("mtllib a.mtl none.mtl\n" + kTriangle + "usemtl skin\nf 1 2 3\nusemtl gone\nf 1 2 3\n",
                                 "newmtl skin\nmap_Kd skin.png\n");
    const std::string where = "; looked for beside the mesh and there in textures, texture, maps, images, materials";
    EXPECT_EQ(in.warnings, (std::vector<std::string>{"DGM3012: texture missing: skin.png" + where,
                                                     "DGM3011: material library missing: none.mtl" + where,
                                                     "material not defined: gone"}));
    EXPECT_EQ(in.mesh.face_materials, (std::vector<std::uint32_t>{0, 1}));
    EXPECT_TRUE(in.mesh.materials[0].diffuse_map.empty());
}

TEST_F(ObjMaterials, WindowsPathsMayHaveBlanks) {
    for (const char* name : {"My Textures/skin one.png", "textures/skin two.png", "skin three.png"}) picture(name);
    const auto found = [&](const std::string& statement) {
        const ImportedMesh in =
            read("mtllib a.mtl\n" + kTriangle + "usemtl skin\nf 1 2 3\n", "newmtl skin\nmap_Kd " + statement + "\n");
        return in.mesh.materials[0].diffuse_map.path.lexically_relative(folder_.path()).generic_string();
    };
    const std::string one = "My Textures/skin one.png";
    EXPECT_EQ(found("My Textures\\skin one.png"), one);
    EXPECT_EQ(found("C:\\Users\\Jane Doe\\Asset\\My Textures\\skin one.png"), one);
    EXPECT_EQ(found("-bm 1 \"C:\\Jane Doe\\my textures\\SKIN one.png\""), one);
    EXPECT_EQ(found("\\\\server\\share\\My Textures\\skin one.png"), one);
    EXPECT_EQ(found("file:///C:/Jane%20Doe/My%20Textures/skin%20one.png"), one);
    EXPECT_EQ(found("D:\\art work\\skin two.png"), "textures/skin two.png");
    EXPECT_EQ(found("..\\other place\\skin three.png"), "skin three.png");
    EXPECT_EQ(found("C:\\My Textures\\skin four.png"), "");
}

TEST_F(ObjMaterials, NamesMayHaveSpacesAndHashes) {
    const ImportedMesh in = read("mtllib a.mtl\n" + kTriangle + "f 1 2 3\nusemtl Material #25 \nf 1 2 3\n",
                                 "newmtl Material #25\nKd 0 0 1\n");
    ASSERT_EQ(in.mesh.materials.size(), 2u);
    EXPECT_EQ(in.mesh.materials[0].diffuse, (Rgba8{0, 0, 255, 255}));
    // Faces before the first usemtl get a material of their own at the end.
    EXPECT_EQ(in.mesh.face_materials, (std::vector<std::uint32_t>{1, 0}));
}

TEST(Obj, RefusalsSayWhere) {
    const auto error_of = [](const std::string& text) {
        try {
            (void)read_text(text);
        } catch (const Error& error) {
            return error.code().id() + " " + error.what() + " @" + error.place().substr(error.place().rfind('/') + 1);
        }
        return std::string("none");
    };
    EXPECT_EQ(error_of(""), "DGM3001 the file is empty @a.obj");
    EXPECT_EQ(error_of(" \n \n").substr(0, 7), "DGM3001");
    EXPECT_EQ(error_of(kTriangle), "DGM3001 no usable faces @a.obj");
    EXPECT_EQ(error_of(kTriangle + "f 1 2 9\n"),
              "DGM3001 no usable faces; 1 faces name vertices that do not exist @a.obj:4:1");
    // Columns count from 1: of the statement, or of the word that cannot be read.
    EXPECT_EQ(error_of(kTriangle + "\t l 1 2\n"), "DGM3001 no usable faces; 1 line elements @a.obj:4:3");
    EXPECT_EQ(
        error_of(kTriangle + "f 1 x 3\nf 1 2\n"),
        "DGM3001 no usable faces; 1 face statements cannot be read; 1 faces have fewer than three corners @a.obj:4:5");
    EXPECT_EQ(error_of(std::string("\x89PNG\r\n\0\1\2", 9)), "DGM3001 no usable faces; no vertices @a.obj");
    EXPECT_EQ(error_of(kTriangle + "f \\").substr(0, 7), "DGM3001");
    std::string star, face = "f";
    for (int k = 0; k < 4001; ++k) {
        const double angle = 6.28318530717958 * k * 2000 / 4001;
        star += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
        face += " " + std::to_string(k + 1);
    }
    EXPECT_EQ(error_of(kTriangle + star + "f 1 2 3\n" + face + "\n"),
              "DGM3019 polygons of too many corners cross themselves, up to this one @a.obj:4006:1");
}

TEST(Obj, LimitsHold) {
    const TempFolder folder;
    write_bytes(folder / "a.obj", kTriangle + "f 1 2 3\nf 1 2 3\n");
    const auto code_with = [&](dgm::formats::MeshReadLimits limits) {
        try {
            (void)read_mesh(folder / "a.obj", limits);
        } catch (const Error& error) { return error.code().number; }
        return 0;
    };
    EXPECT_EQ(code_with({}), 0);
    EXPECT_EQ(code_with({.max_faces = 1}), codes::kTooLarge.number);
    EXPECT_EQ(code_with({.max_vertices = 2}), codes::kTooLarge.number);
    EXPECT_EQ(code_with({.max_file_bytes = 10}), codes::kTooLarge.number);
}

TEST(Obj, ContentIsRecognisedWithoutExtension) {
    const TempFolder folder;
    write_bytes(folder / "mesh", "# made by hand\n" + kTriangle + "f 1 2 3\n");
    EXPECT_EQ(read_mesh(folder / "mesh").mesh.faces.size(), 1u);
    EXPECT_TRUE(dgm::formats::has_mesh_extension("A.OBJ"));
    EXPECT_TRUE(dgm::formats::has_mesh_extension("a.3Ds"));
    EXPECT_FALSE(dgm::formats::has_mesh_extension("a.png"));
}

TEST(Obj, RandomBytesDoNoHarm) {
    const TempFolder folder;
    dgm::test::Random random(4);
    const std::string words[] = {"v",
                                 "vt",
                                 "vn",
                                 "f",
                                 "usemtl",
                                 "mtllib",
                                 "1",
                                 "-1",
                                 "1e999",
                                 "/",
                                 "//",
                                 "nan",
                                 "\\",
                                 "\n",
                                 "\r",
                                 "#",
                                 "2/1",
                                 "3//1",
                                 "99999999999999999999",
                                 " ",
                                 "\t",
                                 "x",
                                 "4294967295",
                                 "-4294967296"};
    for (int k = 0; k < 300; ++k) {
        std::string text;
        for (int w = 0; w < 400; ++w)
            text += words[random.below(std::size(words))] + (random.below(3) == 0 ? "\n" : " ");
        write_bytes(folder / "a.obj", text);
        try {
            const ImportedMesh in = read_mesh(folder / "a.obj");
            for (const Face& face : in.mesh.faces)
                for (const std::uint32_t v : face) ASSERT_LT(v, in.mesh.positions.size());
        } catch (const Error& error) { EXPECT_EQ(error.code().number, codes::kNoFaces.number); }
    }
}

}  // namespace
