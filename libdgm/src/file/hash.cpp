// SPDX-License-Identifier: MIT
// libdgm/src/file/hash.cpp
// The only place that sees xxHash: header only, inlined, so the library carries no dependency.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>

#include "file/asset_impl.h"

namespace dgm::detail {

Hash hash_bytes(const void* data, std::size_t bytes) noexcept {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(data, bytes));
    Hash hash;
    static_assert(sizeof(canonical.digest) == 16);
    std::memcpy(hash.data(), canonical.digest, 16);
    return hash;
}

}  // namespace dgm::detail
