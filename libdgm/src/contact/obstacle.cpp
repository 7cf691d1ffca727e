// SPDX-License-Identifier: MIT
// libdgm/src/contact/obstacle.cpp
// Measures the distance of a point from an obstacle, and finds the nearest point of its border.
//
// The nearest triangle of a surface (surface_search.h) says on which side a point lies; where several share the
// nearest point, the one that faces the point most of those at the edge that leads most towards it.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "contact/contact_impl.h"
#include "contact/surface_search.h"

namespace dgm {
namespace detail {
namespace {

Probe round_probe(Double3 p, Double3 centre, double radius) noexcept {
    const Double3 v = p - centre;
    const double length = std::sqrt(dot(v, v));
    // At the centre every way out is as good: take one.
    const Double3 way = length > 0 ? (1 / length) * v : Double3{0, 0, 1};
    return {length - radius, centre + radius * way};
}

Probe box_probe(const Shape& o, Double3 p) noexcept {
    const Double3 q = to_own(o, p);
    const double c[3] = {q.x, q.y, q.z}, h[3] = {o.half.x, o.half.y, o.half.z};
    double nearest[3], outside = 0;
    int face = 0;
    for (int k = 0; k < 3; ++k) {
        nearest[k] = std::clamp(c[k], -h[k], h[k]);
        outside += (c[k] - nearest[k]) * (c[k] - nearest[k]);
        if (std::fabs(c[k]) - h[k] > std::fabs(c[face]) - h[face]) face = k;
    }
    if (outside > 0) return {std::sqrt(outside), from_own(o, {nearest[0], nearest[1], nearest[2]})};
    nearest[face] = std::copysign(h[face], c[face]);
    return {std::fabs(c[face]) - h[face], from_own(o, {nearest[0], nearest[1], nearest[2]})};
}

Probe surface_probe(const Shape& o, Double3 p) noexcept {
    const Hit hit = search_surface(o, to_own(o, p), o.hint);
    o.hint = hit.triangle;
    const double length = std::sqrt(hit.square);
    const bool straight = std::fabs(hit.facing) > 0.7 * length || length < 1e-4 * double{o.surface->mean_step};
    const std::uint32_t facet = straight && hit.triangle < kNone ? static_cast<std::uint32_t>(hit.triangle) : kNone;
    const Double3 nearest = from_own(o, hit.nearest);
    if (!(hit.facing < 0)) return {length, nearest, facet};
    // Beside the border of an open surface the nearest point is on an edge, and the way to it leans.
    if (length > o.reach || (o.open && -hit.facing < 0.7 * length)) return {length, nearest, facet};
    return {-length, nearest, facet};
}

constexpr Error kBadObstacle{ErrorCode::BadArgument, kNoOffset, "the obstacle is not finite or out of range"};

bool read_rotation(const float* r, Double3* axis) noexcept {
    for (int k = 0; k < 3; ++k) axis[k] = {r[k], r[3 + k], r[6 + k]};
    for (int a = 0; a < 3; ++a)
        for (int b = a; b < 3; ++b)
            if (!(std::fabs(dot(axis[a], axis[b]) - (a == b ? 1 : 0)) < 1e-4)) return false;
    return dot(axis[0], cross(axis[1], axis[2])) > 0;
}
}  // namespace

Result<Shape> make_shape(const Obstacle& o) noexcept {
    Shape shape;
    shape.kind = o.kind;
    if (!is_place(o.point)) return kBadObstacle;
    shape.point = widen(o.point);
    switch (o.kind) {
        case ObstacleKind::Plane: {
            const Double3 n = widen(o.normal);
            const double length = std::sqrt(dot(n, n));
            if (!is_finite(o.normal) || !(length > 0)) return kBadObstacle;
            shape.normal = (1 / length) * n;
            shape.offset = dot(shape.normal, shape.point);
            return shape;
        }
        case ObstacleKind::Capsule:
            if (!is_place(o.end)) return kBadObstacle;
            shape.end = widen(o.end);
            [[fallthrough]];
        case ObstacleKind::Sphere:
            if (!(o.radius > 0 && o.radius <= kMaxCoordinate)) return kBadObstacle;
            shape.radius = o.radius;
            return shape;
        case ObstacleKind::Box:
            if (!is_place(o.half) || !(o.half.x > 0 && o.half.y > 0 && o.half.z > 0)) return kBadObstacle;
            shape.half = widen(o.half);
            return read_rotation(o.rotation, shape.axis) ? Result<Shape>{shape} : Result<Shape>{kBadObstacle};
        case ObstacleKind::Surface:
            break;
        default:
            return Error{ErrorCode::Unsupported, kNoOffset, "the kind of obstacle is not supported"};
    }
    if (o.surface == nullptr || !(o.reach >= 0 && o.reach <= kMaxCoordinate)) return kBadObstacle;
    if (!read_rotation(o.rotation, shape.axis)) return kBadObstacle;
    StateImpl& s = *o.surface->impl();
    if (o.before.x != nullptr && o.before.count != s.total()) return kBadObstacle;
    shape.was = o.before;
    if (!s.any_face) return Error{ErrorCode::NotFound, kNoOffset, "the obstacle has no triangle"};
    shape.surface = &s;
    refit(s, s.now_boxes);
    shape.open = s.open_surface;
    shape.reach = o.reach > 0 ? o.reach : shape.open ? 4 * double{s.mean_step} : kInfinity;
    const Box& root = s.now_boxes.boxes[s.now_boxes.start[s.now_boxes.levels - 1]];
    for (int k = 0; k < 3; ++k)
        shape.rounding = std::max({shape.rounding, 1e-6 * std::fabs(root.low[k]), 1e-6 * std::fabs(root.high[k])});
    return shape;
}

Probe probe(const Shape& o, Double3 p) noexcept {
    switch (o.kind) {
        case ObstacleKind::Plane: {
            const double d = o.normal.x * p.x + o.normal.y * p.y + o.normal.z * p.z - o.offset;
            return {d, p - d * o.normal};
        }
        case ObstacleKind::Sphere:
            return round_probe(p, o.point, o.radius);
        case ObstacleKind::Capsule: {
            const Double3 along = o.end - o.point;
            const double square = dot(along, along);
            const double t = square > 0 ? std::clamp(dot(p - o.point, along) / square, 0.0, 1.0) : 0;
            return round_probe(p, o.point + t * along, o.radius);
        }
        case ObstacleKind::Box:
            return box_probe(o, p);
        case ObstacleKind::Surface:
            break;
    }
    return surface_probe(o, p);
}

void look_into(const Shape& o, const Box& box) noexcept {
    if (o.near == nullptr || o.kind != ObstacleKind::Surface) return;
    NearTiles& n = *o.near;
    const Double3 low{box.low[0], box.low[1], box.low[2]}, high{box.high[0], box.high[1], box.high[2]};
    const Double3 centre = to_own(o, 0.5 * (low + high)), half = 0.5 * (high - low);
    double own[3];
    for (int d = 0; d < 3; ++d)
        own[d] = (1 + 1e-6) *
                 (std::fabs(o.axis[d].x) * half.x + std::fabs(o.axis[d].y) * half.y + std::fabs(o.axis[d].z) * half.z);
    const Double3 reach{own[0], own[1], own[2]}, first = centre - reach, last = centre + reach;
    const bool same =
        holds(n.want[0], first) && holds(first, n.want[0]) && holds(n.want[1], last) && holds(last, n.want[1]);
    n.listed = n.listed && n.wanted && same;
    n.want[0] = first;
    n.want[1] = last;
    n.wanted = true;
}

bool is_apart(const Shape& o, const StateImpl& s, const Rect& samples) noexcept {
    // An open surface may be gone round, and a limited reach ends in the open.
    if (o.near == nullptr || o.is_limited()) return false;
    const NearTiles& n = *o.near;
    if (!n.listed || !n.wanted) return false;
    const BoxFrame& f = n.frame;
    const Double3 centre{f.centre[0], f.centre[1], f.centre[2]};
    double low[3] = {kInfinity, kInfinity, kInfinity}, high[3] = {-kInfinity, -kInfinity, -kInfinity};
    for (std::uint32_t i = samples.i0; i <= samples.i1; ++i)
        for (std::uint32_t k = i * s.tables.cols + samples.j0; k <= i * s.tables.cols + samples.j1; ++k) {
            const Double3 p = to_own(o, widen(s.point(k))), v = p - centre;
            if (!(p.x >= n.low.x && p.y >= n.low.y && p.z >= n.low.z && p.x <= n.high.x && p.y <= n.high.y &&
                  p.z <= n.high.z))
                return false;
            for (int d = 0; d < 3; ++d) {
                const double at = f.axis[d][0] * v.x + f.axis[d][1] * v.y + f.axis[d][2] * v.z;
                low[d] = std::min(low[d], at);
                high[d] = std::max(high[d], at);
            }
        }
    const double slack = 4 * o.rounding;
    BoxesNearJob job{n.boxes, NearTiles::kMost, (n.count + 7) / 8 * 8, {}, {}, static_cast<float>(slack * slack)};
    for (int d = 0; d < 3; ++d) {
        job.low[d] = static_cast<float>(low[d]);
        job.high[d] = static_cast<float>(high[d]);
    }
    std::uint64_t tiles = o.surface->rows_of->boxes_near(job);
    job.stride = job.count = 64;
    for (; tiles != 0; tiles &= tiles - 1) {
        const auto e = static_cast<std::uint32_t>(__builtin_ctzll(tiles));
        if (o.surface->has_faces(n.tiles[e])) return false;
        job.boxes = n.quads[e];
        if (o.surface->rows_of->boxes_near(job) != 0) return false;
    }
    return true;
}

Probe facet_probe(const Shape& o, std::uint32_t facet, Double3 p) noexcept {
    const auto f = corners_of(*o.surface, facet);
    const auto at = [&](std::uint32_t k) { return widen(o.surface->point(k)); };
    const Double3 a = at(f[0]), q = to_own(o, p), n = cross(at(f[1]) - a, at(f[2]) - a);
    const double square = dot(n, n);
    if (!(square > 0)) return {0, p, facet};
    const double share = dot(n, q - a) / square;
    return {share * std::sqrt(square), from_own(o, q - share * n), facet};
}

double box_distance(const Shape& o, const Box& box) noexcept {
    if (!(box.low[0] <= box.high[0])) return kInfinity;
    const Double3 low{box.low[0], box.low[1], box.low[2]}, high{box.high[0], box.high[1], box.high[2]};
    const Double3 centre = 0.5 * (low + high), half = 0.5 * (high - low);
    if (o.kind == ObstacleKind::Plane)
        return dot(o.normal, centre) - o.offset -
               (std::fabs(o.normal.x) * half.x + std::fabs(o.normal.y) * half.y + std::fabs(o.normal.z) * half.z);
    // Distances change by no more than the way gone. Behind a surface of limited reach they change sign again.
    const double radius = std::sqrt(dot(half, half));
    Shape alone = o;  // from one large box to the next there is nothing near to share
    alone.near = nullptr;
    const bool small = o.kind == ObstacleKind::Surface && radius < 2 * kTileQuads * double{o.surface->mean_step};
    if (small) look_into(o, box);
    const double distance = probe(small ? o : alone, centre).distance;
    if (!small) o.hint = alone.hint;
    return o.is_limited() ? std::fabs(distance) - radius - o.reach : distance - radius;
}
}  // namespace detail

Result<ObstacleDistance> obstacle_distance(const Obstacle& obstacle, Vec3 point) noexcept {
    if (!detail::is_place(point))
        return Error{ErrorCode::BadArgument, kNoOffset, "a coordinate of the point is beyond 1e18"};
    auto shape = detail::make_shape(obstacle);
    if (!shape) return shape.error();
    const detail::Probe p = detail::probe(shape.value(), detail::widen(point));
    return ObstacleDistance{static_cast<float>(p.distance), detail::narrow(p.nearest)};
}

}  // namespace dgm
