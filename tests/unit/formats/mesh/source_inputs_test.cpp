// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/source_inputs.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "mesh/material_files.h"
#include "mesh/mesh_reader.h"
#include "mesh/mtl_reader.h"
#include "model/error.h"
#include "support/no_descriptors.h"
#include "support/temp_folder.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;

class SourceInputsTest : public testing::Test {
 protected:
    void SetUp() override { fs::create_directories(root_ / "textures"); }
    fs::path write(const std::string& name, const std::string& text) {
        std::ofstream(root_ / name, std::ios::binary) << text;
        return root_ / name;
    }
    std::string found(const SourceInputs& inputs) {
        std::string out;
        for (const fs::path& file : inputs.files) out += file.lexically_relative(root_).string() + ";";
        for (const std::string& missing : inputs.missing) out += missing.substr(0, missing.find("; looked")) + ";";
        return out;
    }
    const test::TempFolder scratch_;
    const fs::path& root_ = scratch_.path();
};

std::string chunk(unsigned id, const std::string& body) {
    const std::uint32_t length = 6 + static_cast<std::uint32_t>(body.size());
    std::string out{static_cast<char>(id & 255), static_cast<char>(id >> 8)};
    for (int k = 0; k < 4; ++k) out += static_cast<char>((length >> (8 * k)) & 255);
    return out + body;
}

TEST_F(SourceInputsTest, ObjNamesLibrariesAndTheyNameTextures) {
    write("a.mtl", "newmtl x\nmap_Kd skin.png\nmap_Bump -bm 2 gone.png\n");
    write("My Lib.mtl", "newmtl y\nmap_Kd C:\\art\\Deep.JPG\n");
    write("skin.png", "");
    write("textures/deep.jpg", "");
    const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n";
    const std::string all = "My Lib.mtl;a.mtl;skin.png;textures/deep.jpg;DGM3012: texture missing: gone.png;";
    EXPECT_EQ(
        found(*source_inputs(write("m.obj", "# mtllib no.mtl\nmtllib a.mtl\n" + faces + "  MTLLIB My Lib.mtl\n"))),
        all);
    EXPECT_EQ(found(*source_inputs(write("m.obj", "mtllib \\\r\n a.mtl\rmtllib no.mtl\r\n" + faces))),
              "a.mtl;skin.png;DGM3012: texture missing: gone.png;DGM3011: material library missing: no.mtl;");
    EXPECT_EQ(found(*source_inputs(write("m.obj", faces + "g mtllib a.mtl\nmtllibs a.mtl\n"))), "");
    // As the import has them: files that are used are among those that are named.
    const fs::path mesh = write("m.obj", "mtllib a.mtl\n" + faces);
    EXPECT_EQ(source_inputs(mesh)->files, read_mesh(mesh).dependencies);
}

TEST_F(SourceInputsTest, ALibraryIsReadOnceByWhateverNamesAndContinuedLinesOnce) {
    write("a.mtl", "newmtl x\nmap_Kd gone.png\n");
    fs::create_symlink("a.mtl", root_ / "b.mtl");
    const std::string names = "a.mtl ./a.mtl A.MTL b.mtl a.mtl";
    const auto named = source_inputs(write("m.obj", "mtllib " + names + "\nmtllib a.mtl\n"));
    EXPECT_EQ(named->missing.size(), 1u) << "one library, one warning";
    // A line that goes on and on is one statement, not one for each of its lines: 60 000 squared would take minutes.
    std::string turns;
    for (int k = 0; k < 60'000; ++k) turns += "mtllib q\\\n";
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EQ(source_inputs(write("m.obj", turns))->files.size(), 0u);
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
}

TEST_F(SourceInputsTest, AnUnreadableLibraryIsAWarning) {
    write("huge.mtl", "");
    fs::resize_file(root_ / "huge.mtl", std::uintmax_t{1} << 40);
    const auto inputs = source_inputs(write("m.obj", "mtllib huge.mtl\n"));
    ASSERT_EQ(inputs->missing.size(), 1u);
    EXPECT_EQ(inputs->missing[0].substr(0, 7), "DGM3007");
}

// Else the same mesh has another map, and another hash, where descriptors or memory are short.
TEST_F(SourceInputsTest, AShortageIsNoMissingFile) {
    write("a.mtl", "newmtl x\n");
    FileFinder finder(root_ / "m.obj");
    MtlLibrary library;
    std::vector<std::string> warnings;
    std::vector<fs::path> dependencies;
    const std::vector<std::string> names{"a.mtl"};
    const test::NoDescriptors none;
    EXPECT_THROW(read_mtl_libraries(names, finder, library, warnings, dependencies), model::Error);
    EXPECT_THROW((void)finder.find("A.MTL"), model::Error) << "the folder cannot be listed";
}

TEST_F(SourceInputsTest, ThreeDsNamesTextures) {
    write("SKIN.JPG", "");
    const std::string map = chunk(0xA200, chunk(0x0030, "\x64\0"s) + chunk(0xA300, "skin.jpg\0"s)),
                      bump = chunk(0xA230, chunk(0xA300, "bump.jpg\0"s));
    const std::string material = chunk(0xAFFF, chunk(0xA000, "x\0"s) + map + bump);
    const std::string mesh = chunk(0x4000, "name\0"s + chunk(0x4100, chunk(0xA300, "not a map\0"s)));
    const std::string good = chunk(0x4D4D, chunk(0x0002, "\3\0\0\0"s) + chunk(0x3D3D, material + mesh));
    EXPECT_EQ(found(*source_inputs(write("m.3ds", good))), "SKIN.JPG;DGM3012: texture missing: bump.jpg;");
    for (std::size_t cut = 0; cut < good.size(); ++cut)  // whatever is lost, it ends
        EXPECT_TRUE(source_inputs(write("m.3ds", good.substr(0, cut))));
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::string bad = good;
        bad[at] = static_cast<char>(0xff);
        EXPECT_TRUE(source_inputs(write("m.3ds", bad)));
    }
}

TEST_F(SourceInputsTest, OtherFormats) {
    EXPECT_EQ(found(*source_inputs(write("m.ply", "ply"))), "");
    EXPECT_FALSE(source_inputs(write("m.gltf", "{}")));
    EXPECT_FALSE(source_inputs(write("m", "v 0 0 0")));
}

}  // namespace
}  // namespace dgm::formats
