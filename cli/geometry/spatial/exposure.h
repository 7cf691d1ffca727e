// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/exposure.h
// Measures how much of a surface is in plain view: the complement of its ambient occlusion.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/tri_mesh.h"
#include "model/vec.h"

namespace dgm::bake {

/// Exposure of a point: the cosine-weighted share of the directions above it that leave the surface unhindered, 1 all
/// over a convex body, 0 inside a closed crack. It is estimated by kRays directions, the same in the frame of every
/// normal.
///
/// Immutable after construction; may be asked from any number of threads. Answers do not depend on their number, nor on
/// the vector instructions of the processor.
class ExposureIndex {
 public:
    static constexpr int kRays = 48;

    /// @param mesh  read here only. Faces with a vertex that is not finite or out of range hide nothing.
    /// @throws model::Error kInternal if Embree cannot build
    explicit ExposureIndex(const model::TriMesh& mesh);
    ~ExposureIndex();
    ExposureIndex(ExposureIndex&&) noexcept;
    ExposureIndex& operator=(ExposureIndex&&) noexcept;

    /// @param point  on the surface
    /// @param normal  outward, unit; zero for a point without one, whose exposure is 1
    /// Cost: kRays rays, some 20 microseconds.
    [[nodiscard]] double at(const model::Vec3d& point, const model::Vec3d& normal) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Exposure of every vertex of `mesh`, with its area-weighted normal.
/// @throws model::Error kInternal
[[nodiscard]] std::vector<double> vertex_exposure(const model::TriMesh& mesh);

}  // namespace dgm::bake
