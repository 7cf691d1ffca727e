// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/files/files_test.cpp
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "files/folder_list.h"
#include "files/io_failure.h"
#include "files/nesting.h"
#include "files/output_file.h"
#include "files/regular_file.h"
#include "files/staging_folder.h"
#include "files/whole_file.h"
#include "model/codes.h"
#include "model/printable.h"
#include "support/no_descriptors.h"
#include "support/temp_folder.h"

namespace dgm::formats {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
    [[nodiscard]] std::size_t entries() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    static std::string content(const fs::path& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    template <class Work>
    static int code_of(const Work& work) {
        try {
            work();
        } catch (const model::Error& error) { return error.code().number; }
        return 0;
    }
    const test::TempFolder scratch_;
    const fs::path& folder_ = scratch_.path();
};

TEST_F(Files, AnythingButARegularFileIsRefusedWithoutWaiting) {
    const fs::path pipe = folder_ / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_EQ(code_of([&] { RegularFile file(pipe); }), codes::kReadFailed.number);
    EXPECT_EQ(code_of([&] { RegularFile file("/dev/zero"); }), codes::kReadFailed.number);
    EXPECT_EQ(code_of([&] { RegularFile file(folder_); }), codes::kReadFailed.number);
    EXPECT_EQ(code_of([&] { RegularFile file(folder_ / "none"); }), codes::kFileMissing.number);
}

TEST_F(Files, SizesAreLookedAtBeforeBytes) {
    const fs::path sparse = folder_ / "sparse";
    std::ofstream(sparse) << "x";
    fs::resize_file(sparse, std::uintmax_t{1} << 40);
    EXPECT_EQ(code_of([&] { (void)read_small_file(sparse, 1 << 20); }), codes::kTooLarge.number);
    std::ofstream(folder_ / "small") << "abc";
    EXPECT_EQ(read_small_file(folder_ / "small", 3), "abc");
    EXPECT_EQ(code_of([&] { (void)read_small_file(folder_ / "small", 2); }), codes::kTooLarge.number);
}

TEST_F(Files, AWholeFileIsAllThereOrSaysWhyNot) {
    const std::string bytes("a\0b", 3);
    write_whole_file(folder_ / "file", bytes);
    EXPECT_EQ(content(folder_ / "file"), bytes);
    EXPECT_EQ(code_of([&] { write_whole_file(folder_ / "none/file", bytes); }), codes::kWriteFailed.number);
    EXPECT_EQ(entries(), 1U);
    EXPECT_EQ(code_of([&] { write_whole_file("/dev/full", bytes); }), codes::kNoSpace.number);
    try {
        write_whole_file(folder_ / "none/file", bytes, "output");
        FAIL();
    } catch (const model::Error& error) { EXPECT_EQ(error.place(), "output"); }
}

TEST_F(Files, AStagingFolderIsRemovedWithoutADescriptor) {
    std::optional<StagingFolder> staging(folder_ / "output");
    for (const char* name : {"a", "b"}) write_whole_file(staging->where(name), "x");
    {
        const test::NoDescriptors none;
        staging.reset();
    }
    EXPECT_EQ(entries(), 0U);
}

// A file that cannot be opened for now is no missing one, and a folder that cannot be listed is no empty one.
TEST_F(Files, WhatMayPassIsToldApart) {
    std::ofstream(folder_ / "file") << "x";
    const test::NoDescriptors none;
    EXPECT_EQ(code_of([&] { RegularFile file(folder_ / "file"); }), codes::kIoTrouble.number);
    EXPECT_EQ(code_of([&] { RegularFile file(folder_ / "none"); }), codes::kIoTrouble.number);
    EXPECT_EQ(code_of([&] { (void)files_below(folder_); }), codes::kIoTrouble.number);
    for (const int passing : {EIO, EMFILE, ENFILE, ENOMEM, ESTALE})
        EXPECT_EQ(&read_failure(passing), &codes::kIoTrouble);
    for (const int lasting : {EACCES, ELOOP, ENAMETOOLONG}) EXPECT_EQ(&read_failure(lasting), &codes::kReadFailed);
    EXPECT_EQ(&write_failure(EDQUOT), &codes::kNoSpace);
}

TEST_F(Files, HiddenFilesBelongToNoFoldersList) {
    fs::create_directories(folder_ / "b/c");
    fs::create_directories(folder_ / ".dgm-abcdef");
    for (const char* name : {"b/c/1", "b.2", "b/.3", ".dgm-abcdef/4"}) std::ofstream(folder_ / name) << "x";
    fs::create_directory_symlink(folder_, folder_ / "b/round");
    EXPECT_EQ(files_below(folder_), (std::vector<fs::path>{"b.2", "b/c/1"}));
    EXPECT_TRUE(files_below(folder_ / "gone").empty());
}

TEST_F(Files, AStagingFolderIsPrivateAndLeavesNothing) {
    fs::path path;
    {
        const StagingFolder staging(folder_ / "output");
        path = staging.path();
        struct stat status {};
        ASSERT_EQ(::lstat(path.c_str(), &status), 0);
        EXPECT_EQ(status.st_mode & 07777, 0700u);
        const StagingFolder other(folder_ / "output");
        EXPECT_NE(other.path(), path);
        std::ofstream(staging.where("left")) << "x";
    }
    EXPECT_EQ(entries(), 0u);
}

// One whose folder inside cannot be opened stays, with its lock: the next program removes it, and need not wait.
TEST_F(Files, AStagingFolderThatStaysKeepsItsLock) {
    fs::path path;
    {
        std::optional<StagingFolder> staging(folder_ / "output");
        path = staging->path();
        fs::create_directories(staging->where("inner/deep"));
        std::ofstream(staging->where("inner/deep/file")) << "x";
        const test::NoDescriptors none;
        staging.reset();
    }
    EXPECT_TRUE(fs::exists(path / ".lock"));
    remove_dead_staging_folders(folder_);
    EXPECT_EQ(entries(), 0U);
    {
        const StagingFolder staging(folder_ / "output");
        fs::create_directories(staging.where("inner/deep"));
        std::ofstream(staging.where("inner/deep/file")) << "x";
    }
    EXPECT_EQ(entries(), 0U);
}

TEST_F(Files, FoldersOfKilledProgramsAreCollectedAndThoseOfLivingOnesStay) {
    const StagingFolder living(folder_ / "output");
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const StagingFolder staging(folder_ / "output");
        std::ofstream(staging.where("part")) << "half";
        (void)!::write(ready[1], "x", 1);
        for (;;) ::pause();
    }
    char byte = 0;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    remove_dead_staging_folders(folder_);
    EXPECT_EQ(entries(), 2u) << "both are in use";
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_EQ(entries(), 2u);
    remove_dead_staging_folders(folder_);
    EXPECT_EQ(entries(), 1u);
    EXPECT_TRUE(fs::exists(living.path()));
    ::close(ready[0]);
    ::close(ready[1]);
}

