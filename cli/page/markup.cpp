// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/markup.cpp
#include "page/markup.h"

#include <zlib.h>

#include <array>
#include <cstdint>
#include <new>

#include "model/entities.h"

namespace dgm::page {
namespace {
/// Length of the UTF-8 character that `text` begins with; 0 if it is none.
std::size_t character_length(std::string_view text) {
    const auto at = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned char first = at(0);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
    for (std::size_t k = 1; k < length; ++k)
        if ((at(k) & 0xc0) != 0x80) return 0;
    // Longer forms than needed, surrogates, and what is beyond U+10FFFF.
    const bool wrong = (first == 0xe0 && at(1) < 0xa0) || (first == 0xed && at(1) > 0x9f) ||
                       (first == 0xf0 && at(1) < 0x90) || (first == 0xf4 && at(1) > 0x8f);
    return wrong ? 0 : length;
}
}  // namespace

std::string base64(std::span<const std::byte> bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t k = 0; k < bytes.size(); k += 3) {
        std::uint32_t group = 0;
        for (std::size_t b = 0; b < 3; ++b)
            group = group << 8 | (k + b < bytes.size() ? std::to_integer<std::uint32_t>(bytes[k + b]) : 0);
        for (std::size_t d = 0; d < 4; ++d) out += k + d > bytes.size() ? '=' : kDigits[group >> (18 - 6 * d) & 63];
    }
    return out;
}

std::string deflated(std::span<const std::byte> bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string out(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                  static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) != Z_OK)
        throw std::bad_alloc();
    out.resize(size);
    return out;
}

std::string attribute_text(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const std::size_t length = character_length(text);
        const char c = text[0];
        if (length == 0 || static_cast<unsigned char>(c) < 0x20 || c == '\x7f')
            out += '?';
        else if (const std::string_view entity = model::entity_of(c); !entity.empty())
            out += entity;
        else
            out += text.substr(0, length);
        text.remove_prefix(length == 0 ? 1 : length);
    }
    return out;
}

}  // namespace dgm::page
