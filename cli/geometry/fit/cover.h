// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/cover.h
// The source vertices over each face of a fitted grid, which repairs must not leave uncovered.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/fit/points_by_face.h"
#include "geometry/mesh/triangle.h"

namespace dgm::bake {

/// The source vertices by the face of the grid that they lay over when it was made. Not for several threads at once.
class Cover {
 public:
    /// @param faces  of the grid
    Cover(const Matches& matches, std::size_t faces) {
        const std::span<const Match> vertices = std::span(matches.points).subspan(matches.area_points);
        PointsByFace by_face(vertices, faces);
        first_ = std::move(by_face.first);
        points_.reserve(vertices.size());
        for (const std::uint32_t k : by_face.of) points_.push_back(vertices[k].position);
    }

    [[nodiscard]] std::span<const Vec3d> over(std::uint32_t face) const {
        return std::span(points_).subspan(first_[face], first_[face + 1] - first_[face]);
    }

    /// Squared distance to `faces` of the farthest of the vertices over them; of one that is far enough, if there is.
    /// @param is_enough  of a squared distance; true for all greater ones, too
    template <class IsEnough>
    [[nodiscard]] double farthest(const LinkedSurface& grid, std::span<const std::uint32_t> faces,
                                  const IsEnough& is_enough) {
        corners_.clear();
        for (const std::uint32_t f : faces) corners_.push_back(grid.corners(f));
        double farthest = 0;
        std::array<double, 3> ignored;
        for (std::size_t own = 0; own < faces.size(); ++own)
            for (const Vec3d& p : over(faces[own])) {
                // Most lie over their own face still, no farther than the farthest so far: the others do not matter.
                double least = closest_on_triangle(p, corners_[own], ignored);
                for (std::size_t k = 0; k < faces.size() && least > farthest; ++k)
                    if (k != own) least = std::min(least, closest_on_triangle(p, corners_[k], ignored));
                if (!(least > farthest)) continue;
                farthest = least;
                if (is_enough(farthest)) return farthest;
            }
        return farthest;
    }

 private:
    std::vector<std::uint32_t> first_;  // of a face in points_; one more at the end
    std::vector<Vec3d> points_;
    std::vector<std::array<Vec3d, 3>> corners_;  // of the faces asked for
};

}  // namespace dgm::bake
