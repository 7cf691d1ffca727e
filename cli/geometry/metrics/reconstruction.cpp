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

#include "geometry/metrics/turned_faces.h"
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

/// The layers of a chart that its surface is made of, with types and shapes checked; those that it lacks are null.
struct SurfaceLayers {
    const Layer* geometry = nullptr;
    const Layer *border = nullptr, *border_faces = nullptr, *border_uv = nullptr, *border_normal = nullptr;
    const Layer *diagonals = nullptr, *mask = nullptr, *normal = nullptr, *seams = nullptr, *reversed = nullptr;
    std::uint64_t rows = 0, cols = 0;
    std::uint64_t extra = 0;  ///< samples beside the grid
    [[nodiscard]] std::uint64_t samples() const { return rows * cols + extra; }
};

SurfaceLayers surface_layers(const Chart& chart) {
    SurfaceLayers out;
    out.geometry = chart.find(model::layers::kGeometry);
    if (out.geometry == nullptr)
        throw model::Error(model::codes::kMissingLayer, "the chart has no geometry", model::layers::kGeometry);
    out.rows = chart.rows;
    out.cols = chart.cols;
    const std::uint64_t m = out.rows, n = out.cols;
    if (m < 2 || n < 2)
        bad_shape(model::layers::kGeometry,
                  "a grid of " + std::to_string(m) + " x " + std::to_string(n) + " samples has no quads");
    check_layer(*out.geometry, {ElementType::kF32, ElementType::kU16}, {m, n, 3});
    const auto optional_layer = [&](const char* name, std::initializer_list<ElementType> types,
                                    std::initializer_list<std::uint64_t> shape) {
        const Layer* layer = chart.find(name);
        if (layer != nullptr) check_layer(*layer, types, shape);
        return layer;
    };
    out.border = optional_layer(model::layers::kBorderGeometry, {ElementType::kF32, ElementType::kU16}, {kAnyCount, 3});
    out.extra = out.border == nullptr ? 0 : out.border->shape[0];
    if (out.samples() > std::numeric_limits<std::uint32_t>::max())
        bad_shape(model::layers::kGeometry, "there are too many samples");
    out.diagonals = optional_layer(model::layers::kDiagonals, {ElementType::kU8}, {m - 1, n - 1});
    out.mask = optional_layer(model::layers::kMask, {ElementType::kU8}, {m, n});
    out.border_faces = optional_layer(model::layers::kBorderFaces, {ElementType::kU32}, {kAnyCount, 3});
    out.border_uv = optional_layer(model::layers::kBorderUv, {ElementType::kF32}, {out.extra, 2});
    out.normal = optional_layer(model::layers::kNormal, {ElementType::kI16}, {m, n, 2});
    out.border_normal = optional_layer(model::layers::kBorderNormal, {ElementType::kI16}, {out.extra, 2});
    out.seams = optional_layer(model::layers::kSeams, {ElementType::kU32}, {kAnyCount, 2});
    out.reversed =
        optional_layer(model::layers::kReversed, {ElementType::kU8}, {out.seams == nullptr ? 0 : out.seams->shape[0]});
    return out;
}

/// Two faces for each quad whose samples all lie on the surface.
void append_quads(const SurfaceLayers& layers, std::vector<Face>& faces) {
    const std::uint64_t m = layers.rows, n = layers.cols;
    const auto on_surface = [&](std::size_t i, std::size_t j) {
        return layers.mask == nullptr || element<std::uint8_t>(*layers.mask, sample_index(i, j, n)) != 0;
    };
    for (std::uint32_t i = 0; i + 1 < m; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            if (!on_surface(i, j) || !on_surface(i + 1, j) || !on_surface(i, j + 1) || !on_surface(i + 1, j + 1))
                continue;
            const unsigned diagonal =
                layers.diagonals == nullptr ? 0 : element<std::uint8_t>(*layers.diagonals, i * (n - 1) + j);
            for (const Face& f : quad_triangles(i, j, static_cast<std::uint32_t>(n), diagonal)) faces.push_back(f);
        }
}

void append_border_faces(const SurfaceLayers& layers, std::vector<Face>& faces) {
    if (layers.border_faces == nullptr) return;
    for (std::size_t t = 0; t < layers.border_faces->shape[0]; ++t) {
        Face f;
        for (std::size_t k = 0; k < 3; ++k) {
            f[k] = element<std::uint32_t>(*layers.border_faces, 3 * t + k);
            if (f[k] >= layers.samples())
                throw model::Error(model::codes::kBadValue,
                                   "face " + std::to_string(t) + " names sample " + std::to_string(f[k]) + " of " +
                                       std::to_string(layers.samples()),
                                   model::layers::kBorderFaces);
        }
        faces.push_back(f);
    }
}

