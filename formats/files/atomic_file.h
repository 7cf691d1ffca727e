// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/atomic_file.h
// Putting a finished file in its place, so that a crash leaves the old file or the new one, never a part.
#pragma once
#include <filesystem>

namespace dgm::formats {

/// Makes the folders above `file` that are not there, as every option does that names an output. What cannot be made
/// shows when the file is written.
void make_folder_of(const std::filesystem::path& file);

/// fsync of the file's data and length. @throws model::Error with write_failure()
void sync_file(const std::filesystem::path& path);

/// fsync `temporary`, rename it to `final_path` (same file system), fsync the folder. On error `temporary` stays and
/// `final_path` is untouched. @throws model::Error with write_failure()
void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& final_path);

}  // namespace dgm::formats
