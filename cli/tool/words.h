// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/words.h
// Finds the word that was meant by a mistyped one.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::tool {

/// Edits (insert, delete, replace) from one word to the other [Levenshtein 1966].
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `words` that was meant by a mistyped one: at most two slips away. Empty if there is none.
[[nodiscard]] std::string_view nearest(std::string_view word, const std::vector<std::string>& words);

/// For a word that is not one of `words`: `there is no method "lcsm"; did you mean lscm?`, then a line with all of
/// them.
[[nodiscard]] std::string unknown_word(std::string_view what, std::string_view word,
                                       const std::vector<std::string>& words);

}  // namespace dgm::tool
