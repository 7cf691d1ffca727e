// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/tangent_space.cpp
//
// [Mikkelsen 2008] Simulation of wrinkled surfaces revisited. Master's thesis, University of Copenhagen. The rule that
// glTF 2.0, section 3.7.2.1, names for tangents.
#include "export/tangent_space.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/metrics/bump_normals.h"
#include "math/portable.h"
#include "render/layer_values.h"

namespace dgm::exporter {
namespace {
using model::Face;
using model::Vec2d;
using model::Vec3d;

Vec3d in_plane(const Vec3d& vector, const Vec3d& normal) {
    return normalized(vector - normal * dot(vector, normal), Vec3d{});
}

Vec3d any_perpendicular(const Vec3d& normal) {
    const Vec3d axis = std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    return in_plane(axis, normal);
}

/// Calls visit(texel, weights) for each texel of a rows x cols picture under the triangle, texel (0, 0) at (u, v) =
/// (0, 0) and the last at (1, 1). Edges belong to both sides. Cost: the rows it touches and the texels it covers.
template <class Visit>
void for_texels(const std::array<Vec2d, 3>& uv, std::uint32_t rows, std::uint32_t cols, Visit visit) {
    std::array<Vec2d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = {uv[k].x * (rows - 1.0), uv[k].y * (cols - 1.0)};
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    if (!(area > 0) || !std::isfinite(area)) return;
    constexpr double kSlack = 1e-6;  // of a texel; a texel on an edge must not fall between two faces
    const auto [low, high] = std::minmax({p[0].x, p[1].x, p[2].x});
    const double first = std::max(std::ceil(low - kSlack), 0.0), last = std::min(std::floor(high + kSlack), rows - 1.0);
    for (double x = first; x <= last; ++x) {
        double from = cols, to = -1;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d a = p[k], b = p[(k + 1) % 3];
            const double here = std::clamp(x, std::min(a.x, b.x), std::max(a.x, b.x));
            if (std::abs(here - x) > kSlack) continue;  // the row misses this edge
            for (const double y : a.x == b.x ? std::array{a.y, b.y}
                                             : std::array{a.y + (b.y - a.y) * ((here - a.x) / (b.x - a.x)),
                                                          a.y + (b.y - a.y) * ((here - a.x) / (b.x - a.x))}) {
                from = std::min(from, y);
                to = std::max(to, y);
            }
        }
        const double last_y = std::min(std::floor(to + kSlack), cols - 1.0);
        for (double y = std::max(std::ceil(from - kSlack), 0.0); y <= last_y; ++y) {
            std::array<double, 3> weight{};
            double sum = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                weight[k] = std::max(0.0, cross(p[(k + 1) % 3] - Vec2d{x, y}, p[(k + 2) % 3] - Vec2d{x, y}));
                sum += weight[k];
            }
            for (double& w : weight) w /= sum;
            visit(static_cast<std::size_t>(x) * cols + static_cast<std::size_t>(y), weight);
        }
    }
}

/// `direction` in the basis t, cross(n, t), n, which need not be orthogonal; kept above the surface.
Vec3d in_basis(const Vec3d& direction, const Vec3d& t, const Vec3d& n) {
    constexpr double kLowest = 0.01;  // glTF knows no normals below the surface
    const Vec3d b = cross(n, t);
    const double volume = dot(t, cross(b, n));
    if (!(volume > 1e-6)) return {0, 0, 1};
    Vec3d out{dot(direction, cross(b, n)), dot(t, cross(direction, n)), dot(t, cross(b, direction))};
    out = normalized(out / volume);
    if (out.z < kLowest) out.z = kLowest;
    return normalized(out);
}

model::Rgba8 colour_of(const Vec3d& n) {
    // 127.5 is the code of 0 and rounds to 128 whatever the last bits of a computed 0.
    const auto code = [](double c) {
        return static_cast<std::uint8_t>(std::clamp(std::floor(128 + 127.5 * c + 1e-6), 0.0, 255.0));
    };
    return {code(n.x), code(n.y), code(n.z), 255};
}
}  // namespace

std::vector<Vec3d> vertex_tangents(const ChartMesh& mesh) {
    std::vector<Vec3d> sum(mesh.positions.size());
    for (const Face& f : mesh.faces) {
        const Vec3d p1 = mesh.positions[f[1]] - mesh.positions[f[0]], p2 = mesh.positions[f[2]] - mesh.positions[f[0]];
        const Vec2d q1 = mesh.uvs[f[1]] - mesh.uvs[f[0]], q2 = mesh.uvs[f[2]] - mesh.uvs[f[0]];
        if (!(cross(q1, q2) > 0)) continue;
        const Vec3d along = q1.x * p2 - q2.x * p1;  // dP/dv times twice the area in the map
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d& n = mesh.normals[f[k]];
            const Vec3d& at = mesh.positions[f[k]];
            const Vec3d next = in_plane(mesh.positions[f[(k + 1) % 3]] - at, n);
            const Vec3d previous = in_plane(mesh.positions[f[(k + 2) % 3]] - at, n);
            const double angle = math::acos(std::clamp(dot(next, previous), -1.0, 1.0));
            sum[f[k]] += in_plane(along, n) * angle;
        }
    }
    for (std::size_t v = 0; v < sum.size(); ++v) {
        sum[v] = in_plane(sum[v], mesh.normals[v]);
        if (sum[v] == Vec3d{} || !is_finite(sum[v])) sum[v] = any_perpendicular(mesh.normals[v]);
    }
    return sum;
}

std::optional<formats::Image> tangent_normal_map(const model::Chart& chart, const bake::Reconstruction& surface,
                                                 const ChartMesh& mesh, std::span<const Vec3d> tangents) {
    const model::Layer* bump = chart.find("bump");
    if (bump == nullptr || mesh.normals.empty()) return std::nullopt;
    const render::Plane size = render::read_plane(*bump, {model::ElementType::kF16}, 1);
    const auto shading = bake::BumpNormals::of(chart, surface);
    if (!shading) return std::nullopt;
    formats::Image image{size.cols, size.rows,
                         std::vector<model::Rgba8>(std::size_t{size.rows} * size.cols, colour_of({0, 0, 1}))};
    std::vector<char> done(image.pixels.size(), 0);
    const std::uint32_t grid = chart.rows * chart.cols;
    for (const Face& f : mesh.faces) {
        if (f[0] >= grid || f[1] >= grid || f[2] >= grid) continue;  // the layer says nothing about strips
        for_texels({mesh.uvs[f[0]], mesh.uvs[f[1]], mesh.uvs[f[2]]}, size.rows, size.cols,
                   [&](std::size_t texel, const std::array<double, 3>& weight) {
                       const Vec3d wanted = shading->at_texel(texel);
                       if (done[texel] != 0 || wanted == Vec3d{}) return;
                       Vec3d n, t;
                       for (std::size_t k = 0; k < 3; ++k) {
                           n += mesh.normals[f[k]] * weight[k];
                           t += tangents[f[k]] * weight[k];
                       }
                       image.pixels[texel] = colour_of(in_basis(wanted, normalized(t), normalized(n)));
                       done[texel] = 1;
                   });
    }
    return image;
}

}  // namespace dgm::exporter
