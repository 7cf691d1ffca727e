// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/hash.cpp
#include "dgm/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>
#include <vector>

#include "model/codes.h"
#include "model/file_errors.h"

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

Hash128 hash_file(const std::filesystem::path& path) {
    namespace codes = model::codes;
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw model::missing_file(path);
    if (!std::filesystem::is_regular_file(status)) throw model::no_regular_file(path);  // opening a pipe would wait
    std::ifstream file(path, std::ios::binary);
    if (!file) throw model::unreadable_file(path);
    Hasher hasher;
    std::vector<char> block(std::size_t{1} << 20);
    while (file) {
        file.read(block.data(), static_cast<std::streamsize>(block.size()));
        hasher.add(std::as_bytes(std::span(block)).first(static_cast<std::size_t>(file.gcount())));
    }
    if (!file.eof()) throw model::Error(codes::kReadFailed, "the file cannot be read to its end", path.string());
    return hasher.result();
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
