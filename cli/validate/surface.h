// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/surface.h
// A chart in its local frame, with values that several checks share.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <dgm/grid.h>

#include "geometry/metrics/reconstruction.h"
#include "model/element.h"
#include "model/map_set.h"
#include "validate/finding_list.h"

namespace dgm::validate {

/// Boxes and radii are floats in the chart's local frame: this much of its diagonal is rounding.
inline constexpr double kFloatSlack = 1e-6;

struct Box {
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();
    model::Vec3d low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
    void add(const model::Vec3d& p) {
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

/// The chart in its local frame (position minus offset), with values that several checks share.
struct Surface {
    const model::Chart& chart;
    std::size_t chart_index;
    const bake::Reconstruction& reconstruction;
    std::uint32_t m, n;
    std::vector<model::Vec3d> local;
    std::vector<std::uint8_t> in_face;  // 1 for vertices that a face names
    Box bounds;                         // of those, local frame
    bool finite = true;                 // all of those
    const model::Layer* mask;

    Surface(const model::Chart& c, std::size_t index, const bake::Reconstruction& r)
        : chart(c), chart_index(index), reconstruction(r), m(c.rows), n(c.cols), mask(c.find("mask")) {
        local.reserve(r.mesh.positions.size());
        for (const model::Vec3d& p : r.mesh.positions)
            local.push_back(p - model::Vec3d{c.offset[0], c.offset[1], c.offset[2]});
        in_face.assign(local.size(), 0);
        for (const model::Face& f : r.mesh.faces)
            for (const std::uint32_t v : f) in_face[v] = 1;
        for (std::size_t v = 0; v < local.size(); ++v) {
            if (in_face[v] == 0) continue;
            bounds.add(local[v]);
            finite = finite && is_finite(local[v]);
        }
    }
    [[nodiscard]] std::size_t grid() const { return std::size_t{m} * n; }
    [[nodiscard]] bool on_surface(std::size_t i, std::size_t j) const {
        return mask == nullptr || model::element<std::uint8_t>(*mask, sample_index(i, j, n)) != 0;
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

}  // namespace dgm::validate
