// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/layer_checks.cpp
// The table of docs/design.md section 4 as data, then the range of each value.
//
// Normals need no check of length: every pair of octahedral codes decodes to a unit vector. But of the codes that mean
// the same vector the format has chosen one (SPEC.md 3.4).
#include "validate/layer_checks.h"

#include <dgm/grid.h>
#include <dgm/limits.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::validate {
namespace {
using model::Chart;
using model::element;
using model::ElementType;
using model::Layer;
namespace codes = model::codes;

static_assert(std::endian::native == std::endian::little, "layers are read as they are stored");

// Extents that depend on the chart; all others are numbers.
constexpr std::int64_t kRows = -1, kCols = -2, kQuadRows = -3, kQuadCols = -4, kBorder = -5, kAny = -6, kSome = -7;

enum class Presence { kAlways, kOptional, kFreeDomain, kFreeDomainOptional };

struct LayerRule {
    const char* name;
    std::array<ElementType, 2> types;  // either
    std::vector<std::int64_t> shape;
    Presence presence;
};

const std::vector<LayerRule>& rules() {
    using enum ElementType;
    using enum Presence;
    static const std::vector<LayerRule> table{
        {"geometry", {kF32, kU16}, {kRows, kCols, 3}, kAlways},
        {"normal", {kI16, kI16}, {kRows, kCols, 2}, kOptional},
        {"texture", {kU8, kU8}, {kSome, kSome, 4}, kOptional},
        {"bump", {kF16, kF16}, {kSome, kSome}, kOptional},
        {"collision", {kF32, kF32}, {kSome, 6}, kOptional},
        {"cover", {kF32, kF32}, {kRows, kCols}, kOptional},
        {"deformation", {kF32, kF32}, {kRows, kCols, 4}, kOptional},
        {"contact", {kF32, kF32}, {kRows, kCols, 2}, kOptional},
        {"material", {kF32, kF32}, {kSome}, kOptional},
        {"seams", {kU32, kU32}, {kAny, 2}, kOptional},
        {"reversed", {kU8, kU8}, {kAny}, kOptional},
        {"diagonals", {kU8, kU8}, {kQuadRows, kQuadCols}, kOptional},
        {"mask", {kU8, kU8}, {kRows, kCols}, kFreeDomain},
        {"border_uv", {kF32, kF32}, {kBorder, 2}, kFreeDomain},
        {"border_geometry", {kF32, kU16}, {kBorder, 3}, kFreeDomain},
        {"border_normal", {kI16, kI16}, {kBorder, 2}, kFreeDomainOptional},
        {"border_faces", {kU32, kU32}, {kAny, 3}, kFreeDomain},
    };
    return table;
}

bool extent_fits(std::uint64_t is, std::int64_t want, const Chart& chart) {
    switch (want) {
        case kRows:
            return is == chart.rows;
        case kCols:
            return is == chart.cols;
        case kQuadRows:
            return is + 1 == chart.rows;
        case kQuadCols:
            return is + 1 == chart.cols;
        case kBorder:
            return is == border_samples(chart);
        case kAny:
            return true;
        case kSome:
            return is > 0;
        default:
            return is == static_cast<std::uint64_t>(want);
    }
}

bool size_fits(const Layer& layer) {
    std::uint64_t bytes = layout::element_size(layer.type);
    for (const std::uint64_t extent : layer.shape)
        if (__builtin_mul_overflow(bytes, extent, &bytes)) return false;
    return bytes == layer.bytes.size() && !layer.shape.empty();
}

/// Reports the elements for which `is_bad` holds: how many, and where the first one stands.
template <class IsBad, class Value>
void report_elements(const Layer& layer, std::size_t chart_index, const model::Code& code, const char* what,
                     const IsBad& is_bad, const Value& value, std::optional<double> limit, FindingList& findings) {
    std::size_t count = 0, first = 0, total = 1;
    for (const std::uint64_t extent : layer.shape) total *= extent;
    for (std::size_t k = 0; k < total; ++k)
        if (is_bad(k) && count++ == 0) first = k;
    if (count == 0) return;
    const std::optional<double> measured = value(first);
    findings.error(code, layer_path(chart_index, layer.name) + element_text(layer.shape, first),
                   fmt::format("{} {}, {} of {} values", what, count == 1 ? "here" : "here first", count, total),
                   {measured, limit});
}

bool check_shape(const Layer& layer, const LayerRule& rule, const Chart& chart, std::size_t chart_index,
                 FindingList& findings) {
    const std::string place = layer_path(chart_index, layer.name);
    if (std::find(rule.types.begin(), rule.types.end(), layer.type) == rule.types.end()) {
        findings.error(codes::kBadLayerShape, place,
                       fmt::format("element type {} does not suit this layer", static_cast<std::uint32_t>(layer.type)));
        return false;
    }
    const bool fits = layer.shape.size() == rule.shape.size() &&
                      std::equal(layer.shape.begin(), layer.shape.end(), rule.shape.begin(),
                                 [&](std::uint64_t is, std::int64_t want) { return extent_fits(is, want, chart); });
    if (!fits) {
        findings.error(codes::kBadLayerShape, place,
                       fmt::format("shape [{}] does not suit a chart of {} x {} samples and {} border samples",
                                   fmt::join(layer.shape, "]["), chart.rows, chart.cols, border_samples(chart)));
        return false;
    }
    if (!size_fits(layer)) {
        findings.error(
            codes::kBadLayerShape, place,
            fmt::format("{} bytes do not make shape [{}]", layer.bytes.size(), fmt::join(layer.shape, "][")));
        return false;
    }
    return true;
}

void check_finite(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    const auto no_value = [](std::size_t) { return std::optional<double>(); };
    if (layer.type == ElementType::kF32)
        report_elements(
            layer, chart_index, codes::kNotFinite, "not a finite number",
            [&](std::size_t k) { return !std::isfinite(element<float>(layer, k)); }, no_value, {}, findings);
    if (layer.type == ElementType::kF16)
        report_elements(
            layer, chart_index, codes::kNotFinite, "not a finite number",
            [&](std::size_t k) { return (element<std::uint16_t>(layer, k) & 0x7c00u) == 0x7c00u; }, no_value, {},
            findings);
}

void check_booleans(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    report_elements(
        layer, chart_index, codes::kBadValue, "neither 0 nor 1",
        [&](std::size_t k) { return element<std::uint8_t>(layer, k) > 1; },
        [&](std::size_t k) { return static_cast<double>(element<std::uint8_t>(layer, k)); }, 1, findings);
}

/// One of the codes that decode to the same vector is right: never -32768, and on the border of the square the code
/// whose other coordinate is not negative.
void check_octahedral(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    constexpr int kEdge = 32767;
    const auto code = [&](std::size_t k) { return int{static_cast<std::int16_t>(element<std::uint16_t>(layer, k))}; };
    report_elements(
        layer, chart_index, codes::kBadNormal, "not an octahedral code of the format",
        [&](std::size_t k) {
            const int is = code(k), other = code(k ^ 1);
            return is < -kEdge || (is < 0 && std::abs(other) == kEdge);
        },
        [&](std::size_t k) { return static_cast<double>(code(k)); }, std::nullopt, findings);
}

/// Attributes of `bump`: a finite scale that is not negative, and shading in 0..1.
void check_bump_attributes(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    for (const auto& [name, high] :
         {std::pair{"scale", std::numeric_limits<double>::max()}, std::pair{"shading", 1.0}}) {
        const auto found = layer.attributes.find(name);
        if (found == layer.attributes.end()) continue;
        const auto* value = std::get_if<std::vector<double>>(&found->second);
        const std::string place = layer_path(chart_index, layer.name) + "@" + name;
        if (value == nullptr || value->size() != 1)
            findings.error(codes::kBadAttribute, place, "the attribute is not one f64");
        else if (!(value->front() >= 0 && value->front() <= high))
            findings.error(codes::kBadValue, place, "the attribute is out of its range", {value->front(), high});
    }
}

/// Channel `channel` of `channels` must lie in [low, high].
void check_range(const Layer& layer, std::size_t chart_index, std::size_t channels, std::size_t channel, double low,
                 double high, const char* what, FindingList& findings) {
    const auto value = [&](std::size_t k) { return static_cast<double>(element<float>(layer, k)); };
    report_elements(
        layer, chart_index, codes::kBadValue, what,
        [&](std::size_t k) { return k % channels == channel && (value(k) < low || value(k) > high); }, value,
        std::nullopt, findings);
}

/// Entries that are known in their ranges: the unit alone, or all.
void check_material(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    const std::size_t count = layer.shape.front();
    if (count > 1 && count < kMaterialValues)
        findings.error(codes::kBadLayerShape, layer_path(chart_index, layer.name),
                       fmt::format("{} entries: a unit is 1, a material {} or more", count, kMaterialValues));
    const auto value = [&](std::size_t k) { return static_cast<double>(element<float>(layer, k)); };
    report_elements(
        layer, chart_index, codes::kBadValue, "out of the range of this entry",
        [&](std::size_t k) {
            return k < kMaterialValues && (value(k) < double{kMaterialLow[k]} || value(k) > double{kMaterialHigh[k]});
        },
        value, std::nullopt, findings);
}

void check_first_fundamental_form(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    // E, F and G are each rounded to float: EG - F^2 may come out a few 2^-24 EG below zero.
    constexpr double kSlack = 1e-5;
    const auto determinant = [&](std::size_t k) {
        const double E = element<float>(layer, k), F = element<float>(layer, k + 1), G = element<float>(layer, k + 2);
        return E * G - F * F;
    };
    report_elements(
        layer, chart_index, codes::kBadValue, "E G - F^2 is negative: not a metric",
        [&](std::size_t k) {
            if (k % 4 != 0) return false;
            const double E = element<float>(layer, k), G = element<float>(layer, k + 2);
            return determinant(k) < -kSlack * std::abs(E * G);
        },
        determinant, 0, findings);
}

void check_values(const Layer& layer, std::size_t chart_index, FindingList& findings) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::size_t before = findings.size();
    check_finite(layer, chart_index, findings);
    if (findings.size() != before) return;  // ranges of values that are no numbers add nothing
    const std::string& name = layer.name;
    const auto range = [&](std::size_t channels, std::size_t channel, double low, double high, const char* what) {
        check_range(layer, chart_index, channels, channel, low, high, what, findings);
    };
    if (name == "normal" || name == "border_normal") check_octahedral(layer, chart_index, findings);
    if (name == "bump") check_bump_attributes(layer, chart_index, findings);
    if (name == "mask" || name == "diagonals") check_booleans(layer, chart_index, findings);
    if (name == "cover") range(1, 0, 0, kInfinity, "negative radius");
    if (name == "deformation") {
        range(4, 0, 0, kMaxForm, "E is outside 0..1e30");
        range(4, 1, -kMaxForm, kMaxForm, "F is beyond 1e30");
        range(4, 2, 0, kMaxForm, "G is outside 0..1e30");
        range(4, 3, 0, 1, "stiffness is outside 0..1");
        if (findings.size() == before) check_first_fundamental_form(layer, chart_index, findings);
    }
    if (name == "contact") {
        range(2, 0, 0, kInfinity, "area is negative");
        range(2, 1, 0, 1, "mobility is outside 0..1");
    }
    if (name == "material") check_material(layer, chart_index, findings);
    if (name == "border_uv") {
        range(2, 0, 0, 1, "u is outside 0..1");
        range(2, 1, 0, 1, "v is outside 0..1");
    }
}

