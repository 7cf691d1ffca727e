// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/surface_error.h
// Measures the distance of two surfaces (docs/design.md section 7): rms, hausdorff, normal_rms.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "geometry/spatial/closest_point.h"
#include "model/progress.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

struct SurfaceError {
    double rms = 0, hausdorff = 0;             ///< symmetric: the larger of the two directions; units of the meshes
    double rms_forward = 0, rms_backward = 0;  ///< source to map, map to source
    double hausdorff_forward = 0, hausdorff_backward = 0;
    model::Vec3d hausdorff_at;  ///< where `hausdorff` was found: a point of the source or of the map
    /// Angles of the source's normals to those of the closest map points, source to map. The source's are its corner
    /// normals, interpolated, if both meshes have some, else those of its faces.
    double normal_rms_degrees = 0;       ///< to the map's normals of the same kind
    double normal_rms_face_degrees = 0;  ///< to the map's face normals
    double normal_rms_bump_degrees = std::numeric_limits<double>::quiet_NaN();  ///< to `shading`, NaN without
    double diagonal = 0;                                                        ///< bounding-box diagonal of the source
    std::uint64_t samples = 0;          ///< points used, both directions together
    [[nodiscard]] double psnr() const;  ///< 20 log10(diagonal / rms), capped at 300 dB for identical surfaces
};

/// Most points with which baker and validator measure; the same seed gives them the same points.
inline constexpr std::uint64_t kSurfaceSamples = 400'000;
/// Enough points for each face of the two meshes: the distance is smooth where a face of one lies over one face of the
/// other, and there are hardly more of such places than faces. And the least of all.
inline constexpr std::uint64_t kSamplesPerFace = 24, kLeastSurfaceSamples = 20'000;
inline constexpr std::size_t kSurfaceTops = 256;

/// With how many points two meshes are measured each way: kSamplesPerFace, kLeastSurfaceSamples at least; `most` at
/// most.
[[nodiscard]] std::uint64_t surface_samples(const model::TriMesh& source, const model::TriMesh& map,
                                            std::uint64_t most = kSurfaceSamples);

struct SurfaceErrorOptions {
    /// Area-weighted random points each way, beside every vertex and points along borders and long creases; without a
    /// number those of surface_samples().
    std::optional<std::uint64_t> samples;
    std::uint64_t seed = 1;
    /// Without them `hausdorff` is of the random points alone, and the faces of the worst are not looked at more
    /// closely; rms is the same.
    bool vertices = true;
    /// Farthest points, and as many of other faces, that `hausdorff` climbs from; to climb costs as much as 48 points.
    std::size_t tops = kSurfaceTops;
    /// The closest points of the source, if there is an index already; must be built of the mesh measured.
    const ClosestPointIndex* source_index = nullptr;
    /// Unit normal at a point of a face of the map (index, barycentric coordinates) as drawn with the layer `bump`;
    /// empty: none. Called from several threads.
    std::function<model::Vec3d(std::uint32_t, const double (&)[3])> shading = {};
};

/// Symmetric surface-to-surface error by dense area-weighted sampling (deterministic) plus all vertices of both meshes,
/// with exact point-triangle distances. `hausdorff` climbs from the farthest points to the tops on their faces, so that
/// it hardly depends on where the points fell. The same bits whatever the number of threads.
/// @throws model::Error kNoFaces if a mesh has no faces
[[nodiscard]] SurfaceError measure_surface_error(const model::TriMesh& source, const model::TriMesh& map,
                                                 const SurfaceErrorOptions& options = {},
                                                 const model::Progress& progress = {});

}  // namespace dgm::bake
