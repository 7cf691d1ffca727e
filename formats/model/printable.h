// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/printable.h
// Text of strangers (file names, names and messages in files) made safe for a terminal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace dgm::model {

/// The bytes of the UTF-8 character at the start of `text` (not empty); 0 if they are none: a stray byte, an overlong
/// form, a surrogate, or a number beyond Unicode.
[[nodiscard]] inline std::size_t utf8_bytes(std::string_view text, std::uint32_t& character) {
    const auto byte = [&](std::size_t k) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[k])); };
    character = byte(0);
    if (character < 0x80) return 1;
    const std::size_t bytes = character >= 0xF0 ? 4 : character >= 0xE0 ? 3 : 2;
    if (character < 0xC2 || character > 0xF4 || text.size() < bytes) return 0;
    character &= 0x7FU >> bytes;
    for (std::size_t k = 1; k < bytes; ++k) {
        if ((byte(k) & 0xC0) != 0x80) return 0;
        character = character << 6 | (byte(k) & 0x3F);
    }
    constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = character >= 0xD800 && character < 0xE000;
    return character < kLeast[bytes] || character > 0x10FFFF || is_surrogate ? 0 : bytes;
}

/// `text` with control characters, those that change the direction of writing, and bytes that are no UTF-8 as \xNN:
/// file names and library messages must not steer the terminal. Everything else stays.
[[nodiscard]] inline std::string printable(std::string_view text) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string out;
    while (!text.empty()) {
        std::uint32_t c = 0;
        const std::size_t bytes = utf8_bytes(text, c);
        const bool is_control = c < 0x20 || (c >= 0x7F && c < 0xA0);
        const bool turns = (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069) || c == 0x2028 || c == 0x2029;
        const std::string_view whole = text.substr(0, bytes == 0 ? 1 : bytes);
        if (bytes == 0 || is_control || turns)
            for (const char byte : whole) {
                out += "\\x";
                out += kDigits[static_cast<unsigned char>(byte) >> 4];
                out += kDigits[static_cast<unsigned char>(byte) & 15];
            }
        else
            out += whole;
        text.remove_prefix(whole.size());
    }
    return out;
}

/// The same, but line ends stay.
[[nodiscard]] inline std::string printable_lines(std::string_view text) {
    std::string out;
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
        out += printable(text.substr(0, end)) + '\n';
        text.remove_prefix(end + 1);
    }
    return out + printable(text);
}

}  // namespace dgm::model
