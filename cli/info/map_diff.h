// SPDX-License-Identifier: GPL-3.0-or-later
// cli/info/map_diff.h
// Differences of two maps: they show the effect of a changed setting, tool or mesh on the file.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/map_set.h"

namespace dgm::info {

struct LayerDifference {
    enum class Kind { kOnlyInFirst, kOnlyInSecond, kType, kShape, kAttributes, kValues };
    std::size_t chart = 0;
    std::string layer;
    Kind kind = Kind::kValues;
    std::string first{}, second{};            ///< kType, kShape: what each has, "257 x 257 x 3"
    std::uint64_t changed = 0, elements = 0;  ///< kValues: stored numbers that differ, of how many
    double largest = 0;                       ///< kValues: of the stored numbers as they decode (f16 to its value)
};

struct MapDifference {
    std::vector<std::string> fields;  ///< "source hash", "settings hash", "chart 0: method": what is beside the layers
    std::vector<LayerDifference> layers;  ///< by chart, then in the order of the first file
    /// Largest distance of two samples with the same place in the same chart, in source units, also between f32 and
    /// u16. Nothing if no chart has a geometry of one shape in both.
    std::optional<double> largest_move;
    double diagonal = 0;  ///< of the first map's boxes together, source units

    [[nodiscard]] bool empty() const { return fields.empty() && layers.empty(); }
};

/// Compares charts by their number and layers by their name. NaN equals NaN of the same bits. The reports (measured
/// errors) and generators of the two are not compared: they follow from the rest, or tell of the tool.
[[nodiscard]] MapDifference difference(const model::MapSet& first, const model::MapSet& second);

/// Lines for people, each with a line end; one that says so if nothing differs.
[[nodiscard]] std::string to_text(const MapDifference& difference);

/// {"equal": false, "fields": [...], "layers": [{"chart", "layer", "kind", ...}], "largest_move": 0.1, ...}, indented
/// by two, with a line end. Numbers that are not finite are null.
[[nodiscard]] std::string to_json(const MapDifference& difference);

}  // namespace dgm::info
