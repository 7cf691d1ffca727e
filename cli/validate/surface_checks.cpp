// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/surface_checks.cpp
#include "validate/surface_checks.h"

#include <dgm/grid.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "model/codes.h"
#include "validate/layer_checks.h"

namespace dgm::validate {
namespace {
using bake::Reconstruction;
using bake::Topology;
using model::Chart;
using model::Face;
using model::Layer;
using model::Vec3d;
namespace codes = model::codes;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Boxes and radii are floats in the chart's local frame: this much of its diagonal is rounding.
constexpr double kFloatSlack = 1e-6;

struct Box {
    Vec3d low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
    void add(const Vec3d& p) {
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    [[nodiscard]] bool empty() const { return !(low.x <= high.x && low.y <= high.y && low.z <= high.z); }
    [[nodiscard]] double diagonal() const { return empty() ? 0 : length(high - low); }
    /// How far `inner` sticks out of this box; 0 if it does not.
    [[nodiscard]] double protrusion(const Box& inner) const {
        double out = 0;
        for (int k = 0; k < 3; ++k) out = std::max({out, low[k] - inner.low[k], inner.high[k] - high[k]});
        return out;
    }
};

/// The chart in its local frame (position minus offset), with what several checks ask for.
struct Surface {
    const Chart& chart;
    std::size_t chart_index;
    const Reconstruction& reconstruction;
    std::uint32_t m, n;
    std::vector<Vec3d> local;
    Box bounds;  // of the vertices that faces name, local frame
    const Layer* mask;

