// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_sources.cpp
#include "edit/edit_sources.h"

#include <fmt/format.h>

#include <system_error>
#include <variant>

#include "dgm/dgm_reader.h"
#include "exr/exr_planes.h"
#include "mesh/mesh_formats.h"
#include "model/codes.h"
#include "model/element.h"
#include "model/file_errors.h"

namespace dgm::edit {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Chart;
using model::Layer;
using Meaning = formats::ExrPlane::Meaning;

constexpr unsigned kLow16 = 0xFFFF;

/// Half of a u32: compared with its half of the map's number, and put together with the other.
void offer_half(PaintedMap& map, PartEdit& edit, const Layer& layer, const formats::ExrPlane& plane, std::size_t k) {
    const std::size_t element = k * edit.numbers + plane.component;
    const auto before = model::element<std::uint32_t>(layer, element);
    const bool low = plane.meaning == Meaning::kLow16;
    const Rounding rounding = plane.is_half ? Rounding::half() : Rounding::exact();
    const double saved = static_cast<double>(plane.values[k]);
    if (is_untouched(low ? before & kLow16 : before >> 16, saved, rounding)) return;
    const auto now = model::element<std::uint32_t>(map.maps().charts[plane.chart].layers[plane.layer], element);
    const double value = low ? (now & ~kLow16) + saved : saved * (kLow16 + 1.0) + (now & kLow16);
    map.offer(edit, plane.component, k, value, Rounding::exact());
}

/// @throws model::Error kEditUnrelated
void check_charts(const model::MapSet& ours, const model::MapSet& theirs, const fs::path& path) {
    const auto refuse = [&](const std::string& message) {
        throw model::Error(codes::kEditUnrelated, message, path.string());
    };
    if (ours.charts.size() != theirs.charts.size())
        refuse(fmt::format("it has {} charts, the map {}", theirs.charts.size(), ours.charts.size()));
    for (std::size_t k = 0; k < ours.charts.size(); ++k) {
        const Chart &a = ours.charts[k], &b = theirs.charts[k];
        if (a.rows != b.rows || a.cols != b.cols || a.domain != b.domain)
            refuse(fmt::format("chart {} is {} x {}, the map's {} x {}{}", k, b.rows, b.cols, a.rows, a.cols,
                               a.domain != b.domain ? ", and of another domain" : ""));
    }
}

/// Attributes that a painter may change: how heights are stored, and how much of them a shader takes.
void offer_attributes(PaintedMap& map, std::size_t chart, std::size_t number, const Layer& theirs) {
    Layer& ours = map.maps().charts[chart].layers[number];
    for (const MapPart& part : parts_of(ours)) {
        if (!map.choice().has(part)) continue;
        if (part.name == "bump") {
            if (const auto shading = theirs.attributes.find("shading"); shading != theirs.attributes.end())
                ours.attributes["shading"] = shading->second;
        } else if (part.is_editable && part.name == part.layer && part.name != "texture") {
            ours.attributes = theirs.attributes;
        } else if (map.choice().is_all() && ours.attributes != theirs.attributes) {
            throw model::Error(codes::kEditForbidden, fmt::format("attributes of {} may not be edited", ours.name),
                               fmt::format("/charts/{}/{}", chart, ours.name));
        }
    }
}

void offer_layer(PaintedMap& map, std::size_t chart, std::size_t number, const Layer& theirs, const fs::path& path) {
    const Layer& ours = map.original().charts[chart].layers[number];
    const std::uint32_t numbers = numbers_of(ours);
    // Heights in the unit of the map.
    const double unit = unit_of(ours) > 0 ? unit_of(theirs) / unit_of(ours) : 1;
    for (std::uint32_t c = 0; c < numbers; ++c) {
        PartEdit* edit = map.edit_of(chart, number, c, path);
        if (edit == nullptr) continue;
        for (std::size_t k = 0; k < edit->changed.size(); ++k)
            map.offer(*edit, c, k, unit * model::element_value(theirs, k * numbers + c), Rounding::exact());
    }
}

}  // namespace

void offer_edit(PaintedMap& map, const fs::path& source) {
    std::error_code error;
    const fs::file_status status = fs::status(source, error);
    if (!fs::exists(status)) throw model::missing_file_or_folder(source);
    if (source.extension() == ".dgm") return offer_dgm(map, source);
    if (!fs::is_directory(status)) formats::check_map_name(source);
    const bool is_layers = !fs::is_directory(status) && formats::has_exr_description(source);
    if (!is_layers && (fs::is_directory(status) || source.extension() == ".json" || is_plain_map(source)))
        return offer_plain_maps(map, source);
    if (source.extension() == ".png")
        throw model::Error(codes::kEditUnrelated, "no maps.json beside it lists a map of this name", source.string())
            .with_hint("keep the pictures and the JSON of dgm-export --maps together, and their names");
    offer_exr(map, source);
}

void offer_exr(PaintedMap& map, const fs::path& exr) {
    for (const formats::ExrPlane& plane : formats::read_exr_planes(exr, map.original().charts)) {
        PartEdit* edit = map.edit_of(plane.chart, plane.layer, plane.component, plane.file);
        if (edit == nullptr || plane.values.size() != edit->changed.size()) continue;
        const Layer& layer = map.original().charts[plane.chart].layers[plane.layer];
        const bool is_split = plane.meaning == Meaning::kLow16 || plane.meaning == Meaning::kHigh16;
        // Codes of a texture come back exactly, whatever the file rounds to.
        const bool rounds = plane.is_half && plane.meaning == Meaning::kValue;
        for (std::size_t k = 0; k < plane.values.size(); ++k) {
            if (is_split)
                offer_half(map, *edit, layer, plane, k);
            else
                map.offer(*edit, plane.component, k, static_cast<double>(plane.values[k]),
                          rounds ? Rounding::half() : Rounding::exact());
        }
    }
}

void offer_dgm(PaintedMap& map, const fs::path& dgm) {
    const formats::ChangedDgm theirs = formats::read_changed_dgm(dgm);
    const model::MapSet& ours = map.original();
    check_charts(ours, theirs.maps, dgm);
    for (std::size_t c = 0; c < ours.charts.size(); ++c) {
        const Chart &a = ours.charts[c], &b = theirs.maps.charts[c];
        if (map.choice().is_all() && (a.offset != b.offset || a.scale != b.scale))
            throw model::Error(codes::kEditUnrelated, fmt::format("chart {} lies elsewhere in space", c), dgm.string());
        for (std::size_t l = 0; l < a.layers.size(); ++l) {
            const Layer* other = b.find(a.layers[l].name);
            if (other == nullptr) continue;  // what is not there was not edited
            bool is_asked = false;
            for (const MapPart& part : parts_of(a.layers[l])) is_asked = is_asked || map.choice().has(part);
            if (!is_asked) continue;
            if (other->type != a.layers[l].type || other->shape != a.layers[l].shape)
                throw model::Error(
                    codes::kEditUnrelated,
                    fmt::format("layer {} of chart {} is {} {}, the map's {} {}", other->name, c,
                                model::type_name(other->type), model::shape_text(other->shape),
                                model::type_name(a.layers[l].type), model::shape_text(a.layers[l].shape)),
                    dgm.string());
            offer_attributes(map, c, l, *other);
            offer_layer(map, c, l, *other, dgm);
        }
    }
}

}  // namespace dgm::edit
