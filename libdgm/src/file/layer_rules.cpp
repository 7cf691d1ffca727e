// SPDX-License-Identifier: MIT
// libdgm/src/file/layer_rules.cpp
// Types and shapes of the layers of docs/design.md section 4, as a table.
#include <cstring>

#include <dgm/grid.h>
#include <dgm/limits.h>

#include "file/asset_impl.h"

namespace dgm::detail {
namespace {
using layout::ElementType;

/// Rule for one entry of a shape.
enum class Side : std::uint8_t {
    kRows,
    kCols,
    kQuadRows,
    kQuadCols,
    kBorder,
    kNodes,
    kSome,
    kAny,
    kUnitOrMaterial,
    k2,
    k3,
    k4,
    k6
};

struct LayerRule {
    const char* name;
    ElementType type, other_type;  // the same twice if there is one
    std::uint32_t rank;
    Side shape[3];
    bool free_only = false;
};

constexpr LayerRule kRules[] = {
    {"geometry", ElementType::kF32, ElementType::kU16, 3, {Side::kRows, Side::kCols, Side::k3}},
    {"normal", ElementType::kI16, ElementType::kI16, 3, {Side::kRows, Side::kCols, Side::k2}},
    {"texture", ElementType::kU8, ElementType::kU8, 3, {Side::kSome, Side::kSome, Side::k4}},
    {"bump", ElementType::kF16, ElementType::kF16, 2, {Side::kSome, Side::kSome}},
    {"collision", ElementType::kF32, ElementType::kF32, 2, {Side::kNodes, Side::k6}},
    {"cover", ElementType::kF32, ElementType::kF32, 2, {Side::kRows, Side::kCols}},
    {"deformation", ElementType::kF32, ElementType::kF32, 3, {Side::kRows, Side::kCols, Side::k4}},
    {"contact", ElementType::kF32, ElementType::kF32, 3, {Side::kRows, Side::kCols, Side::k2}},
    {"material", ElementType::kF32, ElementType::kF32, 1, {Side::kUnitOrMaterial}},
    {"seams", ElementType::kU32, ElementType::kU32, 2, {Side::kAny, Side::k2}},
    {"reversed", ElementType::kU8, ElementType::kU8, 1, {Side::kAny}},
    {"diagonals", ElementType::kU8, ElementType::kU8, 2, {Side::kQuadRows, Side::kQuadCols}},
    {"mask", ElementType::kU8, ElementType::kU8, 2, {Side::kRows, Side::kCols}, true},
    {"border_uv", ElementType::kF32, ElementType::kF32, 2, {Side::kBorder, Side::k2}, true},
    {"border_geometry", ElementType::kF32, ElementType::kU16, 2, {Side::kBorder, Side::k3}, true},
    {"border_normal", ElementType::kI16, ElementType::kI16, 2, {Side::kBorder, Side::k2}, true},
    {"border_faces", ElementType::kU32, ElementType::kU32, 2, {Side::kAny, Side::k3}, true},
};

/// Nodes of the box pyramid: leaf tiles, then halved (rounded up) in both directions down to one root.
std::uint64_t pyramid_nodes(std::uint32_t rows, std::uint32_t cols) noexcept {
    std::uint64_t r = tile_count(rows - 1), c = tile_count(cols - 1), nodes = r * c;
    while (r * c > 1) {
        r = (r + 1) / 2;
        c = (c + 1) / 2;
        nodes += r * c;
    }
    return nodes;
}

bool side_fits(Side side, std::uint64_t is, const layout::ChartRecord& chart) noexcept {
    switch (side) {
        case Side::kRows:
            return is == chart.rows;
        case Side::kCols:
            return is == chart.cols;
        case Side::kQuadRows:
            return is == chart.rows - 1;
        case Side::kQuadCols:
            return is == chart.cols - 1;
        case Side::kBorder:
            return is == chart.border_samples;
        case Side::kNodes:
            return is == pyramid_nodes(chart.rows, chart.cols);
        case Side::kSome:
            return is >= 1 && is <= 0xFFFFFFFFu;
        case Side::kUnitOrMaterial:
            return is == 1 || (is >= kMaterialValues && is <= 0xFFFFFFFFu);
        case Side::kAny:
            return is <= 0xFFFFFFFFu;
        case Side::k2:
            return is == 2;
        case Side::k3:
            return is == 3;
        case Side::k4:
            return is == 4;
        case Side::k6:
            return is == 6;
    }
    return false;
}
}  // namespace

Result<void> check_layer(const layout::ChartRecord& chart, LayerInfo& layer) noexcept {
    const layout::LayerRecord& record = layer.record;
    layer.known = false;
    for (const LayerRule& rule : kRules) {
        if (std::strcmp(rule.name, record.name) != 0) continue;
        layer.known = true;
        const auto type = static_cast<ElementType>(record.type);
        if (type != rule.type && type != rule.other_type)
            return Error{ErrorCode::BadLayer, layer.record_offset + offsetof(layout::LayerRecord, type),
                         "the element type does not suit this layer"};
        if (rule.free_only && chart.domain != static_cast<std::uint32_t>(layout::Domain::kFree))
            return Error{ErrorCode::BadLayer, layer.record_offset, "the layer belongs to free domains only"};
        if (record.rank != rule.rank)
            return Error{ErrorCode::BadLayer, layer.record_offset + offsetof(layout::LayerRecord, rank),
                         "the rank does not suit this layer"};
        for (std::uint32_t k = 0; k < rule.rank; ++k)
            if (!side_fits(rule.shape[k], record.shape[k], chart))
                return Error{ErrorCode::BadLayer, layer.record_offset + offsetof(layout::LayerRecord, shape) + 8 * k,
                             "the shape does not suit the chart"};
        return {};
    }
    if ((record.flags & layout::kLayerRequired) != 0)
        return Error{ErrorCode::UnknownLayer, layer.record_offset, "a required layer is unknown to this version"};
    return {};
}

}  // namespace dgm::detail
