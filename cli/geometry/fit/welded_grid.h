// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/welded_grid.h
// A chart's surface with its seams closed: one unknown per class of samples.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/fit/linked_surface.h"

namespace dgm::bake {

struct WeldedGrid {
    LinkedSurface surface;                 ///< positions per class; faces in the order of SampledChart::faces()
    std::vector<std::uint32_t> class_of;   ///< per sample, kNone off the surface
    std::vector<std::uint32_t> sample_of;  ///< per class: its representative
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  ///< two classes, lower first, each edge once
    std::vector<std::array<std::uint32_t, 3>> edge_of;           ///< per face
    std::vector<char> on_border;                                 ///< per class: on the source's real border
    std::vector<char> reversed;               ///< per class: a copy of it is reversed; empty: none is
    std::vector<std::uint32_t> face_of_quad;  ///< first of the quad's two faces, kNone where no quad is drawn

    explicit WeldedGrid(const SampledChart& chart);
    /// Reads the chart's diagonals again.
    void link(const SampledChart& chart);
    /// First face of the quad that a place of the map falls in, kNone where no quad is drawn.
    [[nodiscard]] std::uint32_t face_at(const SampledChart& chart, const Vec2d& uv) const;
    /// The same where the map puts a point of chart.disk.
    [[nodiscard]] std::uint32_t face_at(const SampledChart& chart, const SurfaceSample& at) const;
    /// Every sample takes the position of its class.
    void write_positions(SampledChart& chart) const;
    /// Adds a face's normal to that of its class: where copies are reversed, on the side of those before it.
    void add_facing(Vec3d& sum, const Vec3d& normal, std::uint32_t c) const {
        sum += !reversed.empty() && reversed[c] && dot(sum, normal) < 0 ? -normal : normal;
    }
    /// Faces around each class: faces[first[c]] .. faces[first[c + 1] - 1].
    struct Rings {
        std::vector<std::uint32_t> first, faces;
    };
    [[nodiscard]] Rings rings() const;
};

}  // namespace dgm::bake
