// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/map_set.h
// Content of a .dgm or an EXR in memory: charts of named layers. Nothing about how it was computed.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <dgm/layout.h>

namespace dgm::model {

using layout::Domain;
using layout::ElementType;

/// Value of an HDF5 or EXR attribute.
using AttributeValue = std::variant<std::string, std::vector<double>, std::vector<std::uint32_t>>;

struct Layer {
    std::string name;  ///< docs/design.md section 4: geometry, normal, texture, bump, collision, cover, ...
    ElementType type = ElementType::kF32;
    std::vector<std::uint64_t> shape;                  ///< row-major, 1 to 4 entries
    std::vector<std::byte> bytes;                      ///< little-endian, product of shape * element size
    std::map<std::string, AttributeValue> attributes;  ///< beside offset and scale, which the chart carries
    bool required = false;                             ///< layout::kLayerRequired
    friend bool operator==(const Layer&, const Layer&) = default;
};

struct Chart {
    std::uint32_t rows = 0, cols = 0;
    Domain domain = Domain::kSquare;
    std::string method;              ///< at most 15 ASCII characters
    std::array<double, 6> bbox{};    ///< min xyz, max xyz of the reconstruction, source frame
    std::array<double, 3> offset{};  ///< position = offset + scale * stored geometry
    std::array<double, 3> scale{1, 1, 1};
    std::vector<Layer> layers;  ///< in file order

    [[nodiscard]] const Layer* find(std::string_view layer) const {
        for (const Layer& l : layers)
            if (l.name == layer) return &l;
        return nullptr;
    }
    [[nodiscard]] Layer* find(std::string_view layer) {
        return const_cast<Layer*>(static_cast<const Chart*>(this)->find(layer));
    }
    friend bool operator==(const Chart&, const Chart&) = default;
};

struct MapSet {
    std::uint32_t format_version = layout::kFormatVersion;
    std::string generator;                       ///< "dgm-bake 0.1.0"
    std::string source_name;                     ///< file name without folder
    std::array<std::uint8_t, 16> source_hash{};  ///< XXH3-128, canonical byte order
    std::array<std::uint8_t, 16> settings_hash{};
    std::string report_json;  ///< measured errors, docs/design.md section 7
    std::vector<Chart> charts;
    friend bool operator==(const MapSet&, const MapSet&) = default;
};

}  // namespace dgm::model
