// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/file_index.h
// Reads header and records from a file's raw bytes and checks them, before HDF5 sees the file.
#pragma once
#include <optional>

#include <dgm/layout.h>

#include "dgm/dgm_reader.h"
#include "dgm/finding_list.h"
#include "dgm/index.h"
#include "dgm/raw_file.h"

namespace dgm::formats {

struct FileIndex {
    layout::FileHeader header{};
    Index index;
    /// The records follow the header in the user block; else they lie behind it, in the dataset /index.
    [[nodiscard]] bool in_user_block() const { return header.index_offset == sizeof header; }
};

/// The index of a file in which every layer lies where its record says and shares no bytes with another. The layers'
/// values are not checked.
/// @return nothing if the layers cannot be read; the reason is among the findings
[[nodiscard]] std::optional<FileIndex> read_file_index(const RawFile& raw, const DgmReadLimits& limits,
                                                       FindingList& findings);

}  // namespace dgm::formats
