// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/linked_surface.h
// Surfaces on which a point finds its closest point by walking from where it was last time.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/cut/disk.h"

namespace dgm::bake {

/// An indexed surface with the face across each edge. Edge k of a face runs from its corner k to corner k + 1.
struct LinkedSurface {
    std::vector<Vec3d> positions;
    std::vector<Face> faces;
    std::vector<std::array<std::uint32_t, 3>> neighbours;  ///< kNone on a border
    std::vector<Vec3d> normals;                            ///< unit, per face; zero for a face without area
    /// Per face, 1 beside a seam across which windings disagree (metrics/turned_faces.h); empty: nowhere.
    std::vector<char> either_side;

    [[nodiscard]] std::array<Vec3d, 3> corners(std::size_t face) const {
        return {positions[faces[face][0]], positions[faces[face][1]], positions[faces[face][2]]};
    }
    void update_normal(std::size_t face);
    void update_normals();
};

/// A point of a surface and how far it is from the point that was looked up.
struct SurfaceHit {
    std::uint32_t face = kNone;
    double squared = 0;  ///< squared distance
    std::array<double, 3> b{0, 0, 0};
};

[[nodiscard]] inline Vec3d point_at(const LinkedSurface& surface, const SurfaceHit& hit) {
    const auto q = surface.corners(hit.face);
    return q[0] * hit.b[0] + q[1] * hit.b[1] + q[2] * hit.b[2];
}

/// Goes from face to face, each step nearer to `p`, until no neighbour of the closest point is nearer: a local minimum
/// of the distance, on the sheet that `start` lies on. Bounded work. Thread-safe.
/// @param looked  counts up by the faces looked at, unless it is null
[[nodiscard]] SurfaceHit walk_to_closest(const LinkedSurface& surface, const Vec3d& p, std::uint32_t start,
                                         std::uint64_t* looked = nullptr);

/// Floods some hundred faces around a start, time and again.
class NearbyFaces {
 public:
    /// @param surface  must outlive the object; its content may change in between
    explicit NearbyFaces(const LinkedSurface& surface) : surface_(surface) {}

    template <class Visit>
    void visit(std::uint32_t start, Visit visit_face) {
        constexpr std::size_t kMost = 400;
        if (++turn_ == 0 || seen_.size() != surface_.faces.size()) {
            seen_.assign(surface_.faces.size(), 0);
            turn_ = 1;
        }
        reached_.assign(1, start);
        seen_[start] = turn_;
        for (std::size_t k = 0; k < reached_.size(); ++k) {
            const std::uint32_t face = reached_[k];
            visit_face(face);
            if (reached_.size() == kMost) continue;
            for (const std::uint32_t next : surface_.neighbours[face])
                if (next != kNone && reached_.size() < kMost && seen_[next] != turn_) {
                    seen_[next] = turn_;
                    reached_.push_back(next);
                }
        }
    }

 private:
    const LinkedSurface& surface_;
    std::vector<std::uint32_t> seen_, reached_;  // seen_: per face, the last turn that reached it
    std::uint32_t turn_ = 0;
};

/// The closest point among some hundred faces around a start: the other wall of a narrow fold, where a walk does not
/// go.
class NearbySearch {
 public:
    /// @param surface  must outlive the search; its content may change in between
    explicit NearbySearch(const LinkedSurface& surface) : surface_(surface), nearby_(surface) {}
    [[nodiscard]] SurfaceHit from(const Vec3d& p, std::uint32_t start);

 private:
    const LinkedSurface& surface_;
    NearbyFaces nearby_;
};

/// The source of a chart with its cut closed: the disk's faces, in their order, over its surface points.
[[nodiscard]] LinkedSurface link_source(const Disk& disk);

/// Unit face normals at the scale of faces with `area`: smaller faces take the direction of their surroundings. The
/// sides of a spike between two samples face all directions, and would keep the grid from growing one.
[[nodiscard]] std::vector<Vec3d> normals_at_scale(const LinkedSurface& surface, double area);

}  // namespace dgm::bake
