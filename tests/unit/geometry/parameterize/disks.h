// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/disks.h
// Small disks made on the spot.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "geometry/parameterize/parameterizer.h"
#include "model/codes.h"

namespace dgm::bake::testing {

struct Disk {
    std::vector<Vec3d> positions;
    std::vector<Face> faces;
    std::vector<std::uint32_t> border;
    std::vector<Vec2d> border_uv;
    [[nodiscard]] DiskView view() const { return {positions, faces, border, border_uv}; }
};

/// The one border cycle, surface on its left, from its lowest vertex.
inline void find_border(Disk& disk) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Face& f : disk.faces)
        for (std::size_t k = 0; k < 3; ++k) edges[{f[k], f[(k + 1) % 3]}] = 1;
    std::map<std::uint32_t, std::uint32_t> next;
    for (const auto& [e, count] : edges)
        if (!edges.contains({e.second, e.first})) next[e.first] = e.second;
    disk.border.clear();
    for (std::uint32_t v = next.begin()->first; disk.border.empty() || v != disk.border.front(); v = next[v])
        disk.border.push_back(v);
}

/// rows x cols quads; `place` maps (s, t) in [0, 1]^2 to space. Diagonals alternate, so that no border face has all its
/// corners on one side of the square.
template <typename Place>
Disk grid(std::uint32_t rows, std::uint32_t cols, const Place& place) {
    Disk d;
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j <= cols; ++j)
            d.positions.push_back(place(static_cast<double>(j) / cols, static_cast<double>(i) / rows));
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return i * (cols + 1) + j; };
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < cols; ++j) {
            const std::uint32_t a = at(i, j), b = at(i, j + 1), c = at(i + 1, j + 1), e = at(i + 1, j);
            if ((i + j) % 2 == 0) {
                d.faces.push_back({a, b, c});
                d.faces.push_back({a, c, e});
            } else {
                d.faces.push_back({a, b, e});
                d.faces.push_back({b, c, e});
            }
        }
    find_border(d);
    return d;
}

/// The border of grid() on the unit square, at (s, t).
inline void put_grid_border_on_square(Disk& d, std::uint32_t rows, std::uint32_t cols) {
    d.border_uv.clear();
    for (const std::uint32_t v : d.border)
        d.border_uv.push_back({static_cast<double>(v % (cols + 1)) / cols, static_cast<double>(v / (cols + 1)) / rows});
}

/// Rings of `around` vertices at profile points (radius, height), the last profile point a single tip.
inline Disk revolve(std::uint32_t around, const std::vector<Vec2d>& profile) {
    Disk d;
    const auto rings = static_cast<std::uint32_t>(profile.size()) - 1;
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double angle = 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / around;
            d.positions.push_back({profile[i].x * std::cos(angle), profile[i].x * std::sin(angle), profile[i].y});
        }
    d.positions.push_back({0, 0, profile.back().y});
    const auto at = [&](std::uint32_t i, std::uint32_t j) { return i * around + j % around; };
    for (std::uint32_t i = 0; i + 1 < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t a = at(i, j), b = at(i, j + 1), c = at(i + 1, j), e = at(i + 1, j + 1);
            if (i % 2 == 0) {
                d.faces.push_back({a, b, c});
                d.faces.push_back({b, e, c});
            } else {
                d.faces.push_back({a, b, e});
                d.faces.push_back({a, e, c});
            }
        }
    for (std::uint32_t j = 0; j < around; ++j)
        d.faces.push_back({at(rings - 1, j), at(rings - 1, j + 1), rings * around});
    find_border(d);
    return d;
}

/// A sphere of diameter 1 with a hole of `hole` radians around its south pole.
inline Disk sphere_with_hole(std::uint32_t around, std::uint32_t rings, double hole) {
    std::vector<Vec2d> profile;
    for (std::uint32_t i = 0; i <= rings; ++i) {
        const double polar = hole + (std::numbers::pi - hole) * i / rings;
        profile.push_back({0.5 * std::sin(polar), -0.5 * std::cos(polar)});
    }
    return revolve(around, profile);
}

/// A brim and a finger as long as many times its girth, where uniform Tutte weights underflow.
inline Disk long_finger(std::uint32_t around, std::uint32_t rings) {
    std::vector<Vec2d> profile{{0.05, 0}, {0.03, 0}};
    for (std::uint32_t i = 1; i <= rings; ++i) profile.push_back({0.01, 0.9 * i / rings});
    profile.push_back({0, 0.91});
    return revolve(around, profile);
}

/// Disks that a parameterizer must refuse, made from a good 3 x 3 grid, each with its name.
inline std::vector<std::pair<const char*, Disk>> no_disks(const Disk& good) {
    std::vector<std::pair<const char*, Disk>> out;
    const auto broken = [&](const char* what) -> Disk& { return out.emplace_back(what, good).second; };
    broken("a mesh without faces").faces.clear();
    broken("an index out of range").faces[4][1] = 99;
    broken("a NaN").positions[5].y = std::nan("");
    broken("an unused vertex").positions.push_back({0, 0, 1});
    Disk& ring = broken("a ring");
    ring.faces.erase(ring.faces.begin() + 8);  // the middle: a second border
    Disk& turned = broken("a turned face");
    std::swap(turned.faces[3][0], turned.faces[3][1]);
    Disk& backwards = broken("a border the wrong way round");
    std::reverse(backwards.border.begin(), backwards.border.end());
    Disk& gap = broken("a border with a gap");
    gap.border.pop_back();
    if (!gap.border_uv.empty()) gap.border_uv.pop_back();
    out.emplace_back(
        "a closed surface",
        Disk{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {}, {}});
    return out;
}

/// `solve` must throw kMapInvalid.
template <class Solve>
void expect_no_map(const char* what, const Solve& solve) {
    try {
        static_cast<void>(solve());
        ADD_FAILURE() << "took " << what;
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kMapInvalid.number) << what; }
}

}  // namespace dgm::bake::testing
