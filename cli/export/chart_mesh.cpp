// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/chart_mesh.cpp
#include "export/chart_mesh.h"

#include <algorithm>
#include <filesystem>

#include "geometry/metrics/reconstruction.h"

namespace dgm::exporter {
using model::Face;
using model::Vec2d;
using model::Vec3d;

ChartMesh chart_mesh(const bake::Reconstruction& surface, const Vec3d& origin, const std::vector<Face>* coarse) {
    const model::TriMesh& full = surface.mesh;
    ChartMesh out;
    out.faces = coarse != nullptr ? *coarse : full.faces;
    out.positions.reserve(full.positions.size());
    for (const Vec3d& p : full.positions) out.positions.push_back(p - origin);
    if (!full.corner_normals.empty()) out.normals.assign(full.positions.size(), {0, 0, 1});
    if (!full.corner_uvs.empty()) out.uvs.resize(full.positions.size());
    for (std::size_t c = 0; c < 3 * full.faces.size(); ++c) {
        const std::uint32_t v = full.faces[c / 3][c % 3];
        if (!out.normals.empty()) out.normals[v] = full.corner_normals[c];
        if (!out.uvs.empty()) out.uvs[v] = {full.corner_uvs[c].y, full.corner_uvs[c].x};
    }
    return out;
}

std::vector<std::uint32_t> named_vertices(const std::vector<Face>& faces, std::size_t count) {
    std::vector<char> named(count, 0);
    for (const Face& face : faces)
        for (const std::uint32_t v : face) named[v] = 1;
    std::vector<std::uint32_t> used;
    for (std::uint32_t v = 0; v < named.size(); ++v)
        if (named[v] != 0) used.push_back(v);
    return used;
}

std::vector<Face> renumbered(std::vector<Face> faces, const std::vector<std::uint32_t>& used) {
    if (used.empty()) return faces;
    std::vector<std::uint32_t> number(used.back() + std::size_t{1}, 0);
    for (std::uint32_t k = 0; k < used.size(); ++k) number[used[k]] = k;
    for (Face& face : faces)
        for (std::uint32_t& v : face) v = number[v];
    return faces;
}

bool is_open(const bake::Reconstruction& surface) {
    std::vector<std::uint64_t> edges;
    edges.reserve(3 * surface.welded_faces.size());
    for (const Face& f : surface.welded_faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            edges.push_back((std::uint64_t{std::min(a, b)} << 32) | std::max(a, b));
        }
    // A surface without an inside is seen from both sides, too.
    if (std::find(surface.reversed.begin(), surface.reversed.end(), 1) != surface.reversed.end()) return true;
    std::sort(edges.begin(), edges.end());
    for (std::size_t k = 0; k < edges.size(); ++k)
        if ((k == 0 || edges[k - 1] != edges[k]) && (k + 1 == edges.size() || edges[k + 1] != edges[k])) return true;
    return false;
}

Vec2d place_in_picture(const Vec2d& uv, std::uint32_t across, std::uint32_t down) {
    return {(uv.y * (across - 1.0) + 0.5) / across, (uv.x * (down - 1.0) + 0.5) / down};
}

std::string asset_name(const model::MapSet& maps) {
    const std::string stem = std::filesystem::path(maps.source_name).stem().string();
    return stem.empty() ? "surface" : stem;
}

std::vector<std::string> chart_names(const model::MapSet& maps) {
    const std::string asset = asset_name(maps);
    if (maps.charts.size() == 1) return {asset};
    std::vector<std::string> out;
    for (std::size_t k = 0; k < maps.charts.size(); ++k) out.push_back(asset + "_chart" + std::to_string(k));
    return out;
}

}  // namespace dgm::exporter
