// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/painted_map.cpp
#include "edit/painted_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <variant>

#include "dgm/index.h"
#include "edit/texture_padding.h"
#include "edit/weld_agreement.h"
#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::edit {
namespace {

namespace codes = model::codes;
using model::Chart;
using model::ElementType;
using model::Layer;

template <class T>
void write(Layer& layer, std::size_t element, T value) {
    std::memcpy(layer.bytes.data() + element * sizeof(T), &value, sizeof(T));
}

template <class T>
T whole(double value) {
    const double low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
    return static_cast<T>(std::llround(std::clamp(value, low, high)));
}

void store_element(Layer& layer, std::size_t element, double value) {
    switch (layer.type) {
        case ElementType::kU8:
            return write(layer, element, whole<std::uint8_t>(value));
        case ElementType::kU16:
            return write(layer, element, whole<std::uint16_t>(value));
        case ElementType::kU32:
            return write(layer, element, whole<std::uint32_t>(value));
        case ElementType::kI16:
            return write(layer, element, whole<std::int16_t>(value));
        case ElementType::kF16:
            return write(layer, element, model::half_bits(static_cast<float>(value)));
        case ElementType::kF32:
            return write(layer, element, static_cast<float>(value));
    }
}

std::size_t samples_of(const Layer& layer) {
    const std::size_t numbers = std::size_t{numbers_of(layer)} * layout::element_size(layer.type);
    return layer.bytes.size() / std::max<std::size_t>(1, numbers);
}

bool is_grid_sized(const Chart& chart, const Layer& layer) {
    return layer.shape.size() >= 2 && layer.shape[0] == chart.rows && layer.shape[1] == chart.cols;
}

/// One line about a part that may not be edited.
std::string complaint(const PartEdit& edit, const Layer& layer) {
    if (edit.is_trusted)
        return fmt::format(
            "{} may not be edited, since {}; its bytes differ from their hash, and only the map as it was "
            "tells which samples: dgm-edit MAP.dgm --from THIS.dgm",
            edit.part.name, edit.part.why);
    const auto first = std::find(edit.changed.begin(), edit.changed.end(), 1) - edit.changed.begin();
    return fmt::format("{} may not be edited, since {}: {} of {} samples differ, by at most {:.4g}, first {}",
                       edit.part.name, edit.part.why, edit.samples, edit.changed.size(), edit.largest,
                       sample_place(edit.chart, layer, static_cast<std::size_t>(first)));
}

}  // namespace

double unit_of(const Layer& layer) {
    const auto scale = layer.attributes.find("scale");
    if (layer.name != model::layers::kBump || scale == layer.attributes.end()) return 1;
    const auto* values = std::get_if<std::vector<double>>(&scale->second);
    return values != nullptr && values->size() == 1 ? values->front() : 1;
}

std::string sample_place(std::size_t chart, const Layer& layer, std::size_t sample) {
    std::string out = formats::h5_place(chart, layer.name);
    std::vector<std::uint64_t> shape = layer.shape;
    if (shape.size() >= 2 && numbers_of(layer) > 1) shape.pop_back();
    std::string index;
    for (std::size_t k = shape.size(); k-- > 0; sample /= std::max<std::uint64_t>(1, shape[k]))
        index.insert(0, fmt::format("[{}]", sample % std::max<std::uint64_t>(1, shape[k])));
    return out + index;
}

PaintedMap::PaintedMap(const model::MapSet& maps, const PartChoice& choice)
    : original_(maps), choice_(choice), maps_(maps) {}

