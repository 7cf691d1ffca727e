// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/test_maps.cpp
#include "test_maps.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "model/error.h"

namespace dgm::test {
namespace {

using layout::ElementType;
using model::Chart;
using model::Layer;

Layer random_layer(Random& random, std::string name, ElementType type, std::vector<std::uint64_t> shape) {
    Layer layer;
    layer.name = std::move(name);
    layer.type = type;
    layer.shape = std::move(shape);
    std::uint64_t size = layout::element_size(type);
    for (const std::uint64_t extent : layer.shape) size *= extent;
    layer.bytes.resize(size);
    for (std::byte& byte : layer.bytes) byte = static_cast<std::byte>(random.next() & 255);
    return layer;
}

}  // namespace

std::uint64_t Random::next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

Chart random_chart(Random& random, const MapChoice& choice) {
    using enum ElementType;
    const std::uint64_t m = choice.rows, n = choice.cols;
    Chart chart;
    chart.rows = choice.rows;
    chart.cols = choice.cols;
    chart.domain = choice.free_domain ? model::Domain::kFree : model::Domain::kSquare;
    chart.method = choice.free_domain ? "lscm" : "stretch";
    for (std::size_t k = 0; k < 3; ++k) {
        chart.bbox[k] = -random.unit() * 1e7;
        chart.bbox[k + 3] = random.unit() / 3;
        chart.offset[k] = random.unit() * 1e7;
        if (choice.u16_geometry) chart.scale[k] = random.unit() / 65535;
    }
    auto add = [&](const char* name, ElementType type, std::vector<std::uint64_t> shape) -> Layer& {
        return chart.layers.emplace_back(random_layer(random, name, type, std::move(shape)));
    };
    const std::uint64_t mt = choice.same_size_textures ? m : 2 * m + 1, nt = choice.same_size_textures ? n : n + 5;
    add("geometry", choice.u16_geometry ? kU16 : kF32, {m, n, 3}).required = true;
    add("normal", kI16, {m, n, 2});
    add("texture", kU8, {mt, nt, 4}).attributes["colour_space"] = std::string("sRGB");
    add("bump", kF16, {mt, nt}).attributes["amplitude"] = std::vector<double>{0.1, -1e300, 5e-324};
    add("collision", kF32, {85, 6}).attributes["levels"] = std::vector<std::uint32_t>{8, 8, 4, 4, 2, 2, 1, 1};
    add("cover", kF32, {m, n});
    add("deformation", kF32, {m, n, 4});
    add("contact", kF32, {m, n, 2});
    const std::uint64_t pairs = random.below(50);
    add("seams", kU32, {pairs, 2});
    add("reversed", kU8, {pairs}).required = true;
    add("diagonals", kU8, {m - 1, n - 1});
    if (choice.free_domain) {
        const std::uint64_t k = 3 + random.below(40);
        add("mask", kU8, {m, n});
        add("border_uv", kF32, {k, 2});
        add("border_geometry", kF32, {k, 3});
        add("border_normal", kI16, {k, 2});
        add("border_faces", kU32, {2 * k, 3});
    }
    if (choice.unknown_layers) {
        add("x_u8", kU8, {7});
        add("x_u16", kU16, {3, 4, 5, 2});
        add("x_u32", kU32, {n, m});
        add("x_i16", kI16, {2, 9, 11});
        add("x_f16", kF16, {1});
        add("x_f32", kF32, {m, n});
        add("x_empty", kF32, {0, 4});
    }
    return chart;
}

model::MapSet random_maps(std::uint64_t seed, std::size_t charts) {
    Random random(seed);
    model::MapSet maps;
    maps.generator = "test 1.0";
    maps.source_name = "m\xC3\xA9sh with spaces.obj";
    for (auto* hash : {&maps.source_hash, &maps.settings_hash})
        for (std::uint8_t& byte : *hash) byte = static_cast<std::uint8_t>(random.next());
    maps.report_json = R"({"rms":1.25e-05,"text":"caf\u00e9"})";
    for (std::size_t k = 0; k < charts; ++k) {
        MapChoice choice;
        choice.rows = static_cast<std::uint32_t>(3 + random.below(20));
        choice.cols = static_cast<std::uint32_t>(3 + random.below(20));
        choice.free_domain = k % 2 == 1;
        choice.u16_geometry = k % 3 == 2;
        choice.unknown_layers = k % 4 == 0;
        choice.same_size_textures = k % 5 == 4;
        maps.charts.push_back(random_chart(random, choice));
    }
    return maps;
}

int code_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const model::Error& error) { return error.code().number; }
    return 0;
}

std::string read_bytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot read " + path.string());
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace dgm::test
