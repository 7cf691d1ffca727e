// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/hash.h
// XXH3-128 as the format uses it: seed 0, canonical (big-endian) byte order.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "files/regular_file.h"

namespace dgm::formats {

using Hash128 = std::array<std::uint8_t, 16>;

[[nodiscard]] Hash128 hash_bytes(std::span<const std::byte> bytes);

/// The hash of pieces put one behind the other.
class Hasher {
 public:
    Hasher();
    ~Hasher();
    Hasher(const Hasher&) = delete;
    Hasher& operator=(const Hasher&) = delete;
    void add(std::span<const std::byte> bytes);
    [[nodiscard]] Hash128 result() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Of a whole file. Its size is looked at before any byte.
/// @throws model::Error kFileMissing, kReadFailed (also for anything but a regular file); kTooLarge beyond `max_bytes`
[[nodiscard]] Hash128 hash_file(const std::filesystem::path& path,
                                std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max());
/// The rest of `file`, likewise.
[[nodiscard]] Hash128 hash_file(RegularFile& file, std::uint64_t max_bytes);
/// 32 lower-case hexadecimal digits.
[[nodiscard]] std::string to_hex(const Hash128& hash);

}  // namespace dgm::formats
