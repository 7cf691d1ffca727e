// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/hash.cpp
#include "dgm/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "files/regular_file.h"

namespace dgm::formats {
namespace {

Hash128 canonical(XXH128_hash_t hash) {
    XXH128_canonical_t bytes;
    XXH128_canonicalFromHash(&bytes, hash);
    Hash128 out;
    std::copy(std::begin(bytes.digest), std::end(bytes.digest), out.begin());
    return out;
}

}  // namespace

Hash128 hash_bytes(std::span<const std::byte> bytes) {
    return canonical(XXH3_128bits(bytes.data(), bytes.size()));
}

// XXH3_state_t asks for 64-byte alignment, which C++ gives to a member by itself.
struct Hasher::State {
    XXH3_state_t value;
};
Hasher::Hasher() : state_(std::make_unique<State>()) {
    XXH3_128bits_reset(&state_->value);
}
Hasher::~Hasher() = default;
void Hasher::add(std::span<const std::byte> bytes) {
    XXH3_128bits_update(&state_->value, bytes.data(), bytes.size());
}
Hash128 Hasher::result() const {
    return canonical(XXH3_128bits_digest(&state_->value));
}

Hash128 hash_file(RegularFile& file, std::uint64_t max_bytes) {
    file.check_size(max_bytes);
    Hasher hasher;
    std::vector<std::byte> block(std::size_t{1} << 20);
    for (std::size_t got = block.size(); got == block.size();) {
        got = file.read(block);
        hasher.add(std::span(block).first(got));
    }
    return hasher.result();
}

Hash128 hash_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
    RegularFile file(path);
    return hash_file(file, max_bytes);
}

std::string to_hex(const Hash128& hash) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string out;
    for (const std::uint8_t byte : hash) {
        out += kDigits[byte >> 4];
        out += kDigits[byte & 15];
    }
    return out;
}

}  // namespace dgm::formats
