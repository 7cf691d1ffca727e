// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/mapped_file_test.cpp
// Asset::open answers alike on POSIX and on Windows.
#include "platform.h"
#if DGM_TEST_FILES
#include <gtest/gtest.h>

#include <dgm/asset.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "opened.h"

namespace dgm::test {
namespace {
namespace fs = std::filesystem;

/// A folder of this test alone, gone afterwards. Its name, too, is not of one code page.
struct Folder {
    fs::path path;
    Folder() : path(fs::path(testing::TempDir()) / fs::path(u8"dgm_\u0142\u6e2c\U0001F9E0")) {
        path += testing::UnitTest::GetInstance()->current_test_info()->name();  // ctest runs tests side by side
        fs::remove_all(path);
        fs::create_directories(path);
    }
    ~Folder() { fs::remove_all(path); }
    /// UTF-8, as Asset::open takes it.
    [[nodiscard]] std::string name(const char8_t* file) const {
        const std::u8string all = (path / file).u8string();
        return {all.begin(), all.end()};
    }
    void write(const char8_t* file, const Bytes& bytes) const {
        std::ofstream(path / file, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
};
ErrorCode refusal(const std::string& path) {
    return Asset::open(path.c_str()).error().code;
}

TEST(MappedFile, PathsAreUtf8) {
    const Folder folder;
    folder.write(u8"\u00e9t\u00e9 \u30de.dgm", build({grid_chart(5, 7, sheet)}).bytes);
    auto asset = Asset::open(folder.name(u8"\u00e9t\u00e9 \u30de.dgm").c_str());
    ASSERT_TRUE(asset.ok()) << asset.error().message;
    EXPECT_TRUE(asset.value().verify().ok());
    EXPECT_EQ(asset.value().chart(0).value().cols(), 7u);
}

TEST(MappedFile, WhatIsNoFileIsRefused) {
    const Folder folder;
    folder.write(u8"empty.dgm", {});
    EXPECT_EQ(refusal(folder.name(u8"empty.dgm")), ErrorCode::Truncated);
    EXPECT_EQ(refusal(folder.name(u8"none.dgm")), ErrorCode::FileMissing);
    EXPECT_EQ(refusal(folder.name(u8"no/such/folder.dgm")), ErrorCode::FileMissing);
    EXPECT_EQ(refusal(folder.name(u8"empty.dgm/inside.dgm")), ErrorCode::FileMissing);
    EXPECT_EQ(refusal(""), ErrorCode::FileMissing);
    EXPECT_EQ(refusal(folder.name(u8"")), ErrorCode::ReadFailed) << "a folder";
    EXPECT_EQ(refusal(std::string(5000, 'x')), ErrorCode::ReadFailed) << "too long a path";
#if defined(_WIN32)
    EXPECT_EQ(refusal("NUL"), ErrorCode::ReadFailed) << "a device";
    EXPECT_EQ(refusal("\\\\.\\NUL"), ErrorCode::ReadFailed) << "a device";
    EXPECT_EQ(refusal("\xff\xfe.dgm"), ErrorCode::ReadFailed) << "no UTF-8";
#else
    EXPECT_EQ(refusal("/dev/null"), ErrorCode::ReadFailed) << "a device";
#endif
}

TEST(MappedFile, IsGivenBackAndSharedMeanwhile) {
    const Folder folder;
    const Bytes bytes = build({grid_chart(9, 9, sheet)}).bytes;
    folder.write(u8"shared.dgm", bytes);
    const std::string name = folder.name(u8"shared.dgm");
    {
        const std::fstream writer(folder.path / u8"shared.dgm", std::ios::in | std::ios::out | std::ios::binary);
        ASSERT_TRUE(writer.is_open());
        auto one = Asset::open(name.c_str()), two = Asset::open(name.c_str());
        ASSERT_TRUE(one.ok() && two.ok()) << "open elsewhere, for writing too";
        EXPECT_EQ(one.value().usage().mapped_bytes, bytes.size());
        EXPECT_TRUE(two.value().verify().ok());
    }
    // Windows removes no file that is still mapped.
    EXPECT_TRUE(fs::remove(folder.path / u8"shared.dgm"));
    EXPECT_EQ(refusal(name), ErrorCode::FileMissing);
}

}  // namespace
}  // namespace dgm::test
#endif
