// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/nesting.h
// Bounds the nesting of a text before a library reads it: parsers and writers that call themselves once a level end the
// program when the stack does.
#pragma once
#include <cstddef>
#include <optional>
#include <string_view>

namespace dgm::formats {

/// Where a text is nested too deeply; both from 1, columns in bytes.
struct TextPlace {
    std::size_t line = 1, column = 1;
};

/// JSON: brackets and braces. Linear; other faults of the text are the parser's to find.
[[nodiscard]] std::optional<TextPlace> too_deep_json(std::string_view text, std::size_t max_depth);

/// TOML 1.0: brackets and braces, and the dots of a key or header, each on their own.
[[nodiscard]] std::optional<TextPlace> too_deep_toml(std::string_view text, std::size_t max_depth);

/// The depth that reports and scenes may have; those of ours have fewer than 12.
inline constexpr std::size_t kMostNesting = 64;

}  // namespace dgm::formats
