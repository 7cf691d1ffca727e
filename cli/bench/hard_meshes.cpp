// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/hard_meshes.cpp
#include "bench/hard_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace dgm::bench {
namespace {

using model::Face;
using model::TriMesh;
using model::Vec3d;

constexpr std::uint32_t kCells = 16;

/// (a + 1) x (b + 1) vertices in rows of b + 1; `closed` joins each row's end to its start, with b vertices a row.
std::vector<Face> lattice(std::uint32_t a, std::uint32_t b, bool closed) {
    const std::uint32_t width = closed ? b : b + 1;
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < a; ++i)
        for (std::uint32_t j = 0; j < b; ++j) {
            const std::uint32_t p = i * width + j, q = i * width + (j + 1) % width;
            faces.push_back({p, p + width, q + width});
            faces.push_back({p, q + width, q});
        }
    return faces;
}

/// The dome over the given abscissas of both axes.
TriMesh dome_over(const std::vector<double>& x, const std::vector<double>& y) {
    TriMesh mesh;
    for (const double s : x)
        for (const double t : y) {
            const double u = 2 * s - 1, v = 2 * t - 1;
            mesh.positions.push_back({s, t, 0.4 * (1 - u * u) * (1 - v * v)});
        }
    mesh.faces = lattice(static_cast<std::uint32_t>(x.size()) - 1, static_cast<std::uint32_t>(y.size()) - 1, false);
    return mesh;
}

std::vector<double> even() {
    std::vector<double> out;
    for (std::uint32_t k = 0; k <= kCells; ++k) out.push_back(static_cast<double>(k) / kCells);
    return out;
}

}  // namespace

TriMesh dome() {
    return dome_over(even(), even());
}

TriMesh sliver_dome(double thinness) {
    std::vector<double> x = even();
    x[kCells / 2 + 1] = x[kCells / 2] + thinness / kCells;
    return dome_over(x, even());
}

TriMesh offset_dome(double diagonals) {
    TriMesh mesh = dome();
    const double away = diagonals * std::sqrt(2 + 0.16) / std::sqrt(3.0);
    for (Vec3d& p : mesh.positions) p = p + Vec3d{away, away, away};
    return mesh;
}

TriMesh scaled_dome(double scale) {
    TriMesh mesh = dome();
    for (Vec3d& p : mesh.positions) p = p * scale;
    return mesh;
}

TriMesh graded_dome(double ratio) {
    std::vector<double> at(kCells + 1, 0.0);
    for (std::uint32_t k = 0; k < kCells; ++k)
        at[k + 1] = at[k] + std::pow(ratio, -static_cast<double>(k) / (kCells - 1));
    const double length = at[kCells];
    for (double& x : at) x /= length;
    return dome_over(at, at);
}

TriMesh fan_cone(std::uint32_t valence) {
    constexpr std::uint32_t kRings = 3;
    TriMesh mesh;
    mesh.positions.push_back({0, 0, 1});
    for (std::uint32_t ring = 1; ring <= kRings; ++ring)
        for (std::uint32_t k = 0; k < valence; ++k) {
            const double angle = 2 * std::numbers::pi * k / valence, r = static_cast<double>(ring) / kRings;
            mesh.positions.push_back({r * std::cos(angle), r * std::sin(angle), 1 - r});
        }
    for (std::uint32_t k = 0; k < valence; ++k) mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % valence});
    for (const Face& f : lattice(kRings - 1, valence, true)) mesh.faces.push_back({f[0] + 1, f[1] + 1, f[2] + 1});
    return mesh;
}

TriMesh tube(double aspect) {
    constexpr std::uint32_t kAround = 16;
    const auto along = static_cast<std::uint32_t>(std::clamp(aspect * kAround, 8.0, 4096.0));
    TriMesh mesh;
    for (std::uint32_t i = 0; i <= along; ++i)
        for (std::uint32_t k = 0; k < kAround; ++k) {
            const double angle = 2 * std::numbers::pi * k / kAround, r = 0.5 / std::numbers::pi;
            mesh.positions.push_back({r * std::cos(angle), r * std::sin(angle), aspect * i / along});
        }
    mesh.faces = lattice(along, kAround, true);
    for (Face& f : mesh.faces) std::swap(f[1], f[2]);
    return mesh;
}