TEST_F(Files, FoldersOfOthersAndFilesOfUsersAreNotCollected) {
    fs::create_directory(folder_ / ".dgm-abcdef");  // may be entered by others: not one of ours
    fs::permissions(folder_ / ".dgm-abcdef", fs::perms(0755));
    std::ofstream(folder_ / ".dgm-ABCDEF") << "a file";
    fs::create_directory_symlink("/tmp", folder_ / ".dgm-123456");
    ::mkdir((folder_ / ".dgm-fresh1").c_str(), 0700);  // made a moment ago, its lock is yet to come
    remove_dead_staging_folders(folder_);
    EXPECT_EQ(entries(), 4u);
}

TEST_F(Files, OutputsAreReplacedWholeAndLinksStayLinks) {
    const fs::path file = folder_ / "report.json", link = folder_ / "link.json";
    std::ofstream(file) << "old";
    fs::create_symlink("report.json", link);
    const auto before = content(file);
    write_output(link, "new");
    EXPECT_EQ(before, "old");
    EXPECT_EQ(content(file), "new");
    EXPECT_TRUE(fs::is_symlink(link));
    write_output(folder_ / "fresh", "first");
    EXPECT_EQ(content(folder_ / "fresh"), "first");
    EXPECT_EQ(entries(), 3u);
    EXPECT_EQ(code_of([&] { write_output(folder_, "x"); }), codes::kWriteFailed.number);
    fs::create_symlink("loop", folder_ / "loop");
    EXPECT_EQ(code_of([&] { write_output(folder_ / "loop", "x"); }), codes::kWriteFailed.number);
    EXPECT_EQ(code_of([&] { check_output(folder_ / std::string(300, 'n')); }), codes::kWriteFailed.number);
}