PartEdit* PaintedMap::edit_of(std::size_t chart, std::size_t layer, std::uint32_t number,
                              const std::filesystem::path& source) {
    const Layer& of = original_.charts[chart].layers[layer];
    for (const MapPart& part : parts_of(of)) {
        if (number < part.first || number >= part.first + part.count) continue;
        if (!choice_.has(part)) return nullptr;
        const auto [entry, is_new] = edits_.try_emplace({{chart, layer}, part.first});
        PartEdit& edit = entry->second;
        if (is_new) {
            edit.chart = chart;
            edit.layer = layer;
            edit.part = part;
            edit.numbers = numbers_of(of);
            edit.unit = unit_of(of);
            edit.source = source;
            edit.changed.assign(samples_of(of), 0);
        }
        return &edit;
    }
    return nullptr;
}

double PaintedMap::stored(const PartEdit& edit, std::uint32_t number, std::size_t sample) const {
    const Layer& layer = maps_.charts[edit.chart].layers[edit.layer];
    return model::element_value(layer, sample * edit.numbers + number);
}

void PaintedMap::store(const PartEdit& edit, std::uint32_t number, std::size_t sample, double value) {
    Layer& layer = maps_.charts[edit.chart].layers[edit.layer];
    store_element(layer, sample * edit.numbers + number, value);
}

void PaintedMap::mark(PartEdit& edit, std::size_t sample, double change) {
    if (edit.changed[sample] == 0) ++edit.samples;
    edit.changed[sample] = 1;
    const double far = std::abs(change) * edit.unit;
    edit.largest = std::isnan(far) ? std::numeric_limits<double>::infinity() : std::max(edit.largest, far);
}

bool PaintedMap::offer(PartEdit& edit, std::uint32_t number, std::size_t sample, double saved,
                       const Rounding& rounding) {
    const Layer& layer = original_.charts[edit.chart].layers[edit.layer];
    const double before = model::element_value(layer, sample * edit.numbers + number);
    if (is_untouched(before, saved, rounding)) return false;
    if (edit.part.is_editable)
        put(edit, number, sample, saved);
    else
        mark(edit, sample, saved - before);
    return true;
}

void PaintedMap::put(PartEdit& edit, std::uint32_t number, std::size_t sample, double saved) {
    const Layer& layer = original_.charts[edit.chart].layers[edit.layer];
    const double before = model::element_value(layer, sample * edit.numbers + number);
    if (!std::isfinite(saved))
        throw model::Error(codes::kNotFinite,
                           fmt::format("{}: {} was painted, which is no number", edit.part.name, saved),
                           sample_place(edit.chart, layer, sample))
            .with_hint("paint finite numbers; a division by zero in a node or filter makes others");
    if (layer.type == ElementType::kF16 && std::abs(saved) > model::kHalfMax)
        throw model::Error(codes::kBadValue,
                           fmt::format("{}: {:.6g} was painted, and the layer holds up to {:.6g}", edit.part.name,
                                       saved * edit.unit, model::kHalfMax * edit.unit),
                           sample_place(edit.chart, layer, sample))
            .with_hint("paint lower heights, or bake them as geometry");
    const double value = edit.part.is_unit ? std::clamp(saved, 0.0, 1.0) : saved;
    if (value != saved) ++edit.clamped;
    if (value == before) return;  // beyond the range, where the map has its end already
    store(edit, number, sample, value);
    mark(edit, sample, value - before);
}

void PaintedMap::trust(std::size_t chart, std::size_t layer, const std::filesystem::path& source) {
    const Layer& of = original_.charts[chart].layers[layer];
    const std::vector<MapPart> parts = parts_of(of);
    const bool is_free = std::any_of(parts.begin(), parts.end(), [](const MapPart& part) { return part.is_editable; });
    for (const MapPart& part : parts) {
        // Of a layer that may be painted in part, the validator judges the rest: it is computed from the positions.
        if (is_free && !part.is_editable) continue;
        PartEdit* edit = edit_of(chart, layer, part.first, source);
        if (edit == nullptr) continue;
        edit->is_trusted = true;
        if (!part.is_editable) continue;
        for (std::size_t sample = 0; sample < edit->changed.size(); ++sample)
            for (std::uint32_t c = part.first; c < part.first + part.count; ++c)
                put(*edit, c, sample, stored(*edit, c, sample));
        edit->samples = 0;
        std::fill(edit->changed.begin(), edit->changed.end(), char{1});
    }
}

