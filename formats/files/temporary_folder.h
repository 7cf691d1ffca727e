// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/temporary_folder.h
#pragma once
#include <filesystem>
#include <string_view>

namespace dgm::formats {

/// A new empty folder for the program's own use among the system's temporary files, removed with all that is in it.
class TemporaryFolder {
 public:
    /// @param program  its name begins with that
    /// @throws model::Error kWriteFailed
    explicit TemporaryFolder(std::string_view program);
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

}  // namespace dgm::formats
