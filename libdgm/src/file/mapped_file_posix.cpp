// SPDX-License-Identifier: MIT
// libdgm/src/file/mapped_file_posix.cpp
#include "file/mapped_file.h"

#if !defined(_WIN32) && !defined(__wasm__) && !defined(DGM_NO_FILES)

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <limits>

namespace dgm::detail {

Result<MappedFile> MappedFile::open(const char* path, std::uint64_t max_bytes) noexcept {
    // O_NONBLOCK: opening a pipe by mistake must return, not wait for a writer.
    const int file = ::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        if (errno == ENOENT || errno == ENOTDIR)
            return Error{ErrorCode::FileMissing, kNoOffset, "the file does not exist"};
        return Error{ErrorCode::ReadFailed, kNoOffset, "the file cannot be opened for reading"};
    }
    struct Closer {
        int file;
        ~Closer() { ::close(file); }
    } closer{file};
    struct stat status = {};
    if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size < 0)
        return Error{ErrorCode::ReadFailed, kNoOffset, "the path is not a regular file"};
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > max_bytes || size > std::numeric_limits<std::size_t>::max() / 2)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the file is longer than the limit allows"};
    MappedFile mapped;
    if (size == 0) return mapped;
    void* memory = ::mmap(nullptr, static_cast<std::size_t>(size), PROT_READ, MAP_PRIVATE, file, 0);
    if (memory == MAP_FAILED) return Error{ErrorCode::ReadFailed, kNoOffset, "the file cannot be mapped"};
    mapped.bytes_ = {static_cast<const std::byte*>(memory), static_cast<std::size_t>(size)};
    return mapped;
}

MappedFile::~MappedFile() {
    if (bytes_.data() != nullptr) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace dgm::detail

#endif
