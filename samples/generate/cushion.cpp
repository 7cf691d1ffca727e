// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/cushion.cpp
// The cushion, its cover and the flat sheet: pairs of square grids, sewn where they share border vertices.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "math/portable.h"
#include "noise.h"
#include "upholstery.h"

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;

constexpr int kCells = 44;         // quads along a side
constexpr double kHalfWidth = 22;  // centimetres

/// Surface point for grid coordinates in [-1, 1]^2; `side` is +1 for the top and -1 for the bottom.
using Shape = std::function<Vec3d(double x, double y, int side)>;

// Grid lines closer together towards the rim, where the surface bends most.
double graded(int i) {
    const double t = 2.0 * i / kCells - 1;
    return t * (1.22 - 0.22 * t * t);
}

// Corners drawn out, or seen the other way, sides drawn in.
Vec2d outline(double x, double y, double half) {
    return {half * x * (1 - 0.10 * (1 - y * y) * x * x), half * y * (1 - 0.10 * (1 - x * x) * y * y)};
}

double bulge(double x, double y) {
    const double a = std::max(0.0, 1 - math::pow(std::abs(x), 2.3)), b = std::max(0.0, 1 - math::pow(std::abs(y), 2.3));
    return math::pow(a, 0.66) * math::pow(b, 0.66);
}

// Creases: rays out of the corners, and short puckers across the seam.
double creases(double x, double y, int side) {
    const double ax = std::abs(x), ay = std::abs(y);
    const double corner = smooth_step(0.9, 0.25, math::hypot(1 - ax, 1 - ay));
    const double ray = math::sin(11 * math::atan2(1 - ay, 1 - ax + 1e-9) + side + 2 * (x > 0) + 3 * (y > 0));
    const double along = ax > ay ? y : x, in = 1 - std::max(ax, ay);
    const double pucker = math::sin(34 * along + 3 * noise3({5 * along, 0.0 + side, 2.0 * (ax > ay)}, 121));
    return 0.30 * corner * ray +
           0.22 * pucker * smooth_step(0.0, 0.06, in) * smooth_step(0.34, 0.10, in) * (1 - corner);
}

PolyMesh sew(const Shape& shape, bool open_at_x1) {
    PolyMesh mesh;
    constexpr int n = kCells + 1;
    std::vector<std::uint32_t> id(2UL * n * n);
    const auto at = [](int side, int i, int j) { return static_cast<std::size_t>((side > 0 ? 0 : n * n) + i * n + j); };
    for (const int side : {1, -1})
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const bool sewn = i == 0 || j == 0 || j == kCells || (i == kCells && !open_at_x1);
                if (side < 0 && sewn) {
                    id[at(side, i, j)] = id[at(1, i, j)];
                    continue;
                }
                id[at(side, i, j)] = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(shape(graded(i), graded(j), side));
            }
    // Bottom from u = 0 at x = +1 to the fold at u = 1/2, top on from there.
    for (const int side : {1, -1})
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) mesh.uvs.push_back({0.5 + side * (graded(i) + 1) / 4, (graded(j) + 1) / 2});
    for (const int side : {1, -1})
        for (int i = 0; i < kCells; ++i)
            for (int j = 0; j < kCells; ++j) {
                Polygon p;
                std::array<std::array<int, 2>, 4> c{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
                if (side < 0) std::swap(c[1], c[3]);
                for (std::size_t k = 0; k < 4; ++k) {
                    p.vertex[k] = id[at(side, c[k][0], c[k][1])];
                    p.uv[k] = static_cast<std::uint32_t>(at(side, c[k][0], c[k][1]));
                }
                p.group = side > 0 ? 1 : 2;
                add_cell(mesh, p, i, j, kCells);
            }
    quantise(mesh);
    return mesh;
}

double cushion_height(double x, double y, int side) {
    const double b = bulge(x, y);
    return 6.6 * b + creases(x, y, side) * std::min(1.0, 3 * b) +
           0.35 * b * noise3({2.2 * x, 2.2 * y, 1.0 * side}, 122);
}
}  // namespace

