// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/page_map.cpp
#include "page/page_map.h"

#include <dgm/asset.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "dgm/dgm_writer.h"
#include "image/image.h"
#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"
#include "page/grid_codes.h"

namespace dgm::page {
namespace {
using model::Chart;
using model::ElementType;
using model::Layer;
namespace layers = model::layers;

constexpr double kCodes = 65535;
constexpr int kJpegQuality = 88;  // of the organs' textures: no block is seen at one pixel a texel

/// True if component `k` of `layer`, of `each` numbers a sample, is 1 everywhere.
bool all_one(const Layer& layer, std::size_t each, std::size_t k) {
    if (layer.type != ElementType::kF32) return false;
    for (std::size_t s = k; s < layer.bytes.size() / sizeof(float); s += each)
        if (model::element<float>(layer, s) != 1) return false;
    return true;
}

bool needed(const Layer& layer) {
    constexpr std::array kTables{layers::kGeometry,       layers::kMaterial,  layers::kSeams,
                                 layers::kReversed,       layers::kDiagonals, layers::kMask,
                                 layers::kBorderGeometry, layers::kBorderUv,  layers::kBorderFaces};
    if (layer.name == layers::kDeformation) return !all_one(layer, 4, 3);
    if (layer.name == layers::kContact) return !all_one(layer, 2, 1);
    return std::find(kTables.begin(), kTables.end(), layer.name) != kTables.end();
}

/// Samples on the surface: all, or those of the mask.
bool on_surface(const Layer* mask, std::size_t sample) {
    return mask == nullptr || model::element<std::uint8_t>(*mask, sample) != 0;
}

/// Positions of 32 bits become codes of one step on all axes, and the border's follow the new offset.
void quantise(Chart& chart) {
    Layer& geometry = *chart.find(layers::kGeometry);
    const Layer* mask = chart.find(layers::kMask);
    const std::size_t grid = std::size_t{chart.rows} * chart.cols;
    std::array<double, 3> low, high;
    low.fill(std::numeric_limits<double>::infinity()), high.fill(-std::numeric_limits<double>::infinity());
    const auto local = [&](std::size_t s, std::size_t k) {
        return chart.scale[k] * double{model::element<float>(geometry, 3 * s + k)};
    };
    for (std::size_t s = 0; s < grid; ++s)
        for (std::size_t k = 0; on_surface(mask, s) && k < 3; ++k) {
            low[k] = std::min(low[k], local(s, k));
            high[k] = std::max(high[k], local(s, k));
        }
    double extent = 0;
    for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, high[k] - low[k]);
    const double step = extent > 0 && std::isfinite(extent) ? extent / kCodes : 1;
    std::vector<std::byte> codes(2 * 3 * grid);
    for (std::size_t s = 0; s < grid; ++s)
        for (std::size_t k = 0; k < 3; ++k) {
            const double place = on_surface(mask, s) ? std::round((local(s, k) - low[k]) / step) : 0;
            const auto code = static_cast<std::uint16_t>(place >= 0 ? std::min(place, kCodes) : 0);
            std::memcpy(codes.data() + 2 * (3 * s + k), &code, 2);
        }
    if (Layer* border = chart.find(layers::kBorderGeometry); border != nullptr && border->type == ElementType::kF32)
        for (std::size_t e = 0; e < border->bytes.size() / sizeof(float); ++e) {
            const auto moved = static_cast<float>(double{model::element<float>(*border, e)} - low[e % 3]);
            std::memcpy(border->bytes.data() + e * sizeof(float), &moved, sizeof(float));
        }
    for (std::size_t k = 0; k < 3; ++k) chart.offset[k] += std::isfinite(low[k]) ? low[k] : 0, chart.scale[k] = step;
    geometry.type = ElementType::kU16;
    geometry.bytes = std::move(codes);
}

void check_geometry(const Chart& chart) {
    const Layer* geometry = chart.find(layers::kGeometry);
    if (geometry == nullptr) throw model::Error(model::codes::kMissingLayer, "a chart has no layer geometry");
    const std::size_t each = geometry->type == ElementType::kU16 ? 2 : 4;
    const bool known = geometry->type == ElementType::kU16 || geometry->type == ElementType::kF32;
    const std::size_t grid = std::size_t{chart.rows} * chart.cols;
    const Layer* mask = chart.find(layers::kMask);
    if (!known || geometry->bytes.size() != 3 * each * grid || (mask != nullptr && mask->bytes.size() != grid))
        throw model::Error(model::codes::kBadLayerShape, "the layer geometry or mask does not fit the grid");
}

std::vector<std::byte> bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!in) throw model::Error(model::codes::kReadFailed, "the file cannot be read", file.string());
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}
}  // namespace

model::MapSet touch_layers(const model::MapSet& maps) {
    model::MapSet out;
    out.generator = maps.generator;
    out.source_name = maps.source_name;
    out.source_hash = maps.source_hash;
    out.settings_hash = maps.settings_hash;
    out.report_json = "{}";
    for (const Chart& chart : maps.charts) {
        Chart& kept = out.charts.emplace_back(chart);
        std::erase_if(kept.layers, [](const Layer& layer) { return !needed(layer); });
        check_geometry(kept);
        if (kept.find(layers::kGeometry)->type == ElementType::kF32) quantise(kept);
    }
    return out;
}

std::vector<PagePicture> page_pictures(const model::MapSet& maps) {
    std::vector<PagePicture> out;
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        const Layer* texture = maps.charts[k].find(layers::kTexture);
        if (texture == nullptr || texture->type != ElementType::kU8 || texture->shape.size() != 3 ||
            texture->shape[2] != 4)
            continue;
        formats::Image image{
            static_cast<std::uint32_t>(texture->shape[1]), static_cast<std::uint32_t>(texture->shape[0]), {}};
        image.pixels.resize(std::size_t{image.width} * image.height);
        if (texture->bytes.size() != 4 * image.pixels.size()) continue;
        std::memcpy(image.pixels.data(), texture->bytes.data(), texture->bytes.size());
        const bool solid =
            std::all_of(image.pixels.begin(), image.pixels.end(), [](const model::Rgba8& p) { return p.a == 255; });
        PagePicture& picture = out.emplace_back(PagePicture{k, "image/png", formats::encode_png(image)});
        if (!solid) continue;
        std::vector<std::byte> photo = formats::encode_jpeg(image, kJpegQuality);
        if (photo.size() < picture.bytes.size()) picture.type = "image/jpeg", picture.bytes = std::move(photo);
    }
    return out;
}

PackedMap packed_map(const model::MapSet& maps, const std::filesystem::path& scratch) {
    formats::write_dgm(touch_layers(maps), scratch);
    PackedMap out{bytes_of(scratch), {}};
    const auto failed = [](const Error& error) { return model::Error(model::codes::kBadValue, error.message); };
    const Result<Asset> asset = Asset::open(scratch.c_str());
    if (!asset) throw failed(asset.error());
    for (std::uint32_t k = 0; k < asset.value().chart_count(); ++k) {
        const Result<dgm::Chart> chart = asset.value().chart(k);
        if (!chart) throw failed(chart.error());
        const Result<LayerView> geometry = chart.value().find(layers::kGeometry);
        if (!geometry) throw failed(geometry.error());
        const LayerView& view = geometry.value();
        code_grid(std::span(out.bytes).subspan(view.file_offset, view.bytes), maps.charts[k].rows, maps.charts[k].cols);
        out.grids +=
            fmt::format("{}{},{},{}", k > 0 ? " " : "", view.file_offset, maps.charts[k].rows, maps.charts[k].cols);
    }
    return out;
}

}  // namespace dgm::page
