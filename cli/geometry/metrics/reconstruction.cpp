// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/reconstruction.cpp
// Layers to triangles (docs/design.md section 4): the same rules as the runtime's reconstruction, in double.
#include "geometry/metrics/reconstruction.h"

#include <dgm/grid.h>
#include <dgm/octahedral.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>

#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {
using model::Chart;
using model::element;
using model::ElementType;
using model::Face;
using model::Layer;
using model::Vec2d;
using model::Vec3d;

[[noreturn]] void bad_shape(const std::string& layer, const std::string& what) {
    throw model::Error(model::codes::kBadLayerShape, what, layer);
}

/// Checks type, shape and byte count before anything is read. kAnyCount in `shape` matches every number.
constexpr std::uint64_t kAnyCount = std::numeric_limits<std::uint64_t>::max();
void check_layer(const Layer& layer, std::initializer_list<ElementType> types,
                 std::initializer_list<std::uint64_t> shape) {
    if (std::find(types.begin(), types.end(), layer.type) == types.end())
        bad_shape(layer.name, "the element type " + std::to_string(static_cast<std::uint32_t>(layer.type)) +
                                  " does not suit this layer");
    const bool fits = std::equal(layer.shape.begin(), layer.shape.end(), shape.begin(), shape.end(),
                                 [](std::uint64_t is, std::uint64_t want) { return want == kAnyCount || is == want; });
    if (!fits)
        bad_shape(layer.name, "the shape is " + model::shape_text(layer.shape) + ", which does not suit the chart");
    std::uint64_t bytes = layout::element_size(layer.type);
    for (const std::uint64_t s : layer.shape)
        if (__builtin_mul_overflow(bytes, s, &bytes)) bad_shape(layer.name, "the shape overflows");
    if (bytes != layer.bytes.size())
        bad_shape(layer.name, "it holds " + std::to_string(layer.bytes.size()) + " bytes, its shape asks for " +
                                  std::to_string(bytes));
}

/// Positions of a layer of f32 or u16 triples. Only u16 is quantised: `scale` belongs to it, `offset` to both.
void append_positions(const Layer& layer, const Chart& chart, std::vector<Vec3d>& out) {
    const std::size_t count = layer.shape[0] * (layer.shape.size() == 3 ? layer.shape[1] : 1);
    const bool quantised = layer.type == ElementType::kU16;
    const bool scaled = quantised || chart.find(model::layers::kGeometry)->type == ElementType::kF32;
    for (std::size_t s = 0; s < count; ++s) {
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
            const std::size_t e = 3 * s + static_cast<std::size_t>(k);
            const double stored = quantised ? element<std::uint16_t>(layer, e) : element<float>(layer, e);
            p[k] = chart.offset[k] + (scaled ? chart.scale[k] : 1.0) * stored;
        }
        out.push_back(p);
    }
}

void append_normals(const Layer& layer, std::size_t count, std::vector<Vec3d>& out) {
    for (std::size_t s = 0; s < count; ++s) {
        const auto n = decode_octahedral(element<std::int16_t>(layer, 2 * s), element<std::int16_t>(layer, 2 * s + 1));
        out.push_back({n[0], n[1], n[2]});
    }
}

/// Class representative of every vertex. Pairs are (lowest index of the class, copy), each copy once.
std::vector<std::uint32_t> weld_table(const Layer* seams, std::size_t vertices) {
    std::vector<std::uint32_t> weld(vertices);
    for (std::size_t v = 0; v < vertices; ++v) weld[v] = static_cast<std::uint32_t>(v);
    if (seams == nullptr) return weld;
    const auto fail = [](std::size_t pair, const std::string& what) {
        throw model::Error(model::codes::kBadSeamTable, "pair " + std::to_string(pair) + ": " + what,
                           model::layers::kSeams);
    };
    for (std::size_t k = 0; k < seams->shape[0]; ++k) {
        const auto representative = element<std::uint32_t>(*seams, 2 * k),
                   copy = element<std::uint32_t>(*seams, 2 * k + 1);
        if (representative >= vertices || copy >= vertices)
            fail(k, "index " + std::to_string(std::max(representative, copy)) + " is beyond the " +
                        std::to_string(vertices) + " samples");
        if (representative >= copy)
            fail(k, "the representative " + std::to_string(representative) + " is not below its copy " +
                        std::to_string(copy));
        if (weld[copy] != copy) fail(k, "sample " + std::to_string(copy) + " is a copy twice");
        weld[copy] = representative;
    }
    for (std::size_t k = 0; k < seams->shape[0]; ++k) {
        const auto representative = element<std::uint32_t>(*seams, 2 * k);
        if (weld[representative] != representative)
            fail(k, "the representative " + std::to_string(representative) + " is itself a copy");
    }
    return weld;
}
}  // namespace

