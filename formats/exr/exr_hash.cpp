// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_hash.cpp
#include "exr/exr_hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <span>

#include "exr/exr_text.h"

namespace dgm::formats {
namespace {

std::string hash_text(const void* data, std::size_t bytes) {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(data, bytes));
    return hex_of(std::span(canonical.digest));
}

std::string line_of(std::string_view key, const model::AttributeValue& value) {
    return std::string(key) + " " + attribute_text(value) + "\n";
}

template <std::size_t N>
std::string line_of(std::string_view key, const std::array<double, N>& numbers) {
    return line_of(key, std::vector<double>(numbers.begin(), numbers.end()));
}

}  // namespace

std::string exr_layer_hash(const model::Layer& layer) {
    return hash_text(layer.bytes.data(), layer.bytes.size());
}

std::string exr_header_hash(const model::MapSet& maps) {
    std::string text = line_of("format_version", std::vector{maps.format_version});
    text += line_of("generator", maps.generator) + line_of("source_name", maps.source_name);
    text += line_of("source_hash", hex_of(maps.source_hash)) + line_of("settings_hash", hex_of(maps.settings_hash));
    text += line_of("report", maps.report_json);
    for (const model::Chart& chart : maps.charts) {
        text += line_of("chart", std::vector{static_cast<std::uint32_t>(chart.domain), chart.rows, chart.cols});
        text += line_of("method", chart.method) + line_of("bbox", chart.bbox);
        text += line_of("offset", chart.offset) + line_of("scale", chart.scale);
        for (const model::Layer& layer : chart.layers) {
            text += manifest_line({layer.name, layer.type, layer.shape, layer.required}) + "\n";
            for (const auto& [name, value] : layer.attributes) text += line_of("attribute " + name, value);
        }
    }
    return hash_text(text.data(), text.size());
}

}  // namespace dgm::formats
