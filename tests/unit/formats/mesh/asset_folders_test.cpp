// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/mesh/asset_folders_test.cpp
#include "mesh/asset_folders.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <assimp/IOStream.hpp>

#include "mesh/guarded_io.h"
#include "mesh/material_files.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "support/no_descriptors.h"
#include "test_maps.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;
using Why = FoundFile::Why;

/// in/mesh.obj and what it may name lie below in; library and private beside it.
class AssetFoldersTest : public testing::Test {
 protected:
    void SetUp() override {
        for (const char* folder : {"in/skins", "library/wood", "private"}) fs::create_directories(root_ / folder);
        for (const char* file : {"in/skins/a.png", "library/wood/oak.png", "private/photo.png"})
            test::write_bytes(root_ / file, "x");
    }
    FoundFile find(const std::string& name, std::vector<fs::path> roots = {}) const {
        return FileFinder(mesh_, roots).find(name);
    }

    const test::TempFolder root_;
    const fs::path mesh_ = root_ / "in/mesh.obj", library_ = root_ / "library";
};

TEST_F(AssetFoldersTest, NamesThatLeadOutsideAreRefusedWhateverIsThere) {
    const std::string photo = (root_ / "private/photo.png").string();
    for (const std::string& name :
         {photo, std::string("../private/photo.png"), std::string("skins/../../private/photo.png"),
          std::string("..\\private\\photo.png"), "file://" + photo, std::string("%2e%2e/private/photo.png"),
          '"' + photo + '"', std::string("/nowhere/at/all.png"), std::string("../nowhere.png")}) {
        const FoundFile found = find(name);
        EXPECT_FALSE(found) << name;
        EXPECT_EQ(found.why, Why::kOutside) << name;
    }
    // Paths of other machines are not files here, and their ends are looked for as ever.
    EXPECT_EQ(find("C:\\work\\oak.png").why, Why::kMissing);
    EXPECT_EQ(find("file:///C:/work/oak.png").why, Why::kMissing);
    EXPECT_EQ(find("\\\\server\\share\\oak.png").why, Why::kMissing);
    EXPECT_EQ(*find("C:\\work\\skins\\A.PNG"), root_ / "in/skins/a.png");
    EXPECT_EQ(*find("/home/someone/skins/a.png"), root_ / "in/skins/a.png");
    EXPECT_EQ(*find("../elsewhere/skins/a.png"), root_ / "in/skins/a.png");
    EXPECT_EQ(*find("skins/../skins/a.png"), root_ / "in/skins/../skins/a.png");
    EXPECT_EQ(*find((root_ / "in/skins/a.png").string()), root_ / "in/skins/a.png");
}

TEST_F(AssetFoldersTest, LinksThatLeadOutsideAreRefused) {
    fs::create_symlink(root_ / "private/photo.png", root_ / "in/link.png");
    fs::create_directory_symlink(root_ / "private", root_ / "in/folder");
    fs::create_symlink("skins/a.png", root_ / "in/inside.png");
    EXPECT_EQ(find("link.png").why, Why::kOutside);
    EXPECT_EQ(find("folder/photo.png").why, Why::kOutside);
    EXPECT_EQ(find("LINK.PNG").why, Why::kOutside);
    EXPECT_TRUE(find("inside.png"));
    EXPECT_TRUE(find("folder/photo.png", {root_ / "private"}));
    // The mesh's folder may be a link itself: it is the user who names it.
    fs::create_directory_symlink(root_ / "in", root_ / "way");
    EXPECT_TRUE(FileFinder(root_ / "way/mesh.obj").find("skins/a.png"));
}

TEST_F(AssetFoldersTest, PipesAndDevicesAreRefused) {
    ASSERT_EQ(mkfifo((root_ / "in/pipe.png").c_str(), 0600), 0);
    fs::create_symlink("/dev/zero", root_ / "in/zero.png");
    for (const char* name : {"pipe.png", "zero.png", "/dev/zero"}) EXPECT_FALSE(find(name)) << name;
    EXPECT_EQ(find("pipe.png").why, Why::kSpecial);
    EXPECT_EQ(find("zero.png").why, Why::kSpecial);
    EXPECT_EQ(texture_missing("pipe.png", Why::kSpecial), "DGM3014: texture is a pipe or a device: pipe.png");
    EXPECT_EQ(find("zero.png", {"/"}).why, Why::kSpecial);
    EXPECT_EQ(find("skins").why, Why::kMissing);
}

TEST_F(AssetFoldersTest, RootsAreSearchedAfterTheMeshesFolder) {
    const std::vector<fs::path> roots{library_};
    EXPECT_EQ(*find("../library/wood/oak.png", roots), root_ / "in/../library/wood/oak.png");
    EXPECT_EQ(*find((library_ / "wood/oak.png").string(), roots), library_ / "wood/oak.png");
    EXPECT_EQ(*find("D:\\shared\\wood\\Oak.png", roots), library_ / "wood/oak.png");
    EXPECT_EQ(*find("wood/oak.png", roots), library_ / "wood/oak.png");
    EXPECT_EQ(find("../private/photo.png", roots).why, Why::kOutside);
    test::write_bytes(root_ / "library/a.png", "y");
    EXPECT_EQ(*find("x/skins/a.png", roots), root_ / "in/skins/a.png");
}

