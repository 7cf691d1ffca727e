// SPDX-License-Identifier: GPL-3.0-or-later
// cli/info/map_diff.cpp
#include "info/map_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include <dgm/layout.h>

#include "math/portable.h"
#include "model/element.h"
#include "model/printable.h"

namespace dgm::info {
namespace {
using Kind = LayerDifference::Kind;

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::kOnlyInFirst:
            return "only in the first";
        case Kind::kOnlyInSecond:
            return "only in the second";
        case Kind::kType:
            return "type";
        case Kind::kShape:
            return "shape";
        case Kind::kAttributes:
            return "attributes";
        case Kind::kValues:
            return "values";
    }
    return "unknown";
}

/// The difference of two layers of one name, or nothing.
std::optional<LayerDifference> compare(const model::Layer& first, const model::Layer& second) {
    LayerDifference out;
    out.layer = first.name;
    if (first.type != second.type) {
        out.kind = Kind::kType;
        out.first = model::type_name(first.type);
        out.second = model::type_name(second.type);
        return out;
    }
    if (first.shape != second.shape) {
        out.kind = Kind::kShape;
        out.first = model::shape_text(first.shape);
        out.second = model::shape_text(second.shape);
        return out;
    }
    const std::size_t size = layout::element_size(first.type);
    out.elements = first.bytes.size() / size;
    if (first.bytes != second.bytes) {
        for (std::size_t k = 0; k < out.elements; ++k) {
            if (std::memcmp(first.bytes.data() + k * size, second.bytes.data() + k * size, size) == 0) continue;
            ++out.changed;
            const double apart = std::abs(model::element_value(first, k) - model::element_value(second, k));
            // From a number to NaN or infinity: as far apart as can be.
            out.largest = std::isfinite(apart) ? std::max(out.largest, apart) : std::numeric_limits<double>::infinity();
        }
        return out;
    }
    if (first.attributes == second.attributes && first.required == second.required) return std::nullopt;
    out.kind = Kind::kAttributes;
    return out;
}

/// Largest distance of samples in the same place, in source units; nothing if the shapes differ.
std::optional<double> largest_move(const model::Chart& first, const model::Chart& second) {
    const model::Layer *a = first.find("geometry"), *b = second.find("geometry");
    if (a == nullptr || b == nullptr || a->shape != b->shape || a->shape.empty() || a->shape.back() != 3)
        return std::nullopt;
    double largest = 0;
    for (std::size_t p = 0; p < a->bytes.size() / layout::element_size(a->type); p += 3) {
        double square = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // Offsets may be far larger than what is to be seen: their difference first.
            const double apart =
                (first.offset[axis] - second.offset[axis]) + (first.scale[axis] * model::element_value(*a, p + axis) -
                                                              second.scale[axis] * model::element_value(*b, p + axis));
            square += apart * apart;
        }
        if (!std::isfinite(square)) return std::numeric_limits<double>::infinity();
        largest = std::max(largest, square);
    }
    return std::sqrt(largest);
}

void compare_charts(MapDifference& out, std::size_t number, const model::Chart& first, const model::Chart& second) {
    const auto field = [&](bool equal, const char* name) {
        if (!equal) out.fields.push_back(fmt::format("chart {}: {}", number, name));
    };
    field(first.rows == second.rows && first.cols == second.cols, "size");
    field(first.domain == second.domain, "domain");
    field(first.method == second.method, "method");
    field(first.bbox == second.bbox, "box");
    field(first.offset == second.offset && first.scale == second.scale, "offset and scale");
    for (const model::Layer& layer : first.layers) {
        const model::Layer* other = second.find(layer.name);
        std::optional<LayerDifference> found;
        if (other != nullptr) found = compare(layer, *other);
        if (other == nullptr) found = LayerDifference{.layer = layer.name, .kind = Kind::kOnlyInFirst};
        if (!found) continue;
        found->chart = number;
        out.layers.push_back(std::move(*found));
    }
    for (const model::Layer& layer : second.layers)
        if (first.find(layer.name) == nullptr)
            out.layers.push_back({.chart = number, .layer = layer.name, .kind = Kind::kOnlyInSecond});
    if (const auto move = largest_move(first, second)) out.largest_move = std::max(out.largest_move.value_or(0), *move);
}

double diagonal(const model::MapSet& maps) {
    std::array<double, 6> box{1, 1, 1, -1, -1, -1};
    for (const model::Chart& chart : maps.charts)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const bool none = &chart == maps.charts.data();
            box[axis] = none ? chart.bbox[axis] : std::min(box[axis], chart.bbox[axis]);
            box[axis + 3] = none ? chart.bbox[axis + 3] : std::max(box[axis + 3], chart.bbox[axis + 3]);
        }
    return maps.charts.empty() ? 0 : math::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
}

}  // namespace

MapDifference difference(const model::MapSet& first, const model::MapSet& second) {
    MapDifference out;
    out.diagonal = diagonal(first);
    if (first.format_version != second.format_version) out.fields.emplace_back("format version");
    if (first.source_name != second.source_name) out.fields.emplace_back("source name");
    if (first.source_hash != second.source_hash) out.fields.emplace_back("source hash");
    if (first.settings_hash != second.settings_hash) out.fields.emplace_back("settings hash");
    if (first.charts.size() != second.charts.size())
        out.fields.push_back(fmt::format("charts: {} and {}", first.charts.size(), second.charts.size()));
    for (std::size_t k = 0; k < std::min(first.charts.size(), second.charts.size()); ++k)
        compare_charts(out, k, first.charts[k], second.charts[k]);
    return out;
}

std::string to_text(const MapDifference& difference) {
    if (difference.empty()) return "no difference\n";
    std::string out;
    for (const std::string& field : difference.fields) out += fmt::format("  {}: not equal\n", field);
    for (const LayerDifference& d : difference.layers) {
        out += fmt::format("  chart {}: {:<16} ", d.chart, model::printable(d.layer));
        if (d.kind == Kind::kValues)
            out += fmt::format("{} of {} numbers differ, by at most {:.4g}\n", d.changed, d.elements, d.largest);
        else if (d.kind == Kind::kType || d.kind == Kind::kShape)
            out += fmt::format("{} {} and {}\n", kind_name(d.kind), d.first, d.second);
        else if (d.kind == Kind::kAttributes)
            out += "the attributes differ\n";
        else
            out += fmt::format("{} file\n", kind_name(d.kind));
    }
    if (difference.largest_move && difference.diagonal > 0)
        out += fmt::format("  samples lie at most {:.4g} apart ({:.4g} % of the diagonal)\n", *difference.largest_move,
                           100 * *difference.largest_move / difference.diagonal);
    return out;
}

std::string to_json(const MapDifference& difference) {
    nlohmann::ordered_json out = nlohmann::ordered_json::object();
    out["equal"] = difference.empty();
    out["fields"] = difference.fields;
    out["layers"] = nlohmann::ordered_json::array();
    for (const LayerDifference& d : difference.layers) {
        nlohmann::ordered_json layer{{"chart", d.chart}, {"layer", d.layer}, {"kind", kind_name(d.kind)}};
        if (d.kind == Kind::kType || d.kind == Kind::kShape) layer["first"] = d.first, layer["second"] = d.second;
        if (d.kind == Kind::kValues) {
            layer["changed"] = d.changed, layer["elements"] = d.elements;
            layer["largest"] = d.largest;
        }
        out["layers"].push_back(std::move(layer));
    }
    out["largest_move"] = difference.largest_move ? nlohmann::ordered_json(*difference.largest_move) : nullptr;
    out["diagonal"] = difference.diagonal;
    return out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dgm::info
