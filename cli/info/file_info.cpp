// SPDX-License-Identifier: GPL-3.0-or-later
// cli/info/file_info.cpp
#include "info/file_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include <dgm/layout.h>
#include <dgm/limits.h>

#include "baking/materials.h"
#include "dgm/dgm_reader.h"
#include "dgm/hash.h"
#include "exr/exr_reader.h"
#include "mesh/mesh_formats.h"
#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"
#include "model/printable.h"
#include "process/json_apart.h"
#include "validate/validation.h"

namespace dgm::info {
namespace {
using Json = nlohmann::ordered_json;
using model::printable;

const char* domain_name(model::Domain domain) {
    return domain == model::Domain::kFree ? "free" : "square";
}

/// The index records, in file order. The file has just been checked, so a surprise means that it changed meanwhile.
std::vector<layout::LayerRecord> layer_records(const std::filesystem::path& path, std::size_t charts,
                                               std::size_t layers) {
    std::ifstream file(path, std::ios::binary);
    layout::FileHeader header{};
    file.read(reinterpret_cast<char*>(&header), sizeof header);
    std::vector<layout::LayerRecord> records(layers);
    if (file && header.chart_count == charts && header.layer_count == layers) {
        file.seekg(static_cast<std::streamoff>(header.index_offset + charts * sizeof(layout::ChartRecord)));
        file.read(reinterpret_cast<char*>(records.data()),
                  static_cast<std::streamsize>(layers * sizeof(layout::LayerRecord)));
        if (file) return records;
    }
    throw model::Error(model::codes::kReadFailed, "the file changed while it was read");
}

/// The value at a path of keys, or null.
const nlohmann::json* find(const nlohmann::json& from, std::initializer_list<const char*> keys) {
    const nlohmann::json* at = &from;
    for (const char* key : keys) {
        if (!at->is_object()) return nullptr;
        const auto it = at->find(key);
        if (it == at->end()) return nullptr;
        at = &*it;
    }
    return at;
}

/// "psnr 81.2 dB, rms 0.0087 %, max 0.12 %" of what a SurfaceError of the report has.
std::string error_text(const nlohmann::json& report) {
    std::string out;
    const auto add = [&](std::initializer_list<const char*> keys, const char* before, const char* after) {
        const nlohmann::json* value = find(report, keys);
        if (value == nullptr || !value->is_number()) return;
        out += fmt::format("{}{} {:.4g}{}", out.empty() ? "" : ", ", before, value->get<double>(), after);
    };
    add({"error", "psnr"}, "PSNR", " dB");
    add({"error", "rms_percent"}, "rms", " %");
    add({"error", "hausdorff_percent"}, "max", " %");
    add({"error", "normal_rms_degrees"}, "normals", " degrees");
    add({"seam_gap"}, "seam gap", "");
    add({"map", "flips"}, "flips", "");
    add({"map", "stretch_l2"}, "stretch", "");
    add({"utilisation"}, "utilisation", "");
    return out;
}

/// A line for each edit that the report lists (dgm-edit).
std::string edits_text(const nlohmann::json& report) {
    const nlohmann::json* edits = find(report, {"edits"});
    if (edits == nullptr || !edits->is_array()) return {};
    std::string out;
    for (const nlohmann::json& edit : *edits) {
        const auto text = [&](const char* key) {
            const nlohmann::json* value = find(edit, {key});
            return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
        };
        const nlohmann::json* samples = find(edit, {"samples"});
        const std::uint64_t count =
            samples != nullptr && samples->is_number_unsigned() ? samples->get<std::uint64_t>() : 0;
        out += fmt::format("  edited    {}{}, from {}  {}\n", text("layer"),
                           count > 0 ? fmt::format(": {} sample{}", count, count == 1 ? "" : "s") : "", text("source"),
                           text("source_hash"));
    }
    return out;
}

std::string vector_text(std::span<const double> v) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]);
}

