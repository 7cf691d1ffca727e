// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/curved_rest_shapes.cpp
#include "geometry/parameterize/curved_rest_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dgm::bake {
namespace {

constexpr int kRounds = 2;  // of smoothing, for normals and for curvature each

/// Symmetric tensor in space: xx, xy, xz, yy, yz, zz.
using Tensor = std::array<double, 6>;

/// Two tangents of a face, in which its rest shape is laid flat (rest_shapes.h).
struct Frame {
    Vec3d x, y;
};

std::vector<double> areas_around(const DiskView& disk, const std::vector<RestShape>& rest) {
    std::vector<double> out(disk.positions.size(), 0.0);
    for (std::size_t f = 0; f < rest.size(); ++f)
        for (const std::uint32_t v : disk.faces[f]) out[v] += rest[f].area;
    return out;
}

std::vector<Vec3d> smooth_normals(const DiskView& disk, const std::vector<RestShape>& rest) {
    std::vector<Vec3d> normals(disk.positions.size());
    for (const Face& t : disk.faces) {
        const Vec3d normal =
            cross(disk.positions[t[1]] - disk.positions[t[0]], disk.positions[t[2]] - disk.positions[t[0]]);
        for (const std::uint32_t v : t) normals[v] = normals[v] + normal;
    }
    for (Vec3d& normal : normals) normal = normalized(normal, Vec3d{});
    for (int round = 0; round < kRounds; ++round) {
        std::vector<Vec3d> sums(normals.size());
        for (std::size_t f = 0; f < rest.size(); ++f) {
            const Face& t = disk.faces[f];
            const Vec3d share = (normals[t[0]] + normals[t[1]] + normals[t[2]]) * rest[f].area;
            for (const std::uint32_t v : t) sums[v] = sums[v] + share;
        }
        for (std::size_t v = 0; v < normals.size(); ++v) normals[v] = normalized(sums[v], normals[v]);
    }
    return normals;
}

/// Change of the normal along both axes of a face.
struct NormalChange {
    Vec3d x, y;
};

NormalChange change_of(const std::vector<Vec3d>& normals, const Face& face, const RestShape& rest) {
    NormalChange out{};
    for (std::size_t k = 0; k < 3; ++k) {
        out.x = out.x + normals[face[k]] * rest.hat[k].x;
        out.y = out.y + normals[face[k]] * rest.hat[k].y;
    }
    return out;
}

/// Means over the faces about each vertex, then over the corners of each face.
template <std::size_t N>
void smooth(const DiskView& disk, const std::vector<RestShape>& rest, std::vector<std::array<double, N>>& values) {
    const std::vector<double> around = areas_around(disk, rest);
    for (int round = 0; round < kRounds; ++round) {
        std::vector<std::array<double, N>> sums(around.size());
        for (std::size_t f = 0; f < rest.size(); ++f)
            for (const std::uint32_t v : disk.faces[f])
                for (std::size_t c = 0; c < N; ++c) sums[v][c] += rest[f].area * values[f][c];
        for (std::size_t f = 0; f < rest.size(); ++f) {
            values[f] = {};
            for (const std::uint32_t v : disk.faces[f])
                for (std::size_t c = 0; c < N; ++c) values[f][c] += sums[v][c] / around[v] / 3;
        }
    }
}

double total_area(const std::vector<RestShape>& rest) {
    double out = 0;
    for (const RestShape& shape : rest) out += shape.area;
    return out;
}

Frame frame_of(const DiskView& disk, const Face& face) {
    const Vec3d& p = disk.positions[face[0]];
    const Vec3d x = normalized(disk.positions[face[1]] - p, Vec3d{1, 0, 0});
    const Vec3d normal = normalized(cross(x, disk.positions[face[2]] - p), Vec3d{});
    return {x, cross(normal, x)};
}

/// The square of the second fundamental form, as a tensor in space: sums of it do not cancel where signs differ.
Tensor squared_form(const Frame& at, const NormalChange& change) {
    const double xx = dot(at.x, change.x), yy = dot(at.y, change.y),
                 xy = 0.5 * (dot(at.x, change.y) + dot(at.y, change.x));
    const Vec3d a = at.x * xx + at.y * xy, b = at.x * xy + at.y * yy;
    return {a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.x * a.z + b.x * b.z,
            a.y * a.y + b.y * b.y, a.y * a.z + b.y * b.z, a.z * a.z + b.z * b.z};
}

/// A symmetric tensor of the plane: its eigenvalues, and the direction of the larger one.
struct Principal {
    double large = 0, small = 0;
    Vec2d along{1, 0};
};

/// The principal curvatures, without their signs.
Principal principal(const Frame& at, const Tensor& q) {
    const auto times = [&](const Vec3d& v) {
        return Vec3d{q[0] * v.x + q[1] * v.y + q[2] * v.z, q[1] * v.x + q[3] * v.y + q[4] * v.z,
                     q[2] * v.x + q[4] * v.y + q[5] * v.z};
    };
    const Vec3d x = times(at.x);
    const double xx = dot(at.x, x), xy = dot(at.y, x), yy = dot(at.y, times(at.y));
    const double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy), radius = std::sqrt(half * half + xy * xy);
    Principal out{std::sqrt(std::max(0.0, mean + radius)), std::sqrt(std::max(0.0, mean - radius)), {}};
    const Vec2d way = half > 0 ? Vec2d{half + radius, xy} : Vec2d{xy, radius - half};
    const double size = std::sqrt(dot(way, way));
    out.along = size > 0 ? way * (1 / size) : Vec2d{1, 0};
    return out;
}

}  // namespace