    Surface(const Chart& c, std::size_t index, const Reconstruction& r)
        : chart(c), chart_index(index), reconstruction(r), m(c.rows), n(c.cols), mask(c.find("mask")) {
        local.reserve(r.mesh.positions.size());
        for (const Vec3d& p : r.mesh.positions) local.push_back(p - Vec3d{c.offset[0], c.offset[1], c.offset[2]});
        for (const Face& f : r.mesh.faces)
            for (const std::uint32_t v : f) bounds.add(local[v]);
    }
    [[nodiscard]] bool on_surface(std::size_t i, std::size_t j) const {
        return mask == nullptr || element<std::uint8_t>(*mask, sample_index(i, j, n)) != 0;
    }
    [[nodiscard]] bool has_quad(std::size_t i, std::size_t j) const {
        return on_surface(i, j) && on_surface(i + 1, j) && on_surface(i, j + 1) && on_surface(i + 1, j + 1);
    }
    [[nodiscard]] std::string path(const char* layer) const { return layer_path(chart_index, layer); }
    [[nodiscard]] std::string sample_text(std::size_t s) const {
        const std::size_t grid = std::size_t{m} * n;
        return s < grid ? fmt::format("sample ({}, {})", s / n, s % n) : fmt::format("border sample {}", s - grid);
    }
};

/// True if samples a and b hold the same bytes in the grid layer or, beyond the grid, in its border twin. Where one
/// stands in each, the decoded values decide (`same_value`).
bool same_sample(const Surface& s, const Layer& grid_layer, const Layer* border_layer, std::size_t sample_bytes,
                 std::size_t a, std::size_t b, bool same_value) {
    const std::size_t grid = std::size_t{s.m} * s.n;
    if ((a < grid) != (b < grid)) return same_value;
    const Layer* layer = a < grid ? &grid_layer : border_layer;
    if (layer == nullptr) return true;
    const std::size_t base = a < grid ? 0 : grid;
    const std::size_t bytes = layer->type == grid_layer.type ? sample_bytes
                                                             : sample_bytes / layout::element_size(grid_layer.type) *
                                                                   layout::element_size(layer->type);
    return std::memcmp(layer->bytes.data() + (a - base) * bytes, layer->bytes.data() + (b - base) * bytes, bytes) == 0;
}

void check_seams(const Surface& s, FindingList& findings) {
    const Layer& geometry = *s.chart.find("geometry");
    const Layer* normal = s.chart.find("normal");
    const std::vector<Vec3d>& positions = s.reconstruction.mesh.positions;
    std::size_t torn = 0, first_torn = 0, bent = 0, first_bent = 0;
    const auto& weld = s.reconstruction.weld;
    for (std::size_t copy = 0; copy < weld.size(); ++copy) {
        const std::size_t rep = weld[copy];
        if (rep == copy) continue;
        if (!same_sample(s, geometry, s.chart.find("border_geometry"), 3 * layout::element_size(geometry.type), rep,
                         copy, positions[rep] == positions[copy]) &&
            torn++ == 0)
            first_torn = copy;
        if (normal != nullptr &&
            !same_sample(s, *normal, s.chart.find("border_normal"), 2 * sizeof(std::int16_t), rep, copy, true) &&
            bent++ == 0)
            first_bent = copy;
    }
    if (torn > 0)
        findings.error(codes::kSeamGap, s.path("geometry"),
                       fmt::format("{} differs from its mate, {}; {} of the seam's copies do",
                                   s.sample_text(first_torn), s.sample_text(weld[first_torn]), torn),
                       {s.reconstruction.seam_gap, 0});
    if (bent > 0)
        findings.warning(codes::kSeamGap, s.path("normal"),
                         fmt::format("the normal of {} differs from that of its mate, {}; {} of the seam's copies do",
                                     s.sample_text(first_bent), s.sample_text(weld[first_bent]), bent));
}

/// Strip faces and seam pairs may name samples of the surface only.
void check_masked_samples(const Surface& s, FindingList& findings) {
    if (s.mask == nullptr) return;
    const std::size_t grid = std::size_t{s.m} * s.n;
    const auto check = [&](const char* name, const model::Code& code) {
        const Layer* layer = s.chart.find(name);
        if (layer == nullptr) return;
        std::size_t bad = 0, first = 0;
        const std::size_t count = layer->bytes.size() / sizeof(std::uint32_t);
        for (std::size_t k = 0; k < count; ++k) {
            const auto sample = element<std::uint32_t>(*layer, k);
            if (sample < grid && element<std::uint8_t>(*s.mask, sample) == 0 && bad++ == 0) first = k;
        }
        if (bad > 0)
            findings.error(code, s.path(name) + element_text(layer->shape, first),
                           fmt::format("{} is not on the surface; so are {} of {} entries",
                                       s.sample_text(element<std::uint32_t>(*layer, first)), bad, count));
    };
    check("border_faces", codes::kBadValue);
    check("seams", codes::kBadSeamTable);
}

/// Faces that have shrunk to a line or a point still draw, but have no normal.
void check_areas(const Surface& s, FindingList& findings) {
    std::size_t flat = 0;
    for (const Face& f : s.reconstruction.mesh.faces)
        if (cross(s.local[f[1]] - s.local[f[0]], s.local[f[2]] - s.local[f[0]]) == Vec3d{}) ++flat;
    if (flat > 0)
        findings.warning(codes::kBadTopology, s.path("geometry"),
                         fmt::format("{} of {} faces have no area", flat, s.reconstruction.mesh.faces.size()),
                         {static_cast<double>(flat), 0});
}

Topology check_topology(const Surface& s, FindingList& findings) {
    const Topology t = bake::measure_topology(s.local.size(), s.reconstruction.welded_faces);
    const std::string place = s.path("geometry");
    if (s.reconstruction.mesh.faces.empty())
        findings.error(codes::kBadTopology, place, "the reconstruction has no faces");
    if (t.degenerate_faces > 0)
        findings.error(codes::kBadTopology, place, "faces name one surface point twice",
                       {static_cast<double>(t.degenerate_faces), 0});
    if (!t.manifold)
        findings.error(codes::kBadTopology, place, "an edge has more than two faces, or a vertex more than one fan");
    else if (!t.oriented)
        findings.error(codes::kBadTopology, place, "neighbouring faces differ in orientation");
    return t;
}

void check_bounds(const Surface& s, FindingList& findings) {
    const auto& b = s.chart.bbox;
    const Vec3d offset{s.chart.offset[0], s.chart.offset[1], s.chart.offset[2]};
    const Box stored{Vec3d{b[0], b[1], b[2]} - offset, Vec3d{b[3], b[4], b[5]} - offset};
    const double slack =
        kFloatSlack * s.bounds.diagonal() + 4 * std::numeric_limits<double>::epsilon() * length(offset);
    const double off = std::max(stored.protrusion(s.bounds), s.bounds.protrusion(stored));
    if (!(off <= slack))
        findings.error(codes::kBadBounds, s.path(""), "bbox is not the box of the reconstruction", {off, slack});
}

Box stored_box(const Layer& collision, std::size_t node) {
    const auto at = [&](std::size_t k) { return static_cast<double>(element<float>(collision, 6 * node + k)); };
    return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}};
}

/// Boxes of the leaf tiles' quads, row by row.
std::vector<Box> leaf_boxes(const Surface& s, std::uint32_t tile_rows, std::uint32_t tile_cols) {
    std::vector<Box> boxes(std::size_t{tile_rows} * tile_cols);
    for (std::uint32_t i = 0; i + 1 < s.m; ++i)
        for (std::uint32_t j = 0; j + 1 < s.n; ++j) {
            if (!s.has_quad(i, j)) continue;
            Box& box = boxes[std::size_t{i / kTileQuads} * tile_cols + j / kTileQuads];
            for (const std::size_t v : {sample_index(i, j, s.n), sample_index(i + 1, j, s.n),
                                        sample_index(i, j + 1, s.n), sample_index(i + 1, j + 1, s.n)})
                box.add(s.local[v]);
        }
    return boxes;
}

/// Each leaf holds its quads, each parent its children, the root everything.
void check_collision(const Surface& s, const Layer& collision, FindingList& findings) {
    std::vector<std::array<std::uint32_t, 2>> levels{{tile_count(s.m - 1), tile_count(s.n - 1)}};
    while (levels.back()[0] > 1 || levels.back()[1] > 1)
        levels.push_back({(levels.back()[0] + 1) / 2, (levels.back()[1] + 1) / 2});
    std::vector<std::uint32_t> expected;
    std::uint64_t nodes = 0;
    for (const auto& [rows, cols] : levels) {
        expected.insert(expected.end(), {rows, cols});
        nodes += std::uint64_t{rows} * cols;
    }
    const auto attribute = collision.attributes.find("levels");
    const auto* stored =
        attribute == collision.attributes.end() ? nullptr : std::get_if<std::vector<std::uint32_t>>(&attribute->second);
    if (stored == nullptr || *stored != expected || collision.shape[0] != nodes) {
        findings.error(
            codes::kBadLayerShape, s.path("collision"),
            fmt::format("attribute `levels` or the number of nodes is not that of the pyramid over {} x {} samples",
                        s.m, s.n),
            {static_cast<double>(collision.shape[0]), static_cast<double>(nodes)});
        return;
    }
    const double slack = kFloatSlack * s.bounds.diagonal();
    std::vector<Box> inner = leaf_boxes(s, levels[0][0], levels[0][1]);
    std::size_t bad = 0, first = 0, node = 0;
    double worst = 0;
    for (std::size_t level = 0; level < levels.size(); ++level) {
        const auto [rows, cols] = levels[level];
        if (level > 0) {
            std::vector<Box> parents(std::size_t{rows} * cols);
            const std::uint32_t child_cols = levels[level - 1][1];
            for (std::size_t c = 0; c < inner.size(); ++c) {
                if (inner[c].empty()) continue;
                Box& parent = parents[c / child_cols / 2 * cols + c % child_cols / 2];
                parent.add(inner[c].low);
                parent.add(inner[c].high);
            }
            inner = std::move(parents);
        }
        if (level + 1 == levels.size() && !s.bounds.empty()) inner[0] = s.bounds;
        for (std::size_t k = 0; k < inner.size(); ++k, ++node) {
            if (inner[k].empty()) continue;
            const double out = stored_box(collision, node).protrusion(inner[k]);
            if (out <= slack) continue;
            if (bad++ == 0) first = node;
            worst = std::max(worst, out);
        }
    }
    if (bad > 0)
        findings.error(codes::kBadCollision, s.path("collision") + fmt::format("[{}]", first),
                       fmt::format("the surface sticks out of {} of {} boxes, here first", bad, nodes), {worst, slack});
}

/// Quads are flat or folded along a diagonal, so the farthest point of a quad from a sample is one of its corners.
void check_cover(const Surface& s, const Layer& cover, FindingList& findings) {
    const double slack = kFloatSlack * s.bounds.diagonal();
    std::vector<double> needed(std::size_t{s.m} * s.n, 0.0);
    for (std::uint32_t i = 0; i + 1 < s.m; ++i)
        for (std::uint32_t j = 0; j + 1 < s.n; ++j) {
            if (!s.has_quad(i, j)) continue;
            const std::array<std::size_t, 4> corners{sample_index(i, j, s.n), sample_index(i + 1, j, s.n),
                                                     sample_index(i, j + 1, s.n), sample_index(i + 1, j + 1, s.n)};
            for (const std::size_t a : corners)
                for (const std::size_t b : corners) needed[a] = std::max(needed[a], length(s.local[a] - s.local[b]));
        }
    std::size_t bad = 0, first = 0;
    for (std::size_t k = 0; k < needed.size(); ++k)
        if (element<float>(cover, k) < needed[k] - slack && bad++ == 0) first = k;
    if (bad > 0)
        findings.error(
            codes::kBadCollision, s.path("cover") + element_text(cover.shape, first),
            fmt::format("points of the sample's quads are farther away than the cover radius, here first; {} "
                        "of {} samples",
                        bad, needed.size()),
            {element<float>(cover, first), needed[first]});
}

void check_contact(const Surface& s, const Layer& contact, FindingList& findings) {
    constexpr double kTolerance = 1e-3;  // relative
    double stored = 0, surface = 0;
    for (std::size_t k = 0; k < std::size_t{s.m} * s.n; ++k) stored += element<float>(contact, 2 * k);
    for (const Face& f : s.reconstruction.mesh.faces)
        surface += 0.5 * length(cross(s.local[f[1]] - s.local[f[0]], s.local[f[2]] - s.local[f[0]]));
    if (!(std::abs(stored - surface) <= kTolerance * surface))
        findings.error(codes::kBadContact, s.path("contact"),
                       fmt::format("the sample areas sum to {:.6g}, the surface has {:.6g}", stored, surface),
                       {std::abs(stored - surface), kTolerance * surface});
}

bool all_finite(const Surface& s) {
    for (const Face& f : s.reconstruction.mesh.faces)
        for (const std::uint32_t v : f)
            if (!is_finite(s.local[v])) return false;
    return true;
}
}  // namespace

Topology check_surface(const Chart& chart, std::size_t chart_index, const Reconstruction& reconstruction,
                       FindingList& findings) {
    const Surface s(chart, chart_index, reconstruction);
    const Topology topology = check_topology(s, findings);
    check_masked_samples(s, findings);
    check_seams(s, findings);
    if (!all_finite(s)) return topology;  // reported with the layer; distances would only repeat it
    check_areas(s, findings);
    check_bounds(s, findings);
    const auto finite = [](const Layer& layer) {
        for (std::size_t k = 0; k < layer.bytes.size() / sizeof(float); ++k)
            if (!std::isfinite(element<float>(layer, k))) return false;
        return true;
    };
    if (const Layer* layer = chart.find("collision"); layer != nullptr && finite(*layer))
        check_collision(s, *layer, findings);
    if (const Layer* layer = chart.find("cover"); layer != nullptr && finite(*layer)) check_cover(s, *layer, findings);
    if (const Layer* layer = chart.find("contact"); layer != nullptr && finite(*layer))
        check_contact(s, *layer, findings);
    return topology;
}

}  // namespace dgm::validate