/// What the layer `material` says; empty if there is none.
std::vector<float> material_of(const model::Chart& chart) {
    const model::Layer* layer = chart.find(model::layers::kMaterial);
    std::vector<float> out;
    if (layer == nullptr || layer->type != model::ElementType::kF32) return out;
    const std::size_t count = layer->bytes.size() / sizeof(float);
    for (std::size_t k = 0; k < (count < kMaterialValues ? std::min<std::size_t>(count, 1) : kMaterialValues); ++k)
        out.push_back(model::element<float>(*layer, k));
    return out;
}

/// "a unit is 0.001 m; membrane 200 N/m, poisson 0.3, ..."
std::string material_text(std::span<const float> material) {
    std::string out = fmt::format("a unit is {:.6g} m", material[0]);
    for (std::size_t k = 1; k < material.size(); ++k) {
        const bake::MaterialKey& key = bake::kMaterialKeys[k - 1];
        out += fmt::format("{} {} {:.6g}{}{}", k == 1 ? ";" : ",", key.name, material[k], key.unit.empty() ? "" : " ",
                           key.unit);
    }
    return out;
}

Json chart_json(const ChartInfo& chart, bool is_exr) {
    Json out = Json::object();
    out["rows"] = chart.rows, out["cols"] = chart.cols;
    out["domain"] = domain_name(chart.domain), out["method"] = chart.method;
    out["bbox"] = chart.bbox, out["offset"] = chart.offset, out["scale"] = chart.scale;
    if (!chart.material.empty()) out["metres_per_unit"] = chart.material[0];
    if (chart.material.size() > 1) {
        Json& material = out["material"] = Json::object();
        for (std::size_t k = 1; k < chart.material.size(); ++k)
            material[std::string(bake::kMaterialKeys[k - 1].name)] = chart.material[k];
    }
    out["layers"] = Json::array();
    for (const LayerInfo& layer : chart.layers) {
        Json l = Json::object();
        l["name"] = layer.name, l["type"] = model::type_name(layer.type), l["shape"] = layer.shape;
        l["offset"] = is_exr ? Json(nullptr) : Json(layer.offset), l["bytes"] = layer.bytes,
        l["hash"] = formats::to_hex(layer.hash);
        l["required"] = layer.required;
        out["layers"].push_back(std::move(l));
    }
    return out;
}
bool is_exr(const std::filesystem::path& path) {
    constexpr std::array<char, 4> kMagic{'\x76', '\x2f', '\x31', '\x01'};
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;  // a pipe would lose its first bytes
    std::array<char, 4> start{};
    std::ifstream file(path, std::ios::binary);
    file.read(start.data(), start.size());
    return file && start == kMagic;
}

/// An EXR stores channels: its layers have types, shapes and bytes as decoded, and no place of their own.
void add_decoded_layers(const model::Chart& chart, ChartInfo& out) {
    for (const model::Layer& layer : chart.layers) {
        LayerInfo& info = out.layers.emplace_back();
        info.name = layer.name;
        info.type = layer.type;
        info.shape.assign(layer.shape.begin(), layer.shape.end());
        info.bytes = layer.bytes.size();
        info.hash = formats::hash_bytes(layer.bytes);
        info.required = layer.required;
    }
}

}  // namespace

model::MapSet read_maps(const std::filesystem::path& path) {
    formats::check_map_name(path);
    return is_exr(path) ? formats::read_exr(path) : formats::read_dgm(path);
}

