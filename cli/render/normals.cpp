// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/normals.cpp
//
// [Thuermer and Wuethrich 1998] Computing vertex normals from polygonal facets. Journal of Graphics Tools 3(1).
#include "render/normals.h"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <tuple>

#include "math/portable.h"

namespace dgm::render {
namespace {
using model::Vec3d;

/// For each vertex, the lowest vertex at the same position.
std::vector<std::uint32_t> weld_equal_positions(const std::vector<Vec3d>& positions) {
    std::vector<std::uint32_t> order(positions.size()), weld(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) {
        const Vec3d& p = positions[v];
        return std::tuple(p.x, p.y, p.z, v);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (std::size_t k = 0; k < order.size(); ++k) {
        const bool same = k > 0 && positions[order[k]] == positions[order[k - 1]];
        weld[order[k]] = same ? weld[order[k - 1]] : order[k];
    }
    return weld;
}

double corner_angle(const Vec3d& at, const Vec3d& next, const Vec3d& previous) {
    const Vec3d a = next - at, b = previous - at;
    return math::atan2(length(cross(a, b)), dot(a, b));
}
}  // namespace

std::vector<Vec3d> smooth_corner_normals(const model::TriMesh& mesh, double crease_degrees) {
    constexpr std::uint32_t kManyFaces = 64;
    const double min_cosine = math::cos(crease_degrees * std::numbers::pi / 180);
    const std::size_t corners = 3 * mesh.faces.size();
    const std::vector<std::uint32_t> weld = weld_equal_positions(mesh.positions);

    std::vector<Vec3d> face_normals(mesh.faces.size());
    std::vector<double> angles(corners);
    std::vector<std::uint32_t> first(mesh.positions.size() + 1, 0), incident(corners);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto p = mesh.corners(f);
        face_normals[f] = normalized(cross(p[1] - p[0], p[2] - p[0]), {0, 0, 0});
        for (std::size_t k = 0; k < 3; ++k) {
            angles[3 * f + k] = corner_angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
            ++first[weld[mesh.faces[f][k]] + 1];
        }
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
    for (std::size_t c = 0; c < corners; ++c)
        incident[fill[weld[mesh.faces[c / 3][c % 3]]]++] = static_cast<std::uint32_t>(c);

    std::vector<Vec3d> normals(corners);
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const bool ignore_creases = first[v + 1] - first[v] > kManyFaces;
        Vec3d everything;
        if (ignore_creases)
            for (std::uint32_t s = first[v]; s < first[v + 1]; ++s)
                everything += angles[incident[s]] * face_normals[incident[s] / 3];
        for (std::uint32_t s = first[v]; s < first[v + 1]; ++s) {
            const Vec3d& own = face_normals[incident[s] / 3];
            Vec3d sum = everything;
            if (!ignore_creases)
                for (std::uint32_t t = first[v]; t < first[v + 1]; ++t) {
                    const Vec3d& other = face_normals[incident[t] / 3];
                    if (own == Vec3d{} || dot(own, other) > min_cosine) sum += angles[incident[t]] * other;
                }
            normals[incident[s]] = normalized(sum, normalized(own));
        }
    }
    return normals;
}

}  // namespace dgm::render