std::vector<RestShape> curved_rest_shapes(const DiskView& disk) {
    constexpr double kMostCurved = 100;
    std::vector<RestShape> rest = rest_shapes(disk);
    const std::vector<Vec3d> normals = smooth_normals(disk, rest);
    std::vector<std::array<double, 1>> squared(rest.size());  // |II|^2
    for (std::size_t f = 0; f < rest.size(); ++f) {
        const NormalChange change = change_of(normals, disk.faces[f], rest[f]);
        squared[f] = {dot(change.x, change.x) + dot(change.y, change.y)};
    }
    smooth(disk, rest, squared);
    const double total = total_area(rest);
    double mean = 0;
    for (std::size_t f = 0; f < rest.size(); ++f) mean += rest[f].area / total * std::sqrt(squared[f][0]);
    const double scale = std::sqrt(total);
    for (std::size_t f = 0; f < rest.size(); ++f) {
        for (Vec2d& b : rest[f].hat) b = b * scale;
        if (mean * scale > 1e-6) rest[f].area *= 1 + std::min(squared[f][0] / (mean * mean), kMostCurved);
    }
    return rest;
}

std::vector<RestShape> directed_rest_shapes(const DiskView& disk) {
    constexpr double kLeast = 0.5, kMost = 10, kRatio = 4;
    std::vector<RestShape> rest = rest_shapes(disk);
    const std::vector<Vec3d> normals = smooth_normals(disk, rest);
    std::vector<Frame> frames(rest.size());
    std::vector<Tensor> squared(rest.size());
    for (std::size_t f = 0; f < rest.size(); ++f) {
        frames[f] = frame_of(disk, disk.faces[f]);
        squared[f] = squared_form(frames[f], change_of(normals, disk.faces[f], rest[f]));
    }
    smooth(disk, rest, squared);
    const double total = total_area(rest);
    std::vector<Principal> curvature(rest.size());
    double mean = 0;
    for (std::size_t f = 0; f < rest.size(); ++f) {
        curvature[f] = principal(frames[f], squared[f]);
        mean += rest[f].area / total * 0.5 * (curvature[f].large + curvature[f].small);
    }
    if (!(mean * std::sqrt(total) > 1e-6)) mean = 1;  // a plane: all alike
    double room = 0;
    for (std::size_t f = 0; f < rest.size(); ++f) {
        Principal& k = curvature[f];
        k.large = std::clamp(k.large, kLeast * mean, kMost * mean);
        k.small = std::clamp(k.small, std::max(kLeast * mean, k.large / kRatio), k.large);
        room += rest[f].area * std::sqrt(k.large * k.small);
    }
    for (std::size_t f = 0; f < rest.size(); ++f) {
        const Principal& k = curvature[f];
        const double along = std::sqrt(room / k.large), across = std::sqrt(room / k.small);
        const Vec2d other{-k.along.y, k.along.x};
        for (Vec2d& b : rest[f].hat) b = k.along * (along * dot(k.along, b)) + other * (across * dot(other, b));
    }
    return rest;
}

}  // namespace dgm::bake