/// Gives each corner of each face the value of its sample.
template <class Value>
void fill_corners(const std::vector<Face>& faces, const std::vector<Value>& samples, std::vector<Value>& corners) {
    corners.reserve(3 * faces.size());
    for (const Face& f : faces)
        for (const std::uint32_t v : f) corners.push_back(samples[v]);
}

void fill_normals(const SurfaceLayers& layers, model::TriMesh& mesh) {
    if (layers.normal == nullptr || (layers.extra > 0 && layers.border_normal == nullptr)) return;
    std::vector<Vec3d> normals;
    normals.reserve(layers.samples());
    append_normals(*layers.normal, layers.rows * layers.cols, normals);
    if (layers.border_normal != nullptr) append_normals(*layers.border_normal, layers.extra, normals);
    fill_corners(mesh.faces, normals, mesh.corner_normals);
}

void fill_uvs(const SurfaceLayers& layers, model::TriMesh& mesh) {
    if (layers.extra > 0 && layers.border_uv == nullptr) return;
    const std::uint64_t m = layers.rows, n = layers.cols;
    std::vector<Vec2d> uvs;
    uvs.reserve(layers.samples());
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j < n; ++j)
            uvs.push_back({static_cast<double>(j) / static_cast<double>(n - 1),
                           static_cast<double>(i) / static_cast<double>(m - 1)});
    for (std::size_t b = 0; b < layers.extra; ++b)
        uvs.push_back({element<float>(*layers.border_uv, 2 * b + 1), element<float>(*layers.border_uv, 2 * b)});
    fill_corners(mesh.faces, uvs, mesh.corner_uvs);
}

/// The largest distance between two samples of one weld class; infinity if it is not a number.
double largest_seam_gap(const std::vector<Vec3d>& positions, const std::vector<std::uint32_t>& weld) {
    double largest = 0;
    for (std::size_t v = 0; v < weld.size(); ++v) {
        if (weld[v] == v) continue;
        const double gap = length(positions[v] - positions[weld[v]]);
        largest = std::max(largest, std::isnan(gap) ? std::numeric_limits<double>::infinity() : gap);
    }
    return largest;
}
}  // namespace

std::vector<char> faces_beside_reversed(const Reconstruction& surface) {
    std::vector<char> reversed(surface.reversed.empty() ? 0 : surface.weld.size(), 0);
    for (std::size_t v = 0; v < surface.reversed.size(); ++v)
        if (surface.reversed[v]) reversed[surface.weld[v]] = 1;
    return faces_beside_reversed(surface.welded_faces, reversed);
}

Reconstruction reconstruct(const Chart& chart, Corners fill) {
    const SurfaceLayers layers = surface_layers(chart);
    Reconstruction out;
    model::TriMesh& mesh = out.mesh;
    mesh.positions.reserve(layers.samples());
    append_positions(*layers.geometry, chart, mesh.positions);
    if (layers.border != nullptr) append_positions(*layers.border, chart, mesh.positions);
    mesh.faces.reserve(2 * (layers.rows - 1) * (layers.cols - 1) +
                       (layers.border_faces == nullptr ? 0 : layers.border_faces->shape[0]));
    append_quads(layers, mesh.faces);
    append_border_faces(layers, mesh.faces);
    if (fill == Corners::kFill) {
        fill_normals(layers, mesh);
        fill_uvs(layers, mesh);
    }
    out.weld = weld_table(layers.seams, mesh.positions.size());
    if (layers.reversed != nullptr) {
        out.reversed.resize(mesh.positions.size(), 0);
        for (std::size_t k = 0; k < layers.reversed->shape[0]; ++k)
            out.reversed[element<std::uint32_t>(*layers.seams, 2 * k + 1)] =
                element<std::uint8_t>(*layers.reversed, k) & 1u;
    }
    out.seam_gap = largest_seam_gap(mesh.positions, out.weld);
    out.welded_faces.reserve(mesh.faces.size());
    for (const Face& f : mesh.faces) out.welded_faces.push_back({out.weld[f[0]], out.weld[f[1]], out.weld[f[2]]});
    return out;
}

}  // namespace dgm::bake
