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

/// Around all of a surface, in its own frame.
const Box& box_of(const StateImpl& surface) noexcept {
    const Pyramid& y = surface.now_boxes;
    return y.boxes[y.start[y.levels - 1]];
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

Double3 facing(const std::array<Double3, 3>& corners) noexcept {
    return cross(corners[1] - corners[0], corners[2] - corners[0]);
}
/// A direction in the state's frame.
Double3 along_axes(const Shape& shape, Double3 own) noexcept {
    return from_own(shape, own) - shape.point;
}

/// The triangle of a surface that was found last, in the surface's own frame.
struct Facet {
    std::array<Double3, 3> was, now;
};
[[gnu::cold, gnu::noinline]] Facet facet_of(const Shape& shape) noexcept {
    const StateImpl& s = *shape.surface;
    const std::array<std::uint32_t, 3> corners = corners_of(s, shape.hint);
    Facet out;
    for (std::size_t k = 0; k < 3; ++k) {
        out.now[k] = widen(s.point(corners[k]));
        out.was[k] = shape.was.x != nullptr ? widen(shape.was[corners[k]]) : out.now[k];
    }
    return out;
}
/// Its corners, and Shape::ahead of their way back.
std::array<Double3, 3> underway(const Facet& f, double ahead) noexcept {
    return {mixed(f.now[0], f.was[0], ahead), mixed(f.now[1], f.was[1], ahead), mixed(f.now[2], f.was[2], ahead)};
}
/// From where the material of a point stood to where it will be.
[[gnu::cold, gnu::noinline]] Double3 way_of_facet(const Facet& f, Double3 point, double ahead) noexcept {
    const std::array<Double3, 3> q = underway(f, ahead);
    const Double3 normal = facing(q), off = point - q[0];
    const double square = dot(normal, normal);
    const double b = square > 0 ? dot(normal, cross(off, q[2] - q[0])) / square : 0;
    const double c = square > 0 ? dot(normal, cross(q[1] - q[0], off)) / square : 0;
    return (1 - b - c) * (f.now[0] - f.was[0]) + b * (f.now[1] - f.was[1]) + c * (f.now[2] - f.was[2]);
}

/// The same as way_come() for a surface that is known as it was.
[[gnu::cold, gnu::noinline]] Double3 way_of_skin(const Shape& before, const Shape& now, const Probe& there) noexcept {
    if (now.hint == kNoTriangle) return {};
    const Double3 own = to_own(now, there.nearest), way = way_of_facet(facet_of(now), own, now.ahead);
    const Double3 come = there.nearest - from_own(before, own - now.share * way);
    return std::isfinite(dot(come, come)) ? come : Double3{};
}

}  // namespace

