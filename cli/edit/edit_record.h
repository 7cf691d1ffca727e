// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_record.h
// Says what an edit did: in the file, and to people.
#pragma once
#include <filesystem>
#include <string>

#include "edit/painted_map.h"

namespace dgm::edit {

/// Adds a row to `edits` in the map's report for each part that was changed: its name, how many samples, and the name
/// and hash of the file that they came from. What the report claims of shading with bump is taken back if that was
/// changed. A report that is no JSON object stays as it is. No dates, so that the same edit gives the same bytes.
/// @throws model::Error kReadFailed if a source cannot be read any more; kBadReport for one nested too deeply
void record_edits(PaintedMap& map);

/// A line for each part that was looked at: "stiffness: 412 of 1089 samples changed, by at most 0.75; ...". Parts that
/// may not be edited, and were not, are left out.
[[nodiscard]] std::string edit_lines(const PaintedMap& map);

/// Checks the result as dgm-validate does. @throws model::Error the first finding that the map did not have before
void check_result(const PaintedMap& map);

}  // namespace dgm::edit