TriMesh pierced_slab(std::uint32_t holes) {
    const std::uint32_t a = 2 * std::max(1U, holes) + 1, b = 3;
    const auto solid = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        if (i < 0 || j < 0 || k != 0 || i >= a || j >= b) return false;
        return !(j == 1 && i % 2 == 1 && static_cast<std::uint32_t>(i) / 2 < holes);
    };
    TriMesh mesh;
    std::map<std::array<std::int64_t, 3>, std::uint32_t> ids;
    const auto vertex = [&](const std::array<std::int64_t, 3>& p) {
        const auto [it, fresh] = ids.try_emplace(p, static_cast<std::uint32_t>(mesh.positions.size()));
        if (fresh)
            mesh.positions.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
        return it->second;
    };
    for (std::int64_t i = 0; i < a; ++i)
        for (std::int64_t j = 0; j < b; ++j)
            for (std::size_t axis = 0; axis < 3 && solid(i, j, 0); ++axis)
                for (const int side : {0, 1}) {
                    std::array<std::int64_t, 3> next{i, j, 0};
                    next[axis] += side == 1 ? 1 : -1;
                    if (solid(next[0], next[1], next[2])) continue;
                    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
                    std::array<std::uint32_t, 4> q{};
                    for (std::size_t c = 0; c < 4; ++c) {
                        std::array<std::int64_t, 3> p{i, j, 0};
                        p[axis] += side;
                        p[u] += c == 1 || c == 2 ? 1 : 0;
                        p[v] += c >= 2 ? 1 : 0;
                        q[c] = vertex(p);
                    }
                    if (side == 0) std::swap(q[1], q[3]);
                    mesh.faces.push_back({q[0], q[1], q[2]});
                    mesh.faces.push_back({q[0], q[2], q[3]});
                }
    return mesh;
}

TriMesh bumpy_ball(std::uint64_t faces) {
    // 8 n^2 faces: each of the octahedron's faces has n strips.
    const auto n = static_cast<std::int64_t>(std::max(3.0, std::round(std::sqrt(static_cast<double>(faces) / 8))));
    TriMesh mesh;
    // A vertex is a lattice point with |x| + |y| + |z| = n: its place in a table by (x, y) and the sign of z.
    const std::int64_t width = 2 * n + 1;
    std::vector<std::uint32_t> ids(static_cast<std::size_t>(2 * width * width), UINT32_MAX);
    const auto vertex = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        std::uint32_t& id = ids[static_cast<std::size_t>(((z < 0 ? 1 : 0) * width + x + n) * width + y + n)];
        if (id == UINT32_MAX) {
            id = static_cast<std::uint32_t>(mesh.positions.size());
            const Vec3d p{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
            const Vec3d d = p * (1 / length(p));
            const double r =
                1 + 0.15 * std::sin(5 * d.x + 1) * std::cos(4 * d.y) + 0.08 * std::sin(9 * d.z) * std::cos(7 * d.x);
            mesh.positions.push_back(d * r);
        }
        return id;
    };
    for (const int sx : {1, -1})
        for (const int sy : {1, -1})
            for (const int sz : {1, -1}) {
                const auto at = [&](std::int64_t i, std::int64_t j) {
                    return vertex(sx * i, sy * j, sz * (n - i - j));
                };
                for (std::int64_t i = 0; i < n; ++i)
                    for (std::int64_t j = 0; i + j < n; ++j) {
                        Face f{at(i, j), at(i + 1, j), at(i, j + 1)};
                        if (sx * sy * sz < 0) std::swap(f[1], f[2]);
                        mesh.faces.push_back(f);
                        if (i + j + 1 == n) continue;
                        Face g{at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
                        if (sx * sy * sz < 0) std::swap(g[1], g[2]);
                        mesh.faces.push_back(g);
                    }
            }
    return mesh;
}

}  // namespace dgm::bench