void add_tool(Scene& scene, const ToolInput& tool, double radius) noexcept {
    Shape& shape = scene.shapes[scene.count];
    shape = {};
    shape.kind = ObstacleKind::Sphere;
    shape.point = widen(tool.position);
    shape.radius = radius;
    scene.turns[scene.count] = 0;
    scene.boxes[scene.count] = {};
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
        const StateImpl* const surface = shape.value().surface;
        scene.turns[scene.count] = surface != nullptr ? surface->moved : 0;
        scene.boxes[scene.count] = surface != nullptr ? box_of(*surface) : Box{};
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

bool has_kept_shape(const Scene& before, const Scene& now, std::uint32_t o) noexcept {
    const Shape* const stood = was_at(before, now, o);
    if (stood == nullptr || stood->reach != now.shapes[o].reach) return false;
    const std::uint32_t k = place_of(before, now.ids[o]);
    const Box &then = before.boxes[k], &here = now.boxes[o];
    return before.turns[k] == now.turns[o] && std::equal(then.low, then.low + 3, here.low) &&
           std::equal(then.high, then.high + 3, here.high);
}

bool has_stayed(const Scene& before, const Scene& now, std::uint32_t o) noexcept {
    // All of a shape from `point` on are doubles.
    constexpr std::size_t kBytes = offsetof(Shape, surface) - offsetof(Shape, point);
    static_assert(kBytes == 23 * sizeof(double));
    if (!has_kept_shape(before, now, o)) return false;
    const void *const then = &last_of(before, now, o).point, *const here = &now.shapes[o].point;
    return std::memcmp(then, here, kBytes) == 0;
}

double longest_way(const Shape& before, const Shape& now) noexcept {
    if (now.kind == ObstacleKind::Plane) {
        const Double3 turn = now.normal - before.normal;
        return dot(turn, turn) != 0 ? kInfinity : (1 + 1e-9) * std::fabs(now.offset - before.offset);
    }
    Double3 way = now.point - before.point;
    double most = dot(way, way);
    if (now.kind == ObstacleKind::Capsule) {
        way = now.end - before.end;
        most = std::max(most, dot(way, way));
    }
    if (now.kind == ObstacleKind::Box || now.kind == ObstacleKind::Surface) {
        const bool is_box = now.kind == ObstacleKind::Box;
        const Box all = is_box ? Box{{-1, -1, -1}, {1, 1, 1}} : box_of(*now.surface);
        most = 0;  // at a corner, as ways change linearly
        for (int k = 0; k < 8; ++k) {
            const Double3 own{(k & 1) != 0 ? all.high[0] : all.low[0], (k & 2) != 0 ? all.high[1] : all.low[1],
                              (k & 4) != 0 ? all.high[2] : all.low[2]};
            const auto at = [&](const Shape& o) {
                return from_own(o, is_box ? Double3{o.half.x * own.x, o.half.y * own.y, o.half.z * own.z} : own);
            };
            way = at(now) - at(before);
            most = std::max(most, dot(way, way));
        }
    }
    return (1 + 1e-9) * (std::sqrt(most) + std::fabs(now.radius - before.radius));
}

Probe probe_underway(const Shape& shape, Double3 x) noexcept {
    Probe there = probe(shape, x);
    if (!(shape.ahead > 0) || shape.was.x == nullptr || shape.hint == kNoTriangle) return there;
    // The point on the material's way: what will be nearest to where it takes a point along is nearest now.
    constexpr int kMost = 4;
    Double3 gone;
    for (int round = 0; round < kMost; ++round) {
        const Double3 own = way_of_facet(facet_of(shape), to_own(shape, there.nearest), 0);
        const Double3 way = along_axes(shape, shape.ahead * own);
        const Double3 change = way - gone;
        if (!std::isfinite(dot(way, way)) || !(dot(change, change) > shape.rounding * shape.rounding)) break;
        gone = way;
        there = probe(shape, x + gone);
    }
    const Facet f = facet_of(shape);
    const Double3 then = facing(f.now), here = facing(underway(f, shape.ahead));
    const double size = std::sqrt(dot(then, then)), other = std::sqrt(dot(here, here));
    Double3 off = x + gone - there.nearest;
    if (size > 0 && other > 0)
        off = turned(off, along_axes(shape, (1 / size) * then), along_axes(shape, (1 / other) * here));
    there.nearest = x - off;
    return there;
}

double farthest_way(const Shape& shape) noexcept {
    if (shape.was.x == nullptr) return 0;
    double most = 0;
    for (std::uint32_t k = 0; k < shape.surface->total(); ++k) {
        const Double3 way = widen(shape.surface->point(k)) - widen(shape.was[k]);
        const double square = dot(way, way);
        if (!(square < kInfinity)) return kInfinity;
        most = std::max(most, square);
    }
    return std::sqrt(most);
}

Double3 normal_at(const Shape& shape, const Probe& there, Double3 x) noexcept {
    if (shape.kind == ObstacleKind::Plane) return shape.normal;
    Double3 way = there.distance < 0 ? there.nearest - x : x - there.nearest;
    if (shape.kind == ObstacleKind::Surface && std::fabs(there.distance) < shape.rounding) {
        const Double3 normal = along_axes(shape, facing(underway(facet_of(shape), shape.ahead)));
        if (dot(normal, normal) > 0) way = normal;
    }
    const double length = std::sqrt(dot(way, way));
    return length > 0 ? (1 / length) * way : Double3{};
}

Double3 way_come(const Shape& before, const Shape& now, Double3 at, const Probe& there) noexcept {
    if (&before == &now) return {};  // to the bit: what rests there must not creep
    if (now.was.x != nullptr) return way_of_skin(before, now, there);
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
