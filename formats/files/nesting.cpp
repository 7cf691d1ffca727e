// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/nesting.cpp
#include "files/nesting.h"

#include <algorithm>

namespace dgm::formats {
namespace {

TextPlace place_of(std::string_view text, std::size_t at) {
    const std::string_view before = text.substr(0, at);
    const auto lines = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
    const std::size_t line_end = before.rfind('\n');
    return {lines + 1, line_end == std::string_view::npos ? at + 1 : at - line_end};
}

/// Behind the string that begins at `at`, in which a backslash escapes unless it is literal. One that has no end on its
/// line ends there: the parser refuses it at that place.
std::size_t behind_string(std::string_view text, std::size_t at) {
    const char quote = text[at];
    for (++at; at < text.size() && text[at] != quote && text[at] != '\n'; ++at)
        if (text[at] == '\\' && quote == '"') ++at;
    return std::min(at + 1, text.size());
}

/// Behind the string of several lines that begins at `at`; up to two quotes more may stand before its end.
std::size_t behind_long_string(std::string_view text, std::size_t at) {
    const char quote = text[at];
    const std::string_view end = text.substr(at, 3);
    for (at += 3; at < text.size() && text.substr(at, 3) != end; ++at)
        if (text[at] == '\\' && quote == '"') ++at;
    at = std::min(at + 3, text.size());
    for (int k = 0; k < 2 && at < text.size() && text[at] == quote; ++k) ++at;
    return at;
}

}  // namespace

std::optional<TextPlace> too_deep_json(std::string_view text, std::size_t max_depth) {
    std::size_t depth = 0;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '"') {
            // JSON strings have no line ends; one that has is refused by the parser there.
            at = behind_string(text, at) - 1;
        } else if (c == '[' || c == '{') {
            if (++depth > max_depth) return place_of(text, at);
        } else if ((c == ']' || c == '}') && depth > 0) {
            --depth;
        }
    }
    return std::nullopt;
}

std::optional<TextPlace> too_deep_toml(std::string_view text, std::size_t max_depth) {
    std::size_t depth = 0, dots = 0;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '"' || c == '\'') {
            const bool is_long = text.size() - at >= 3 && text[at + 1] == c && text[at + 2] == c;
            at = (is_long ? behind_long_string(text, at) : behind_string(text, at)) - 1;
        } else if (c == '#') {
            at = std::min(text.find('\n', at), text.size()) - 1;
        } else if (c == '.') {
            if (++dots > max_depth) return place_of(text, at);
        } else if (c == '=' || c == ',' || c == '\n') {
            dots = 0;
        } else if (c == '[' || c == '{') {
            dots = 0;
            if (++depth > max_depth) return place_of(text, at);
        } else if ((c == ']' || c == '}') && depth > 0) {
            dots = 0;
            --depth;
        }
    }
    return std::nullopt;
}

}  // namespace dgm::formats