Reconstruction reconstruct(const Chart& chart, Corners fill) {
    const Layer* geometry = chart.find(model::layers::kGeometry);
    if (geometry == nullptr)
        throw model::Error(model::codes::kMissingLayer, "the chart has no geometry", model::layers::kGeometry);
    const std::uint64_t m = chart.rows, n = chart.cols;
    if (m < 2 || n < 2)
        bad_shape(model::layers::kGeometry,
                  "a grid of " + std::to_string(m) + " x " + std::to_string(n) + " samples has no quads");
    check_layer(*geometry, {ElementType::kF32, ElementType::kU16}, {m, n, 3});

    const Layer* border = chart.find(model::layers::kBorderGeometry);
    if (border != nullptr) check_layer(*border, {ElementType::kF32, ElementType::kU16}, {kAnyCount, 3});
    const std::uint64_t grid = m * n, extra = border == nullptr ? 0 : border->shape[0];
    if (grid + extra > std::numeric_limits<std::uint32_t>::max())
        bad_shape(model::layers::kGeometry, "there are too many samples");
    const auto optional_layer = [&](const char* name, std::initializer_list<ElementType> types,
                                    std::initializer_list<std::uint64_t> shape) {
        const Layer* layer = chart.find(name);
        if (layer != nullptr) check_layer(*layer, types, shape);
        return layer;
    };
    const Layer* diagonals = optional_layer(model::layers::kDiagonals, {ElementType::kU8}, {m - 1, n - 1});
    const Layer* mask = optional_layer(model::layers::kMask, {ElementType::kU8}, {m, n});
    const Layer* border_faces = optional_layer(model::layers::kBorderFaces, {ElementType::kU32}, {kAnyCount, 3});
    const Layer* border_uv = optional_layer(model::layers::kBorderUv, {ElementType::kF32}, {extra, 2});
    const Layer* normal = optional_layer(model::layers::kNormal, {ElementType::kI16}, {m, n, 2});
    const Layer* border_normal = optional_layer(model::layers::kBorderNormal, {ElementType::kI16}, {extra, 2});
    const Layer* seams = optional_layer(model::layers::kSeams, {ElementType::kU32}, {kAnyCount, 2});

    Reconstruction out;
    model::TriMesh& mesh = out.mesh;
    mesh.positions.reserve(grid + extra);
    mesh.faces.reserve(2 * (m - 1) * (n - 1) + (border_faces == nullptr ? 0 : border_faces->shape[0]));
    append_positions(*geometry, chart, mesh.positions);
    if (border != nullptr) append_positions(*border, chart, mesh.positions);

    const auto on_surface = [&](std::size_t i, std::size_t j) {
        return mask == nullptr || element<std::uint8_t>(*mask, sample_index(i, j, n)) != 0;
    };
    for (std::uint32_t i = 0; i + 1 < m; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            if (!on_surface(i, j) || !on_surface(i + 1, j) || !on_surface(i, j + 1) || !on_surface(i + 1, j + 1))
                continue;
            const unsigned diagonal = diagonals == nullptr ? 0 : element<std::uint8_t>(*diagonals, i * (n - 1) + j);
            for (const Face& f : quad_triangles(i, j, static_cast<std::uint32_t>(n), diagonal)) mesh.faces.push_back(f);
        }
    if (border_faces != nullptr)
        for (std::size_t t = 0; t < border_faces->shape[0]; ++t) {
            Face f;
            for (std::size_t k = 0; k < 3; ++k) {
                f[k] = element<std::uint32_t>(*border_faces, 3 * t + k);
                if (f[k] >= grid + extra)
                    throw model::Error(model::codes::kBadValue,
                                       "face " + std::to_string(t) + " names sample " + std::to_string(f[k]) + " of " +
                                           std::to_string(grid + extra),
                                       model::layers::kBorderFaces);
            }
            mesh.faces.push_back(f);
        }

    const auto fill_corners = [&](auto& corners, const auto& samples) {
        corners.reserve(3 * mesh.faces.size());
        for (const Face& f : mesh.faces)
            for (const std::uint32_t v : f) corners.push_back(samples[v]);
    };
    const bool all = fill == Corners::kFill;
    if (all && normal != nullptr && (extra == 0 || border_normal != nullptr)) {
        std::vector<Vec3d> normals;
        normals.reserve(grid + extra);
        append_normals(*normal, grid, normals);
        if (border_normal != nullptr) append_normals(*border_normal, extra, normals);
        fill_corners(mesh.corner_normals, normals);
    }
    if (all && (extra == 0 || border_uv != nullptr)) {
        std::vector<Vec2d> uvs;
        uvs.reserve(grid + extra);
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t j = 0; j < n; ++j)
                uvs.push_back({static_cast<double>(j) / static_cast<double>(n - 1),
                               static_cast<double>(i) / static_cast<double>(m - 1)});
        for (std::size_t b = 0; b < extra; ++b)
            uvs.push_back({element<float>(*border_uv, 2 * b + 1), element<float>(*border_uv, 2 * b)});
        fill_corners(mesh.corner_uvs, uvs);
    }

    out.weld = weld_table(seams, mesh.positions.size());
    for (std::size_t v = 0; v < out.weld.size(); ++v) {
        if (out.weld[v] == v) continue;
        const double gap = length(mesh.positions[v] - mesh.positions[out.weld[v]]);
        out.seam_gap = std::max(out.seam_gap, std::isnan(gap) ? std::numeric_limits<double>::infinity() : gap);
    }
    out.welded_faces.reserve(mesh.faces.size());
    for (const Face& f : mesh.faces) out.welded_faces.push_back({out.weld[f[0]], out.weld[f[1]], out.weld[f[2]]});
    return out;
}

}  // namespace dgm::bake
