// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/output_files.h
// Outputs are written aside, read back, and only then renamed: a failed bake leaves the old file or none.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "baking/bake_options.h"
#include "model/error.h"
#include "model/map_set.h"

namespace dgm::bake {

enum class OutputFormat { kDgm, kExr };

/// Writes `maps` to `path`, reads the file back and compares every layer to the bit.
/// @throws model::Error kWriteFailed; kNoSpace or kIoTrouble where that is why; kInternal if the file reads back
///         differently; what the writers and readers throw
void write_verified(const std::filesystem::path& path, const model::MapSet& maps, OutputFormat format,
                    ExrLayout exr_layout);

/// kNoSpace for a full disk or quota, kIoTrouble for a disk or network that failed for the moment, else kWriteFailed.
[[nodiscard]] const model::Code& write_failure(int error_number);

/// The same failure with the reason that writing `bytes` to `temporary` meets, where that passes (write_failure). The
/// file is of no use afterwards.
[[nodiscard]] model::Error explained(const model::Error& error, const std::filesystem::path& temporary,
                                     std::uint64_t bytes = 0);

/// `.NAME.<pid>.tmp` beside `final_path`, so that the rename stays within one file system.
[[nodiscard]] std::filesystem::path temporary_for(const std::filesystem::path& final_path);

/// Moves a finished file to its place, and with an EXR the files of layers that were written beside it; those of an
/// older EXR there that are not replaced are removed. The file itself is moved last.
/// @throws model::Error kWriteFailed
void publish_output(const std::filesystem::path& temporary, const std::filesystem::path& final_path);

/// The size of a file, and with an EXR those of the files of layers beside it. `error` as std::filesystem::file_size.
[[nodiscard]] std::uintmax_t output_bytes(const std::filesystem::path& path, bool is_exr, std::error_code& error);

/// Removes a temporary file and what was written beside it.
void remove_output(const std::filesystem::path& temporary) noexcept;

/// The folders made for outputs; those still empty are removed with it, so that a batch in which nothing was baked
/// leaves nothing behind.
class OutputFolders {
 public:
    /// `shared`: other programs bake into the same folders, which must not go away under them.
    explicit OutputFolders(bool shared = false) : shared_(shared) {}
    OutputFolders(const OutputFolders&) = delete;
    OutputFolders& operator=(const OutputFolders&) = delete;
    ~OutputFolders();

    /// Makes `folder`, and those above it, unless they are there.
    /// @throws model::Error kWriteFailed
    void make(const std::filesystem::path& folder);
    /// Makes the folders between `root` and `file`.
    void make_below(const std::filesystem::path& root, const std::filesystem::path& file);

 private:
    bool shared_;
    std::vector<std::filesystem::path> made_;
};

/// Writes `text` to `path`, which is the old file or the new one at any time.
/// @throws model::Error kWriteFailed; kNoSpace or kIoTrouble where that is why
void write_whole(const std::filesystem::path& path, const std::string& text);

/// Finds out before minutes of baking whether `final_path` can be put in place: it is not a folder, and a file can be
/// created beside it. Leaves nothing behind.
/// @throws model::Error kWriteFailed
void check_writable(const std::filesystem::path& final_path);

}  // namespace dgm::bake
