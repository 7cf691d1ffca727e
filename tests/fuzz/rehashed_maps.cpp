// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/rehashed_maps.cpp
#include "rehashed_maps.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include <dgm/limits.h>
#include <dgm/reconstruct.h>

#include "dgm/dgm_writer.h"
#include "exr/exr_writer.h"
#include "model/error.h"
#include "random_maps.h"
#include "support/rehash.h"
#include "unit/validate/validation_maps.h"

namespace dgm::test {
namespace {

/// The box of the reconstruction: the validator asks for it.
void set_box(const ChartSpec& spec, model::Chart& chart) {
    const Image image = build({spec});
    const auto asset = Asset::open_memory(image.bytes);
    if (!asset) return;
    const Chart opened = asset.value().chart(0).value();
    const auto counts = mesh_counts(opened);
    if (!counts) return;
    std::vector<Vec3> points(counts.value().vertices);
    std::vector<std::uint32_t> corners(static_cast<std::size_t>(counts.value().indices));
    VertexTarget target;
    target.memory = std::as_writable_bytes(std::span(points));
    if (!reconstruct(opened, target, corners) || corners.empty()) return;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto at = [&](std::uint32_t v) {
            const Vec3 p = points[v];
            return chart.offset[a] + double{a == 0 ? p.x : a == 1 ? p.y : p.z};
        };
        chart.bbox[a] = chart.bbox[a + 3] = at(corners[0]);
        for (const std::uint32_t v : corners) {
            chart.bbox[a] = std::min(chart.bbox[a], at(v));
            chart.bbox[a + 3] = std::max(chart.bbox[a + 3], at(v));
        }
    }
}

model::Chart chart_of(const ChartSpec& spec) {
    model::Chart chart;
    chart.rows = spec.rows;
    chart.cols = spec.cols;
    chart.domain = spec.domain;
    chart.method = spec.method;
    std::copy(spec.offset.begin(), spec.offset.end(), chart.offset.begin());
    std::copy(spec.scale.begin(), spec.scale.end(), chart.scale.begin());
    for (const LayerSpec& from : spec.layers) {
        model::Layer& layer = chart.layers.emplace_back();
        layer.name = from.name;
        layer.type = from.type;
        layer.shape = from.shape;
        layer.bytes = from.bytes;
        layer.required = (from.flags & layout::kLayerRequired) != 0;
    }
    set_box(spec, chart);
    return chart;
}

template <class T>
void put(Dice& dice, std::vector<std::byte>& bytes, T value) {
    if (bytes.size() < sizeof value) return;
    const auto places = static_cast<std::uint32_t>(bytes.size() / sizeof value);
    std::memcpy(bytes.data() + sizeof value * dice.below(places), &value, sizeof value);
}

/// Values that the type allows, at the ends of what the format allows as well.
void change_layer(Dice& dice, model::Layer& layer) {
    for (std::uint32_t k = dice.between(1, 4); k > 0; --k) {
        if (layer.type == model::ElementType::kF32)
            put(dice, layer.bytes, dice.one_in(3) ? dice.absurd() : dice.size(-kMaxCoordinate, kMaxCoordinate));
        else if (layer.type == model::ElementType::kU32)
            put(dice, layer.bytes, dice.one_in(2) ? dice.below(1200) : static_cast<std::uint32_t>(dice.bits()));
        else
            put(dice, layer.bytes, static_cast<std::uint8_t>(dice.one_in(2) ? dice.below(3) : dice.below(256)));
    }
}

void change_content(Dice& dice, model::MapSet& maps) {
    model::Chart& chart = maps.charts[dice.below(static_cast<std::uint32_t>(maps.charts.size()))];
    switch (dice.below(7)) {
        case 0:
            chart.scale[dice.below(3)] = dice.of({1e-300, 1e-12, 1e13, 1e300, 5e-324});
            break;
        case 1:
            chart.offset[dice.below(3)] = dice.of({1e300, -1e300, 1e-300, 1e18});
            break;
        case 2:
            chart.bbox[dice.below(6)] = dice.of({0.0, 1e308, -1e308, 1e-320});
            break;
        case 3:
            maps.report_json.insert(dice.below(static_cast<std::uint32_t>(maps.report_json.size()) + 1),
                                    dice.of({"[[[[[[[[", "{\"a\":", "1e999", "\xff", "-", "null,", "\"\\u0000\""}));
            break;
        case 4:
            maps.source_name = dice.of({"", "../../etc/passwd", "\x1b[2J\a", "a\nb", "/", "."});
            break;
        case 5:
            if (!chart.layers.empty()) {
                model::Layer& layer = chart.layers[dice.below(static_cast<std::uint32_t>(chart.layers.size()))];
                layer.attributes[dice.of({"levels", "space", "x", "scale"})] =
                    dice.one_in(2) ? model::AttributeValue(std::vector<std::uint32_t>(dice.below(9), 0xFFFFFFFFu))
                                   : model::AttributeValue(std::string(dice.below(300), 'a'));
            }
            break;
        default:
            if (!chart.layers.empty())
                change_layer(dice, chart.layers[dice.below(static_cast<std::uint32_t>(chart.layers.size()))]);
    }
}

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A number anywhere in [begin, begin + bytes).
void change_word(Dice& dice, std::string& file, std::size_t begin, std::size_t bytes) {
    static constexpr std::size_t kWidths[] = {1, 1, 2, 4, 8};
    const std::size_t width = std::min(kWidths[dice.below(5)], bytes);
    std::uint64_t value = 0;
    const std::size_t at = begin + dice.below(static_cast<std::uint32_t>(bytes - width + 1));
    std::memcpy(&value, file.data() + at, width);
    switch (dice.below(6)) {
        case 0:
            value = 0;
            break;
        case 1:
            value = ~std::uint64_t{0};
            break;
        case 2:
            value += dice.one_in(2) ? 1 : -1;
            break;
        case 3:
            value = file.size() - dice.below(64);
            break;
        case 4:
            value ^= std::uint64_t{1} << dice.below(static_cast<std::uint32_t>(8 * width));
            break;
        default:
            value = dice.bits();
    }
    std::memcpy(file.data() + at, &value, width);
}

void change_bytes(Dice& dice, std::string& file) {
    const std::vector<Hdf5Block> blocks = hdf5_blocks(file);
    layout::FileHeader header;
    std::memcpy(&header, file.data(), sizeof header);
    for (std::uint32_t k = dice.between(1, 4); k > 0; --k) {
        const std::uint32_t what = dice.below(8);
        if (what < 4 && !blocks.empty()) {
            const Hdf5Block& b = blocks[dice.below(static_cast<std::uint32_t>(blocks.size()))];
            change_word(dice, file, b.begin + 4, b.bytes - 4);
        } else if (what < 6) {
            change_word(dice, file, header.index_offset, header.index_bytes);
        } else if (what < 7) {
            change_word(dice, file, 8, sizeof header - 8);
        } else {
            change_word(dice, file, layout::kUserBlockBytes, file.size() - layout::kUserBlockBytes);
        }
    }
    mend_checksums(file, blocks);
}

}  // namespace

