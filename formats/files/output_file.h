// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/output_file.h
// Reports, tables and whatever else a program writes at a name that the user gave: the one way to put it there.
#pragma once
#include <filesystem>
#include <span>
#include <string_view>

#include "model/error.h"

namespace dgm::formats {

/// What stands behind a name for an output.
struct Destination {
    std::filesystem::path path;  ///< links followed: the file that is replaced
    bool is_through = false;     ///< a device, pipe or open descriptor: written to, never replaced
};

/// Links are followed, so that a link stays one and its target is replaced. What leads to a device, a pipe or a
/// descriptor (/dev/stdout, /dev/fd/3, /dev/null) is written through.
/// @throws model::Error kWriteFailed for a folder, a socket, a loop of links, or a name that the file system cannot
///         have
[[nodiscard]] Destination destination_of(const std::filesystem::path& path);

/// Writes `text` to `path`. A regular file is the old one or the new one at any time, whatever happens; anything else
/// is written to as it is. A pipe that nobody reads is an error after some seconds.
/// @throws model::Error kWriteFailed; kNoSpace or kIoTrouble where that is why
void write_output(const std::filesystem::path& path, std::string_view text);

/// Finds out before minutes of work whether write_output() can put a file at `path`. Leaves nothing behind.
/// @throws model::Error as write_output()
void check_output(const std::filesystem::path& path);

/// True if both names lead to one file that is there, by whatever links, or would be the same file.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// @param what  "report", as in "the report would overwrite an input"; an empty `output` is none
/// @throws model::Error kUsage if `output` is one of `inputs`
void refuse_input_as_output(const std::filesystem::path& output, std::span<const std::filesystem::path> inputs,
                            std::string_view what);

}  // namespace dgm::formats
