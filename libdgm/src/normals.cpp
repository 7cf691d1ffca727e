// SPDX-License-Identifier: MIT
// libdgm/src/normals.cpp
// Area vectors over the welded ring (methods section 5). Sums in double, copies in ascending order: every copy of a
// class gets the same bits, and no coordinate that fits a float overflows.
#include <cmath>

#include "state_impl.h"

namespace dgm::detail {
namespace {
struct Sum {
    double x = 0, y = 0, z = 0;
    void add_triangle(Vec3 a, Vec3 b, Vec3 c) noexcept {
        const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
        const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
        x += uy * vz - uz * vy;
        y += uz * vx - ux * vz;
        z += ux * vy - uy * vx;
    }
};

void add_quad(Sum& sum, const StateImpl& s, std::uint32_t i, std::uint32_t j, std::uint32_t sample) noexcept {
    if (!s.tables.has_quad(i, j)) return;
    for (const auto& f : quad_triangles(i, j, s.tables.cols, s.tables.diagonal(i, j)))
        if (f[0] == sample || f[1] == sample || f[2] == sample)
            sum.add_triangle(s.point(f[0]), s.point(f[1]), s.point(f[2]));
}

void add_ring(Sum& sum, const StateImpl& s, std::uint32_t sample) noexcept {
    const ChartTables& t = s.tables;
    if (sample < t.grid) {
        const std::uint32_t i = sample / t.cols, j = sample % t.cols;
        if (i > 0 && j > 0) add_quad(sum, s, i - 1, j - 1, sample);
        if (i > 0 && j + 1 < t.cols) add_quad(sum, s, i - 1, j, sample);
        if (i + 1 < t.rows && j > 0) add_quad(sum, s, i, j - 1, sample);
        if (i + 1 < t.rows && j + 1 < t.cols) add_quad(sum, s, i, j, sample);
    }
    if (s.face_start.empty()) return;
    for (std::uint32_t k = s.face_start[sample]; k < s.face_start[sample + 1]; ++k) {
        const std::uint32_t* f = s.faces.data() + 3 * std::size_t{s.face_of[k]};
        sum.add_triangle(s.point(f[0]), s.point(f[1]), s.point(f[2]));
    }
}
}  // namespace

Vec3 ring_normal(const StateImpl& s, std::uint32_t sample) noexcept {
    Sum sum;
    const std::uint32_t id = s.class_id(sample);
    if (id == kNone)
        add_ring(sum, s, sample);
    else
        for (const std::uint32_t copy : s.members(id)) add_ring(sum, s, copy);
    const double length = std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    if (!(length > 0) || !std::isfinite(length)) return {};
    return {static_cast<float>(sum.x / length), static_cast<float>(sum.y / length), static_cast<float>(sum.z / length)};
}

}  // namespace dgm::detail
