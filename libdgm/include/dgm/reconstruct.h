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

struct ReconstructOptions {
    std::uint32_t lod_stride = 1;  ///< every k-th sample; this version knows 1, others are Unsupported
};

struct MeshCounts {
    std::uint32_t vertices = 0;
    std::uint64_t indices = 0;  ///< three a triangle
};

/// An attribute that is not wanted.
inline constexpr std::size_t kNoAttribute = ~std::size_t{0};

/// Caller-owned vertices: attribute `a` of vertex k starts at data + k * stride + a_offset. All are floats: position
/// xyz (local), normal xyz (unit), uv (x = v along columns, y = u along rows: image convention, first row on top).
struct VertexTarget {
    std::span<std::byte> memory;
    std::size_t stride = 3 * sizeof(float);
    std::size_t position_offset = 0;
    std::size_t normal_offset = kNoAttribute;
    std::size_t uv_offset = kNoAttribute;
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
/// as stored, 0 where that is not finite). Triangles are the quads' two each in row-major order, then the border
/// strip, counter-clockwise in (u, v). Positions are local: add Chart::offset() for the source frame. Normals come
/// from the layer `normal` (and `border_normal`); uv of border samples from `border_uv`.
/// Pass an empty `vertices.memory` or `indices` to leave that part out.
///
/// @return what was written; BufferTooSmall, BadArgument (stride or offsets that overlap the next vertex), NotFinite,
///         BadValue, MissingLayer, Unsupported. On an error the caller's memory may be partly written.
/// Thread-safe. No allocation. Works unaligned, so any packed layout will do.
[[nodiscard]] DGM_API Result<MeshCounts> reconstruct(const Chart& chart, const VertexTarget& vertices,
                                                     std::span<std::uint32_t> indices,
                                                     const ReconstructOptions& options = {}) noexcept;

/// The same for the present shape of a state. Normals are area-weighted over the welded ring (methods section 5), so
/// all copies of a seam class get the same bits; a sample without area gets 0.
[[nodiscard]] DGM_API Result<MeshCounts> reconstruct(const State& state, const VertexTarget& vertices,
                                                     std::span<std::uint32_t> indices,
                                                     const ReconstructOptions& options = {}) noexcept;

}  // namespace dgm
