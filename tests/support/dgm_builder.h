// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/dgm_builder.h
// Byte images of .dgm files by layout.h, without HDF5: files that the runtime maps, and every way to break them.
#pragma once
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <dgm/grid.h>
#include <dgm/layout.h>

namespace dgm::test {

using layout::ElementType;
using Bytes = std::vector<std::byte>;

struct LayerSpec {
    std::string name;
    ElementType type;
    std::vector<std::uint64_t> shape;
    Bytes bytes;
    std::uint32_t flags = 0;
};

struct ChartSpec {
    std::uint32_t rows = 2, cols = 2;
    layout::Domain domain = layout::Domain::kSquare;
    std::uint32_t border_samples = 0;
    std::array<double, 3> offset{}, scale{1, 1, 1};
    std::string method = "test";
    std::vector<LayerSpec> layers;

    template <class T>
    void add(const std::string& name, ElementType type, std::vector<std::uint64_t> shape, const std::vector<T>& values,
             std::uint32_t flags = 0) {
        LayerSpec layer{name, type, std::move(shape), Bytes(values.size() * sizeof(T)), flags};
        if (!values.empty()) std::memcpy(layer.bytes.data(), values.data(), layer.bytes.size());
        layers.push_back(std::move(layer));
    }
    LayerSpec& layer(const std::string& name) {
        for (LayerSpec& l : layers)
            if (l.name == name) return l;
        std::abort();
    }
};

inline void hash_to(std::uint8_t* to, const void* data, std::size_t bytes) {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(data, bytes));
    std::memcpy(to, canonical.digest, 16);
}

/// A file in memory with its header and records to change; `seal` writes them back with fresh hashes.
struct Image {
    Bytes bytes;
    layout::FileHeader header{};
    std::vector<layout::ChartRecord> charts;
    std::vector<layout::LayerRecord> layers;

    void seal() {
        Bytes records(charts.size() * sizeof(layout::ChartRecord) + layers.size() * sizeof(layout::LayerRecord));
        std::memcpy(records.data(), charts.data(), charts.size() * sizeof(layout::ChartRecord));
        std::memcpy(records.data() + charts.size() * sizeof(layout::ChartRecord), layers.data(),
                    layers.size() * sizeof(layout::LayerRecord));
        hash_to(header.index_hash, records.data(), records.size());
        if (header.index_offset <= bytes.size() && records.size() <= bytes.size() - header.index_offset)
            std::memcpy(bytes.data() + header.index_offset, records.data(), records.size());
        seal_header();
    }
    void seal_header() {
        hash_to(header.header_hash, &header, offsetof(layout::FileHeader, header_hash));
        std::memcpy(bytes.data(), &header, sizeof header);
    }
};

inline std::uint64_t align_up(std::uint64_t n) {
    return (n + layout::kMinAlignment - 1) / layout::kMinAlignment * layout::kMinAlignment;
}