/// Local coordinates on the surface, as the runtime will have them: scaled and single.
/// @return true if all are within the runtime's limit
bool check_coordinates(const Chart& chart, const Layer& layer, bool scaled, std::size_t chart_index,
                       FindingList& findings) {
    const std::size_t before = findings.size();
    const bool grid = layer.name == "geometry";
    const Layer* mask = grid ? chart.find("mask") : nullptr;
    const auto value = [&](std::size_t k) {
        const double stored = layer.type == ElementType::kF32 ? double{element<float>(layer, k)}
                                                              : static_cast<double>(element<std::uint16_t>(layer, k));
        return scaled ? chart.scale[k % 3] * stored : stored;
    };
    report_elements(
        layer, chart_index, codes::kBadValue, "a coordinate is beyond 1e18",
        [&](std::size_t k) {
            if (mask != nullptr && k / 3 < mask->bytes.size() && element<std::uint8_t>(*mask, k / 3) == 0) return false;
            return std::abs(value(k)) > double{kMaxCoordinate};
        },
        value, double{kMaxCoordinate}, findings);
    return findings.size() == before;
}

bool check_frame(const Chart& chart, std::size_t chart_index, FindingList& findings) {
    const auto finite = [](double x) { return std::isfinite(x); };
    const bool good = std::all_of(chart.offset.begin(), chart.offset.end(), finite) &&
                      std::all_of(chart.scale.begin(), chart.scale.end(), finite) &&
                      std::all_of(chart.bbox.begin(), chart.bbox.end(), finite);
    if (!good)
        findings.error(codes::kNotFinite, layer_path(chart_index, ""), "offset, scale or bbox is not a finite number");
    if (std::any_of(chart.scale.begin(), chart.scale.end(), [](double x) { return x <= 0; }))
        findings.error(codes::kBadValue, layer_path(chart_index, "geometry") + "@scale", "the scale is not positive",
                       {*std::min_element(chart.scale.begin(), chart.scale.end()), 0});
    const Layer* geometry = chart.find("geometry");
    const bool scaled = std::any_of(chart.scale.begin(), chart.scale.end(), [](double x) { return x != 1; });
    if (geometry != nullptr && geometry->type == ElementType::kF32 && scaled)
        findings.warning(codes::kBadValue, layer_path(chart_index, "geometry") + "@scale",
                         "positions stored as f32 have a scale of 1");
    return good;
}
/// HDF5 tools read the length of a unit from an attribute, the runtime from the layer `material`.
void check_unit(const Chart& chart, const Layer& geometry, std::size_t chart_index, FindingList& findings) {
    const Layer* material = chart.find(model::layers::kMaterial);
    const auto found = geometry.attributes.find(model::layers::kMetresPerUnit);
    const bool said = found != geometry.attributes.end();
    if (!said && material == nullptr) return;
    const std::string place = layer_path(chart_index, geometry.name) + "@" + model::layers::kMetresPerUnit;
    const auto* value = said ? std::get_if<std::vector<double>>(&found->second) : nullptr;
    if (value == nullptr || value->size() != 1)
        findings.error(codes::kBadAttribute, place, "the attribute is not one f64, as layer material asks for");
    else if (material == nullptr || material->bytes.size() < sizeof(float) ||
             element<float>(*material, 0) != static_cast<float>(value->front()))
        findings.error(codes::kBadAttribute, place, "the first entry of layer material is not this number in f32",
                       {value->front(), std::nullopt});
}
}  // namespace

