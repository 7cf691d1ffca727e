// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/repair_counts.h
// Counts the changes of a repair, by kind, in the order of its steps.
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dgm::bake {

using RepairCounts = std::vector<std::pair<std::string, std::uint64_t>>;

/// Adds `n` to the entry `what`; zeros make no entry.
inline void add_count(RepairCounts& counts, std::string_view what, std::uint64_t n) {
    if (n == 0) return;
    const auto entry = std::find_if(counts.begin(), counts.end(), [&](const auto& e) { return e.first == what; });
    if (entry == counts.end()) {
        counts.emplace_back(what, n);
    } else {
        entry->second += n;
    }
}

}  // namespace dgm::bake
