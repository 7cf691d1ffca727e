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

/// The same failure with the reason that writing `bytes` to `temporary` meets, where that passes
/// (formats::write_failure). The
/// file is of no use afterwards.
[[nodiscard]] model::Error explained(const model::Error& error, const std::filesystem::path& temporary,
                                     std::uint64_t bytes = 0);

/// Moves a finished file to its place, and with an EXR the files of layers that were written beside it; those of an
/// older EXR there that are not replaced are removed. The file itself is moved last.
/// @throws model::Error kWriteFailed
void publish_output(const std::filesystem::path& temporary, const std::filesystem::path& final_path);

/// The size of a file, and with an EXR those of the files of layers beside it. `error` as std::filesystem::file_size.
[[nodiscard]] std::uintmax_t output_bytes(const std::filesystem::path& path, bool is_exr, std::error_code& error);

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

/// Finds out before minutes of baking whether a file can be called `final_path`: it is a file or nothing now, and no
/// name is longer than the file system can have.
/// @throws model::Error kWriteFailed
void check_place(const std::filesystem::path& final_path);

}  // namespace dgm::bake