std::uint64_t border_samples(const Chart& chart) {
    const Layer* border = chart.find("border_geometry");
    return border == nullptr || border->shape.empty() ? 0 : border->shape[0];
}

bool check_layers(const Chart& chart, std::size_t chart_index, FindingList& findings) {
    bool good = check_frame(chart, chart_index, findings);
    if (chart.rows < 2 || chart.cols < 2) {
        findings.error(codes::kBadLayerShape, layer_path(chart_index, ""),
                       fmt::format("a grid of {} x {} samples has no quads", chart.rows, chart.cols));
        return false;
    }
    const bool free = chart.domain == model::Domain::kFree;
    for (const LayerRule& rule : rules()) {
        const Layer* layer = chart.find(rule.name);
        const bool only_free = rule.presence == Presence::kFreeDomain || rule.presence == Presence::kFreeDomainOptional;
        if (layer == nullptr) {
            if (rule.presence == Presence::kAlways || (free && rule.presence == Presence::kFreeDomain)) {
                findings.error(codes::kMissingLayer, layer_path(chart_index, rule.name),
                               free ? "a chart with a free domain needs this layer" : "every chart needs this layer");
                good = false;
            }
            continue;
        }
        if (only_free && !free) {
            findings.error(codes::kBadLayerShape, layer_path(chart_index, rule.name),
                           "only a free domain has this layer, and this chart's domain is the square");
            good = false;
        } else if (check_shape(*layer, rule, chart, chart_index, findings))
            check_values(*layer, chart_index, findings);
        else
            good = false;
    }
    if (const Layer* geometry = chart.find("geometry"); geometry != nullptr && good) {
        check_unit(chart, *geometry, chart_index, findings);
        good = check_coordinates(chart, *geometry, true, chart_index, findings);
        // The f32 border of a u16 chart is stored as it is.
        if (const Layer* border = chart.find("border_geometry"))
            good = check_coordinates(chart, *border, border->type == geometry->type, chart_index, findings) && good;
    }
    for (const Layer& layer : chart.layers) {
        const bool known =
            std::any_of(rules().begin(), rules().end(), [&](const LayerRule& rule) { return layer.name == rule.name; });
        if (!known && layer.required)
            findings.error(codes::kUnknownLayer, layer_path(chart_index, layer.name),
                           "the layer is marked as required");
        if (!known && size_fits(layer)) check_finite(layer, chart_index, findings);
    }
    return good;
}

}  // namespace dgm::validate
