// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/cloth_obstacles.h
// What cloth meets.
#pragma once
#include <vector>

#include "cloth_shapes.h"

namespace dgm::test {

inline Obstacle plane(Vec3 point, Vec3 normal) {
    Obstacle o;
    o.point = point;
    o.normal = normal;
    return o;
}
inline Obstacle ball(Vec3 centre, float radius) {
    Obstacle o;
    o.kind = ObstacleKind::Sphere;
    o.point = centre;
    o.radius = radius;
    return o;
}
inline Obstacle box_of(Vec3 half) {
    Obstacle o;
    o.kind = ObstacleKind::Box;
    o.half = half;
    return o;
}
inline Obstacle capsule_between(Vec3 from, Vec3 to, float radius) {
    Obstacle o = ball(from, radius);
    o.kind = ObstacleKind::Capsule;
    o.end = to;
    return o;
}

/// A sheet whose samples are led, with its shape of the frame before.
struct Skin {
    Drape led;
    std::vector<float> before[3];
    std::vector<Vec3> rest;
    explicit Skin(const ChartSpec& chart = grid_chart(17, 17,
                                                      [](double i, double j) {
                                                          return Point{float(i / 8 - 0.5), float(j / 8 - 0.5), 0};
                                                      }))
        : led(chart) {
        led.how.gravity = {};
        for (std::uint32_t k = 0; k < led.state.rows() * led.state.cols(); ++k)
            if (led.state.impl()->representative(k) == k) led.pin(k);
        for (const Pin& pin : led.pins) rest.push_back(pin.position);
    }
    /// Each sample goes to to(its rest).
    template <class To>
    void lead(const To& to) {
        const PointView now = led.state.positions();
        before[0].assign(now.x, now.x + now.count);
        before[1].assign(now.y, now.y + now.count);
        before[2].assign(now.z, now.z + now.count);
        for (std::size_t k = 0; k < rest.size(); ++k) led.pins[k].position = to(rest[k]);
        led.run(1);
    }
    [[nodiscard]] PointView shape_before() const {
        return {before[0].data(), before[1].data(), before[2].data(), before[0].size(), 1};
    }
};
inline Obstacle obstacle_of(Skin& skin) {
    Obstacle o;
    o.kind = ObstacleKind::Surface;
    o.surface = &skin.led.state;
    return o;
}

}  // namespace dgm::test
