// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/index.h
// The rules that chart and layer records obey, for writer and reader alike; no HDF5 here.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <dgm/layout.h>

#include "dgm/dgm_reader.h"
#include "model/map_set.h"

namespace dgm::formats {

inline constexpr std::uint32_t kMaxGridSide = 65535;

/// Records in the order of the index.
struct Index {
    std::vector<layout::ChartRecord> charts;
    std::vector<layout::LayerRecord> layers;
};

[[nodiscard]] std::uint64_t index_bytes(std::uint64_t charts, std::uint64_t layers);
[[nodiscard]] std::vector<std::byte> encode_records(const Index& index);
/// `bytes` must be index_bytes(charts, layers) long.
[[nodiscard]] Index decode_records(std::span<const std::byte> bytes, std::uint32_t charts, std::uint32_t layers);

/// Parts of the file that belong to no layer, from the end of the user block on: [begin, end) pairs, ascending. HDF5's
/// own structures, the report, and gaps. Layers must lie in the file and share no bytes.
[[nodiscard]] std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges_beside_layers(const Index& index,
                                                                                        std::uint64_t file_bytes);

/// Text of a zero-padded field; nothing unless it is 1 or more letters, digits, '_', '-' or '.' and then zeros alone.
[[nodiscard]] std::optional<std::string> field_text(std::span<const char> field);
/// Puts `text` into a zero-filled field. @throws model::Error kBadLayerShape if it does not fit or has other characters
void set_field_text(std::span<char> field, std::string_view text, const std::string& place);

/// Product of shape and element size; nothing if it overflows, a rank is wrong or the type unknown.
[[nodiscard]] std::optional<std::uint64_t> layer_bytes(layout::ElementType type, std::span<const std::uint64_t> shape);

/// Says why a layer of that name, type and shape does not suit this chart (docs/design.md section 4); empty if it does.
/// A name that is not in the format may have any type and shape.
[[nodiscard]] std::string shape_complaint(const layout::ChartRecord& chart, std::string_view name,
                                          layout::ElementType type, std::span<const std::uint64_t> shape);
[[nodiscard]] bool is_known_layer(std::string_view name);

/// A fault in a chart's own numbers, as a message; empty if there is none.
[[nodiscard]] std::string chart_complaint(const layout::ChartRecord& chart);

/// HDF5 path of a layer or, without a name, of a chart.
[[nodiscard]] std::string h5_place(std::size_t chart, std::string_view layer = {});

}  // namespace dgm::formats
