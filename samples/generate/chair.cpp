// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/chair.cpp
// Upholstered boxes: a rounded rectangle for a plan, a grid on top and below, and rings of a profile between, the
// profile making the groove and the round of the piping.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "math/portable.h"
#include "noise.h"
#include "upholstery.h"

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;

constexpr int kCells = 30;  // quads along a side of the plan; even, so that a sample lies in the middle

/// Offset from the plan, outward, and height.
struct ProfilePoint {
    double out, z;
};

struct Box {
    double half_x = 0, half_y = 0, corner = 0;      ///< plan, centimetres
    double height = 0;                              ///< of the piping's axis
    double tile = 1;                                ///< side of the cloth picture on the chair
    std::function<double(double x, double y)> top;  ///< height of the top over its border, plan coordinates -1..1
};

// Nearest point of the plan's inner rectangle, and the way out from it, for a border point of [-1, 1]^2.
Vec3d rim_point(const Box& box, Vec2d q, ProfilePoint at) {
    const Vec2d p{q.x * box.half_x, q.y * box.half_y};
    const Vec2d inner{std::clamp(p.x, box.corner - box.half_x, box.half_x - box.corner),
                      std::clamp(p.y, box.corner - box.half_y, box.half_y - box.corner)};
    const Vec2d way = p - inner;
    const Vec2d r = inner + way * ((box.corner + at.out) / length(way));
    return {r.x, r.y, at.z};
}

Vec3d cap_point(const Box& box, double x, double y, ProfilePoint border) {
    const double m = std::max(std::abs(x), std::abs(y));
    if (m == 0) return {0, 0, border.z};
    const Vec3d rim = rim_point(box, {x / m, y / m}, border);
    const Vec2d flat{x * box.half_x, y * box.half_y};  // square near the middle, rounded towards the rim
    const double w = m * m;
    return {flat.x * (1 - w) + m * rim.x * w, flat.y * (1 - w) + m * rim.y * w, border.z};
}

std::vector<ProfilePoint> profile(double height) {
    std::vector<ProfilePoint> out{{-0.42, height + 0.42}};
    constexpr double kPiping = 0.55;
    for (const double degrees : {118., 86., 54., 22., -10., -42., -74., -106.}) {
        const double a = degrees * std::numbers::pi / 180;
        out.push_back({0.10 + kPiping * math::cos(a), height + kPiping * math::sin(a)});
    }
    const double h = height - 0.75;  // below the piping: a soft side, then round to the bottom
    for (const ProfilePoint p : {ProfilePoint{-0.28, 1.0},
                                 {0.15, 0.86},
                                 {0.42, 0.66},
                                 {0.45, 0.45},
                                 {0.30, 0.26},
                                 {-0.05, 0.11},
                                 {-0.60, 0.03},
                                 {-1.40, 0.0}})
        out.push_back({p.out, p.z * h});
    return out;
}

// Border points of the grid, counter-clockwise from (-1, -1).
std::vector<std::array<int, 2>> border_walk() {
    std::vector<std::array<int, 2>> out;
    out.reserve(4UL * kCells);
    for (int k = 0; k < kCells; ++k) out.push_back({k, 0});
    for (int k = 0; k < kCells; ++k) out.push_back({kCells, k});
    for (int k = kCells; k > 0; --k) out.push_back({k, kCells});
    for (int k = kCells; k > 0; --k) out.push_back({0, k});
    return out;
}

double unit(int i) {
    return 2.0 * i / kCells - 1;
}

/// Builds the box with its plan at z = 0, top up. Vertices: top grid, rings, bottom grid; borders of grids are rings.
class BoxBuilder {
 public:
    explicit BoxBuilder(const Box& box) : box_(box), walk_(border_walk()), profile_(profile(box.height)) {
        add_cap(profile_.front(), true);
        for (std::size_t ring = 1; ring + 1 < profile_.size(); ++ring) add_ring(profile_[ring]);
        add_cap(profile_.back(), false);
        add_sides();
    }
    PolyMesh mesh;

 private:
    static std::uint32_t grid(std::uint32_t base, int i, int j) {
        return base + static_cast<std::uint32_t>(i * (kCells + 1) + j);
    }