/// Header, records in the user block if they fit (else behind it), layers at 64-byte places, hashes.
inline Image build(const std::vector<ChartSpec>& charts) {
    Image image;
    std::memcpy(image.header.magic, layout::kMagic, sizeof layout::kMagic);
    image.header.format_version = layout::kFormatVersion;
    image.header.header_bytes = sizeof(layout::FileHeader);
    image.header.chart_count = static_cast<std::uint32_t>(charts.size());
    std::uint64_t end = layout::kUserBlockBytes;
    std::size_t layer_count = 0;
    for (const ChartSpec& c : charts) layer_count += c.layers.size();
    image.header.layer_count = static_cast<std::uint32_t>(layer_count);
    image.header.index_bytes = charts.size() * sizeof(layout::ChartRecord) + layer_count * sizeof(layout::LayerRecord);
    image.header.index_offset = sizeof(layout::FileHeader);
    if (image.header.index_bytes > layout::kUserBlockBytes - sizeof(layout::FileHeader)) {
        image.header.index_offset = end;
        end = align_up(end + image.header.index_bytes);
    }
    Bytes& bytes = image.bytes;
    for (std::size_t k = 0; k < charts.size(); ++k) {
        const ChartSpec& c = charts[k];
        layout::ChartRecord record{};
        record.rows = c.rows;
        record.cols = c.cols;
        record.domain = static_cast<std::uint32_t>(c.domain);
        record.first_layer = static_cast<std::uint32_t>(image.layers.size());
        record.layer_count = static_cast<std::uint32_t>(c.layers.size());
        record.border_samples = c.border_samples;
        for (int a = 0; a < 3; ++a) {
            record.bbox[a] = -1;
            record.bbox[a + 3] = 1;
            record.offset[a] = c.offset[static_cast<std::size_t>(a)];
            record.scale[a] = c.scale[static_cast<std::size_t>(a)];
        }
        std::memcpy(record.method, c.method.data(), std::min<std::size_t>(c.method.size(), 15));
        image.charts.push_back(record);
        for (const LayerSpec& l : c.layers) {
            layout::LayerRecord r{};
            std::memcpy(r.name, l.name.data(), std::min<std::size_t>(l.name.size(), 23));
            r.chart = static_cast<std::uint32_t>(k);
            r.type = static_cast<std::uint32_t>(l.type);
            r.rank = static_cast<std::uint32_t>(l.shape.size());
            r.flags = l.flags;
            for (std::size_t d = 0; d < l.shape.size(); ++d) r.shape[d] = l.shape[d];
            r.bytes = l.bytes.size();
            r.offset = l.bytes.empty() ? 0 : end;
            hash_to(r.hash, l.bytes.data(), l.bytes.size());
            if (!l.bytes.empty()) {
                bytes.resize(end + l.bytes.size());
                std::memcpy(bytes.data() + end, l.bytes.data(), l.bytes.size());
                end = align_up(bytes.size());
            }
            image.layers.push_back(r);
        }
    }
    bytes.resize(end);
    image.header.file_bytes = bytes.size();
    image.seal();
    return image;
}

using Point = std::array<float, 3>;
using SeamPairs = std::vector<std::array<std::uint32_t, 2>>;

/// Chart of m x n samples at f(i, j); copies of `seams` (representative, copy) take the representative's bits.
inline ChartSpec grid_chart(std::uint32_t m, std::uint32_t n, const std::function<Point(double, double)>& f,
                            const SeamPairs& seams = {}) {
    ChartSpec chart;
    chart.rows = m;
    chart.cols = n;
    std::vector<Point> points;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) points.push_back(f(i, j));
    std::vector<std::uint32_t> pairs;
    for (const auto& [representative, copy] : seams) {
        points[copy] = points[representative];
        pairs.insert(pairs.end(), {representative, copy});
    }
    chart.add("geometry", ElementType::kF32, {m, n, 3}, points);
    if (!seams.empty()) chart.add("seams", ElementType::kU32, {seams.size(), 2}, pairs);
    return chart;
}

/// A flat sheet in the xy plane with grid step 1, bent a little so that no two distances are equal by symmetry.
inline Point sheet(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j),
            static_cast<float>(0.3 * std::sin(0.37 * i) * std::cos(0.23 * j))};
}

