// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/whole_file.h
// Bytes that are all there, written as a file in one go: where another program or thread cannot see it yet.
#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace dgm::formats {

/// Makes or replaces the file at `path`, or writes to the device there. Nothing is left of a file that cannot be
/// written whole.
/// @param place  what to call it in an error: the name that the file will get; empty: `path`
/// @throws model::Error with write_failure()
void write_whole_file(const std::filesystem::path& path, std::string_view bytes,
                      const std::filesystem::path& place = {});
inline void write_whole_file(const std::filesystem::path& path, std::span<const std::byte> bytes,
                             const std::filesystem::path& place = {}) {
    write_whole_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()), place);
}

}  // namespace dgm::formats
