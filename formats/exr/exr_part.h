// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_part.h
// Reads the pixels of one part into the layers that it holds.
#pragma once
#include <ImfMultiPartInputFile.h>

#include <filesystem>
#include <string>
#include <vector>

#include "model/map_set.h"

namespace dgm::formats {

/// A part by the name that the layers' list gives it.
struct ExrPart {
    int number = 0;
    std::string name;
    bool is_grid = false;  ///< it holds all layers with a number for each sample of a chart's grid
};

/// Fills the bytes of `layers`, which have their types, shapes and sizes already.
/// @throws model::Error kMissingChannel if the part has another size or lacks a channel; kExrUnreadable, at `path`, if
///         a channel holds a number that its layer's type cannot
void read_exr_part(Imf::MultiPartInputFile& file, const ExrPart& part, const std::vector<model::Layer*>& layers,
                   const std::filesystem::path& path);

}  // namespace dgm::formats
