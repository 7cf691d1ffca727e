// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_text.cpp
// [RFC 4648] Josefsson. The Base16, Base32, and Base64 Data Encodings. 2006.
#include "exr/exr_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <type_traits>
#include <utility>

namespace dgm::formats {
namespace {

using layout::ElementType;

constexpr std::array<std::string_view, 7> kTypeNames{"", "u8", "u16", "u32", "i16", "f16", "f32"};
constexpr std::string_view kBase64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

template <class Number>
bool parse_number(std::string_view word, Number& value) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
}

std::vector<std::string_view> split(std::string_view text) {
    std::vector<std::string_view> out;
    while (!text.empty()) {
        const std::size_t space = std::min(text.find(' '), text.size());
        out.push_back(text.substr(0, space));
        text.remove_prefix(std::min(space + 1, text.size()));
    }
    return out;
}

template <class Number>
void append_numbers(std::string& out, const std::vector<Number>& numbers) {
    char digits[32];
    for (const Number number : numbers) {
        const auto [end, error] = std::to_chars(digits, digits + sizeof digits, number);
        (void)error;
        out.append(" ").append(digits, end);
    }
}

}  // namespace

std::string manifest_line(const LayerEntry& entry) {
    std::string out = entry.name;
    out.append(" ").append(kTypeNames[static_cast<std::size_t>(entry.type)]);
    out.append(entry.required ? " required" : " optional");
    append_numbers(out, entry.shape);
    return out;
}

std::optional<LayerEntry> parse_manifest_line(std::string_view line) {
    const std::vector<std::string_view> words = split(line);
    if (words.size() < 4 || words.size() > 3 + layout::kMaxRank || words[0].empty()) return std::nullopt;
    const auto type = std::find(kTypeNames.begin() + 1, kTypeNames.end(), words[1]);
    if (type == kTypeNames.end() || (words[2] != "required" && words[2] != "optional")) return std::nullopt;
    LayerEntry entry;
    entry.name = words[0];
    entry.type = static_cast<ElementType>(type - kTypeNames.begin());
    entry.required = words[2] == "required";
    for (std::size_t k = 3; k < words.size(); ++k)
        if (!parse_number(words[k], entry.shape.emplace_back())) return std::nullopt;
    return entry;
}

std::string attribute_text(const model::AttributeValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return "text " + *text;
    std::string out;
    if (const auto* doubles = std::get_if<std::vector<double>>(&value)) {
        out = "f64";
        append_numbers(out, *doubles);
    } else {
        out = "u32";
        append_numbers(out, std::get<std::vector<std::uint32_t>>(value));
    }
    return out;
}

std::optional<model::AttributeValue> parse_attribute_text(std::string_view text) {
    if (text.starts_with("text ")) return std::string(text.substr(5));
    const std::vector<std::string_view> words = split(text);
    if (words.empty()) return std::nullopt;
    const auto parse_all = [&](auto& numbers) {
        for (std::size_t k = 1; k < words.size(); ++k)
            if (!parse_number(words[k], numbers.emplace_back())) return false;
        return true;
    };
    if (words[0] == "f64") {
        std::vector<double> numbers;
        if (parse_all(numbers)) return numbers;
    } else if (words[0] == "u32") {
        std::vector<std::uint32_t> numbers;
        if (parse_all(numbers)) return numbers;
    }
    return std::nullopt;
}

std::string hex_of(std::span<const std::uint8_t> bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string out;
    for (const std::uint8_t byte : bytes) {
        out += kDigits[byte >> 4];
        out += kDigits[byte & 15];
    }
    return out;
}

bool parse_hex(std::string_view text, std::span<std::uint8_t> bytes) {
    if (text.size() != 2 * bytes.size()) return false;
    for (std::size_t k = 0; k < bytes.size(); ++k) {
        const char* begin = text.data() + 2 * k;
        const auto [end, error] = std::from_chars(begin, begin + 2, bytes[k], 16);
        if (error != std::errc() || end != begin + 2) return false;
    }
    return true;
}

std::string base64_of(std::span<const std::byte> bytes) {
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t k = 0; k < bytes.size(); k += 3) {
        std::uint32_t bits = 0;
        for (std::size_t b = 0; b < 3; ++b)
            bits = bits << 8 | (k + b < bytes.size() ? std::to_integer<std::uint32_t>(bytes[k + b]) : 0);
        for (std::size_t digit = 0; digit < 4; ++digit)
            out += k + digit > bytes.size() ? '=' : kBase64[bits >> (18 - 6 * digit) & 63];
    }
    return out;
}

std::optional<std::vector<std::byte>> parse_base64(std::string_view text) {
    if (text.size() % 4 != 0) return std::nullopt;
    std::size_t padding = 0;
    while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
    std::vector<std::byte> out;
    out.reserve(text.size() / 4 * 3);
    std::array<std::uint32_t, 256> values{};
    for (std::uint32_t k = 0; k < kBase64.size(); ++k) values[static_cast<unsigned char>(kBase64[k])] = k + 1;
    for (std::size_t k = 0; k < text.size(); k += 4) {
        std::uint32_t bits = 0;
        for (std::size_t digit = 0; digit < 4; ++digit) {
            const std::uint32_t value = values[static_cast<unsigned char>(text[k + digit])];
            if (value == 0 && k + digit < text.size() - padding) return std::nullopt;
            bits = bits << 6 | (value == 0 ? 0 : value - 1);
        }
        for (std::size_t b = 0; b < 3; ++b) out.push_back(static_cast<std::byte>(bits >> (16 - 8 * b) & 255));
    }
    for (std::size_t k = 0; k < padding; ++k) {
        if (out.back() != std::byte{0}) return std::nullopt;
        out.pop_back();
    }
    return out;
}

std::vector<std::string_view> lines_of(std::string_view text) {
    std::vector<std::string_view> out;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        out.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return out;
}

}  // namespace dgm::formats
