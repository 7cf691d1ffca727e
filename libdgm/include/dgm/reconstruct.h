// SPDX-License-Identifier: MIT
// libdgm/include/dgm/reconstruct.h
// Paper section 4.3: the grid's implicit connectivity becomes vertices and triangles in the caller's memory.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/asset.h>
#include <dgm/result.h>
#include <dgm/state.h>

namespace dgm {

enum class IndexTopology : std::uint32_t {
    Triangles = 0,
    Strips = 1,  ///< of triangles, kRestart between them
};

/// Ends a strip (GL_PRIMITIVE_RESTART_FIXED_INDEX, and what Vulkan, Direct3D and Metal take for 32-bit indices).
inline constexpr std::uint32_t kRestart = 0xFFFFFFFFu;

struct ReconstructOptions {
    /// Level of detail: blocks of at least k x k quads become two triangles each. Vertices stay what they are: one
    /// vertex buffer serves all levels. Borders of the chart keep all their samples, so that seams stay closed and
    /// levels fit each other from chart to chart.
    std::uint32_t lod_stride = 1;
    IndexTopology topology = IndexTopology::Triangles;
};

struct MeshCounts {
    std::uint32_t vertices = 0;
    std::uint64_t indices = 0;  ///< three a triangle; of strips all, restarts too
};

enum class VertexFormat : std::uint32_t {
    F32 = 0,
    F16 = 1,  ///< IEEE 754 binary16, to nearest
    U16 = 2,  ///< 0 .. 65535: positions of the box from `origin` on, normals of -1 .. 1, uv of 0 .. 1
};

/// An attribute that is not wanted.
inline constexpr std::size_t kNoAttribute = ~std::size_t{0};

/// Caller-owned vertices: attribute `a` of vertex k starts at data + k * stride + a_offset: position xyz (local),
/// normal xyz (unit), uv (x = v along columns, y = u along rows: image convention, first row on top).
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

/// How much memory reconstruct needs. Counts the triangles, O(samples).
/// @return MissingLayer, BadValue, Unsupported.
[[nodiscard]] DGM_API Result<MeshCounts> mesh_counts(const Chart& chart,
                                                     const ReconstructOptions& options = {}) noexcept;
[[nodiscard]] DGM_API Result<MeshCounts> mesh_counts(const State& state,
                                                     const ReconstructOptions& options = {}) noexcept;

/// Writes the baked surface of a chart.
///
/// Vertices are all samples, grid then border, none renumbered; one off the surface is in no triangle (its position is
/// as stored, 0 where that is not finite). Triangles are the quads' two each in row-major order (at stride 1), then the
/// border strip, counter-clockwise in (u, v). Positions are local: add Chart::offset() for the source frame. Normals
/// come from the layer `normal` (and `border_normal`); uv of border samples from `border_uv`. Pass an empty
/// `vertices.memory` or `indices` to leave that part out.
///
/// @return what was written; BufferTooSmall, BadArgument (stride 0, offsets that overlap the next vertex, steps),
/// NotFinite,
///         BadValue, MissingLayer, Unsupported. On an error the caller's memory may be partly written.
/// Thread-safe. No allocation. Works unaligned, so any packed layout will do.
[[nodiscard]] DGM_API Result<MeshCounts> reconstruct(const Chart& chart, const VertexTarget& vertices,
                                                     std::span<std::uint32_t> indices,
                                                     const ReconstructOptions& options = {}) noexcept;

/// The same for the present shape of a state. Normals are area-weighted over the welded ring (docs/methods.md
/// section 5), so all copies of a seam class get the same bits; a sample without area gets 0.
[[nodiscard]] DGM_API Result<MeshCounts> reconstruct(const State& state, const VertexTarget& vertices,
                                                     std::span<std::uint32_t> indices,
                                                     const ReconstructOptions& options = {}) noexcept;

}  // namespace dgm
