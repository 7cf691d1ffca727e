// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/file_pattern.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "model/error.h"
#include "support/no_descriptors.h"
#include "support/temp_folder.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;

TEST(FilePattern, MatchesByComponents) {
    const fs::path root = fs::temp_directory_path() / ("dgm-pattern-" + std::to_string(getpid()));
    fs::create_directories(root / "a" / "b" / ".git");
    for (const char* name : {"x.obj", "a/x.obj", "a/y.3ds", "a/b/x.obj", "a/b/.x.obj", "a/b/.git/x.obj"})
        std::ofstream(root / name) << 'x';
    fs::create_directory_symlink(root, root / "a" / "round");  // a loop
    const auto found = [&](const char* pattern) {
        const auto [folder, files] = files_matching(root / pattern);
        std::string out;
        for (const fs::path& file : files) out += (folder / file).lexically_relative(root).string() + " ";
        return out;
    };
    EXPECT_EQ(found("*.obj"), "x.obj ");
    EXPECT_EQ(found("*/x.obj"), "a/x.obj ");
    EXPECT_EQ(found("**/x.obj"), "a/b/x.obj a/x.obj x.obj ");
    EXPECT_EQ(found("**/**/x.obj"), "a/b/x.obj a/x.obj x.obj ");
    EXPECT_EQ(found("a/**"), "a/b/x.obj a/x.obj a/y.3ds ");
    EXPECT_EQ(found("**/b/*"), "a/b/x.obj ");
    EXPECT_EQ(found("a/[!x].*"), "a/y.3ds ");
    EXPECT_EQ(found("a/b/.x*"), "a/b/.x.obj ");
    EXPECT_EQ(found("gone/*"), "");
    EXPECT_EQ(files_matching(root / "a" / "*.obj").first, root / "a");
    fs::remove_all(root);
}

TEST(FilePattern, AFolderThatCannotBeListedIsNotEmpty) {
    const test::TempFolder root;
    const test::NoDescriptors none;
    EXPECT_THROW((void)files_matching(root / "*.obj"), model::Error);
}

}  // namespace
}  // namespace dgm::bake
