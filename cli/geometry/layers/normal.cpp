// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/normal.cpp
// Layer `normal` (eq. 6 for normals): the source's own normals interpolated, else area-weighted vertex normals.
#include "geometry/layers/layers.h"

#include <numeric>

#include "geometry/cut/disk.h"
#include "model/layer_names.h"
#include "model/octahedral.h"

namespace dgm::bake {
namespace {

/// A component as a disk that nothing is cut from, but with the sides joined along which it was opened.
Disk welded_whole(const TriMesh& mesh) {
    Disk out;
    out.mesh = mesh;
    out.weld.resize(mesh.positions.size());
    std::iota(out.weld.begin(), out.weld.end(), 0u);
    out.weld_count = static_cast<std::uint32_t>(out.weld.size());
    if (mesh.points.empty()) return out;
    out.opposite = opposite_half_edges(mesh.faces);
    out.mate.assign(out.opposite.size(), kNone);
    out.join_sides();
    return out;
}

/// Per vertex, the sum of the area vectors around its surface point, with the winding of the faces around the vertex.
std::vector<Vec3d> vertex_areas(const Disk& disk) {
    const TriMesh& mesh = disk.mesh;
    const std::vector<std::uint8_t> reversed = disk.reversed_vertices();
    std::vector<Vec3d> welded(disk.weld_count, Vec3d{}), out;
    for (const Face& f : mesh.faces) {
        const Vec3d area =
            cross(mesh.positions[f[1]] - mesh.positions[f[0]], mesh.positions[f[2]] - mesh.positions[f[0]]);
        for (const std::uint32_t v : f) welded[disk.weld[v]] += reversed.empty() || !reversed[v] ? area : -area;
    }
    for (std::uint32_t v = 0; v < disk.weld.size(); ++v)
        out.push_back(reversed.empty() || !reversed[v] ? welded[disk.weld[v]] : -welded[disk.weld[v]]);
    return out;
}

}  // namespace

void complete_normals(TriMesh& mesh) {
    const std::vector<Vec3d> smooth = vertex_areas(welded_whole(mesh));
    mesh.corner_normals.resize(3 * mesh.faces.size(), Vec3d{});
    for (std::size_t c = 0; c < mesh.corner_normals.size(); ++c) {
        Vec3d& n = mesh.corner_normals[c];
        n = normalized(n, normalized(smooth[mesh.faces[c / 3][c % 3]], Vec3d{}));
    }
}

model::OctahedralCode sample_code(const SampledChart& chart, std::size_t sample, model::OctahedralCode code) {
    if (!chart.is_reversed(sample)) return code;
    return model::encode_octahedral(-model::decode_octahedral(code));
}

StoredNormals store_normals(const LayerInput& in) {
    const SampledChart& chart = in.chart;
    const TriMesh& mesh = chart.disk->mesh;
    // Over the welded surface, so that the two sides of a cut agree.
    std::vector<Vec3d> welded = vertex_areas(*chart.disk);
    for (Vec3d& n : welded) n = normalized(n, Vec3d{});
    StoredNormals out;
    const std::size_t grid = chart.grid_count(), extra = chart.samples.size() - grid;
    out.normal = empty_layer(model::layers::kNormal, model::ElementType::kI16, {chart.m, chart.n, 2});
    if (extra > 0) out.border_normal = empty_layer(model::layers::kBorderNormal, model::ElementType::kI16, {extra, 2});
    out.decoded.assign(chart.samples.size(), Vec3d{0, 0, 1});
    for (std::size_t s = 0; s < chart.samples.size(); ++s) {
        if (!chart.on_surface(s)) continue;
        const SurfaceSample& at = chart.samples[chart.representative[s]];
        if (at.face == kNone) continue;
        Vec3d own, smooth;
        for (int k = 0; k < 3; ++k) {
            if (!mesh.corner_normals.empty()) own += mesh.corner_normals[3 * at.face + k] * at.b[k];
            smooth += welded[mesh.faces[at.face][k]] * at.b[k];
        }
        const model::OctahedralCode code =
            sample_code(chart, s, model::encode_octahedral(length(own) > 0.1 ? own : smooth));
        auto codes = s < grid ? values<std::int16_t>(out.normal).subspan(2 * s, 2)
                              : values<std::int16_t>(*out.border_normal).subspan(2 * (s - grid), 2);
        codes[0] = code[0];
        codes[1] = code[1];
        out.decoded[s] = model::decode_octahedral(code);
    }
    return out;
}

}  // namespace dgm::bake
