// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/plain_maps.h
// Layers as pictures for engines: one file a layer, all of one size, and a JSON that says what the pixels are.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "model/map_set.h"

namespace dgm::exporter {

struct PlainMapOptions {
    std::optional<std::uint32_t> chart;  ///< only this one; default all
    bool power_of_two = false;           ///< each side is raised to the next power of two
};

/// Writes STEM_<map>.exr and .png, with several charts STEM_chart<k>_<map>, and STEM_maps.json into `folder`, which is
/// made if it is not there. docs/plain-maps.md describes the files.
///
/// Maps have the grid's size, cols x rows, pixel (x, y) being sample (y, x): no other window, no margin. A texture or
/// bump of another resolution is written in the grid's size and, as STEM_texture_full.png and STEM_bump_full.exr, in
/// its own.
///
/// Other sizes come from a tent filter whose corner pixels stay on the corner samples: linear interpolation where the
/// map grows, an average over a pixel's reach where it shrinks. Colours are averaged as light, normals are made unit
/// vectors again, samples outside a free chart's mask do not count. Single numbers are gray. Same maps and options,
/// same bytes.
///
/// @throws model::Error kUsage for a chart that does not exist; kMissingLayer, kBadLayerShape for layers that are not
///         as SPEC.md has them; kWriteFailed: no file is published then
void export_plain_maps(const model::MapSet& maps, const std::filesystem::path& folder, const std::string& stem,
                       const PlainMapOptions& options);

}  // namespace dgm::exporter
