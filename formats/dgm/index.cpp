// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/index.cpp
#include "dgm/index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "records are little-endian and copied as they stand");

using layout::ElementType;

/// An extent of a known layer's shape.
enum Extent : int { kAny = -1, kRows = -2, kCols = -3, kRowQuads = -4, kColQuads = -5, kBorder = -6 };

struct KnownLayer {
    std::string_view name;
    std::vector<ElementType> types;
    std::vector<int> shape;  ///< an Extent, or the number itself
};

const std::vector<KnownLayer>& known_layers() {
    using enum ElementType;
    static const std::vector<KnownLayer> table{
        {model::layers::kGeometry, {kF32, kU16}, {kRows, kCols, 3}},
        {model::layers::kNormal, {kI16}, {kRows, kCols, 2}},
        {model::layers::kTexture, {kU8}, {kAny, kAny, 4}},
        {model::layers::kBump, {kF16}, {kAny, kAny}},
        {model::layers::kCollision, {kF32}, {kAny, 6}},
        {model::layers::kCover, {kF32}, {kRows, kCols}},
        {model::layers::kDeformation, {kF32}, {kRows, kCols, 4}},
        {model::layers::kContact, {kF32}, {kRows, kCols, 2}},
        {model::layers::kMaterial, {kF32}, {kAny}},
        {model::layers::kSeams, {kU32}, {kAny, 2}},
        {model::layers::kReversed, {kU8}, {kAny}},
        {model::layers::kDiagonals, {kU8}, {kRowQuads, kColQuads}},
        {model::layers::kMask, {kU8}, {kRows, kCols}},
        {model::layers::kBorderUv, {kF32}, {kBorder, 2}},
        {model::layers::kBorderGeometry, {kF32, kU16}, {kBorder, 3}},
        {model::layers::kBorderNormal, {kI16}, {kBorder, 2}},
        {model::layers::kBorderFaces, {kU32}, {kAny, 3}},
    };
    return table;
}

const KnownLayer* find_known(std::string_view name) {
    for (const KnownLayer& layer : known_layers())
        if (layer.name == name) return &layer;
    return nullptr;
}

bool is_name_character(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
}

}  // namespace

std::uint64_t index_bytes(std::uint64_t charts, std::uint64_t layers) {
    return charts * sizeof(layout::ChartRecord) + layers * sizeof(layout::LayerRecord);
}

std::vector<std::byte> encode_records(const Index& index) {
    std::vector<std::byte> out(index_bytes(index.charts.size(), index.layers.size()));
    const std::size_t chart_bytes = index.charts.size() * sizeof(layout::ChartRecord);
    if (chart_bytes > 0) std::memcpy(out.data(), index.charts.data(), chart_bytes);
    if (!index.layers.empty())
        std::memcpy(out.data() + chart_bytes, index.layers.data(), index.layers.size() * sizeof(layout::LayerRecord));
    return out;
}

Index decode_records(std::span<const std::byte> bytes, std::uint32_t charts, std::uint32_t layers) {
    Index out;
    out.charts.resize(charts);
    out.layers.resize(layers);
    const std::size_t chart_bytes = charts * sizeof(layout::ChartRecord);
    if (charts > 0) std::memcpy(out.charts.data(), bytes.data(), chart_bytes);
    if (layers > 0) std::memcpy(out.layers.data(), bytes.data() + chart_bytes, layers * sizeof(layout::LayerRecord));
    return out;
}

std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges_beside_layers(const Index& index,
                                                                          std::uint64_t file_bytes) {
    std::vector<std::pair<std::uint64_t, std::uint64_t>> layers, out;
    for (const layout::LayerRecord& layer : index.layers)
        if (layer.bytes > 0) layers.emplace_back(layer.offset, layer.offset + layer.bytes);
    std::sort(layers.begin(), layers.end());
    std::uint64_t begin = layout::kUserBlockBytes;
    for (const auto& [first, last] : layers) {
        if (begin < first) out.emplace_back(begin, first);
        begin = last;
    }
    if (begin < file_bytes) out.emplace_back(begin, file_bytes);
    return out;
}

std::optional<std::string> field_text(std::span<const char> field) {
    const auto end = std::find(field.begin(), field.end(), '\0');
    if (!std::all_of(end, field.end(), [](char c) { return c == '\0'; })) return std::nullopt;
    std::string text(field.begin(), end);
    // "." and ".." mean the group itself to HDF5.
    if (text.empty() || text.front() == '.' || !std::all_of(text.begin(), text.end(), is_name_character))
        return std::nullopt;
    return text;
}

