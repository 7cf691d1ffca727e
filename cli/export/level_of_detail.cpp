// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/level_of_detail.cpp
#include "export/level_of_detail.h"

#include <dgm/asset.h>
#include <dgm/reconstruct.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "dgm/dgm_writer.h"
#include "model/codes.h"

namespace dgm::exporter {
namespace {
using model::TriMesh;
using model::Vec2d;
using model::Vec3d;

template <class T>
T taken(Result<T> result) {
    if (!result)
        throw model::Error(model::codes::kBadValue,
                           std::string(error_name(result.error().code)) + ": " + result.error().message);
    return std::move(result).value();
}

/// One entry a vertex from three a face; vertices without a face keep T{}.
template <class T>
std::vector<T> per_vertex(const TriMesh& mesh, const std::vector<T>& corners) {
    std::vector<T> out(corners.empty() ? 0 : mesh.positions.size());
    for (std::size_t c = 0; c < corners.size(); ++c) out[mesh.faces[c / 3][c % 3]] = corners[c];
    return out;
}
/// What triangles are made of, and nothing else.
model::MapSet shape_of(const model::MapSet& maps) {
    model::MapSet out;
    out.generator = maps.generator;
    out.report_json = "{}";
    for (const model::Chart& chart : maps.charts) {
        model::Chart& kept = out.charts.emplace_back(chart);
        std::erase_if(kept.layers, [](const model::Layer& layer) {
            constexpr std::array kShape{"geometry",  "seams",           "diagonals",   "mask",
                                        "border_uv", "border_geometry", "border_faces"};
            return std::find(kShape.begin(), kShape.end(), layer.name) == kShape.end();
        });
    }
    return out;
}
}  // namespace

std::vector<std::vector<model::Face>> faces_at_stride(const model::MapSet& maps, std::uint32_t stride,
                                                      const std::filesystem::path& scratch) {
    formats::write_dgm(shape_of(maps), scratch);
    const Asset asset = taken(Asset::open(scratch.c_str()));
    const ReconstructOptions options{.lod_stride = stride};
    std::vector<std::vector<model::Face>> out;
    for (std::uint32_t k = 0; k < asset.chart_count(); ++k) {
        const Chart chart = taken(asset.chart(k));
        std::vector<std::uint32_t> corners(taken(mesh_counts(chart, options)).indices);
        static_cast<void>(taken(reconstruct(chart, {}, corners, options)));
        std::vector<model::Face> faces(corners.size() / 3);
        for (std::size_t c = 0; c < corners.size(); ++c) faces[c / 3][c % 3] = corners[c];
        out.push_back(std::move(faces));
    }
    return out;
}

void thin_by_stride(render::ChartSurface& surface, const model::MapSet& maps, std::uint32_t stride,
                    const std::filesystem::path& scratch) {
    const std::vector<std::vector<model::Face>> charts = faces_at_stride(maps, stride, scratch);
    const TriMesh full = std::move(surface.mesh);
    const std::vector<Vec3d> normals = per_vertex(full, full.corner_normals);
    const std::vector<Vec2d> uvs = per_vertex(full, full.corner_uvs);

    TriMesh thin;
    thin.materials = full.materials;
    std::vector<std::uint32_t> number(full.positions.size(), ~0u);  // of a vertex in `thin`
    std::uint32_t base = 0;
    for (std::uint32_t k = 0; k < charts.size(); ++k) {
        for (const model::Face& face : charts[k]) {
            model::Face& renamed = thin.faces.emplace_back();
            thin.face_materials.push_back(k);
            for (std::size_t c = 0; c < 3; ++c) {
                const std::uint32_t v = base + face[c];  // both count a chart's grid samples, then its border samples
                if (number[v] == ~0u) {
                    number[v] = static_cast<std::uint32_t>(thin.positions.size());
                    thin.positions.push_back(full.positions[v]);
                }
                renamed[c] = number[v];
                if (!normals.empty()) thin.corner_normals.push_back(normals[v]);
                if (!uvs.empty()) thin.corner_uvs.push_back(uvs[v]);
            }
        }
        const model::Chart& chart = maps.charts[k];
        const model::Layer* border = chart.find("border_geometry");
        base += chart.rows * chart.cols + static_cast<std::uint32_t>(border == nullptr ? 0 : border->shape[0]);
    }
    surface.mesh = std::move(thin);
    surface.grid.clear();
    surface.seams.clear();
    surface.borders.clear();
}

}  // namespace dgm::exporter