PolyMesh make_cushion() {
    return sew(
        [](double x, double y, int side) {
            const Vec2d p = outline(x, y, kHalfWidth);
            return Vec3d{p.x, p.y, side * cushion_height(x, y, side)};
        },
        false);
}

PolyMesh make_cushion_cover() {
    return sew(
        [](double x, double y, int side) {
            // The bag reaches past the cushion at +x; there its two lips gape instead of meeting.
            const Vec2d p = outline(x, y, 1.05 * kHalfWidth);
            const double reach = smooth_step(0.2, 1.0, x), rim = std::max(0.0, 1 - math::pow(std::abs(y), 2.6));
            const double slack = 0.55 * math::pow(rim, 0.5) * smooth_step(-1.0, -0.8, x);
            const double folds =
                0.45 * noise3({1.6 * x + 4, 3.2 * y, 2.0 * side}, 131) +
                0.40 * math::sin(9 * y + 2 * side + 1.5 * noise3({2 * x, 2 * y, 1.0 * side}, 132)) * reach;
            const double closed = cushion_height(x, y, side) + slack;
            const double lip = (2.7 + 0.5 * side * math::sin(5 * y)) * math::pow(rim, 0.7);
            const double height =
                std::max(closed, 0.0) * (1 - smooth_step(0.85, 1.0, x)) + lip * smooth_step(0.72, 1.0, x);
            const double loose = smooth_step(0.0, 0.3, rim) * smooth_step(-1.0, -0.6, x);
            return Vec3d{p.x + 5.0 * smooth_step(0.6, 1.0, x), p.y,
                         side * (height + loose * (0.45 + folds)) - 0.5 * reach * rim};
        },
        true);
}

PolyMesh make_sheet() {
    constexpr int kSide = 40;
    PolyMesh mesh;
    for (int i = 0; i <= kSide; ++i)
        for (int j = 0; j <= kSide; ++j) {
            const Vec2d t{j / static_cast<double>(kSide), i / static_cast<double>(kSide)};
            mesh.positions.push_back({100 * t.x - 50, 100 * t.y - 50, 0});
            mesh.uvs.push_back(t);
        }
    for (std::uint32_t i = 0; i < kSide; ++i)
        for (std::uint32_t j = 0; j < kSide; ++j) {
            const std::uint32_t a = i * (kSide + 1) + j, b = a + kSide + 1;
            Polygon p;
            p.vertex = p.uv = {a, a + 1, b + 1, b};
            mesh.polygons.push_back(p);
        }
    quantise(mesh);
    return mesh;
}

PolyMesh make_skirt() {
    constexpr std::uint32_t kAround = 48, kDown = 24;
    constexpr double kHalfWidth = 16, kHalfDepth = 12, kLength = 45;
    PolyMesh mesh;
    for (std::uint32_t i = 0; i <= kDown; ++i)
        for (std::uint32_t j = 0; j <= kAround; ++j) {
            const double down = i / double{kDown}, around = j / double{kAround}, wide = 1 + down;
            const double angle = 2 * std::numbers::pi * around;
            if (j < kAround)
                mesh.positions.push_back(
                    {kHalfWidth * wide * math::cos(angle), kHalfDepth * wide * math::sin(angle), -kLength * down});
            mesh.uvs.push_back({around, 1 - down});
        }
    for (std::uint32_t i = 0; i < kDown; ++i)
        for (std::uint32_t j = 0; j < kAround; ++j) {
            const std::uint32_t next = (j + 1) % kAround, above = i * kAround, below = above + kAround;
            const std::uint32_t uv = i * (kAround + 1) + j, uv_below = uv + kAround + 1;
            Polygon p;
            p.vertex = {below + j, below + next, above + next, above + j};
            p.uv = {uv_below, uv_below + 1, uv + 1, uv};
            mesh.polygons.push_back(p);
        }
    quantise(mesh);
    return mesh;
}

}  // namespace dgm::samples
