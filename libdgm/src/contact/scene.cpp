// SPDX-License-Identifier: MIT
// libdgm/src/contact/scene.cpp
#include "contact/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "contact/surface_search.h"

namespace dgm::detail {
namespace {

/// Place in a scene, or its count.
std::uint32_t place_of(const Scene& scene, std::uint32_t id) noexcept {
    return static_cast<std::uint32_t>(std::find(scene.ids, scene.ids + scene.count, id) - scene.ids);
}

/// Turned as unit vector `from` turns to unit vector `to` by the smallest angle; not at all if they are opposite.
Double3 turned(Double3 v, Double3 from, Double3 to) noexcept {
    const Double3 both = from + to;
    const double cosine = 1 + dot(from, to);
    if (!(cosine > 1e-6)) return v;
    return v + (2 * dot(from, v)) * to - (dot(both, v) / cosine) * both;
}

Double3 mixed(Double3 a, Double3 b, double part) noexcept {
    return a + part * (b - a);
}

/// A unit vector along `v`, or `other` if that is next to nothing.
Double3 unit_of(Double3 v, Double3 other) noexcept {
    const double square = dot(v, v);
    return square > 1e-6 ? (1 / std::sqrt(square)) * v : other;
}

/// Samples of a surface in its own frame.
[[gnu::cold, gnu::noinline]] std::array<Double3, 3> places_of(const PointView& samples,
                                                              const std::array<std::uint32_t, 3>& corners) noexcept {
    std::array<Double3, 3> out;
    for (std::size_t k = 0; k < 3; ++k) out[k] = widen(samples[corners[k]]);
    return out;
}
/// Those of its present shape.
PointView samples_now(const Shape& shape) noexcept {
    const StateImpl& s = *shape.surface;
    return {s.now.x, s.now.y, s.now.z, s.total(), 1};
}

/// Not unit; of the triangle that was found last.
[[gnu::cold, gnu::noinline]] Double3 facing_now(const Shape& shape) noexcept {
    const std::array<Double3, 3> q = places_of(samples_now(shape), corners_of(*shape.surface, shape.hint));
    return from_own(shape, cross(q[1] - q[0], q[2] - q[0])) - shape.point;
}

/// The same as way_come() for a surface that is known as it was.
[[gnu::cold, gnu::noinline]] Double3 way_of_skin(const Shape& before, const Shape& now, Double3 at) noexcept {
    const Double3 nearest = probe(now, at).nearest, own = to_own(now, nearest);
    if (now.hint == kNoTriangle) return {};
    const std::array<std::uint32_t, 3> corners = corners_of(*now.surface, now.hint);
    const std::array<Double3, 3> q = places_of(samples_now(now), corners), was = places_of(now.was, corners);
    const Double3 ab = q[1] - q[0], ac = q[2] - q[0], normal = cross(ab, ac);
    const double square = dot(normal, normal);
    const double b = square > 0 ? dot(normal, cross(own - q[0], ac)) / square : 0;
    const double c = square > 0 ? dot(normal, cross(ab, own - q[0])) / square : 0;
    const Double3 stood = (1 - b - c) * was[0] + b * was[1] + c * was[2];
    const Double3 way = nearest - from_own(before, own + now.share * (stood - own));
    return std::isfinite(dot(way, way)) ? way : Double3{};
}

}  // namespace

void add_tool(Scene& scene, const ToolInput& tool, double radius) noexcept {
    Shape& shape = scene.shapes[scene.count];
    shape = {};
    shape.kind = ObstacleKind::Sphere;
    shape.point = widen(tool.position);
    shape.radius = radius;
    scene.turns[scene.count] = 0;
    scene.ids[scene.count++] = tool.tool;
}

Result<void> add_obstacles(Scene& scene, std::span<const Obstacle> obstacles, const StateImpl& pressed) noexcept {
    for (std::uint32_t k = 0; k < obstacles.size(); ++k) {
        const Obstacle& o = obstacles[k];
        if (o.kind == ObstacleKind::Surface && o.surface != nullptr && o.surface->unsettled() == &pressed)
            return Error{ErrorCode::BadArgument, kNoOffset, "the obstacle is the state itself"};
        auto shape = make_shape(o);
        if (!shape) return shape.error();
        scene.shapes[scene.count] = shape.value();
        scene.turns[scene.count] = shape.value().surface != nullptr ? shape.value().surface->moved : 0;
        scene.ids[scene.count++] = Scene::kMost + k;
    }
    return {};
}

const Shape* was_at(const Scene& before, const Scene& now, std::uint32_t o) noexcept {
    const std::uint32_t k = place_of(before, now.ids[o]);
    if (k == before.count) return nullptr;
    const Shape &a = before.shapes[k], &b = now.shapes[o];
    return a.kind == b.kind && a.surface == b.surface ? &a : nullptr;
}

const Shape& last_of(const Scene& before, const Scene& now, std::uint32_t o) noexcept {
    const Shape* const stood = was_at(before, now, o);
    return stood != nullptr ? *stood : now.shapes[o];
}

bool has_stayed(const Scene& before, const Scene& now, std::uint32_t o) noexcept {
    // All of a shape from `point` on are doubles.
    constexpr std::size_t kBytes = offsetof(Shape, surface) - offsetof(Shape, point);
    static_assert(kBytes == 23 * sizeof(double));
    const std::uint32_t k = place_of(before, now.ids[o]);
    if (was_at(before, now, o) == nullptr || before.turns[k] != now.turns[o]) return false;
    const void *const then = &before.shapes[k].point, *const here = &now.shapes[o].point;
    return std::memcmp(then, here, kBytes) == 0;
}

Double3 normal_at(const Shape& shape, const Probe& there, Double3 x) noexcept {
    if (shape.kind == ObstacleKind::Plane) return shape.normal;
    Double3 way = there.distance < 0 ? there.nearest - x : x - there.nearest;
    if (shape.kind == ObstacleKind::Surface && std::fabs(there.distance) < shape.rounding) {
        const Double3 facing = facing_now(shape);
        if (dot(facing, facing) > 0) way = facing;
    }
    const double length = std::sqrt(dot(way, way));
    return length > 0 ? (1 / length) * way : Double3{};
}

Double3 way_come(const Shape& before, const Shape& now, Double3 at) noexcept {
    if (&before == &now) return {};  // to the bit: what rests there must not creep
    if (now.was.x != nullptr) return way_of_skin(before, now, at);
    const Double3 way = now.point - before.point, off = at - now.point;
    switch (now.kind) {
        case ObstacleKind::Plane:
            return way + off - turned(off, now.normal, before.normal);
        case ObstacleKind::Sphere:
            return way;
        case ObstacleKind::Capsule: {
            const Double3 along = now.end - now.point;
            const double square = dot(along, along);
            const double t = square > 0 ? std::clamp(dot(off, along) / square, 0.0, 1.0) : 0;
            return (1 - t) * way + t * (now.end - before.end);
        }
        case ObstacleKind::Box:
        case ObstacleKind::Surface:
            break;
    }
    Double3 turn;
    for (int k = 0; k < 3; ++k) turn = turn + dot(now.axis[k], off) * (now.axis[k] - before.axis[k]);
    return way + turn;
}

Shape between(const Shape& before, const Shape& now, double part) noexcept {
    if (part >= 1) return now;
    Shape out = now;
    out.point = mixed(before.point, now.point, part);
    out.end = mixed(before.end, now.end, part);
    if (now.kind == ObstacleKind::Plane) {
        out.normal = unit_of(mixed(before.normal, now.normal, part), now.normal);
        out.offset = dot(out.normal, out.point);
    }
    if (now.kind == ObstacleKind::Box || now.kind == ObstacleKind::Surface) {
        Double3* const axis = out.axis;
        axis[0] = unit_of(mixed(before.axis[0], now.axis[0], part), now.axis[0]);
        const Double3 second = mixed(before.axis[1], now.axis[1], part);
        axis[1] = unit_of(second - dot(second, axis[0]) * axis[0], {});
        axis[2] = cross(axis[0], axis[1]);
        if (!(dot(axis[2], axis[2]) > 0.5)) std::copy(now.axis, now.axis + 3, axis);  // turned by half a turn or so
    }
    return out;
}

}  // namespace dgm::detail
