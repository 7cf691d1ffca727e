// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/map_parts.cpp
#include "edit/map_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/codes.h"
#include "model/layer_names.h"
#include "tool/words.h"

namespace dgm::edit {
namespace {

namespace layers = model::layers;
namespace codes = model::codes;

constexpr char kShape[] = "it is the shape itself, which normals, boxes, metric and areas are computed from",
               kFromShape[] = "it is computed from the positions",
               kTopology[] = "it says how samples are joined; another choice would be another surface";

MapPart locked(const char* name, const char* layer, std::uint32_t first, std::uint32_t count, const char* why) {
    return {name, layer, first, count, false, false, false, why};
}
MapPart open(const char* name, const char* layer, std::uint32_t first, std::uint32_t count, bool is_unit) {
    return {name, layer, first, count, true, is_unit, is_unit, ""};
}

const std::vector<MapPart>& known_parts() {
    static const std::vector<MapPart> table{
        locked("geometry", layers::kGeometry, 0, 3, kShape),
        locked("normal", layers::kNormal, 0, 2,
               "it decides which side a tool is on, and bump is measured along it; paint bump instead"),
        open("texture", layers::kTexture, 0, 4, false),
        open("bump", layers::kBump, 0, 1, false),
        locked("collision", layers::kCollision, 0, 6, kFromShape),
        locked("cover", layers::kCover, 0, 1, kFromShape),
        locked("metric", layers::kDeformation, 0, 3, kFromShape),
        open("stiffness", layers::kDeformation, 3, 1, true),
        locked("contact_area", layers::kContact, 0, 1, kFromShape),
        open("mobility", layers::kContact, 1, 1, true),
        locked("material", layers::kMaterial, 0, 1, "it was checked against the body; bake again with --material"),
        locked("seams", layers::kSeams, 0, 2, kTopology),
        locked("diagonals", layers::kDiagonals, 0, 1, kTopology),
        locked("mask", layers::kMask, 0, 1, "it is the chart's outline; hold a region still with mobility instead"),
        locked("border_uv", layers::kBorderUv, 0, 2, kTopology),
        locked("border_geometry", layers::kBorderGeometry, 0, 3, kShape),
        locked("border_normal", layers::kBorderNormal, 0, 2, "it is the normal of border samples"),
        locked("border_faces", layers::kBorderFaces, 0, 3, kTopology),
    };
    return table;
}

}  // namespace

std::vector<MapPart> parts_of(const model::Layer& layer) {
    std::vector<MapPart> out;
    for (const MapPart& part : known_parts())
        if (part.layer == layer.name) out.push_back(part);
    if (!out.empty()) return out;
    MapPart own{layer.name, layer.name, 0, 1, !layer.required, false, false, {}};
    constexpr std::uint64_t kMostChannels = 8;  // as many as an EXR shows as channels of one picture
    if (layer.shape.size() >= 3 && layer.shape.back() >= 1 && layer.shape.back() <= kMostChannels)
        own.count = static_cast<std::uint32_t>(layer.shape.back());
    if (layer.required) own.why = "the file cannot be read without it, and this tool does not know what it means";
    return {own};
}

std::uint32_t numbers_of(const model::Layer& layer) {
    std::uint32_t out = 0;
    for (const MapPart& part : parts_of(layer)) out += part.count;
    return out;
}

std::vector<std::string> part_names(const model::MapSet& maps) {
    std::vector<std::string> out;
    for (const model::Chart& chart : maps.charts)
        for (const model::Layer& layer : chart.layers)
            for (const MapPart& part : parts_of(layer))
                if (std::find(out.begin(), out.end(), part.name) == out.end()) out.push_back(part.name);
    return out;
}

PartChoice::PartChoice(const model::MapSet& maps, std::span<const std::string> names)
    : names_(names.begin(), names.end()) {
    for (const std::string& name : names_) {
        std::string why;
        bool is_there = false, is_editable = false;
        for (const model::Chart& chart : maps.charts)
            for (const model::Layer& layer : chart.layers)
                for (const MapPart& part : parts_of(layer)) {
                    if (part.name != name && part.layer != name) continue;
                    is_there = true;
                    is_editable = is_editable || part.is_editable;
                    if (!part.is_editable) why = part.why;
                }
        if (!is_there)
            throw model::Error(codes::kUsage,
                               fmt::format("--layer: {}", tool::unknown_word("layer", name, part_names(maps))));
        if (!is_editable) throw model::Error(codes::kEditForbidden, fmt::format("--layer {}: {}", name, why), name);
    }
}

bool PartChoice::has(const MapPart& part) const {
    return names_.empty() || std::find(names_.begin(), names_.end(), part.name) != names_.end() ||
           std::find(names_.begin(), names_.end(), part.layer) != names_.end();
}

}  // namespace dgm::edit
