// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/sandbox_test.cpp
// Ways out, tried from inside. On a system that lacks a part of the sandbox the tests that need it are skipped.
#include "process/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <map>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "model/codes.h"
#include "process/worker_io.h"
#include "support/no_descriptors.h"
#include "test_maps.h"

namespace dgm::bake {
namespace {

constexpr std::uint64_t kMostBytes = 1 << 16;
constexpr int kInside = 0, kOutside = 1, kShort = 2, kLacking = 77;

/// Exit code of a process that does `work`, or 128 and the signal that has ended it.
int end_of(const std::function<int()>& work) {
    const pid_t child = fork();
    if (child == 0) _exit(work());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Exit code of a process that has entered a sandbox with one readable folder and tries a way out: kInside if the try
/// failed with one of the errors of a refusal.
int after(const std::filesystem::path& readable, const std::function<bool()>& gets_out,
          const std::filesystem::path& writable = {}) {
    return end_of([&] {
        Sandbox sandbox{.readable = {readable}, .writable = {}, .starts_threads = !writable.empty()};
        if (!writable.empty()) sandbox.writable.push_back(writable);
        sandbox.file_bytes = writable.empty() ? 0 : kMostBytes;
        limit_worker_memory(std::uint64_t{2} << 30, 1);
        if (!enter_sandbox(sandbox).empty()) return kLacking;
        errno = 0;
        const bool out = gets_out();
        return out || (errno != EPERM && errno != EACCES) ? kOutside : kInside;
    });
}

TEST(Sandbox, RefusesEveryWayOut) {
    const test::TempFolder folder, other;
    test::write_bytes(folder / "mine", "x");
    test::write_bytes(other / "secret", "x");
    const std::string secret = (other / "secret").string(), mine = (folder / "mine").string();
    const std::string planted = (folder / "planted").string();
    const pid_t program = getpid();
    const std::vector<std::pair<const char*, std::function<bool()>>> tries = {
        {"socket", [] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }},
        {"unix socket", [] { return socket(AF_UNIX, SOCK_STREAM, 0) >= 0; }},
        {"another file", [&] { return open(secret.c_str(), O_RDONLY) >= 0; }},
        {"/etc/passwd", [] { return open("/etc/passwd", O_RDONLY) >= 0; }},
        {"/proc/self/environ", [] { return open("/proc/self/environ", O_RDONLY) >= 0; }},
        {"its file, to write", [&] { return open(mine.c_str(), O_RDWR) >= 0; }},
        {"its file, to cut", [&] { return open(mine.c_str(), O_RDONLY | O_TRUNC) >= 0; }},
        {"truncate", [&] { return truncate(mine.c_str(), 0) == 0; }},
        {"a new file", [&] { return open(planted.c_str(), O_WRONLY | O_CREAT, 0600) >= 0; }},
        {"a new name", [&] { return rename(mine.c_str(), planted.c_str()) == 0; }},
        {"a link", [&] { return symlink("/etc/passwd", planted.c_str()) == 0; }},
        {"no file any more", [&] { return unlink(mine.c_str()) == 0; }},
        {"other rights", [&] { return chmod(mine.c_str(), 0777) == 0; }},
        {"another process", [] { return fork() >= 0; }},
        {"another program", [] { return execl("/bin/true", "true", nullptr) == 0; }},
        {"ptrace", [&] { return ptrace(PTRACE_ATTACH, program, nullptr, nullptr) == 0; }},
        {"kill", [&] { return kill(program, 0) == 0; }},
        {"rights back", [] { return setuid(0) == 0; }},
        {"a namespace", [] { return syscall(SYS_unshare, 0x10000000) == 0; }},
        {"memory of others", [&] { return syscall(SYS_process_vm_readv, program, nullptr, 0, nullptr, 0, 0) >= 0; }},
        {"io_uring", [] { return syscall(SYS_io_uring_setup, 1, nullptr) >= 0; }},
        {"bpf", [] { return syscall(SYS_bpf, 0, nullptr, 0) >= 0; }},
        {"keys", [] { return syscall(SYS_keyctl, 0, -3, 0) >= 0; }},
    };
    for (const auto& [name, way] : tries) {
        const int end = after(folder.path(), way);
        if (end == kLacking) GTEST_SKIP() << "this system lacks a part of the sandbox";
        EXPECT_EQ(end, kInside) << name;
    }
    EXPECT_EQ(test::read_bytes(folder / "mine"), "x");
}

TEST(Sandbox, LeavesReadingAndMemory) {
    const test::TempFolder folder;
    test::write_bytes(folder / "mine", "x");
    const std::string mine = (folder / "mine").string();
    const int end = after(folder.path(), [&] {
        const int file = open(mine.c_str(), O_RDONLY);
        char byte = 0;
        void* block = std::malloc(std::size_t{64} << 20);
        const bool works = file >= 0 && read(file, &byte, 1) == 1 && byte == 'x' && block != nullptr;
        std::free(block);
        return works;
    });
    if (end == kLacking) GTEST_SKIP() << "this system lacks a part of the sandbox";
    EXPECT_EQ(end, kOutside);  // here: it worked
}

TEST(Sandbox, WritesIntoItsFoldersAlone) {
    const test::TempFolder mine, other;
    const std::string inside = (mine / "new").string(), outside = (other / "new").string();
    const auto makes = [](const std::string& path) {
        const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        return file >= 0 && write(file, "x", 1) == 1 && fsync(file) == 0;
    };
    const std::vector<std::pair<const char*, std::function<bool()>>> refused = {
        {"a file elsewhere", [&] { return makes(outside); }},
        {"a folder elsewhere", [&] { return mkdir(outside.c_str(), 0700) == 0; }},
        {"a device", [&] { return mknod((mine / "pipe").c_str(), S_IFIFO | 0600, 0) == 0; }},
        {"a process", [] { return fork() >= 0; }},
        {"a program", [] { return execl("/bin/true", "true", nullptr) == 0; }},
        {"a socket", [] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }},
    };
    for (const auto& [name, way] : refused) {
        const int end = after("/", way, mine.path());
        if (end == kLacking) GTEST_SKIP() << "this system lacks a part of the sandbox";
        EXPECT_EQ(end, kInside) << name;
    }
    EXPECT_EQ(
        after(
            "/",
            [&] {
                const std::string folder = (mine / "folder").string(), moved = (mine / "moved").string();
                bool works = makes(inside) && mkdir(folder.c_str(), 0700) == 0;
                works = works && rename(inside.c_str(), (folder + "/new").c_str()) == 0;  // from one folder to another
                works = works && rename((folder + "/new").c_str(), moved.c_str()) == 0 && rmdir(folder.c_str()) == 0;
                std::thread([&] { works = works && unlink(moved.c_str()) == 0; }).join();
                return works;
            },
            mine.path()),
        kOutside);  // here: all of it worked
}

TEST(Sandbox, AWorkerReadsWhatItsMeshMayNameAlone) {
    const test::TempFolder mine, library, other, out;
    for (const test::TempFolder* folder : {&mine, &library, &other}) test::write_bytes(*folder / "a", "x");
    std::filesystem::create_symlink(other / "a", mine / "link");
    const auto opens = [](const std::filesystem::path& path) {
        const int file = open(path.c_str(), O_RDONLY);
        return file >= 0;
    };
    const auto inside = [&](const std::filesystem::path& path) {
        return end_of([&] {
            const Sandbox sandbox = worker_sandbox(mine / "m.obj", {library.path()}, {out / "m.dgm"});
            if (!enter_sandbox(sandbox).empty()) return kLacking;
            return opens(path) ? kOutside : kInside;
        });
    };
    if (inside(mine / "a") == kLacking) GTEST_SKIP() << "this system lacks a part of the sandbox";
    EXPECT_EQ(inside(mine / "a"), kOutside);
    EXPECT_EQ(inside(library / "a"), kOutside);
    for (const std::filesystem::path& path :
         {other / "a", mine / "link", std::filesystem::path("/etc/passwd"), std::filesystem::path("/etc/shadow"),
          std::filesystem::path("/root"), std::filesystem::path("/home"), std::filesystem::path("/tmp"),
          std::filesystem::path("/proc/1/environ")})
        EXPECT_EQ(inside(path), kInside) << path;
}

TEST(Sandbox, FilesDoNotGrowWithoutEnd) {
    const test::TempFolder mine;
    const std::string path = (mine / "large").string();
    const int end = after(
        "/",
        [&] {
            const int file = open(path.c_str(), O_WRONLY | O_CREAT, 0600);
            const std::string block(kMostBytes, 'x');
            if (file < 0 || write(file, block.data(), block.size()) != static_cast<ssize_t>(kMostBytes)) return false;
            const bool refused = write(file, "x", 1) < 0 && errno == EFBIG;
            errno = EPERM;  // for after()
            return !refused;
        },
        mine.path());
    if (end == kLacking) GTEST_SKIP() << "this system lacks a part of the sandbox";
    EXPECT_EQ(end, kInside);
    EXPECT_EQ(std::filesystem::file_size(path), kMostBytes);
}

TEST(Sandbox, IsWholeOrEndsTheProcessWhereMemoryIsShort) {
#if defined(__SANITIZE_ADDRESS__)
    GTEST_SKIP() << "memory cannot be limited beside the sanitizer's";
#endif
    std::map<int, int> ends;
    for (std::size_t left = 4096; left <= 8 << 20; left += std::max<std::size_t>(4096, left / 8)) {
        const int end = end_of([&] {
            limit_worker_memory(left, 1);
            try {
                if (!enter_sandbox({.readable = {}, .writable = {}}).empty()) return kLacking;
            } catch (const std::bad_alloc&) { return kShort; }
            return socket(AF_INET, SOCK_STREAM, 0) >= 0 ? kOutside : kInside;
        });
        if (end == kLacking) GTEST_SKIP() << "this system lacks a part of the sandbox";
        ++ends[end];
    }
    EXPECT_EQ(ends.size(), 2U) << ::testing::PrintToString(ends);
    EXPECT_GT(ends[kInside], 0);
    EXPECT_GT(ends[kShort], 0);
}

// One that lacks a file of the mesh's folder would make another map of it, and one without Landlock is none.
TEST(Sandbox, IsWholeOrAnError) {
    if (!sandbox_lacks().empty()) GTEST_SKIP() << "this system lacks a part of the sandbox";
    const test::TempFolder folder;
    const int end = end_of([&] {
        const test::NoDescriptors none;
        try {
            static_cast<void>(enter_sandbox({.readable = {folder.path()}, .writable = {}}));
        } catch (const model::Error& error) {
            return error.code().number == model::codes::kSystemBusy.number ? kShort : kOutside;
        }
        return kInside;
    });
    EXPECT_EQ(end, kShort);
}

TEST(Sandbox, TimeEnds) {
    const int end = end_of([] {
        static_cast<void>(enter_sandbox({.readable = {}, .writable = {}, .cpu_seconds = 1}));
        for (;;) static_cast<void>(getpid());
        return 0;
    });
    EXPECT_EQ(end, 128 + SIGXCPU);
}

}  // namespace
}  // namespace dgm::bake
