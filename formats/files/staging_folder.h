// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/staging_folder.h
// A private folder beside the outputs in which files are completed before they are moved into place.
#pragma once
#include <filesystem>

#include "files/io_failure.h"

namespace dgm::formats {

/// Its name (".dgm-" and six random characters) cannot be foretold, and nobody but its owner may look or write into it:
/// whoever else may write to the folder around it can plant no link in the way of a file. A lock tells later programs
/// that it is in use. Folders whose program was killed are removed by the next program that makes one beside them.
class StagingFolder {
 public:
    /// @param output  one of the outputs: the folder is made beside it
    /// @param failed  what to say if it cannot be made, before the reason
    /// @throws model::Error with write_failure() and `output` as its place
    explicit StagingFolder(const std::filesystem::path& output, const char* failed = "the file cannot be written");
    StagingFolder(StagingFolder&& other) noexcept;
    StagingFolder& operator=(StagingFolder&& other) noexcept;
    /// Removes the folder and what is still in it.
    ~StagingFolder();

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    /// Where to write the file that will be called `name`.
    [[nodiscard]] std::filesystem::path where(const std::filesystem::path& name) const { return path_ / name; }

 private:
    std::filesystem::path path_;
    int folder_ = -1;  ///< kept open, since the destructor may find neither memory nor descriptors
    int lock_ = -1;
};

/// True for the lock of a staging folder, which is no output.
[[nodiscard]] bool is_staging_lock(const std::filesystem::path& file);

/// Removes the staging folders in `folder` that belong to this user and to no living program. Never throws.
void remove_dead_staging_folders(const std::filesystem::path& folder) noexcept;

}  // namespace dgm::formats
