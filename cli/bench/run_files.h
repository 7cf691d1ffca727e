// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_files.h
// The forms in which a run leaves the program.
#pragma once
#include <string>
#include <string_view>

#include "bench/table.h"

namespace dgm::bench {

/// Indented JSON with every setting, machine fact and figure; numbers that are not finite are null. Figures that have a
/// spread are objects {median, low, high, n}.
[[nodiscard]] std::string to_json(const Run& run);

/// The inverse of to_json, but for plots, findings and comparison.
/// @throws model::Error kUsage if `text` is not such a file
[[nodiscard]] Run run_from_json(std::string_view text);

/// RFC 4180. A column with a spread becomes four: KEY, KEY_low, KEY_high, KEY_n.
[[nodiscard]] std::string to_csv(const Table& table);

/// Machine facts and settings: kind, name, value.
[[nodiscard]] std::string facts_csv(const Run& run);

/// One page that needs nothing else: plots, sortable tables, light and dark.
[[nodiscard]] std::string to_html(const Run& run);

}  // namespace dgm::bench