    void add_cap(ProfilePoint border, bool top) {
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        (top ? top_ : bottom_) = base;
        const auto uv_base = static_cast<std::uint32_t>(mesh.uvs.size());
        for (int i = 0; i <= kCells; ++i)
            for (int j = 0; j <= kCells; ++j) {
                Vec3d p = cap_point(box_, unit(i), unit(j), border);
                mesh.uvs.push_back({0.5 + (top ? p.x : -p.x) / box_.tile, 0.5 + p.y / box_.tile});
                if (top) p.z += box_.top(unit(i), unit(j));
                mesh.positions.push_back(p);
            }
        for (int i = 0; i < kCells; ++i)
            for (int j = 0; j < kCells; ++j) {
                std::array<std::array<int, 2>, 4> c{{{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
                if (!top) std::swap(c[1], c[3]);
                Polygon p;
                p.group = top ? 1 : 3;
                for (std::size_t k = 0; k < 4; ++k) {
                    p.vertex[k] = grid(base, c[k][0], c[k][1]);
                    p.uv[k] = grid(uv_base, c[k][0], c[k][1]);
                }
                add_cell(mesh, p, i, j, kCells);
            }
    }

    void add_ring(ProfilePoint at) {
        rings_.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
        for (const auto& w : walk_) mesh.positions.push_back(rim_point(box_, {unit(w[0]), unit(w[1])}, at));
    }

    [[nodiscard]] std::uint32_t side_vertex(std::size_t ring, std::size_t k) const {
        k %= walk_.size();
        if (ring == 0) return grid(top_, walk_[k][0], walk_[k][1]);
        if (ring > rings_.size()) return grid(bottom_, walk_[k][0], walk_[k][1]);
        return rings_[ring - 1] + static_cast<std::uint32_t>(k);
    }

    // Each of the four sides has the picture once along it, so neighbouring sides meet where it tiles.
    void add_sides() {
        std::vector<double> drop{0};
        for (std::size_t r = 1; r < profile_.size(); ++r)
            drop.push_back(drop.back() +
                           math::hypot(profile_[r].out - profile_[r - 1].out, profile_[r].z - profile_[r - 1].z));
        const auto uv_base = static_cast<std::uint32_t>(mesh.uvs.size());
        for (const double d : drop)
            for (int k = 0; k <= kCells; ++k) mesh.uvs.push_back({k / static_cast<double>(kCells), 1 - d / box_.tile});
        for (std::size_t r = 0; r + 1 < drop.size(); ++r)
            for (std::size_t k = 0; k < walk_.size(); ++k) {
                const auto column = static_cast<std::uint32_t>(k % kCells);
                const auto uv = [&](std::size_t ring, std::uint32_t c) {
                    return uv_base + static_cast<std::uint32_t>(ring * (kCells + 1)) + c;
                };
                Polygon p;
                p.vertex = {side_vertex(r, k), side_vertex(r + 1, k), side_vertex(r + 1, k + 1), side_vertex(r, k + 1)};
                p.uv = {uv(r, column), uv(r + 1, column), uv(r + 1, column + 1), uv(r, column + 1)};
                p.group = 2;
                mesh.polygons.push_back(p);
            }
    }

    const Box& box_;
    std::vector<std::array<int, 2>> walk_;
    std::vector<ProfilePoint> profile_;
    std::vector<std::uint32_t> rings_;
    std::uint32_t top_ = 0, bottom_ = 0;
};

// 0 on the border of the plan, 1 a little way in: the padding's round edge.
double padding(double x, double y, double softness) {
    return (1 - math::exp(-softness * (1 - std::abs(x)))) * (1 - math::exp(-softness * (1 - std::abs(y))));
}
}  // namespace

PolyMesh make_chair_seat() {
    Box box;
    box.half_x = 24;
    box.half_y = 22.5;
    box.corner = 6;
    box.height = 6.5;
    box.tile = 50;
    box.top = [](double x, double y) {
        const double dish = math::exp(-(x * x + (y + 0.1) * (y + 0.1)) / 0.32);
        return padding(x, y, 7) * (2.9 - 2.1 * dish + 0.15 * noise3({2.5 * x, 2.5 * y, 0}, 141));
    };
    PolyMesh mesh = BoxBuilder(box).mesh;
    orient_outward(mesh);
    quantise(mesh);
    return mesh;
}

PolyMesh make_chair_back() {
    Box box;
    box.half_x = 23;
    box.half_y = 26;
    box.corner = 8;
    box.height = 4.5;
    box.tile = 54;
    box.top = [](double x, double y) {
        constexpr std::array<std::array<double, 2>, 5> kButtons{
            {{0, 0}, {-0.42, 0.44}, {0.42, 0.44}, {-0.42, -0.44}, {0.42, -0.44}}};
        double pull = 0;
        for (const auto& b : kButtons) {
            const double dx = x - b[0], dy = y - b[1], r2 = dx * dx + dy * dy;
            const double star =
                1 + 0.35 * math::cos(4 * math::atan2(dy, dx));  // the cloth pleats towards its neighbours
            pull += 1.5 * math::exp(-r2 / 0.006) + 1.2 * math::exp(-r2 / (0.035 * star));
        }
        return padding(x, y, 6) * std::max(0.2, 3.4 - pull);
    };
    PolyMesh mesh = BoxBuilder(box).mesh;
    orient_outward(mesh);
    // Hollow towards the sitter, a crest at the head, then upright with a little recline. The box's top becomes front.
    for (Vec3d& p : mesh.positions) {
        constexpr double kRadius = 62, kRecline = 0.20;
        const double crest = 3.2 * std::max(0.0, 1 - p.x * p.x / 529) * smooth_step(0, 26, p.y);
        const double angle = p.x / kRadius, r = kRadius - p.z;
        const Vec3d bent{r * math::sin(angle), p.y + crest, kRadius - r * math::cos(angle)};
        const double c = math::cos(kRecline), s = math::sin(kRecline);
        p = {bent.x, -bent.z * c + bent.y * s, bent.y * c + bent.z * s};
    }
    quantise(mesh);
    return mesh;
}

}  // namespace dgm::samples
