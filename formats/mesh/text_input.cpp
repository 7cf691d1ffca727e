// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/text_input.cpp
#include "mesh/text_input.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "files/regular_file.h"

namespace dgm::formats {
namespace {

constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\0';
}

void append_utf8(std::string& out, std::uint32_t code_point) {
    if (code_point < 0x80) {
        out += static_cast<char>(code_point);
    } else if (code_point < 0x800) {
        out += static_cast<char>(0xC0 | (code_point >> 6));
        out += static_cast<char>(0x80 | (code_point & 0x3F));
    } else if (code_point < 0x10000) {
        out += static_cast<char>(0xE0 | (code_point >> 12));
        out += static_cast<char>(0x80 | ((code_point >> 6) & 0x3F));
        out += static_cast<char>(0x80 | (code_point & 0x3F));
    } else {
        out += static_cast<char>(0xF0 | (code_point >> 18));
        out += static_cast<char>(0x80 | ((code_point >> 12) & 0x3F));
        out += static_cast<char>(0x80 | ((code_point >> 6) & 0x3F));
        out += static_cast<char>(0x80 | (code_point & 0x3F));
    }
}

std::string utf8_of_utf16(std::string_view bytes, bool big_endian) {
    const auto unit = [&](std::size_t k) -> std::uint32_t {
        const auto first = static_cast<unsigned char>(bytes[2 * k]),
                   second = static_cast<unsigned char>(bytes[2 * k + 1]);
        return big_endian ? (first << 8 | second) : (second << 8 | first);
    };
    constexpr std::uint32_t kReplacement = 0xFFFD;
    std::string out;
    out.reserve(bytes.size() / 2);
    const std::size_t units = bytes.size() / 2;
    for (std::size_t k = 0; k < units; ++k) {
        const std::uint32_t u = unit(k);
        if (u < 0xD800 || u > 0xDFFF) {
            append_utf8(out, u);
        } else if (u < 0xDC00 && k + 1 < units && unit(k + 1) >= 0xDC00 && unit(k + 1) <= 0xDFFF) {
            append_utf8(out, 0x10000 + ((u - 0xD800) << 10) + (unit(k + 1) - 0xDC00));
            ++k;
        } else {
            append_utf8(out, kReplacement);
        }
    }
    return out;
}

/// Decimal exponent of the leading digit of an out-of-range number: separates overflow from underflow.
double out_of_range_value(std::string_view word) {
    const bool negative = !word.empty() && word.front() == '-';
    std::int64_t exponent = 0;
    const std::size_t e = word.find_first_of("eE");
    if (e != std::string_view::npos) {
        std::string_view digits = word.substr(e + 1);
        if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
        if (error == std::errc::result_out_of_range)
            exponent = digits.front() == '-' ? std::numeric_limits<std::int32_t>::min()
                                             : std::numeric_limits<std::int32_t>::max();
    }
    // Position of the first digit that is not 0, counted from the point: 12.3 -> +2, 0.012 -> -1.
    const std::string_view mantissa = word.substr(0, e);
    const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
    const std::size_t first = mantissa.find_first_of("123456789");
    if (first == std::string_view::npos) return negative ? -0.0 : 0.0;
    const auto place = static_cast<std::int64_t>(point) - static_cast<std::int64_t>(first);
    const double magnitude =
        (exponent > 0 ? place > -exponent : place + exponent > 0) ? std::numeric_limits<double>::infinity() : 0.0;
    return negative ? -magnitude : magnitude;
}

std::optional<double> parse_plain(std::string_view word) {
    if (!word.empty() && word.front() == '+') {
        word.remove_prefix(1);
        if (!word.empty() && (word.front() == '-' || word.front() == '+')) return std::nullopt;
    }
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::invalid_argument) return std::nullopt;
    const std::string_view tail(end, static_cast<std::size_t>(word.data() + word.size() - end));
    if (!tail.empty()) {
        // MSVC before 2015 prints 1.#INF, -1.#IND, 1.#QNAN.
        if (!tail.starts_with('#')) return std::nullopt;
        const std::string kind = lower_case(tail.substr(1));
        if (kind.starts_with("inf")) return std::copysign(std::numeric_limits<double>::infinity(), value);
        return std::numeric_limits<double>::quiet_NaN();
    }
    return error == std::errc::result_out_of_range ? out_of_range_value(word) : value;
}

}  // namespace

std::string read_text_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
    std::string text = RegularFile(path).read_text(max_bytes);
    const std::string_view view = text;
    if (view.starts_with("\xEF\xBB\xBF")) return text.substr(3);
    if (view.starts_with("\xFF\xFE")) return utf8_of_utf16(view.substr(2), false);
    if (view.starts_with("\xFE\xFF")) return utf8_of_utf16(view.substr(2), true);
    return text;
}

std::string_view LineReader::physical_line() {
    std::size_t end = 0;
    while (end < rest_.size() && rest_[end] != '\n' && rest_[end] != '\r') ++end;
    const std::string_view line = rest_.substr(0, end);
    if (end < rest_.size()) end += rest_[end] == '\r' && end + 1 < rest_.size() && rest_[end + 1] == '\n' ? 2 : 1;
    rest_.remove_prefix(end);
    ++physical_;
    return line;
}

bool LineReader::next(std::string_view& line) {
    if (rest_.empty()) return false;
    line = physical_line();
    number_ = physical_;
    // Comments are left alone: "# from C:\models\" must not swallow the next line.
    if (!line.ends_with('\\') || trim(line).starts_with('#')) return true;
    joined_.clear();
    while (line.ends_with('\\')) {
        joined_.append(line.substr(0, line.size() - 1)).append(" ");
        if (rest_.empty()) {
            line = {};
            break;
        }
        line = physical_line();
    }
    joined_.append(line);
    line = joined_;
    return true;
}

std::string_view next_word(std::string_view& rest) {
    std::size_t begin = 0;
    while (begin < rest.size() && is_blank(rest[begin])) ++begin;
    std::size_t end = begin;
    while (end < rest.size() && !is_blank(rest[end])) ++end;
    const std::string_view word = rest.substr(begin, end - begin);
    rest.remove_prefix(end);
    return word;
}

std::string_view trim(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string lower_case(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

std::optional<double> parse_number(std::string_view word) {
    if (const auto value = parse_plain(word)) return value;
    const std::size_t comma = word.find(',');
    if (comma == std::string_view::npos || word.find(',', comma + 1) != std::string_view::npos) return std::nullopt;
    std::string pointed(word);
    pointed[comma] = '.';
    return parse_plain(pointed);
}

}  // namespace dgm::formats
