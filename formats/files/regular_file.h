// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/regular_file.h
// Opens an input that may be anything: a pipe or a device is refused before it can make the program wait.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "model/error.h"

namespace dgm::formats {

/// Read-only descriptor of a regular file.
class RegularFile {
 public:
    /// Opens without waiting, and asks afterwards what was opened: nobody can exchange the file in between.
    /// @throws model::Error kFileMissing, kReadFailed (also for anything but a regular file), kIoTrouble
    explicit RegularFile(const std::filesystem::path& path);
    ~RegularFile();
    RegularFile(const RegularFile&) = delete;
    RegularFile& operator=(const RegularFile&) = delete;

    [[nodiscard]] std::uint64_t size() const { return size_; }
    /// One number a file, whatever names lead to it.
    [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> identity() const { return {device_, inode_}; }
    /// Fills as much of `block` as there is; less only at the end of the file. @throws model::Error with read_failure()
    [[nodiscard]] std::size_t read(std::span<std::byte> block);
    /// What is read next, counted from the front. False if the file cannot be read from there.
    [[nodiscard]] bool seek(std::uint64_t at);
    /// The rest of the file. Its size is looked at before any byte.
    /// @throws model::Error with read_failure(); kTooLarge beyond `max_bytes`
    [[nodiscard]] std::string read_text(std::uint64_t max_bytes);
    /// @throws model::Error kTooLarge if the file has more than `max_bytes`
    void check_size(std::uint64_t max_bytes) const;

 private:
    std::filesystem::path path_;
    int file_;
    std::uint64_t size_ = 0, device_ = 0, inode_ = 0;
};

/// All of a small file of text. @throws model::Error as RegularFile
[[nodiscard]] std::string read_small_file(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace dgm::formats
