// SPDX-License-Identifier: MIT
// libdgm/src/file/mapped_file.h
// A whole file, read-only, in the address space.
//
// mapped_file_posix.cpp, _win32.cpp and _none.cpp hold it. The preprocessor picks one of them, so that a build system
// of any kind may compile all of src/*.cpp. DGM_NO_FILES asks for the last one on any target.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/result.h>

namespace dgm::detail {

class MappedFile {
 public:
    MappedFile() noexcept = default;
    MappedFile(MappedFile&& other) noexcept : bytes_(other.bytes_) { other.bytes_ = {}; }
    MappedFile& operator=(MappedFile&&) = delete;
    ~MappedFile();

    /// @param path  as the system takes it; on Windows UTF-8
    /// @return FileMissing, ReadFailed (folders and devices too), LimitExceeded if longer than `max_bytes`, Unsupported
    ///         where there are no mapped files. An empty file maps to no bytes.
    [[nodiscard]] static Result<MappedFile> open(const char* path, std::uint64_t max_bytes) noexcept;
    [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
    std::span<const std::byte> bytes_;
};

}  // namespace dgm::detail
