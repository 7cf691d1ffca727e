// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/output_file.cpp
#include "files/output_file.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <system_error>
#include <thread>

#include "files/atomic_file.h"
#include "files/staging_folder.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

constexpr const char* kOtherName = "choose another name, or move what has it";
constexpr int kMostLinks = 40;  // as the kernel
constexpr std::chrono::seconds kNoReader{10}, kNoProgress{60};

[[noreturn]] void fail(int error, const fs::path& path) {
    throw model::Error(write_failure(error), std::string("the file cannot be written: ") + std::strerror(error),
                       path.string());
}

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Links there stand for open descriptors: what they name may be gone, or have another name.
bool is_in_proc(const fs::path& path) {
    struct statfs where {};
    return ::statfs(folder_of(path).c_str(), &where) == 0 && where.f_type == PROC_SUPER_MAGIC;
}

/// An open descriptor, closed at the end of the block.
struct Open {
    int fd;
    ~Open() {
        if (fd >= 0) ::close(fd);
    }
};

/// All of `text`, waiting for a slow reader as long as it takes something.
void write_all(int fd, std::string_view text, const fs::path& path) {
    while (!text.empty()) {
        const ssize_t n = ::write(fd, text.data(), text.size());
        if (n > 0) {
            text.remove_prefix(static_cast<std::size_t>(n));
            continue;
        }
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && errno != EAGAIN) fail(errno, path);
        pollfd ready{fd, POLLOUT, 0};
        if (::poll(&ready, 1, static_cast<int>(std::chrono::milliseconds(kNoProgress).count())) == 0)
            throw model::Error(codes::kWriteFailed, "nobody takes what is written", path.string());
    }
}

int open_through(const fs::path& path) {
    const auto deadline = std::chrono::steady_clock::now() + kNoReader;
    for (;;) {
        const int fd = ::open(path.c_str(), O_WRONLY | O_APPEND | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
        if (fd >= 0) return fd;
        if (errno == EINTR) continue;
        if (errno != ENXIO || std::chrono::steady_clock::now() > deadline) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));  // a pipe whose reader is yet to come
    }
    if (errno == ENXIO) throw model::Error(codes::kWriteFailed, "a pipe that nobody reads", path.string());
    fail(errno, path);
}

void write_new_file(const fs::path& path, std::string_view text) {
    const StagingFolder staging(path);
    const fs::path temporary = staging.where("output");
    {
        const Open file{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666)};
        if (file.fd < 0) fail(errno, path);
        write_all(file.fd, text, path);
        if (::fsync(file.fd) != 0) fail(errno, path);
    }
    publish_file(temporary, path);
}

}  // namespace

Destination destination_of(const fs::path& path) {
    Destination out{path};
    const auto refuse = [&](const char* why) {
        throw model::Error(codes::kWriteFailed, why, path.string()).with_hint(kOtherName);
    };
    for (int links = 0;; ++links) {
        if (is_in_proc(out.path)) return {path, true};
        struct stat status {};
        if (::lstat(out.path.c_str(), &status) != 0) {
            if (errno == ENAMETOOLONG) refuse("the name is longer than the file system can have");
            return out;  // a new file, or a folder that shows when it is written to
        }
        if (S_ISREG(status.st_mode)) return out;
        if (S_ISDIR(status.st_mode)) refuse("the output's name is taken by a folder");
        if (S_ISSOCK(status.st_mode)) refuse("the output's name is taken by a socket");
        if (!S_ISLNK(status.st_mode)) return {path, true};
        if (links == kMostLinks) refuse("the output's name is a link that leads nowhere");
        std::error_code error;
        const fs::path target = fs::read_symlink(out.path, error);
        if (error) refuse("the output's name is a link that cannot be read");
        out.path = target.is_absolute() ? target : folder_of(out.path) / target;
    }
}

void write_output(const fs::path& path, std::string_view text) {
    const Destination to = destination_of(path);
    if (!to.is_through) return write_new_file(to.path, text);
    const Open file{open_through(to.path)};
    write_all(file.fd, text, path);
}

void check_output(const fs::path& path) {
    const Destination to = destination_of(path);
    if (!to.is_through) {
        const StagingFolder probe(to.path);
        return;
    }
    if (::access(to.path.c_str(), W_OK) != 0) fail(errno, path);
}

bool is_same_file(const fs::path& a, const fs::path& b) {
    std::error_code error;
    if (fs::equivalent(a, b, error)) return true;
    return fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

void refuse_input_as_output(const fs::path& output, std::span<const fs::path> inputs, std::string_view what) {
    if (output.empty()) return;
    std::error_code ignored;
    if (!fs::exists(output, ignored)) return;  // inputs are there
    for (const fs::path& input : inputs)
        if (!input.empty() && fs::is_regular_file(input, ignored) && fs::equivalent(output, input, ignored))
            throw model::Error(codes::kUsage, "the " + std::string(what) + " would overwrite an input",
                               output.string());
}

}  // namespace dgm::formats