void PaintedMap::leave_outside(PartEdit& edit) {
    const Chart& chart = original_.charts[edit.chart];
    const Layer* mask = chart.find(model::layers::kMask);
    if (mask == nullptr || !is_grid_sized(chart, chart.layers[edit.layer]) ||
        edit.part.layer == model::layers::kTexture || edit.part.layer == model::layers::kBump)
        return;
    const Layer& before = chart.layers[edit.layer];
    for (std::size_t s = 0; s < edit.changed.size(); ++s) {
        if (edit.changed[s] == 0 || model::element<std::uint8_t>(*mask, s) != 0) continue;
        for (std::uint32_t c = edit.part.first; c < edit.part.first + edit.part.count; ++c)
            store(edit, c, s, model::element_value(before, s * edit.numbers + c));
        edit.changed[s] = 0;
        if (edit.is_trusted) continue;
        --edit.samples;
        ++edit.outside;
    }
}

void PaintedMap::join_copies(PartEdit& edit) {
    const Chart& chart = original_.charts[edit.chart];
    const Layer& layer = maps_.charts[edit.chart].layers[edit.layer];
    // Whether the copies were alike before, nobody knows without the map as it was.
    if (layer.shape.size() < 2 || (edit.is_trusted && !edit.part.has_copies)) return;
    const auto rows = static_cast<std::uint32_t>(layer.shape[0]), cols = static_cast<std::uint32_t>(layer.shape[1]);
    if (std::size_t{rows} * cols != edit.changed.size()) return;
    const SeamSamples seam = samples_with_copies(seam_classes(chart, rows, cols), edit.changed);
    std::vector<double> numbers;
    for (const std::uint32_t sample : seam.samples)
        for (std::uint32_t c = 0; c < edit.part.count; ++c)
            numbers.push_back(stored(edit, edit.part.first + c, sample));
    const bool is_colour = edit.part.layer == model::layers::kTexture;
    const bool averages = is_colour || layer.type == ElementType::kF16 || layer.type == ElementType::kF32;
    for (const Agreement& copy : agree(seam.classes, seam.changed, numbers, edit.part.count, averages)) {
        for (std::uint32_t c = 0; c < edit.part.count; ++c)
            store(edit, edit.part.first + c, seam.samples[copy.sample], copy.value[c]);
        ++edit.joined;
    }
}

void PaintedMap::colour_padding(PartEdit& edit) {
    const Chart& chart = original_.charts[edit.chart];
    Layer& texture = maps_.charts[edit.chart].layers[edit.layer];
    if (edit.part.layer != model::layers::kTexture || edit.is_trusted || chart.domain != model::Domain::kFree) return;
    edit.padded = pad_texture(chart, edit.changed, texture);
}

void PaintedMap::finish() {
    std::string refusal, place;
    for (const auto& [key, edit] : edits_) {
        if (edit.part.is_editable || edit.is_empty()) continue;
        const Layer& layer = original_.charts[edit.chart].layers[edit.layer];
        if (place.empty()) place = formats::h5_place(edit.chart, layer.name);
        refusal += (refusal.empty() ? "" : "\n") + complaint(edit, layer);
    }
    if (!refusal.empty()) throw model::Error(codes::kEditForbidden, refusal, place);
    for (auto& [key, edit] : edits_) {
        if (edit.is_empty()) continue;
        leave_outside(edit);
        join_copies(edit);
        colour_padding(edit);
    }
}

std::vector<const PartEdit*> PaintedMap::edits() const {
    std::vector<const PartEdit*> out;
    for (const auto& [key, edit] : edits_) out.push_back(&edit);
    return out;
}

bool PaintedMap::is_unchanged() const {
    return maps_ == original_;
}

}  // namespace dgm::edit
