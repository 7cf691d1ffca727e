// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/map_parts.h
// What of a map an artist may paint, and why the rest may not be (docs/editing.md).
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/map_set.h"

namespace dgm::edit {

/// A layer, or some of the numbers of its samples: "stiffness" is number 3 of the four of `deformation`.
struct MapPart {
    std::string name, layer;
    std::uint32_t first = 0, count = 1;
    bool is_editable = false;
    bool is_unit = false;     ///< numbers are 0..1
    bool has_copies = false;  ///< the copies of a seam sample have the same bits in a map as it was baked
    std::string why;          ///< why it may not be edited; empty if it may
};

/// The parts of a layer, in the order of its numbers. A layer that SPEC.md does not know is one part, and free unless
/// it is required.
[[nodiscard]] std::vector<MapPart> parts_of(const model::Layer& layer);

/// Numbers of one sample of the layer: 3 of `geometry`, 1 of `bump`.
[[nodiscard]] std::uint32_t numbers_of(const model::Layer& layer);

/// The parts that are asked for by their own names or their layers'; none: all.
class PartChoice {
 public:
    /// @throws model::Error kUsage for a name that the map does not have; kEditForbidden for one that may not be edited
    PartChoice(const model::MapSet& maps, std::span<const std::string> names);
    [[nodiscard]] bool has(const MapPart& part) const;
    [[nodiscard]] bool is_all() const { return names_.empty(); }

 private:
    std::vector<std::string> names_;
};

/// The names of all parts of a map, each once.
[[nodiscard]] std::vector<std::string> part_names(const model::MapSet& maps);

}  // namespace dgm::edit
