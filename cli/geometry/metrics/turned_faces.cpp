// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/turned_faces.cpp
#include "geometry/metrics/turned_faces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

namespace dgm::bake {
using model::Face;
using model::TriMesh;
using model::Vec3d;

std::vector<std::uint32_t> find_turned_faces(const ClosestPointIndex& index, const TriMesh& map, double tie,
                                             double least_cosine, std::span<const char> either_side) {
    const double reach = tie * index.diagonal();
    std::vector<char> turned(map.faces.size(), 0);
    constexpr std::size_t kChunk = 1024;  // neighbours share a hint
    tbb::parallel_for(std::size_t{0}, (turned.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        std::uint32_t hint = ClosestPointIndex::kNoFace;
        for (std::size_t f = chunk * kChunk; f < std::min(turned.size(), (chunk + 1) * kChunk); ++f) {
            const auto [a, b, c] = map.corners(f);
            Vec3d normal = normalized(cross(b - a, c - a), Vec3d{});
            if (normal == Vec3d{}) continue;
            const Vec3d centre = (a + b + c) / 3;
            // Nearly every face agrees with its nearest; only the others need to know how near the nearest is.
            const ClosestPoint any = index.query(centre, hint);
            if (any.face == ClosestPointIndex::kNoFace) continue;
            hint = any.face;
            if (!either_side.empty() && either_side[f] && dot(index.unit_normal(any.face), normal) < 0)
                normal = -normal;
            if (dot(index.unit_normal(any.face), normal) > least_cosine) continue;
            const ClosestPoint facing =
                index.query_facing(centre, normal, least_cosine, any.face, any.distance + reach);
            turned[f] = facing.face == ClosestPointIndex::kNoFace || facing.distance > any.distance + reach;
        }
    });
    std::vector<std::uint32_t> out;
    for (std::size_t f = 0; f < turned.size(); ++f)
        if (turned[f]) out.push_back(static_cast<std::uint32_t>(f));
    return out;
}

std::vector<char> faces_beside_reversed(std::span<const Face> faces, std::span<const char> reversed) {
    if (std::find(reversed.begin(), reversed.end(), char{1}) == reversed.end()) return {};
    std::vector<char> marked(reversed.begin(), reversed.end()), out(faces.size(), 0);
    for (int ring = 0; ring < 2; ++ring) {
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (const std::uint32_t v : faces[f]) out[f] = static_cast<char>(out[f] | marked[v]);
        for (std::size_t f = 0; f < faces.size(); ++f)
            if (out[f])
                for (const std::uint32_t v : faces[f]) marked[v] = 1;
    }
    return out;
}

std::size_t count_turned_faces(const TriMesh& source, const TriMesh& map, const ClosestPointIndex* index,
                               std::span<const char> either_side) {
    std::optional<ClosestPointIndex> own;
    if (index == nullptr) index = &own.emplace(source.positions, source.faces);
    return find_turned_faces(*index, map, kTurnedTie, 0, either_side).size();
}

}  // namespace dgm::bake
