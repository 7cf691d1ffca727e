// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/random_maps.cpp
#include "random_maps.h"

#include <algorithm>
#include <numeric>

#include <dgm/limits.h>

namespace dgm::test {
namespace {
using Uints = std::vector<std::uint32_t>;

/// A surface, a size and a place, all of them extreme now and then; within kMaxCoordinate.
std::function<Point(double, double)> random_shape(Dice& dice, std::uint32_t m, std::uint32_t n) {
    const std::uint32_t kind = dice.below(7);
    const double size = dice.one_in(3) ? dice.of({1e-38, 1e-30, 1e-15, 1e-6, 1e6, 1e15, 1e16}) : 1;
    const double away = dice.one_in(6) ? dice.of({1e3, 1e7, 5e17}) : 0;
    const std::uint64_t seed = dice.bits();
    return [=](double i, double j) {
        const double u = i / (m - 1), v = j / (n - 1);
        double p[3] = {i, j, 0};
        const auto noise = [&](std::uint64_t k) {
            std::uint64_t z =
                seed + k + static_cast<std::uint64_t>(i * 64) * 7919 + static_cast<std::uint64_t>(j * 64) * 104729;
            z = (z ^ z >> 31) * 0xBF58476D1CE4E5B9u;
            z = (z ^ z >> 29) * 0x94D049BB133111EBu;
            return static_cast<double>(z >> 11) * 0x1p-52 - 1;
        };
        switch (kind) {
            case 0:
            case 1:
                p[2] = 0.3 * std::sin(0.37 * i) * std::cos(0.23 * j);
                break;
            case 2:  // a ball of about unit steps
                p[0] = m / 3.0 * std::sin(3.1 * u + 0.02) * std::cos(6.2 * v);
                p[1] = m / 3.0 * std::sin(3.1 * u + 0.02) * std::sin(6.2 * v);
                p[2] = m / 3.0 * std::cos(3.1 * u + 0.02);
                break;
            case 3:
                for (std::uint64_t k = 0; k < 3; ++k) p[k] = 3 * noise(k);
                break;
            case 4:  // one point
                p[0] = p[1] = 1;
                break;
            case 5:  // a line
                p[1] = 0;
                break;
            default:  // steps of all lengths
                p[0] = std::pow(1.7, i);
                p[2] = noise(1) < -0.9 ? 1e3 : 0;
                break;
        }
        Point out;
        for (std::size_t k = 0; k < 3; ++k)
            out[k] =
                static_cast<float>(std::clamp(p[k] * size + away, -double{kMaxCoordinate}, double{kMaxCoordinate}));
        return out;
    };
}

Uints border_of(std::uint32_t m, std::uint32_t n) {
    Uints border;
    for (std::uint32_t k = 0; k < m * n; ++k)
        if (k / n == 0 || k % n == 0 || k / n == m - 1 || k % n == n - 1) border.push_back(k);
    return border;
}

/// Joins any pairs into classes: the lowest index first, each copy once.
SeamPairs classes_of(const SeamPairs& joined, std::uint32_t total) {
    Uints lowest(total);
    std::iota(lowest.begin(), lowest.end(), 0u);
    const auto find = [&](std::uint32_t k) {
        while (lowest[k] != k) k = lowest[k];
        return k;
    };
    for (const auto& [a, b] : joined) {
        const std::uint32_t x = find(a), y = find(b);
        lowest[std::max(x, y)] = std::min(x, y);
    }
    SeamPairs pairs;
    for (std::uint32_t k = 0; k < total; ++k)
        if (find(k) != k) pairs.push_back({find(k), k});
    return pairs;
}

SeamPairs random_pairs(Dice& dice, const Uints& from) {
    SeamPairs pairs;
    if (from.size() < 2) return pairs;
    const auto count = static_cast<std::uint32_t>(from.size());
    const std::uint32_t first = dice.below(count), second = dice.below(count), length = dice.below(count);
    switch (dice.below(4)) {
        case 0:  // single ones
            for (std::uint32_t k = 0; k < dice.below(6) + 1; ++k)
                pairs.push_back({from[dice.below(count)], from[dice.below(count)]});
            break;
        case 1:  // a path, run through in opposite directions
            for (std::uint32_t k = 0; k < length; ++k)
                pairs.push_back({from[(first + k) % count], from[(second + count - k) % count]});
            break;
        case 2:  // the same way: no surface is glued so, but a table may say it
            for (std::uint32_t k = 0; k < length; ++k)
                pairs.push_back({from[(first + k) % count], from[(second + k) % count]});
            break;
        default:  // all one point
            for (std::uint32_t k = 0; k < length; ++k) pairs.push_back({from[first], from[(first + k) % count]});
    }
    return pairs;
}

SeamPairs square_pairs(Dice& dice, std::uint32_t m, std::uint32_t n) {
    SeamPairs pairs;
    switch (dice.below(7)) {
        case 0:
            return tube_seams(m, n);
        case 1:  // a torus
            pairs = tube_seams(m, n);
            for (std::uint32_t j = 0; j < n; ++j) pairs.push_back({j, (m - 1) * n + j});
            return pairs;
        case 2:
            return fold_seams(m, n);
        case 3:
            return m == n ? corner_seams(m) : tube_seams(m, n);
        case 4:
            return m == n ? octahedral_seams(m) : fold_seams(m, n);
        case 5:
            return random_pairs(dice, border_of(m, n));
        default:
            return pairs;
    }
}

template <class T>
std::vector<T> values_of(const LayerSpec& layer) {
    std::vector<T> values(layer.bytes.size() / sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), layer.bytes.data(), layer.bytes.size());
    return values;
}

/// Geometry (and that of the border, if codes are wanted there too) as u16 codes.
void quantise(Dice& dice, ChartSpec& chart) {
    for (double& s : chart.scale) s = dice.one_in(4) ? dice.of({1e-40, 1e-20, 1e13}) : 0.001;
    LayerSpec& layer = chart.layer("geometry");
    const std::vector<float> values = values_of<float>(layer);
    std::vector<std::uint16_t> codes;
    for (const float v : values)
        codes.push_back(static_cast<std::uint16_t>(std::clamp(std::fabs(v) * 1000.0, 0.0, 65535.0)));
    layer.type = ElementType::kU16;
    layer.bytes.assign(codes.size() * 2, {});
    std::memcpy(layer.bytes.data(), codes.data(), layer.bytes.size());
}

float share(Dice& dice) {
    return dice.one_in(3) ? dice.of({0.0f, 1.0f, 1e-45f, 1e-30f, 1e-6f, 0.999999f}) : dice.real(0, 1);
}

void add_behaviour(Dice& dice, ChartSpec& chart) {
    const std::size_t grid = std::size_t{chart.rows} * chart.cols;
    if (dice.one_in(3)) {
        const bool extreme = dice.one_in(2);
        std::vector<float> all;
        for (std::size_t k = 0; k < grid; ++k) {
            const float e = extreme ? dice.size(0, kMaxForm) : 1, g = extreme ? dice.size(0, kMaxForm) : 1;
            all.insert(all.end(), {e, extreme && dice.one_in(4) ? dice.size(0, kMaxForm) : 0, g, share(dice)});
        }
        chart.add("deformation", ElementType::kF32, {chart.rows, chart.cols, 4}, all);
    }
    if (dice.one_in(3)) {
        std::vector<float> all;
        const std::uint32_t kind = dice.below(3);
        for (std::size_t k = 0; k < grid; ++k) all.insert(all.end(), {1, kind == 0 ? 0 : kind == 1 ? 1 : share(dice)});
        chart.add("contact", ElementType::kF32, {chart.rows, chart.cols, 2}, all);
    }
}

void add_pictures(Dice& dice, ChartSpec& chart) {
    const std::size_t grid = std::size_t{chart.rows} * chart.cols;
    if (dice.one_in(2)) {
        std::vector<std::int16_t> codes(2 * grid);
        for (auto& c : codes) c = static_cast<std::int16_t>(dice.bits());
        chart.add("normal", ElementType::kI16, {chart.rows, chart.cols, 2}, codes);
        const std::vector<std::int16_t> border(2 * std::size_t{chart.border_samples}, 99);
        if (!border.empty() && !dice.one_in(4))
            chart.add("border_normal", ElementType::kI16, {chart.border_samples, 2}, border);
    }
    if (dice.one_in(8)) chart.add("texture", ElementType::kU8, {3, 2, 4}, std::vector<std::uint8_t>(24, 9));
    if (dice.one_in(8)) chart.add("bump", ElementType::kF16, {2, 2}, std::vector<std::uint16_t>(4, 0x7C00));
    if (dice.one_in(8))
        chart.add("cover", ElementType::kF32, {chart.rows, chart.cols}, std::vector<float>(grid, dice.absurd()));
    if (dice.one_in(3)) return;
    std::vector<std::uint8_t> splits(std::size_t{chart.rows - 1} * (chart.cols - 1));
    const std::uint32_t kind = dice.below(3);
    for (auto& d : splits) d = static_cast<std::uint8_t>(kind == 2 ? dice.bits() & 1 : kind);
    chart.add("diagonals", ElementType::kU8, {chart.rows - 1, chart.cols - 1}, splits);
}

/// Copies take the bits of their representative, be it a grid or a border sample.
void weld(Dice& dice, ChartSpec& chart, const SeamPairs& pairs, std::uint32_t grid) {
    const std::size_t bytes = chart.layer("geometry").type == ElementType::kU16 ? 6 : 12;  // f32: of the border, too
    const auto at = [&](std::uint32_t k) {
        return chart.layer(k < grid ? "geometry" : "border_geometry").bytes.data() + bytes * (k < grid ? k : k - grid);
    };
    Uints flat;
    for (const auto& [representative, copy] : pairs) {
        std::memcpy(at(copy), at(representative), bytes);
        flat.insert(flat.end(), {representative, copy});
    }
    if (pairs.empty()) return;
    chart.add("seams", ElementType::kU32, {pairs.size(), 2}, flat);
    if (!dice.one_in(4)) return;  // windings as the layer has them, or not
    std::vector<std::uint8_t> reversed(pairs.size());
    for (auto& r : reversed) r = static_cast<std::uint8_t>(dice.one_in(20) ? dice.bits() : dice.bits() & 1);
    chart.add("reversed", ElementType::kU8, {pairs.size()}, reversed, layout::kLayerRequired);
}

ChartSpec random_free_chart(Dice& dice, std::uint32_t m, std::uint32_t n) {
    ChartSpec chart = free_chart(m, n, random_shape(dice, m, n));
    const std::uint32_t grid = m * n, total = grid + chart.border_samples;
    LayerSpec& faces = chart.layer("border_faces");
    Uints corners = values_of<std::uint32_t>(faces), usable;
    auto* mask = reinterpret_cast<std::uint8_t*>(chart.layer("mask").bytes.data());
    if (dice.one_in(8)) corners.clear();
    for (std::uint32_t k = dice.one_in(3) ? dice.below(20) : 0; k > 0; --k) {  // holes
        const std::uint32_t sample = dice.below(grid);
        if (std::find(corners.begin(), corners.end(), sample) == corners.end()) mask[sample] = 0;
    }
    if (dice.one_in(20)) {
        corners.clear();
        std::fill_n(mask, grid, std::uint8_t{0});
    }
    for (std::uint32_t k = 0; k < total; ++k)
        if (k >= grid || mask[k] != 0) usable.push_back(k);
    for (std::uint32_t k = dice.one_in(4) ? dice.below(6) : 0; k > 0; --k) {  // faces that no strip has
        const auto any = [&] { return usable[dice.below(static_cast<std::uint32_t>(usable.size()))]; };
        const std::uint32_t a = any(), b = any(), c = any();
        if (a != b && b != c && c != a) corners.insert(corners.end(), {a, b, c});
    }
    faces.shape[0] = corners.size() / 3;
    faces.bytes.assign(corners.size() * 4, {});
    if (!corners.empty()) std::memcpy(faces.bytes.data(), corners.data(), faces.bytes.size());
    if (dice.one_in(6)) {  // places beside their own
        const float anywhere = dice.real(0, 1);
        auto& uv = chart.layer("border_uv").bytes;
        std::memcpy(uv.data() + 4 * std::size_t{dice.below(2 * chart.border_samples)}, &anywhere, 4);
    }
    Uints border(chart.border_samples);
    std::iota(border.begin(), border.end(), grid);
    if (dice.one_in(2))
        weld(dice, chart, classes_of(random_pairs(dice, dice.one_in(20) ? usable : border), total), grid);
    return chart;
}
}  // namespace