FileInfo read_file_info(const std::filesystem::path& path) {
    const model::MapSet maps = read_maps(path);
    FileInfo out;
    out.file = path.string();
    out.fault = validate::first_error(maps);
    out.bytes = std::filesystem::file_size(path);
    out.is_exr = is_exr(path);
    out.format_version = maps.format_version;
    out.generator = maps.generator;
    out.source_name = maps.source_name;
    out.report_json = maps.report_json;
    out.source_hash = maps.source_hash;
    out.settings_hash = maps.settings_hash;
    std::size_t layers = 0;
    for (const model::Chart& chart : maps.charts) {
        layers += chart.layers.size();
        out.charts.push_back({chart.rows,
                              chart.cols,
                              chart.domain,
                              chart.method,
                              chart.bbox,
                              chart.offset,
                              chart.scale,
                              {},
                              material_of(chart)});
        if (out.is_exr) add_decoded_layers(chart, out.charts.back());
    }
    if (out.is_exr) return out;
    const auto records = layer_records(path, maps.charts.size(), layers);
    for (const layout::LayerRecord& record : records) {
        if (record.chart >= out.charts.size() || record.rank > layout::kMaxRank)
            throw model::Error(model::codes::kReadFailed, "the file changed while it was read");
        LayerInfo layer;
        layer.name.assign(record.name, strnlen(record.name, sizeof record.name));
        layer.type = static_cast<model::ElementType>(record.type);
        layer.shape.assign(record.shape, record.shape + record.rank);
        layer.offset = record.offset;
        layer.bytes = record.bytes;
        std::copy(std::begin(record.hash), std::end(record.hash), layer.hash.begin());
        layer.required = (record.flags & layout::kLayerRequired) != 0;
        out.charts[record.chart].layers.push_back(std::move(layer));
    }
    return out;
}

std::string to_text(const FileInfo& info) {
    const nlohmann::json report = bake::read_map_report(info.report_json);
    std::string out = fmt::format("{}: {} bytes, format {}{}, {}\n", printable(info.file), info.bytes,
                                  info.format_version, info.is_exr ? " as EXR" : "", printable(info.generator));
    out += fmt::format("  source    {}  {}\n", printable(info.source_name), formats::to_hex(info.source_hash));
    out += fmt::format("  settings  {}\n", formats::to_hex(info.settings_hash));
    if (const std::string errors = error_text(report); !errors.empty()) out += fmt::format("  measured  {}\n", errors);
    out += edits_text(report);
    for (std::size_t k = 0; k < info.charts.size(); ++k) {
        const ChartInfo& chart = info.charts[k];
        const bool one_sided = std::any_of(chart.layers.begin(), chart.layers.end(),
                                           [](const LayerInfo& l) { return l.name == model::layers::kReversed; });
        out += fmt::format("  chart {}: {} x {}, {}, {}{}\n", k, chart.rows, chart.cols, domain_name(chart.domain),
                           printable(chart.method), one_sided ? ", one side" : "");
        out += fmt::format("    box       {} .. {}\n", vector_text(std::span(chart.bbox).first(3)),
                           vector_text(std::span(chart.bbox).last(3)));
        if (!chart.material.empty()) out += fmt::format("    material  {}\n", material_text(chart.material));
        const nlohmann::json* reports = find(report, {"charts"});
        if (reports != nullptr && reports->is_array() && k < reports->size())
            if (const std::string errors = error_text((*reports)[k]); !errors.empty())
                out += fmt::format("    measured  {}\n", errors);
        out += fmt::format("    {:<16} {:<4} {:<20} {:>12} {:>12}  {}\n", "layer", "type", "shape", "offset", "bytes",
                           "XXH3-128");
        for (const LayerInfo& layer : chart.layers)
            out += fmt::format("    {:<16} {:<4} {:<20} {:>12} {:>12}  {}\n", printable(layer.name),
                               model::type_name(layer.type), model::shape_text(layer.shape),
                               info.is_exr ? std::string("-") : std::to_string(layer.offset), layer.bytes,
                               formats::to_hex(layer.hash));
    }
    return out;
}

std::string to_json(std::span<const FileInfo> files) {
    Json list = Json::array();
    for (const FileInfo& info : files) {
        Json out = Json::object();
        out["file"] = info.file, out["bytes"] = info.bytes, out["format_version"] = info.format_version;
        out["generator"] = info.generator, out["source_name"] = info.source_name;
        out["source_hash"] = formats::to_hex(info.source_hash);
        out["settings_hash"] = formats::to_hex(info.settings_hash);
        out["charts"] = Json::array();
        for (const ChartInfo& chart : info.charts) out["charts"].push_back(chart_json(chart, info.is_exr));
        out["report"] = bake::read_map_report(info.report_json);
        list.push_back(std::move(out));
    }
    Json whole = Json::object();
    whole["files"] = std::move(list);
    // Names come from files: what is not UTF-8 is replaced, not thrown about.
    return whole.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace dgm::info