TEST_F(AssetFoldersTest, NamesComeBack) {
    const std::vector<fs::path> roots{library_};
    const AssetFolders folders(mesh_, roots);
    for (const char* file : {"in/skins/a.png", "library/wood/oak.png"}) {
        const std::string name = folders.name_of(root_ / file);
        EXPECT_FALSE(leads_outside(name));
        ASSERT_TRUE(folders.resolve(name)) << name;
        EXPECT_TRUE(fs::equivalent(*folders.resolve(name), root_ / file));
    }
    EXPECT_EQ(folders.name_of(root_ / "in/../library/wood/oak.png"), "wood/oak.png");
    EXPECT_EQ(folders.name_of(root_ / "private/photo.png"), "");
    for (const std::string& name : {std::string("../private/photo.png"), (root_ / "private/photo.png").string(),
                                    std::string("none.png"), std::string("skins")})
        EXPECT_FALSE(folders.resolve(name)) << name;
}

TEST_F(AssetFoldersTest, ImportersOpenNothingElse) {
    const auto gltf = [&](const std::string& buffer) {
        return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
               "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
               "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
               "\"buffers\":[{\"byteLength\":36,\"uri\":\"" +
               buffer + "\"}]}";
    };
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::string bytes(reinterpret_cast<const char*>(corners), sizeof corners);
    test::write_bytes(root_ / "in/near.bin", bytes);
    test::write_bytes(root_ / "library/far.bin", bytes);
    ASSERT_EQ(mkfifo((root_ / "in/pipe.bin").c_str(), 0600), 0);
    const auto code_with = [&](const std::string& buffer, std::vector<fs::path> roots = {}) {
        test::write_bytes(root_ / "in/m.gltf", gltf(buffer));
        return test::code_of([&] { (void)read_mesh(root_ / "in/m.gltf", {.asset_roots = std::move(roots)}); });
    };
    EXPECT_EQ(code_with("near.bin"), 0);
    EXPECT_EQ(code_with("../library/far.bin"), model::codes::kReferenceOutside.number);
    EXPECT_EQ(code_with((library_ / "far.bin").string()), model::codes::kReferenceOutside.number);
    EXPECT_EQ(code_with("../library/far.bin", {library_}), 0);
    EXPECT_EQ(code_with("pipe.bin"), model::codes::kReferenceNoFile.number);
    EXPECT_EQ(code_with("none.bin"), model::codes::kImportFailed.number);
    test::write_bytes(root_ / "in/huge.bin", "");
    fs::resize_file(root_ / "in/huge.bin", std::uintmax_t{1} << 40);
    EXPECT_EQ(code_with("huge.bin"), model::codes::kTooLarge.number);
}

// assimp would take a file that cannot be opened for one that is broken.
TEST_F(AssetFoldersTest, TroubleWithAFileIsKept) {
    test::write_bytes(root_ / "in/near.bin", "abcdef");
    OpenedFiles files;
    GuardedIo io(root_ / "in/m.gltf", {}, 5, files);
    {
        const test::NoDescriptors none;
        EXPECT_EQ(io.Open((root_ / "in/near.bin").c_str(), "rb"), nullptr);
    }
    ASSERT_TRUE(files.trouble);
    EXPECT_EQ(&files.trouble->code(), &model::codes::kIoTrouble);
    files.trouble.reset();
    EXPECT_EQ(io.Open((root_ / "in/near.bin").c_str(), "rb"), nullptr) << "more bytes than it may have";
    EXPECT_EQ(&files.trouble->code(), &model::codes::kTooLarge);
    files.trouble.reset();
    EXPECT_EQ(io.Open((root_ / "in/none.bin").c_str(), "rb"), nullptr);
    EXPECT_FALSE(files.trouble);
}

// As fread() and fseek() do it.
TEST_F(AssetFoldersTest, StreamsAreReadInItems) {
    test::write_bytes(root_ / "in/near.bin", "abcdefg");
    OpenedFiles files;
    GuardedIo io(root_ / "in/m.gltf", {}, 7, files);
    Assimp::IOStream* const stream = io.Open((root_ / "in/near.bin").c_str(), "rb");
    ASSERT_NE(stream, nullptr);
    char items[8] = {};
    EXPECT_EQ(stream->FileSize(), 7U);
    EXPECT_EQ(stream->Read(items, 2, 2), 2U);
    EXPECT_EQ(std::string(items), "abcd");
    EXPECT_EQ(stream->Tell(), 4U);
    EXPECT_EQ(stream->Seek(2, aiOrigin_SET), aiReturn_SUCCESS);
    EXPECT_EQ(stream->Seek(1, aiOrigin_CUR), aiReturn_SUCCESS);
    EXPECT_EQ(stream->Read(items, 3, 2), 1U) << "the rest is no whole item";
    EXPECT_EQ(std::string(items, 3), "def");
    EXPECT_EQ(stream->Seek(1, aiOrigin_END), aiReturn_FAILURE);
    EXPECT_EQ(stream->Seek(0, aiOrigin_END), aiReturn_SUCCESS);
    EXPECT_EQ(stream->Tell(), 7U);
    EXPECT_EQ(stream->Write("x", 1, 1), 0U);
    io.Close(stream);
    EXPECT_EQ(files.opened, std::vector<fs::path>{root_ / "in/near.bin"});
}

TEST_F(AssetFoldersTest, PlyHeadersEnd) {
    const std::string head = "ply\nformat ascii 1.0\n", body = "element vertex 3\nproperty float x\n";
    for (const std::string& text :
         {head + "comment end_header\n", head + "obj_info end_header\n", head + body + "comment end_header",
          head + body + "property float end_header\n", head + "end_headers\n", std::string("ply\nend_header_")}) {
        test::write_bytes(root_ / "in/m.ply", text);
        EXPECT_EQ(test::code_of([&] { (void)read_mesh(root_ / "in/m.ply"); }), model::codes::kImportFailed.number)
            << text;
    }
}

}  // namespace
}  // namespace dgm::formats
