// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/curved_rest_shapes.cpp
#include "geometry/parameterize/curved_rest_shapes.h"

#include <algorithm>
#include <cmath>

namespace dgm::bake {

std::vector<RestShape> curved_rest_shapes(const DiskView& disk) {
    constexpr int kRounds = 2;
    constexpr double kMostCurved = 100;
    std::vector<RestShape> rest = rest_shapes(disk);
    const std::size_t n = disk.positions.size();
    std::vector<double> around(n, 0.0);
    std::vector<Vec3d> normals(n);
    double total = 0;
    for (std::size_t f = 0; f < rest.size(); ++f) {
        const Face& t = disk.faces[f];
        const Vec3d normal =
            cross(disk.positions[t[1]] - disk.positions[t[0]], disk.positions[t[2]] - disk.positions[t[0]]);
        for (std::uint32_t v : t) {
            normals[v] = normals[v] + normal;
            around[v] += rest[f].area;
        }
        total += rest[f].area;
    }
    for (Vec3d& normal : normals) normal = normalized(normal, Vec3d{});
    for (int round = 0; round < kRounds; ++round) {
        std::vector<Vec3d> sums(n);
        for (std::size_t f = 0; f < rest.size(); ++f) {
            const Face& t = disk.faces[f];
            const Vec3d share = (normals[t[0]] + normals[t[1]] + normals[t[2]]) * rest[f].area;
            for (std::uint32_t v : t) sums[v] = sums[v] + share;
        }
        for (std::size_t v = 0; v < n; ++v) normals[v] = normalized(sums[v], normals[v]);
    }
    std::vector<double> squared(rest.size());  // |II|^2
    for (std::size_t f = 0; f < rest.size(); ++f) {
        Vec3d x{}, y{};
        for (std::size_t k = 0; k < 3; ++k) {
            x = x + normals[disk.faces[f][k]] * rest[f].hat[k].x;
            y = y + normals[disk.faces[f][k]] * rest[f].hat[k].y;
        }
        squared[f] = dot(x, x) + dot(y, y);
    }
    for (int round = 0; round < kRounds; ++round) {
        std::vector<double> sums(n, 0.0);
        for (std::size_t f = 0; f < rest.size(); ++f)
            for (std::uint32_t v : disk.faces[f]) sums[v] += rest[f].area * squared[f];
        for (std::size_t f = 0; f < rest.size(); ++f) {
            squared[f] = 0;
            for (std::uint32_t v : disk.faces[f]) squared[f] += sums[v] / around[v] / 3;
        }
    }
    double mean = 0;
    for (std::size_t f = 0; f < rest.size(); ++f) mean += rest[f].area / total * std::sqrt(squared[f]);
    const double scale = std::sqrt(total);
    for (std::size_t f = 0; f < rest.size(); ++f) {
        for (Vec2d& b : rest[f].hat) b = b * scale;
        if (mean * scale > 1e-6) rest[f].area *= 1 + std::min(squared[f] / (mean * mean), kMostCurved);
    }
    return rest;
}

}  // namespace dgm::bake
