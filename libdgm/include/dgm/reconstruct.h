// SPDX-License-Identifier: MIT
// libdgm/include/dgm/reconstruct.h
// Turns the grid's implicit connectivity into vertices and triangles in the caller's memory (paper section 4.3).
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/asset.h>
#include <dgm/result.h>
#include <dgm/state.h>

namespace dgm {

/// Form of the indices.
enum class IndexTopology : std::uint32_t {
    Triangles = 0,
    Strips = 1,  ///< triangle strips with kRestart between them
};

/// Ends a strip: the fixed restart index of OpenGL, Vulkan, Direct3D and Metal for 32-bit indices.
inline constexpr std::uint32_t kRestart = 0xFFFFFFFFu;

/// Level of detail and form of the indices.
struct ReconstructOptions {
    /// Level of detail: blocks of at least k x k quads become two triangles each. The vertices do not change, so one
    /// vertex buffer serves all levels. Borders of the chart keep all their samples: seams stay closed, and charts of
    /// different levels fit each other.
    std::uint32_t lod_stride = 1;
    IndexTopology topology = IndexTopology::Triangles;
};

/// Size of a mesh.
struct MeshCounts {
    std::uint32_t vertices = 0;
    std::uint64_t indices = 0;  ///< three for each triangle; strips: all of them, with the restarts
};

/// Format of one number of a vertex attribute.
enum class VertexFormat : std::uint32_t {
    F32 = 0,
    F16 = 1,  ///< IEEE 754 binary16, rounded to nearest
    U16 = 2,  ///< 0 .. 65535: positions as VertexTarget::origin says, normals of -1 .. 1, uv of 0 .. 1
};

/// Offset of an attribute that is not wanted.
inline constexpr std::size_t kNoAttribute = ~std::size_t{0};

/// Vertices in the caller's memory. An attribute of vertex k starts at data + k * stride + its offset. Attributes are
/// position x, y, z (local), normal x, y, z (unit length) and uv (x = v along columns, y = u along rows, as in images:
/// the first row is on top).
struct VertexTarget {
    std::span<std::byte> memory;
    std::size_t stride = 3 * sizeof(float);
    std::size_t position_offset = 0;
    std::size_t normal_offset = kNoAttribute;
    std::size_t uv_offset = kNoAttribute;
    VertexFormat position_format = VertexFormat::F32;
    VertexFormat normal_format = VertexFormat::F32;
    VertexFormat uv_format = VertexFormat::F32;
    /// Positions as U16: stored = (position - origin) / step, rounded and clamped to 0 .. 65535; steps > 0.
    Vec3 origin = {}, step = {};
};

/// Counts the vertices and indices that reconstruct() writes. O(samples).
/// @return MissingLayer, BadValue, BadArgument (stride 0), Unsupported (topology).
[[nodiscard]] DGM_API Result<MeshCounts> mesh_counts(const Chart& chart,
                                                     const ReconstructOptions& options = {}) noexcept;
[[nodiscard]] DGM_API Result<MeshCounts> mesh_counts(const State& state,
                                                     const ReconstructOptions& options = {}) noexcept;

/// Writes the baked surface of a chart.
///
/// Vertices are all samples: the grid, then the border, in the order of their indices. A sample off the surface is in
/// no triangle; its position is as stored, or 0 where that is not finite. Triangles are the two of each quad in
/// row-major order (at stride 1), then the border strip, counter-clockwise in (u, v). Positions are local: add
/// Chart::offset() for the source frame. Normals come from the layers `normal` and `border_normal`; uv of border
/// samples comes from `border_uv`. Pass an empty `vertices.memory` or `indices` to leave that part out.
///
/// @return the numbers written; BufferTooSmall, BadArgument (stride 0, attributes beyond the vertex, steps), NotFinite,
///         BadValue, MissingLayer, Unsupported. On an error the caller's memory may be partly written.
/// Thread-safe. No allocation. Works unaligned, so any packed layout will do.
[[nodiscard]] DGM_API Result<MeshCounts> reconstruct(const Chart& chart, const VertexTarget& vertices,
                                                     std::span<std::uint32_t> indices,
                                                     const ReconstructOptions& options = {}) noexcept;

/// Writes the present shape of a state. Normals are the normalized sums of the area vectors of the triangles around a
/// sample, across seams, so all copies of a weld class get the same bits, or the opposite ones where a surface with one
/// side was opened; a sample without area gets 0.
[[nodiscard]] DGM_API Result<MeshCounts> reconstruct(const State& state, const VertexTarget& vertices,
                                                     std::span<std::uint32_t> indices,
                                                     const ReconstructOptions& options = {}) noexcept;

}  // namespace dgm
