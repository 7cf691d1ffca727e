// SPDX-License-Identifier: MIT
// libdgm/src/mapped_file.h
// A whole file, read-only, in the address space.
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

    /// @return FileMissing, ReadFailed (a folder too), LimitExceeded if longer than `max_bytes`. An empty file maps to
    ///         no bytes.
    [[nodiscard]] static Result<MappedFile> open(const char* path, std::uint64_t max_bytes) noexcept;
    [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
    std::span<const std::byte> bytes_;
};

}  // namespace dgm::detail