/// Free domain: samples 1..m-2, 1..n-2 of the grid on the surface, and around them a strip to border samples half a
/// step outwards, one beside each outer grid sample and one at each corner. `seams` as for grid_chart (border samples
/// count from m * n in counter-clockwise (u, v) order from (0.5, 0.5), along +u first).
inline ChartSpec free_chart(std::uint32_t m, std::uint32_t n, const std::function<Point(double, double)>& f,
                            const SeamPairs& seams = {}) {
    ChartSpec chart = grid_chart(m, n, f);
    chart.domain = layout::Domain::kFree;
    std::vector<std::uint8_t> mask(m * n, 0);
    for (std::uint32_t i = 1; i + 1 < m; ++i)
        for (std::uint32_t j = 1; j + 1 < n; ++j) mask[i * n + j] = 1;
    struct Rim {
        double i, j;
        std::uint32_t inner;
    };
    std::vector<Rim> rim;  // counter-clockwise: along +i at j = 0.5, +j at i = m - 1.5, -i, -j
    const double i0 = 0.5, j0 = 0.5, i1 = m - 1.5, j1 = n - 1.5;
    rim.push_back({i0, j0, n + 1});
    for (std::uint32_t i = 1; i + 1 < m; ++i) rim.push_back({double(i), j0, i * n + 1});
    rim.push_back({i1, j0, (m - 2) * n + 1});
    for (std::uint32_t j = 1; j + 1 < n; ++j) rim.push_back({i1, double(j), (m - 2) * n + j});
    rim.push_back({i1, j1, (m - 2) * n + n - 2});
    for (std::uint32_t i = m - 2; i >= 1; --i) rim.push_back({double(i), j1, i * n + n - 2});
    rim.push_back({i0, j1, n + n - 2});
    for (std::uint32_t j = n - 2; j >= 1; --j) rim.push_back({i0, double(j), n + j});
    std::vector<float> uv;
    std::vector<Point> points;
    std::vector<std::uint32_t> faces, pairs;
    for (std::size_t b = 0; b < rim.size(); ++b) {
        uv.push_back(static_cast<float>(rim[b].i / (m - 1)));
        uv.push_back(static_cast<float>(rim[b].j / (n - 1)));
        points.push_back(f(rim[b].i, rim[b].j));
        const std::size_t next = (b + 1) % rim.size();
        const auto here = static_cast<std::uint32_t>(m * n + b), there = static_cast<std::uint32_t>(m * n + next);
        faces.insert(faces.end(), {here, there, rim[next].inner});
        if (rim[b].inner != rim[next].inner) faces.insert(faces.end(), {here, rim[next].inner, rim[b].inner});
    }
    for (const auto& [representative, copy] : seams) {
        points[copy - m * n] = points[representative - m * n];
        pairs.insert(pairs.end(), {representative, copy});
    }
    chart.border_samples = static_cast<std::uint32_t>(rim.size());
    chart.add("mask", ElementType::kU8, {m, n}, mask);
    chart.add("border_uv", ElementType::kF32, {rim.size(), 2}, uv);
    chart.add("border_geometry", ElementType::kF32, {rim.size(), 3}, points);
    chart.add("border_faces", ElementType::kU32, {faces.size() / 3, 3}, faces);
    if (!seams.empty()) chart.add("seams", ElementType::kU32, {seams.size(), 2}, pairs);
    return chart;
}

/// Side j = 0 glued to side j = n - 1.
inline SeamPairs tube_seams(std::uint32_t m, std::uint32_t n) {
    SeamPairs pairs;
    for (std::uint32_t i = 0; i < m; ++i) pairs.push_back({i * n, i * n + n - 1});
    return pairs;
}
/// Side j = 0 folded at its middle, m odd: the slit a cut path with one leaf opens.
inline SeamPairs fold_seams(std::uint32_t m, std::uint32_t n) {
    SeamPairs pairs;
    for (std::uint32_t i = 0; i < m / 2; ++i) pairs.push_back({i * n, (m - 1 - i) * n});
    return pairs;
}
/// Side i = 0 glued to side j = 0 around their common corner.
inline SeamPairs corner_seams(std::uint32_t side) {
    SeamPairs pairs;
    for (std::uint32_t k = 1; k < side; ++k) pairs.push_back({k, k * side});
    return pairs;
}
/// All four sides folded at their middles, all corners one point: the octahedral unfolding of a sphere.
inline SeamPairs octahedral_seams(std::uint32_t side) {
    SeamPairs pairs;
    const std::uint32_t e = side - 1;
    const auto at = [side](std::uint32_t i, std::uint32_t j) { return i * side + j; };
    for (std::uint32_t k = 1; k < side / 2; ++k) {
        pairs.push_back({at(0, k), at(0, e - k)});
        pairs.push_back({at(e, k), at(e, e - k)});
        pairs.push_back({at(k, 0), at(e - k, 0)});
        pairs.push_back({at(k, e), at(e - k, e)});
    }
    for (const std::uint32_t corner : {at(0, e), at(e, 0), at(e, e)}) pairs.push_back({0, corner});
    return pairs;
}

}  // namespace dgm::test
