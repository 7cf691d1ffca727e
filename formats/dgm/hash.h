// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/hash.h
// XXH3-128 as the format uses it: seed 0, canonical (big-endian) byte order.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

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

/// @throws model::Error kFileMissing, kReadFailed
[[nodiscard]] Hash128 hash_file(const std::filesystem::path& path);
/// 32 lower-case hexadecimal digits.
[[nodiscard]] std::string to_hex(const Hash128& hash);

}  // namespace dgm::formats
