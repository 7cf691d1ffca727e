// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/closest_point.h
// Exact closest point on a triangle mesh, over Embree's bounding volume hierarchy.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "model/vec.h"

namespace dgm::bake {

struct ClosestPoint {
    model::Vec3d point;  ///< on the surface
    std::uint32_t face = std::numeric_limits<std::uint32_t>::max();
    double barycentric[3] = {0, 0, 0};  ///< of `point` in `face`
    double distance = std::numeric_limits<double>::infinity();
};

/// Immutable after construction; `query` may be called from any number of threads.
/// The hierarchy is built in a frame centred on the mesh and scaled by its diagonal, so offset and size cost nothing.
/// Faces with a vertex that is not finite or out of range are never an answer; faces without area are.
class ClosestPointIndex {
 public:
    static constexpr std::uint32_t kNoFace = std::numeric_limits<std::uint32_t>::max();

    /// The spans are read here only. @throws model::Error kInternal if Embree cannot build
    ClosestPointIndex(std::span<const model::Vec3d> positions, std::span<const model::Face> faces);
    ~ClosestPointIndex();
    ClosestPointIndex(ClosestPointIndex&&) noexcept;
    ClosestPointIndex& operator=(ClosestPointIndex&&) noexcept;

    /// Distances are computed in double; ties go to the lowest face index. No answer (face kNoFace) for a point that is
    /// not finite. `hint`: a face likely to be near, such as the last answer; makes it faster, never changes the
    /// result.
    [[nodiscard]] ClosestPoint query(const model::Vec3d& point, std::uint32_t hint = kNoFace) const;

    /// The closest point among faces whose unit normal n has dot(n, normal) > min_cosine; face stays at its maximum
    /// value if there is none. Faces without a normal (unit_normal()) never match. `limit`: faces farther away need not
    /// be found; where whole regions face the other way, it is what keeps a query from visiting every face.
    [[nodiscard]] ClosestPoint query_facing(const model::Vec3d& point, const model::Vec3d& normal, double min_cosine,
                                            std::uint32_t hint = kNoFace,
                                            double limit = std::numeric_limits<double>::infinity()) const;

    /// What the hierarchy holds: triangles, parts of needles, hierarchies of many triangles. The work of building it.
    [[nodiscard]] std::size_t pieces() const;
    /// Of the bounding box of the faces; 1 where that is no number to divide by.
    [[nodiscard]] double diagonal() const;
    /// Zero for a face without area, or so low (1e-13 diagonals) that rounding decides its normal, or left out.
    [[nodiscard]] model::Vec3d unit_normal(std::uint32_t face) const;

    /// The closest point whose face looks the same way, n . normal > 0.3, if it is at most twice as far as the closest
    /// of all, plus `slack`; else the closest of all: a sliver's normal says little, and may agree with the far side
    /// only.
    [[nodiscard]] ClosestPoint query_preferring(const model::Vec3d& point, const model::Vec3d& normal, double slack,
                                                std::uint32_t hint = kNoFace) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace dgm::bake
