// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/h5_comparison.h
// Compares the objects that HDF5 sees in a file with the file's index.
#pragma once
#include <filesystem>

#include "dgm/file_index.h"
#include "dgm/finding_list.h"
#include "dgm/raw_file.h"

namespace dgm::formats {

/// Walks the groups, datasets and attributes of a file whose index is good; every difference and every object beside
/// those of the format is a finding. `part` gets the texts, the layers' attributes and the report.
void compare_with_hdf5(const std::filesystem::path& path, const RawFile& raw, const FileIndex& file,
                       FindingList& findings, Hdf5Part& part);

}  // namespace dgm::formats
