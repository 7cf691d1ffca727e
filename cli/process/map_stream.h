// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/map_stream.h
// Charts in a byte stream, but for the bytes of their layers, which are sent apart or not at all.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "model/map_set.h"
#include "process/byte_stream.h"

namespace dgm::bake {

void put_charts(ByteWriter& out, const std::vector<model::Chart>& charts);

/// The charts, with layers that have no bytes yet.
struct ChartHeads {
    std::vector<model::Chart> charts;
    std::vector<std::uint64_t> sizes;  ///< of the layers, in bytes and in their order; 0 for bytes that are not there
    std::uint64_t total = 0;
};
/// nullopt if a domain is none, or a layer's size does not follow from its shape.
[[nodiscard]] std::optional<ChartHeads> get_charts(ByteReader& in);

/// Elements of a layer; nullopt for an impossible shape.
[[nodiscard]] std::optional<std::uint64_t> elements_of(const model::Layer& layer);

}  // namespace dgm::bake
