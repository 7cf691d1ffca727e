// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/words.cpp
#include "tool/words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace dgm::tool {

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j)
            diagonal =
                std::exchange(row[j + 1], std::min({row[j] + 1, row[j + 1] + 1, diagonal + (a[i] == b[j] ? 0 : 1)}));
    }
    return row.back();
}

std::string_view nearest(std::string_view word, const std::vector<std::string>& words) {
    constexpr std::size_t kLongest = 64;
    std::string_view best;
    std::size_t best_distance = 3;  // more than two slips is another word
    if (word.size() > kLongest) return best;
    for (const std::string& other : words) {
        const std::size_t distance = edit_distance(word, other);
        if (distance >= best_distance || distance >= std::max(word.size(), other.size())) continue;
        best = other;
        best_distance = distance;
    }
    return best;
}

std::string unknown_word(std::string_view what, std::string_view word, const std::vector<std::string>& words) {
    std::string message = fmt::format("there is no {} \"{}\"", what, word);
    if (const std::string_view meant = nearest(word, words); !meant.empty())
        message += fmt::format("; did you mean {}?", meant);
    return message + fmt::format("\nthere are: {}", fmt::join(words, ", "));
}

}  // namespace dgm::tool
