// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/triangles.h
// The triangles of an index.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "geometry/mesh/triangle.h"
#include "geometry/spatial/triangle_distance.h"

namespace dgm::bake {

/// Triangles over the vertices that they share, 16 bytes each and 24 a vertex: what is asked of one is made anew each
/// time, which takes no longer than to fetch it, and an index of a million triangles is half as large.
class Triangles {
 public:
    Triangles() = default;
    /// @param vertices  in the index's frame
    explicit Triangles(std::vector<model::Vec3d> vertices) : vertices_(std::move(vertices)) {}

    void reserve(std::size_t count) { corners_.reserve(count); }
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t face) {
        corners_.push_back({{a, b, c}, face});
    }

    [[nodiscard]] std::size_t size() const { return corners_.size(); }
    [[nodiscard]] bool empty() const { return corners_.empty(); }
    [[nodiscard]] const std::vector<model::Vec3d>& vertices() const { return vertices_; }

    [[nodiscard]] Triangle operator[](std::size_t t) const {
        const auto& [v, face] = corners_[t];
        Triangle out;
        out.a = vertices_[v[0]];
        out.b = vertices_[v[1]];
        out.c = vertices_[v[2]];
        const double longest = longest_edge_squared({out.a, out.b, out.c});
        out.normal = cross(out.b - out.a, out.c - out.a);
        out.normal_squared = dot(out.normal, out.normal);
        if (!(out.normal_squared > kSliverSineSquared * longest * longest) ||
            !(out.normal_squared > std::numeric_limits<double>::min())) {
            out.normal = {};
            out.normal_squared = 0;
        }
        out.face = face;
        out.swap_ab = v[1] < v[0];
        out.swap_bc = v[2] < v[1];
        out.swap_ca = v[0] < v[2];
        return out;
    }

 private:
    struct Corners {
        std::array<std::uint32_t, 3> vertices;
        std::uint32_t face;
    };
    std::vector<model::Vec3d> vertices_;
    std::vector<Corners> corners_;
};

}  // namespace dgm::bake