model::MapSet random_map_set(Dice& dice) {
    model::MapSet maps = good_maps();
    if (dice.one_in(4)) return maps;
    maps.charts.clear();
    maps.report_json.clear();
    for (std::uint32_t k = dice.one_in(4) ? 2 : 1; k > 0; --k) {
        const ChartSpec spec = random_chart(dice);
        maps.charts.push_back(chart_of(spec));
    }
    return maps;
}

std::string rehashed_dgm(Dice& dice, const std::filesystem::path& scratch) {
    model::MapSet maps = random_map_set(dice);
    if (dice.one_in(2)) change_content(dice, maps);
    try {
        formats::write_dgm(maps, scratch);
    } catch (const model::Error&) {  // the writer refuses it: then without the change
        formats::write_dgm(good_maps(), scratch);
    }
    std::string file = bytes_of(scratch);
    if (!dice.one_in(3)) change_bytes(dice, file);
    mend_hashes(file);
    return file;
}

std::string rehashed_exr(Dice& dice, const std::filesystem::path& scratch) {
    model::MapSet maps = random_map_set(dice);
    for (model::Chart& chart : maps.charts)  // layers of another size stand in files of their own
        std::erase_if(chart.layers, [](const auto& l) { return l.name == "texture" || l.name == "bump"; });
    if (!dice.one_in(3)) change_content(dice, maps);
    const auto layout = dice.one_in(2) ? formats::ExrLayout::kMultipart : formats::ExrLayout::kAuto;
    try {
        formats::write_exr(maps, scratch, {layout});
    } catch (const model::Error&) { formats::write_exr(good_maps(), scratch, {layout}); }
    std::string file = bytes_of(scratch);
    if (dice.one_in(2))
        for (std::uint32_t k = dice.between(1, 4); k > 0; --k)
            change_word(dice, file, 0, dice.one_in(4) ? file.size() : std::min<std::size_t>(file.size(), 4000));
    return file;
}

}  // namespace dgm::test
