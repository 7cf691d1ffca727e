// SPDX-License-Identifier: MIT
// libdgm/src/query/pick.cpp
// Walks the pyramid along a ray, nearest box first; ray_triangle.h holds the tests and why they agree.
#include <dgm/pick.h>

#include <cstring>

#include "query/ray_triangle.h"
#include "surface/descent.h"

namespace dgm {
namespace detail {
namespace {

constexpr double kLargest = std::numeric_limits<float>::max();
constexpr std::uint32_t kSide = kTileQuads + 1;  // samples of a tile's quads

/// The nearest hit so far; `triangle` is 2 (i (n - 1) + j) + t of quads, then of border faces.
struct Found {
    double distance;
    std::uint64_t triangle = ~std::uint64_t{0};
    std::uint32_t corners[3] = {};
    TriangleHit hit = {};
};

struct Picker {
    const StateImpl& s;
    const Ray ray;
    const RayPlanes planes;
    const bool back_faces;
    Found best;

    [[gnu::noinline]] void offer(std::uint64_t triangle, const std::uint32_t* corners) noexcept {
        TriangleHit hit;
        if (!meets(ray, shear(ray, planes, corners[0]), shear(ray, planes, corners[1]), shear(ray, planes, corners[2]),
                   hit))
            return;
        if (!hit.front && !back_faces) return;
        if (hit.distance > best.distance || (hit.distance == best.distance && triangle >= best.triangle)) return;
        best.distance = hit.distance;
        best.triangle = triangle;
        best.hit = hit;
        std::copy_n(corners, 3, best.corners);
    }

    void offer_quad(std::uint32_t i, std::uint32_t j) noexcept {
        const ChartTables& t = s.tables;
        if (!t.has_quad(i, j)) return;
        const std::uint64_t first = 2 * (std::uint64_t{i} * (t.cols - 1) + j);
        const auto triangles = quad_triangles(i, j, t.cols, t.diagonal(i, j));
        offer(first, triangles[0].data());
        offer(first + 1, triangles[1].data());
    }

    /// Sides of the ray on which a sample lies: bits x > 0, x < 0, y > 0, y < 0. A quad whose corners share a bit is
    /// not hit (Cohen and Sutherland's codes). Eight at a time.
    void search_quads(std::uint32_t tile) noexcept {
        const ChartTables& t = s.tables;
        const std::uint32_t i0 = tile / s.tile_cols * kTileQuads, j0 = tile % s.tile_cols * kTileQuads;
        const std::uint32_t height = std::min(kTileQuads, t.rows - 1 - i0),
                            width = std::min(kTileQuads, t.cols - 1 - j0);
        std::uint8_t codes[kSide][16] = {};
        for (std::uint32_t i = 0; i <= height; ++i) {
            const std::uint32_t first = (i0 + i) * t.cols + j0;
            for (std::uint32_t j = 0; j <= width; ++j) {
                const Sheared p = shear(ray, planes, first + j);
                codes[i][j] = static_cast<std::uint8_t>((p.x > 0 ? 1 : 0) | (p.x < 0 ? 2 : 0) | (p.y > 0 ? 4 : 0) |
                                                        (p.y < 0 ? 8 : 0));
            }
        }
        for (std::uint32_t i = 0; i < height; ++i) {
            std::uint8_t shared[kTileQuads] = {};
            for (std::uint32_t j = 0; j < kTileQuads; ++j)
                shared[j] =
                    static_cast<std::uint8_t>(codes[i][j] & codes[i][j + 1] & codes[i + 1][j] & codes[i + 1][j + 1]);
            for (std::uint32_t j = 0; j < width; ++j)
                if (shared[j] == 0) offer_quad(i0 + i, j0 + j);
        }
    }

    void search_leaf(std::uint32_t tile) noexcept {
        search_quads(tile);
        if (s.tile_face_start.empty()) return;
        const std::uint64_t first = 2 * std::uint64_t{s.tables.rows - 1} * (s.tables.cols - 1);
        for (std::uint32_t k = s.tile_face_start[tile]; k < s.tile_face_start[tile + 1]; ++k)
            offer(first + s.tile_faces[k], s.faces.data() + 3 * std::size_t{s.tile_faces[k]});
    }

    void run() noexcept {
        descend(
            s.now_boxes, [&](const Box& box) { return box_near(ray, box); },
            [&](double near) { return !(near <= best.distance) || near == __builtin_inf(); },
            [&](std::uint32_t tile) { search_leaf(tile); });
    }
};

/// Unit normal in double; 0 where rounding leaves no area.
Vec3 flat_normal(Vec3 a, Vec3 b, Vec3 c) noexcept {
    const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
    const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
    const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const double length = std::sqrt(x * x + y * y + z * z);
    if (!(length > 0)) return {};
    return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

[[gnu::cold]] RayHit report(const StateImpl& s, const Found& found) noexcept {
    RayHit out;
    const std::uint32_t quads = (s.tables.rows - 1) * (s.tables.cols - 1);
    if (found.triangle < 2 * std::uint64_t{quads}) {
        const auto quad = static_cast<std::uint32_t>(found.triangle / 2);
        out.row = quad / (s.tables.cols - 1);
        out.column = quad % (s.tables.cols - 1);
        out.triangle = static_cast<std::uint32_t>(found.triangle % 2);
    } else {
        out.triangle = static_cast<std::uint32_t>(found.triangle - 2 * std::uint64_t{quads});
    }
    const double* w = found.hit.weight;
    const std::uint32_t nearest = w[0] >= w[1] ? (w[0] >= w[2] ? 0 : 2) : (w[1] >= w[2] ? 1 : 2);
    out.sample = s.representative(found.corners[nearest]);
    double point[3] = {};
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 p = s.point(found.corners[k]);
        out.corners[k] = found.corners[k];
        out.barycentric[k] = static_cast<float>(w[k]);
        point[0] += w[k] * p.x;
        point[1] += w[k] * p.y;
        point[2] += w[k] * p.z;
    }
    const auto narrow = [](double v) { return static_cast<float>(std::clamp(v, -kLargest, kLargest)); };
    out.point = {narrow(point[0]), narrow(point[1]), narrow(point[2])};
    out.distance = narrow(found.distance);
    out.normal = flat_normal(s.point(out.corners[0]), s.point(out.corners[1]), s.point(out.corners[2]));
    out.front = found.hit.front;
    return out;
}
}  // namespace
}  // namespace detail

Result<RayHit> pick_ray(State& state, Vec3 origin, Vec3 direction, const PickOptions& options) noexcept {
    detail::StateImpl& s = *state.impl();
    const auto bad = [](const char* message) { return Error{ErrorCode::BadArgument, kNoOffset, message}; };
    if (!detail::is_finite(origin)) return bad("the ray's origin is not finite");
    if (!detail::is_finite(direction) || direction == Vec3{}) return bad("the ray's direction is 0 or not finite");
    if (!(options.max_distance >= 0)) return bad("the ray's length is not a number from 0");
    detail::refit(s, s.now_boxes);
    const detail::Ray ray = detail::make_ray(origin, direction);
    detail::Picker picker{
        s, ray, detail::planes_of(ray, detail::StateImpl::fixed(s.now)), options.back_faces, {options.max_distance}};
    picker.run();
    if (picker.best.triangle == ~std::uint64_t{0})
        return Error{ErrorCode::NotFound, kNoOffset, "the ray meets no triangle"};
    return detail::report(s, picker.best);
}

}  // namespace dgm
