// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/map_stream.cpp
#include "process/map_stream.h"

#include "process/attribute_stream.h"

namespace dgm::bake {
namespace {

void put_layer(ByteWriter& out, const model::Layer& layer) {
    out.put(layer.name);
    out.put(layer.type);
    out.put_all(layer.shape);
    put_attributes(out, layer.attributes);
    out.put(static_cast<char>(layer.required));
    out.put(std::uint64_t{layer.bytes.size()});
}

/// @return its size in bytes; nullopt if that does not follow from its shape
std::optional<std::uint64_t> get_layer(ByteReader& in, model::Layer& layer) {
    layer.name = in.text();
    layer.type = in.get<model::ElementType>();
    in.get_all(layer.shape);
    layer.attributes = get_attributes(in);
    layer.required = in.get<char>() != 0;
    const auto bytes = in.get<std::uint64_t>();
    std::uint64_t right = layout::element_size(layer.type);
    const std::optional<std::uint64_t> elements = elements_of(layer);
    if (right == 0 || !elements || __builtin_mul_overflow(right, *elements, &right)) return std::nullopt;
    if (bytes != 0 && bytes != right) return std::nullopt;  // none for pixels that were skipped
    return bytes;
}

}  // namespace

std::optional<std::uint64_t> elements_of(const model::Layer& layer) {
    std::uint64_t out = 1;
    if (layer.shape.empty() || layer.shape.size() > layout::kMaxRank) return std::nullopt;
    for (const std::uint64_t extent : layer.shape)
        if (__builtin_mul_overflow(out, extent, &out)) return std::nullopt;
    return out;
}

void put_charts(ByteWriter& out, const std::vector<model::Chart>& charts) {
    out.put_each(charts, [&](const model::Chart& chart) {
        out.put(chart.rows);
        out.put(chart.cols);
        out.put(chart.domain);
        out.put(chart.method);
        out.put(chart.bbox);
        out.put(chart.offset);
        out.put(chart.scale);
        out.put_each(chart.layers, [&](const model::Layer& layer) { put_layer(out, layer); });
    });
}

std::optional<ChartHeads> get_charts(ByteReader& in) {
    ChartHeads out;
    bool fits = true;
    in.get_each([&] {
        model::Chart& chart = out.charts.emplace_back();
        chart.rows = in.get<std::uint32_t>();
        chart.cols = in.get<std::uint32_t>();
        chart.domain = in.get<model::Domain>();
        fits = fits && (chart.domain == model::Domain::kSquare || chart.domain == model::Domain::kFree);
        chart.method = in.text();
        chart.bbox = in.get<decltype(chart.bbox)>();
        chart.offset = in.get<decltype(chart.offset)>();
        chart.scale = in.get<decltype(chart.scale)>();
        in.get_each([&] {
            const std::optional<std::uint64_t> size = get_layer(in, chart.layers.emplace_back());
            fits = fits && size && !__builtin_add_overflow(out.total, *size, &out.total);
            out.sizes.push_back(size.value_or(0));
        });
    });
    return fits ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace dgm::bake
