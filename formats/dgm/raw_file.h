// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/raw_file.h
// A file as bytes at offsets, for the checks before HDF5 sees it.
#pragma once
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <vector>

#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {

/// Read-only file descriptor with range-checked reads.
class RawFile {
 public:
    explicit RawFile(const std::filesystem::path& path)
        : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
        const int error = errno;
        if (file_ < 0)
            throw error == ENOENT || error == ENOTDIR
                ? model::missing_file(path)
                : model::unreadable_file(path, std::generic_category().message(error));
        struct stat status {};
        if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
            ::close(file_);
            throw model::no_regular_file(path);
        }
        size_ = static_cast<std::uint64_t>(status.st_size);
    }
    ~RawFile() { ::close(file_); }
    RawFile(const RawFile&) = delete;
    RawFile& operator=(const RawFile&) = delete;

    [[nodiscard]] std::uint64_t size() const { return size_; }
    [[nodiscard]] bool contains(std::uint64_t offset, std::uint64_t bytes) const {
        return bytes <= size_ && offset <= size_ - bytes;
    }
    /// The range must be contained.
    [[nodiscard]] std::vector<std::byte> read(std::uint64_t offset, std::uint64_t bytes) const {
        std::vector<std::byte> out(bytes);
        std::size_t done = 0;
        while (done < bytes) {
            const ssize_t got = ::pread(file_, out.data() + done, bytes - done, static_cast<off_t>(offset + done));
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0)
                throw model::Error(
                    model::codes::kReadFailed,
                    got < 0 ? std::generic_category().message(errno) : "the file shrank while it was read",
                    path_.string());
            done += static_cast<std::size_t>(got);
        }
        return out;
    }

 private:
    const std::filesystem::path& path_;
    int file_;
    std::uint64_t size_ = 0;
};

}  // namespace dgm::formats