void set_field_text(std::span<char> field, std::string_view text, const std::string& place) {
    const bool good = !text.empty() && text.front() != '.' && text.size() < field.size() &&
                      std::all_of(text.begin(), text.end(), is_name_character);
    if (!good)
        throw model::Error(model::codes::kBadLayerShape,
                           "name \"" + std::string(text) + "\" must be 1 to " + std::to_string(field.size() - 1) +
                               " letters, digits, '_', '-' or '.'",
                           place);
    std::fill(field.begin(), field.end(), '\0');
    std::copy(text.begin(), text.end(), field.begin());
}

std::optional<std::uint64_t> layer_bytes(ElementType type, std::span<const std::uint64_t> shape) {
    std::uint64_t bytes = layout::element_size(type);
    if (bytes == 0 || shape.empty() || shape.size() > layout::kMaxRank) return std::nullopt;
    // Not past an empty extent: its neighbours count too, or a reader that multiplies in another order overflows.
    std::uint64_t without_zeros = bytes;
    for (const std::uint64_t extent : shape) {
        if (__builtin_mul_overflow(without_zeros, std::max<std::uint64_t>(extent, 1), &without_zeros))
            return std::nullopt;
        bytes *= extent;
    }
    return bytes;
}

bool is_known_layer(std::string_view name) {
    return find_known(name) != nullptr;
}

std::string shape_complaint(const layout::ChartRecord& chart, std::string_view name, ElementType type,
                            std::span<const std::uint64_t> shape) {
    const KnownLayer* known = find_known(name);
    if (known == nullptr) return {};
    if (std::find(known->types.begin(), known->types.end(), type) == known->types.end())
        return "element type " + std::to_string(static_cast<std::uint32_t>(type)) + " is not one of this layer's";
    const bool border_only = name.starts_with("border_") || name == model::layers::kMask;
    if (border_only && chart.domain != static_cast<std::uint32_t>(layout::Domain::kFree))
        return "only a chart of a free domain has this layer";
    std::vector<std::uint64_t> expected;
    for (std::size_t k = 0; k < known->shape.size(); ++k) {
        switch (known->shape[k]) {
            case kAny:
                expected.push_back(k < shape.size() ? shape[k] : 1);
                break;
            case kRows:
                expected.push_back(chart.rows);
                break;
            case kCols:
                expected.push_back(chart.cols);
                break;
            case kRowQuads:
                expected.push_back(chart.rows - 1);
                break;
            case kColQuads:
                expected.push_back(chart.cols - 1);
                break;
            case kBorder:
                expected.push_back(chart.border_samples);
                break;
            default:
                expected.push_back(static_cast<std::uint64_t>(known->shape[k]));
        }
    }
    if (!std::equal(expected.begin(), expected.end(), shape.begin(), shape.end()))
        return "shape " + model::shape_text(shape) + " instead of " + model::shape_text(expected);
    return {};
}

std::string chart_complaint(const layout::ChartRecord& chart) {
    if (chart.rows < 2 || chart.cols < 2 || chart.rows > kMaxGridSide || chart.cols > kMaxGridSide)
        return "grid of " + std::to_string(chart.rows) + " x " + std::to_string(chart.cols) + " samples; 2 to " +
               std::to_string(kMaxGridSide) + " a side are possible";
    if (chart.domain > static_cast<std::uint32_t>(layout::Domain::kFree))
        return "unknown domain " + std::to_string(chart.domain);
    if (chart.domain == static_cast<std::uint32_t>(layout::Domain::kSquare) && chart.border_samples != 0)
        return "a square domain has no border samples, but " + std::to_string(chart.border_samples) + " are named";
    if (!field_text(chart.method)) return "the method's name is not clean text";
    for (int k = 0; k < 3; ++k) {
        if (!std::isfinite(chart.bbox[k]) || !std::isfinite(chart.bbox[k + 3]) || chart.bbox[k] > chart.bbox[k + 3])
            return "the bounding box is not finite or inside out";
        if (!std::isfinite(chart.offset[k]) || !std::isfinite(chart.scale[k])) return "offset or scale is not finite";
    }
    return {};
}

std::string h5_place(std::size_t chart, std::string_view layer) {
    std::string out = "/charts/" + std::to_string(chart);
    if (!layer.empty()) out.append("/").append(layer);
    return out;
}

}  // namespace dgm::formats
