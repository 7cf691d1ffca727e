// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/glb_vertices.h
// A chart's vertices as accessors of a .glb, as floats or quantized (KHR_mesh_quantization).
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "export/chart_mesh.h"
#include "export/glb_buffer.h"

namespace dgm::exporter {

/// position in the node's parent = translation + scale * stored
struct GlbFrame {
    model::Vec3d translation;
    double scale = 1;
};

class GlbVertices {
 public:
    /// The vertices of `mesh` that `used` names. All must outlive this.
    GlbVertices(GlbBuffer& buffer, const ChartMesh& mesh, std::span<const std::uint32_t> used, bool quantize)
        : buffer_(buffer), mesh_(mesh), used_(used), quantize_(quantize) {}

    /// Adds POSITION with its bounds and says in `frame` what stored values mean, added to what stands there.
    /// @throws model::Error kNotFinite for a vertex that f32 cannot hold
    std::size_t add_positions(GlbFrame& frame);
    std::size_t add_normals();
    std::size_t add_tangents(const std::vector<model::Vec3d>& tangents);
    /// For a picture of across x down texels.
    std::size_t add_uvs(std::uint32_t across, std::uint32_t down);

 private:
    GlbBuffer& buffer_;
    const ChartMesh& mesh_;
    std::span<const std::uint32_t> used_;
    bool quantize_;
};

}  // namespace dgm::exporter
