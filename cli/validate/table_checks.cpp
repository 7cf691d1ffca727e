// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/table_checks.cpp
// Tables that are worked out from the geometry, worked out again.
#include "validate/table_checks.h"

#include <array>
#include <cmath>

#include "model/codes.h"
#include "model/element.h"

namespace dgm::validate {
namespace {
using model::element;
using model::Face;
using model::Layer;
using model::Vec3d;
namespace codes = model::codes;

Box stored_box(const Layer& collision, std::size_t node) {
    const auto at = [&](std::size_t k) { return static_cast<double>(element<float>(collision, 6 * node + k)); };
    return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}};
}

/// Tile of a strip face (SPEC.md 3.3): that of its lowest grid sample, else of the place of its lowest border sample.
std::size_t strip_tile(const Surface& s, const Face& face, std::uint32_t tile_rows, std::uint32_t tile_cols) {
    const std::size_t lowest = std::min({face[0], face[1], face[2]});
    double i = static_cast<double>(lowest / s.n), j = static_cast<double>(lowest % s.n);
    if (lowest >= s.grid()) {
        const Layer& uv = *s.chart.find("border_uv");
        const std::size_t b = lowest - s.grid();
        i = std::floor(element<float>(uv, 2 * b) * static_cast<float>(s.m - 1));
        j = std::floor(element<float>(uv, 2 * b + 1) * static_cast<float>(s.n - 1));
    }
    const auto tile = [](double quad, std::uint32_t count) {
        return static_cast<std::size_t>(std::clamp(quad / kTileQuads, 0.0, count - 1.0));
    };
    return tile(i, tile_rows) * tile_cols + tile(j, tile_cols);
}

/// Boxes of the leaf tiles' quads and strip faces, row by row.
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
    if (const Layer* strip = s.chart.find("border_faces"); strip != nullptr && s.chart.find("border_uv") != nullptr) {
        const auto& faces = s.reconstruction.mesh.faces;
        for (std::size_t f = faces.size() - strip->shape[0]; f < faces.size(); ++f)
            for (const std::uint32_t v : faces[f]) boxes[strip_tile(s, faces[f], tile_rows, tile_cols)].add(s.local[v]);
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
    std::vector<double> needed(s.grid(), 0.0);  // squared
    for (std::uint32_t i = 0; i + 1 < s.m; ++i)
        for (std::uint32_t j = 0; j + 1 < s.n; ++j) {
            if (!s.has_quad(i, j)) continue;
            const std::array<std::size_t, 4> corners{sample_index(i, j, s.n), sample_index(i + 1, j, s.n),
                                                     sample_index(i, j + 1, s.n), sample_index(i + 1, j + 1, s.n)};
            for (std::size_t a = 0; a < 4; ++a)
                for (std::size_t b = a + 1; b < 4; ++b) {
                    const Vec3d step = s.local[corners[b]] - s.local[corners[a]];
                    const double squared = dot(step, step);
                    needed[corners[a]] = std::max(needed[corners[a]], squared);
                    needed[corners[b]] = std::max(needed[corners[b]], squared);
                }
        }
    for (double& radius : needed) radius = std::sqrt(radius);
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

void check_contact(const Surface& s, const Layer& contact, double surface, FindingList& findings) {
    constexpr double kTolerance = 1e-3;  // relative
    double stored = 0;
    for (std::size_t k = 0; k < s.grid(); ++k) stored += element<float>(contact, 2 * k);
    if (!(std::abs(stored - surface) <= kTolerance * surface))
        findings.error(codes::kBadContact, s.path("contact"),
                       fmt::format("the sample areas sum to {:.6g}, the surface has {:.6g}", stored, surface),
                       {std::abs(stored - surface), kTolerance * surface});
}

/// The numbers that a product of differences may have, whether they are taken forward, backward or in the middle.
struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    void add(double x) {
        low = std::min(low, x);
        high = std::max(high, x);
    }
    [[nodiscard]] double outside(double x) const { return std::max({low - x, x - high, 0.0}); }
};

/// E, F and G where a sample has neighbours on all four sides.
void check_metric(const Surface& s, const Layer& deformation, FindingList& findings) {
    // Positions may be rounded after the differences were taken: to floats, or to the steps of u16.
    constexpr double kTolerance = 1e-3;
    const bool quantised = s.chart.find("geometry")->type == model::ElementType::kU16;
    const auto& scale = s.chart.scale;
    const double rounding =
        quantised ? 2 * std::max({scale[0], scale[1], scale[2]}) : kFloatSlack * s.bounds.diagonal();
    std::size_t bad = 0, first = 0, counted = 0;
    double measured = 0, limit = 0;
    for (std::size_t i = 1; i + 1 < s.m; ++i)
        for (std::size_t j = 1; j + 1 < s.n; ++j) {
            if (!s.on_surface(i, j) || !s.on_surface(i - 1, j) || !s.on_surface(i + 1, j) || !s.on_surface(i, j - 1) ||
                !s.on_surface(i, j + 1))
                continue;
            const std::size_t k = sample_index(i, j, s.n);
            const Vec3d down = s.local[k + s.n] - s.local[k], up = s.local[k] - s.local[k - s.n];
            const Vec3d right = s.local[k + 1] - s.local[k], left = s.local[k] - s.local[k - 1];
            const std::array<Vec3d, 3> along_i{up, down, (up + down) * 0.5}, along_j{left, right, (left + right) * 0.5};
            Range E, F, G;
            for (const Vec3d& a : along_i) {
                E.add(dot(a, a));
                for (const Vec3d& b : along_j) F.add(dot(a, b));
            }
            for (const Vec3d& b : along_j) G.add(dot(b, b));
            const double size = E.high + G.high;
            const double slack = kTolerance * size + rounding * (2 * std::sqrt(size) + rounding);
            const double off = std::max({E.outside(element<float>(deformation, 4 * k)),
                                         F.outside(element<float>(deformation, 4 * k + 1)),
                                         G.outside(element<float>(deformation, 4 * k + 2))});
            ++counted;
            if (off <= slack || bad++ > 0) continue;
            first = k;
            measured = off;
            limit = slack;
        }
    if (bad > 0)
        findings.error(codes::kBadMetric, s.path("deformation") + element_text(deformation.shape, 4 * first),
                       fmt::format("E, F or G is not a product of the steps to the neighbours, here first; {} of {} "
                                   "samples",
                                   bad, counted),
                       {measured, limit});
}

bool all_finite(const Layer& layer) {
    for (std::size_t k = 0; k < layer.bytes.size() / sizeof(float); ++k)
        if (!std::isfinite(element<float>(layer, k))) return false;
    return true;
}

}  // namespace

void check_tables(const Surface& s, double area, FindingList& findings) {
    const auto with = [&](const char* name, const auto& check) {
        const Layer* layer = s.chart.find(name);
        if (layer != nullptr && all_finite(*layer)) check(*layer);
    };
    with("collision", [&](const Layer& layer) { check_collision(s, layer, findings); });
    with("cover", [&](const Layer& layer) { check_cover(s, layer, findings); });
    with("contact", [&](const Layer& layer) { check_contact(s, layer, area, findings); });
    with("deformation", [&](const Layer& layer) { check_metric(s, layer, findings); });
}

}  // namespace dgm::validate