ChartSpec random_chart(Dice& dice) {
    const bool large = dice.one_in(4);
    std::uint32_t m = large ? dice.between(12, 33) : dice.between(2, 12);
    const std::uint32_t n = dice.one_in(2) ? m : large ? dice.between(3, 33) : dice.between(2, 12);
    ChartSpec chart;
    if (dice.one_in(3)) {
        chart = random_free_chart(dice, std::max(m, 3u), std::max(n, 3u));
    } else {
        chart = grid_chart(m, n, random_shape(dice, m, n));
        if (dice.one_in(5)) quantise(dice, chart);
        weld(dice, chart, classes_of(square_pairs(dice, m, n), m * n), m * n);
    }
    for (double& o : chart.offset) o = dice.one_in(5) ? dice.of({1e300, -1e15, 0.1}) : 0;
    add_pictures(dice, chart);
    add_behaviour(dice, chart);
    return chart;
}

void spoil(Dice& dice, ChartSpec& chart) {
    for (std::uint32_t k = dice.between(1, 3); k > 0; --k) {
        LayerSpec& layer = chart.layers[dice.below(static_cast<std::uint32_t>(chart.layers.size()))];
        const std::size_t size = layout::element_size(layer.type), count = layer.bytes.size() / size;
        if (count == 0) continue;
        std::byte* at = layer.bytes.data() + size * dice.below(static_cast<std::uint32_t>(count));
        const float number = dice.one_in(2) ? dice.absurd() : dice.real(-2, 2);
        const std::uint32_t word = dice.one_in(2) ? dice.below(1200) : static_cast<std::uint32_t>(dice.bits());
        if (layer.type == ElementType::kF32)
            std::memcpy(at, &number, size);
        else
            std::memcpy(at, &word, size);
    }
    if (dice.one_in(10)) chart.scale[dice.below(3)] = dice.of({1e300, 1e-300, 1e14, -1.0});
}

}  // namespace dgm::test