TEST_F(Files, DevicesPipesAndDescriptorsAreWrittenThrough) {
    const fs::path pipe = folder_ / "pipe", null = folder_ / "null";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    write_output(pipe, "through");
    char text[16] = {};
    EXPECT_EQ(::read(reader, text, sizeof text), 7);
    EXPECT_EQ(std::string(text), "through");
    ::close(reader);
    fs::create_symlink("/dev/null", null);
    write_output(null, "x");
    EXPECT_TRUE(fs::is_character_file(fs::status("/dev/null")));
    EXPECT_TRUE(fs::is_symlink(null));
    EXPECT_EQ(code_of([&] { write_output("/dev/full", "x"); }), codes::kNoSpace.number);
    EXPECT_TRUE(fs::is_character_file(fs::status("/dev/full")));
    // A descriptor of a regular file: the file stays the one that is open, and keeps what was in it.
    const fs::path log = folder_ / "log";
    std::ofstream(log) << "before ";
    const int fd = ::open(log.c_str(), O_WRONLY);
    write_output("/dev/fd/" + std::to_string(fd), "after");
    struct stat open_file {
    }, named{};
    ASSERT_EQ(::fstat(fd, &open_file), 0);
    ASSERT_EQ(::stat(log.c_str(), &named), 0);
    EXPECT_EQ(open_file.st_ino, named.st_ino);
    EXPECT_EQ(content(log), "before after");
    ::close(fd);
}

TEST_F(Files, AnInputIsNoOutput) {
    const fs::path input = folder_ / "in", hard = folder_ / "hard", soft = folder_ / "soft";
    std::ofstream(input) << "x";
    fs::create_hard_link(input, hard);
    fs::create_symlink("in", soft);
    const std::vector<fs::path> inputs{input};
    for (const fs::path& output : {input, hard, soft, folder_ / "." / "in"})
        EXPECT_EQ(code_of([&] { refuse_input_as_output(output, inputs, "report"); }), codes::kUsage.number) << output;
    EXPECT_EQ(code_of([&] { refuse_input_as_output(folder_ / "out", inputs, "report"); }), 0);
    EXPECT_EQ(code_of([&] { refuse_input_as_output({}, inputs, "report"); }), 0);
}

TEST(Nesting, IsMeasuredInJson) {
    EXPECT_FALSE(too_deep_json(R"({"a": [[1, "[[[[\"[[["]]})", 3));
    const auto place = too_deep_json("[\n [[1]]]", 2);
    ASSERT_TRUE(place);
    EXPECT_EQ(place->line, 2u);
    EXPECT_EQ(place->column, 3u);
    EXPECT_TRUE(too_deep_json(std::string(100'000, '['), 64));
}

TEST(Nesting, IsMeasuredInToml) {
    EXPECT_FALSE(too_deep_toml("a.b = 1.5\n# ....\nc = \"....\"\nd = '....'\ne = '''..\n..'''\n[x.y]\n[[z]]\n", 3));
    EXPECT_FALSE(too_deep_toml("a = \"\"\"x\\\"\"\"\"\n....\n", 4)) << "behind the string there are four dots";
    EXPECT_TRUE(too_deep_toml("a = \"\"\"x\\\"\"\"\"\n.....\n", 4));
    EXPECT_TRUE(too_deep_toml("a = [[[[1]]]]", 3));
    const auto place = too_deep_toml("x = 1\na.a.a.a = 2", 2);
    ASSERT_TRUE(place);
    EXPECT_EQ(place->line, 2u);
    EXPECT_EQ(place->column, 6u);
    EXPECT_TRUE(too_deep_toml("\"a\" . 'b' . c . d = 1", 2));
}

TEST(Printable, KeepsTextAndShowsWhatSteersATerminal) {
    using model::printable;
    EXPECT_EQ(printable("Möbius 面.obj"), "Möbius 面.obj");
    EXPECT_EQ(printable("\x1b]0;x\x07"), "\\x1b]0;x\\x07");
    EXPECT_EQ(printable("a\nb\x7f"), "a\\x0ab\\x7f");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m"),
              "\\xc2\\x9b31m")
        << "a control character of two bytes";
    EXPECT_EQ(printable("\xff\xc3(\xe2\x82"), "\\xff\\xc3(\\xe2\\x82") << "no UTF-8";
    EXPECT_EQ(printable("\xc0\xaf\xed\xa0\x80"), "\\xc0\\xaf\\xed\\xa0\\x80") << "overlong, and a surrogate";
    EXPECT_EQ(printable("\xe2\x80\xae"
                        "gpj"),
              "\\xe2\\x80\\xaegpj")
        << "turns the direction of writing";
    EXPECT_EQ(model::printable_lines("a\x1b\nb\n"), "a\\x1b\nb\n");
}

}  // namespace
}  // namespace dgm::formats
