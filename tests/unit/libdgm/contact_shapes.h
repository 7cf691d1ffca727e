// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/contact_shapes.h
// Closed shapes on one chart, and their volume by the welded triangles, written out apart from the library's.
#pragma once
#include <dgm/contact.h>
#include <dgm/reconstruct.h>

#include <cmath>
#include <vector>

#include "opened.h"

namespace dgm::test {

/// Unit vector of the octahedral unfolding at (u, v) in 0..1: side points fold onto each other as octahedral_seams say.
inline std::array<double, 3> octahedral(double u, double v) {
    const double a = 2 * u - 1, b = 2 * v - 1;
    double x = a, y = b;
    const double z = 1 - std::fabs(a) - std::fabs(b);
    if (z < 0) {
        x = std::copysign(1 - std::fabs(b), a);
        y = std::copysign(1 - std::fabs(a), b);
    }
    const double length = std::sqrt(x * x + y * y + z * z);
    return {x / length, y / length, z / length};
}

/// Sphere of radius 1 around the origin, `shape` turns a unit vector into a point.
template <class Shape>
ChartSpec closed_chart(std::uint32_t side, Shape shape) {
    return grid_chart(
        side, side,
        [&](double i, double j) {
            const auto n = octahedral(i / (side - 1), j / (side - 1));
            const std::array<double, 3> p = shape(n);
            return Point{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
        },
        octahedral_seams(side));
}
inline ChartSpec sphere_chart(std::uint32_t side) {
    return closed_chart(side, [](std::array<double, 3> n) { return n; });
}

/// The same on a free chart: its border loop, four sides of `side` - 1 steps, folds at the middle of each. `point`
/// turns a unit vector into a Point.
template <class ToPoint>
ChartSpec closed_free_chart(std::uint32_t side, ToPoint point) {
    const std::uint32_t first = side * side, steps = side - 1;
    SeamPairs seams;
    for (std::uint32_t start = 0; start < 4 * steps; start += steps)
        for (std::uint32_t k = 1; 2 * k < steps; ++k) seams.push_back({first + start + k, first + start + steps - k});
    for (std::uint32_t corner = 1; corner < 4; ++corner) seams.push_back({first, first + corner * steps});
    return free_chart(
        side, side,
        [&](double i, double j) { return point(octahedral((i - 0.5) / (side - 2), (j - 0.5) / (side - 2))); }, seams);
}

struct Triangles {
    std::vector<std::uint32_t> indices;
    explicit Triangles(const State& state) : indices(mesh_counts(state).value().indices) {
        EXPECT_TRUE(reconstruct(state, {}, indices).ok());
    }
    [[nodiscard]] double volume(const State& state) const {
        const PointView p = state.positions();
        double six = 0;
        for (std::size_t k = 0; k < indices.size(); k += 3) {
            const Vec3 a = p[indices[k]], b = p[indices[k + 1]], c = p[indices[k + 2]];
            six += double(a.x) * (double(b.y) * c.z - double(b.z) * c.y) +
                   double(a.y) * (double(b.z) * c.x - double(b.x) * c.z) +
                   double(a.z) * (double(b.x) * c.y - double(b.y) * c.x);
        }
        return six / 6;
    }
};

inline void expect_closed_seams(const State& state) {
    const PointView p = state.positions();
    for (std::uint32_t id = 0; id < state.class_count(); ++id)
        for (const std::uint32_t copy : state.class_members(id))
            ASSERT_TRUE(same_bits(p[state.class_members(id)[0]], p[copy])) << "class " << id;
}

}  // namespace dgm::test
