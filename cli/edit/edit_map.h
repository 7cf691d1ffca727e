// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_map.h
// The whole of an edit: read, compare, check, write.
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace dgm::edit {

struct EditOptions {
    std::filesystem::path map;        ///< the .dgm
    std::filesystem::path source;     ///< what was painted; empty: repair
    std::filesystem::path output;     ///< empty: in place of `map`
    std::vector<std::string> layers;  ///< only these parts; none: all
    bool repair = false;              ///< trust the layers of `map` whose hash does not fit
    bool dry_run = false;             ///< write nothing
};

struct EditOutcome {
    std::string lines;  ///< edit_lines()
    bool is_changed = false;
    bool is_written = false;  ///< in place, an edit that changes nothing leaves the file as it is
};

/// The file is written aside, read back, compared and renamed, as a bake's; an edit that changes nothing gives the
/// map's own bytes. Same map and edit, same bytes. Not thread-safe: HDF5.
/// @throws model::Error as the readers; kEditForbidden, kEditUnrelated, kNotFinite, kBadValue; what check_result finds;
///         kWriteFailed, kNoSpace, kIoTrouble. No file has changed then.
[[nodiscard]] EditOutcome edit_map(const EditOptions& options);

}  // namespace dgm::edit
