// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/changed_life.h
// States of every kind of chart to which anything may happen, and what ranges of changed samples cover.
#pragma once
#include <dgm/changed.h>
#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/tick.h>

#include <limits>
#include <optional>
#include <random>

#include "contact_shapes.h"
#include "opened.h"

namespace dgm::test {

inline constexpr float kAtOnce = std::numeric_limits<float>::infinity();

inline DeformTable table_of(std::uint32_t reach) {
    KernelOptions kernel;
    kernel.reach = reach;
    kernel.sigma = static_cast<float>(reach);
    return DeformTable::create(kernel).value();
}

/// Positions and normals of all samples, as one list of six planes.
inline std::vector<float> shape_of(const State& state) {
    std::vector<float> all;
    for (const PointView& v : {state.positions(), state.normals()})
        for (const float* plane : {v.x, v.y, v.z}) all.insert(all.end(), plane, plane + v.count);
    return all;
}
inline bool same(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// Marks the samples of ranges. @return false if one is out of bounds or a rectangle runs into the next row.
inline bool cover(const State& state, std::span<const ChangedRange> ranges, std::vector<char>& covered) {
    covered.assign(state.sample_count(), 0);
    const std::size_t grid = std::size_t{state.rows()} * state.cols();
    for (const ChangedRange& r : ranges) {
        if (r.columns == 0 || r.rows == 0) return false;
        if (r.first < grid ? r.first % state.cols() + r.columns > state.cols() : r.rows != 1) return false;
        if (r.first < grid && r.first / state.cols() + r.rows > state.rows()) return false;
        for (std::size_t i = 0; i < r.rows; ++i)
            for (std::size_t c = 0; c < r.columns; ++c) {
                const std::size_t k = r.first + i * state.cols() + c;
                if (k >= covered.size()) return false;
                covered[k] = 1;
            }
    }
    return true;
}

struct Life {
    State state;
    const DeformTable table = table_of(6), small = table_of(2);
    std::optional<ContactSolver> solver;
    std::mt19937 random;
    float size = 1;
    Life(const ChartSpec& chart, unsigned seed) : state(make_state(chart)), random(seed) {
        solver.emplace(std::move(ContactSolver::create(state)).value());
        size = state.mean_step();
    }
    std::uint32_t sample() {
        for (;;) {
            const auto k = static_cast<std::uint32_t>(random() % state.sample_count());
            if (state.on_surface(k)) return k;
        }
    }
    Vec3 some(float scale) {
        std::uniform_real_distribution<float> u(-scale, scale);
        const float x = u(random), y = u(random), z = u(random);
        return {x, y, z};
    }
    void touch() {
        Touch t;
        t.sample = sample();
        t.displacement = some(size);
        t.d_max = 2 * size;
        t.mode = random() % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        t.footprint = random() % 4 == 0 ? Footprint::Geodesic : Footprint::Grid;
        ASSERT_TRUE(deform(state, random() % 2 == 0 ? table : small, t).ok());
    }
    void ticks() {
        TickOptions o;
        o.d_max = 2 * size;
        const float rates[] = {kAtOnce, 20, 0, 3000};
        o.relax_rate = rates[random() % 4];
        o.mode = random() % 5 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        o.footprint = random() % 4 == 0 ? Footprint::Geodesic : Footprint::Grid;
        o.normals = random() % 4 != 0;
        ToolInput in[2];
        in[1].tool = 1;
        for (ToolInput& t : in) {
            const std::uint32_t k = sample();
            t.position = state.positions()[k] - (size / 2) * state.normal(k);
            t.engaged = random() % 4 != 0;
        }
        const auto turns = random() % 6;
        for (unsigned k = 0; k < turns; ++k) {
            in[0].position = in[0].position + some(size / 4);
            ASSERT_TRUE(tick(state, table, o, {in, 1 + random() % 2}, {}).ok());
        }
    }
    void press() {
        Obstacle obstacle;
        const std::uint32_t k = sample();
        obstacle.kind = random() % 2 == 0 ? ObstacleKind::Plane : ObstacleKind::Sphere;
        const Vec3 n = state.normal(k);
        if (n == Vec3{}) return;
        obstacle.normal = n;
        obstacle.point = state.positions()[k] - (size / 2) * n;
        obstacle.radius = 2 * size;
        if (obstacle.kind == ObstacleKind::Plane) obstacle.normal = Vec3{} - n;
        ContactOptions o;
        o.mode = random() % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        static_cast<void>(resolve_contact(state, *solver, obstacle, o).ok());
    }
    void step() {
        switch (random() % 12) {
            case 0:
            case 1:
            case 2:
                return touch();
            case 3:
            case 4:
            case 5:
                return ticks();
            case 6:
                return state.release();
            case 7:
                ASSERT_TRUE(state.relax(0.01f, random() % 3 == 0 ? kAtOnce : 10).ok());
                return;
            case 8:
                return press();
            case 9:
                if (random() % 4 == 0) state.reset();
                return;
            default:
                return state.update_normals();
        }
    }
};

inline ChartSpec sheet_chart(std::uint32_t m, std::uint32_t n) {
    return grid_chart(m, n, test::sheet);
}
/// Opposite border samples of the strip's sides j = 0.5 and j = n - 1.5 are the same place.
inline ChartSpec free_tube(std::uint32_t m, std::uint32_t n) {
    const auto round = [n](double i, double j) {
        const double a = 2 * 3.14159265358979 * (j - 0.5) / (n - 2);
        return Point{static_cast<float>(5 * std::cos(a)), static_cast<float>(5 * std::sin(a)), static_cast<float>(i)};
    };
    SeamPairs pairs;
    const std::uint32_t first = m * n, down = m - 1, across = n - 2, up = first + down + across + 1;
    for (std::uint32_t k = 0; k <= down; ++k) pairs.push_back({first + k, up + down - k});
    return free_chart(m, n, round, pairs);
}
inline std::vector<ChartSpec> all_charts() {
    return {sheet_chart(41, 35), grid_chart(33, 41, test::sheet, tube_seams(33, 41)),
            sphere_chart(33),    free_chart(27, 34, test::sheet),
            free_tube(26, 22),   sheet_chart(5, 3)};
}

}  // namespace dgm::test
