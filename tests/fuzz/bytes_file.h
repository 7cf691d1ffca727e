// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/bytes_file.h
// Bytes as a file with a path, in memory: what readers that take paths are fuzzed with.
#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "target.h"

namespace dgm::test {

class BytesFile {
 public:
    BytesFile(const std::uint8_t* data, std::size_t size) : fd_(memfd_create("fuzz", MFD_CLOEXEC)) {
        require(fd_ >= 0);
        while (size > 0) {
            const ssize_t n = write(fd_, data, size);
            require(n > 0);
            data += n;
            size -= static_cast<std::size_t>(n);
        }
    }
    ~BytesFile() { close(fd_); }
    BytesFile(const BytesFile&) = delete;
    BytesFile& operator=(const BytesFile&) = delete;
    [[nodiscard]] std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
    int fd_;
};

}  // namespace dgm::test
