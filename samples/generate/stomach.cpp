// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/stomach.cpp
// Two swept sacks, the stomach itself and the oesophagus, blended by a smooth minimum and cut flat at their ends.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "atlas.h"
#include "implicit_surface.h"
#include "math/portable.h"
#include "noise.h"
#include "organs.h"

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;

struct Ball {
    Vec3d centre;
    double radius;
};

// From the dome of the fundus round the J to the duodenum.
const std::vector<Ball> kSack = {{{5.6, -0.8, 8.4}, 4.0},   {{5.4, -0.5, 6.4}, 4.3},   {{5.0, 0.0, 3.4}, 4.2},
                                 {{4.6, 0.4, 0.2}, 3.85},   {{3.5, 0.8, -2.9}, 3.4},   {{1.3, 1.0, -5.2}, 2.95},
                                 {{-1.5, 0.9, -6.0}, 2.5},  {{-4.0, 0.5, -5.0}, 2.0},  {{-5.7, 0.1, -3.6}, 1.3},
                                 {{-7.0, -0.3, -2.7}, 1.6}, {{-8.4, -0.8, -2.9}, 1.6}, {{-9.3, -1.2, -4.4}, 1.45},
                                 {{-9.5, -1.5, -7.0}, 1.4}};
const std::vector<Ball> kOesophagus = {
    {{2.6, -0.4, 4.6}, 1.5}, {{0.9, -0.5, 6.6}, 1.15}, {{-0.3, -0.7, 8.8}, 1.0}, {{-0.8, -0.9, 12.4}, 1.0}};

/// A ball swept along a Catmull-Rom curve through its control balls, sampled finely enough to look smooth.
class Sweep {
 public:
    explicit Sweep(const std::vector<Ball>& control) {
        constexpr int kSteps = 8;
        const auto n = static_cast<int>(control.size());
        const auto at = [&](int i) -> const Ball& {
            return control[static_cast<std::size_t>(std::clamp(i, 0, n - 1))];
        };
        for (int i = 0; i + 1 < n; ++i)
            for (int k = 0; k < kSteps + (i + 2 == n ? 1 : 0); ++k) {
                const double t = k / static_cast<double>(kSteps);
                const double w0 = t * (-1 + t * (2 - t)) / 2, w1 = 1 + t * t * (-5 + 3 * t) / 2,
                             w2 = t * (1 + t * (4 - 3 * t)) / 2, w3 = t * t * (t - 1) / 2;
                balls_.push_back(
                    {at(i - 1).centre * w0 + at(i).centre * w1 + at(i + 1).centre * w2 + at(i + 2).centre * w3,
                     at(i - 1).radius * w0 + at(i).radius * w1 + at(i + 1).radius * w2 + at(i + 2).radius * w3});
            }
    }
    /// Where a point lies relative to the sweep.
    struct Near {
        double distance = 1e30;  ///< to the swept surface, negative inside
        double along = 0;        ///< 0..1 from the first to the last control ball
        Vec3d centre;
    };
    [[nodiscard]] Near nearest(const Vec3d& p) const {
        Near out;
        for (std::size_t i = 0; i + 1 < balls_.size(); ++i) {
            const Vec3d axis = balls_[i + 1].centre - balls_[i].centre;
            const double t = std::clamp(dot(p - balls_[i].centre, axis) / dot(axis, axis), 0.0, 1.0);
            const Vec3d c = balls_[i].centre + axis * t;
            const double d = length(p - c) - (balls_[i].radius + (balls_[i + 1].radius - balls_[i].radius) * t);
            if (d < out.distance) out = {d, (static_cast<double>(i) + t) / static_cast<double>(balls_.size() - 1), c};
        }
        return out;
    }
    [[nodiscard]] Ball ball(double along) const {
        const double s = std::clamp(along, 0.0, 1.0) * static_cast<double>(balls_.size() - 1);
        const auto i = std::min(static_cast<std::size_t>(s), balls_.size() - 2);
        const double t = s - static_cast<double>(i);
        return {balls_[i].centre + (balls_[i + 1].centre - balls_[i].centre) * t,
                balls_[i].radius + (balls_[i + 1].radius - balls_[i].radius) * t};
    }
    /// Length of the axis up to there.
    [[nodiscard]] double arc(double along) const {
        const double s = std::clamp(along, 0.0, 1.0) * static_cast<double>(balls_.size() - 1);
        double sum = 0;
        for (std::size_t i = 0; i + 1 < balls_.size(); ++i)
            sum += std::clamp(s - static_cast<double>(i), 0.0, 1.0) * length(balls_[i + 1].centre - balls_[i].centre);
        return sum;
    }
    [[nodiscard]] Vec3d tangent(double along) const {
        return normalized(ball(along + 0.01).centre - ball(along - 0.01).centre);
    }

 private:
    std::vector<Ball> balls_;
};

// Direction from the centreline to the greater curvature: outward in the plane of the J.
Vec3d greater_side(const Sweep& sweep, double along) {
    const Vec3d t = sweep.tangent(along);
    return normalized(Vec3d{-t.z, 0, t.x});
}

class Stomach {
 public:
    [[nodiscard]] double field(const Vec3d& world) const {
        const Vec3d p = flattened(world);
        const Sweep::Near sack = sack_.nearest(p);
        const double tube = smooth_max(oesophagus_.nearest(p).distance, world.z - 11.6, 0.35);
        double d = smooth_min(sack.distance + folds(p, sack), tube, 0.9);
        d += 0.16 * fractal3(world * 0.28, 2, 11);
        return world.x < -6 ? smooth_max(d, -6.3 - world.z, 0.35) : d;
    }
    [[nodiscard]] const Sweep& sack() const { return sack_; }
    [[nodiscard]] Sweep::Near nearest(const Vec3d& world) const { return sack_.nearest(flattened(world)); }
    [[nodiscard]] Sweep::Near nearest_of_oesophagus(const Vec3d& world) const {
        return oesophagus_.nearest(flattened(world));
    }
    [[nodiscard]] Vec3d surface_point(double along, double angle) const;
    /// Where a cloth that is wrapped around one of the sweeps has this point: turns around it, centimetres along it.
    [[nodiscard]] Vec2d wrapped(const Vec3d& world, const Sweep& sweep) const;
    [[nodiscard]] const Sweep& oesophagus() const { return oesophagus_; }

 private:
    // The sack is a little flatter from front to back than it is wide.
    static constexpr double kFlat = 0.86;
    static Vec3d flattened(const Vec3d& world) { return {world.x, world.y / kFlat, world.z}; }

    // Long soft folds down the body, strongest along the greater curvature.
    [[nodiscard]] double folds(const Vec3d& p, const Sweep::Near& at) const {
        const double strength = smooth_step(0.05, 0.2, at.along) * (1 - smooth_step(0.5, 0.66, at.along));
        if (strength <= 0) return 0;
        const Vec3d d = p - at.centre;
        const double angle = math::atan2(d.y, dot(d, greater_side(sack_, at.along)));
        const double wander = 1.1 * noise3(p * 0.22, 21);
        const double depth = 0.15 + 0.07 * noise3(p * 0.35, 22);
        return strength * depth * (0.65 + 0.35 * math::cos(angle)) * math::cos(10 * angle + 2.5 * wander);
    }

    Sweep sack_{kSack}, oesophagus_{kOesophagus};
};

Vec3d Stomach::surface_point(double along, double angle) const {
    const Ball b = sack_.ball(along);
    const Vec3d g = greater_side(sack_, along);
    const Vec3d direction = g * math::cos(angle) + Vec3d{0, kFlat, 0} * math::sin(angle);
    const Vec3d centre{b.centre.x, b.centre.y * kFlat, b.centre.z};
    double low = 0, high = 2.2 * b.radius;
    for (int k = 0; k < 30; ++k) {
        const double middle = (low + high) / 2;
        (field(centre + direction * middle) < 0 ? low : high) = middle;
    }
    return centre + direction * low;
}

Vec2d Stomach::wrapped(const Vec3d& world, const Sweep& sweep) const {
    const Sweep::Near at = sweep.nearest(flattened(world));
    const Vec3d d = flattened(world) - at.centre, t = sweep.tangent(at.along);
    const double angle = math::atan2(d.y, dot(d, greater_side(sweep, at.along)));
    // Beyond the ends, and where the radius changes, the nearest point of the axis stands still: go on by latitude.
    const double rise = std::clamp(dot(normalized(d), t), -1.0, 1.0);
    const double latitude = math::atan2(rise, std::sqrt((1 - rise) * (1 + rise)));
    return {angle / (2 * std::numbers::pi), sweep.arc(at.along) + length(d) * latitude};
}

/// A straight piece of a blood vessel on the surface.
struct Vessel {
    Vec3d a, b;
    double radius_a, radius_b;
};

/// The vessels along the two curvatures, their branches over front and back, and twigs of those.
class VesselTree {
 public:
    explicit VesselTree(const Stomach& stomach) : stomach_(stomach) {
        for (const double side : {0.0, std::numbers::pi}) {
            trail(0.08, side, 0.76, side, 0.15, 0.08, static_cast<std::uint32_t>(side), 60);
            for (int k = 0; k < 26; ++k) {
                const double along = 0.10 + 0.025 * k + 0.006 * (hash01(k, 0, 0, 31) - 0.5);
                for (const int face : {-1, 1}) branch(along, side, face, k);
            }
        }
    }
    /// 1 in the middle of a vessel, falling to 0 at its walls.
    [[nodiscard]] double strength(const Vec3d& p) const {
        double best = 0;
        const auto bucket = buckets_.find(bucket_of(p));
        if (bucket == buckets_.end()) return 0;
        for (const std::size_t i : bucket->second) {
            const Vessel& v = pieces_[i];
            const Vec3d axis = v.b - v.a, d = p - v.a;
            const double t = std::clamp(dot(d, axis) / std::max(dot(axis, axis), 1e-12), 0.0, 1.0);
            const double r = v.radius_a + (v.radius_b - v.radius_a) * t;
            best = std::max(best, (1 - smooth_step(0.35, 1.25, length(d - axis * t) / r)) * std::min(1.0, r / 0.07));
        }
        return best;
    }

 private:
    using Bucket = std::array<int, 3>;  // a cell of one centimetre
    static Bucket bucket_of(const Vec3d& p) {
        return {static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                static_cast<int>(std::floor(p.z))};
    }
    void add(const Vessel& v) {
        const double reach = 1.25 * std::max(v.radius_a, v.radius_b);
        const Vec3d margin{reach, reach, reach};
        const Bucket low =
            bucket_of(Vec3d{std::min(v.a.x, v.b.x), std::min(v.a.y, v.b.y), std::min(v.a.z, v.b.z)} - margin);
        const Bucket high =
            bucket_of(Vec3d{std::max(v.a.x, v.b.x), std::max(v.a.y, v.b.y), std::max(v.a.z, v.b.z)} + margin);
        for (int x = low[0]; x <= high[0]; ++x)
            for (int y = low[1]; y <= high[1]; ++y)
                for (int z = low[2]; z <= high[2]; ++z) buckets_[{x, y, z}].push_back(pieces_.size());
        pieces_.push_back(v);
    }

    void branch(double along, double side, int face, int k) {
        const double reach = (0.9 + 0.45 * hash01(k, face, static_cast<int>(side), 32)) * face * (side > 1 ? 0.8 : 1);
        const double drift = 0.03 * (hash01(k, face, static_cast<int>(side), 33) - 0.4);
        const auto seed = static_cast<std::uint32_t>(100 + 8 * k + face + 2 * static_cast<int>(side));
        const double end = side + reach;
        trail(along, side, along + drift, end, 0.085, 0.035, seed, 14);
        for (int twig = 0; twig < 4; ++twig) {
            const double t = 0.35 + 0.17 * twig, sign = twig % 2 == 0 ? 1 : -1;
            const double start = side + reach * t;
            trail(along + drift * t, start, along + drift * t + sign * 0.020, start + 0.3 * reach, 0.05, 0.028,
                  seed + 1000, 7);
        }
    }

    void trail(double along_a, double angle_a, double along_b, double angle_b, double radius_a, double radius_b,
               std::uint32_t seed, int steps) {
        Vec3d last;
        for (int k = 0; k <= steps; ++k) {
            const double t = k / static_cast<double>(steps);
            const double along = along_a + (along_b - along_a) * t, angle = angle_a + (angle_b - angle_a) * t;
            const double sway = smooth_step(0, 0.2, t);
            const Vec3d at{along * 60, angle * 4, 0};
            const Vec3d p = stomach_.surface_point(along + sway * 0.006 * noise3(at, seed + 7),
                                                   angle + sway * 0.10 * noise3(at, seed + 8));
            const double r0 = radius_a + (radius_b - radius_a) * std::max(0.0, t - 1.0 / steps);
            if (k > 0) add({last, p, r0, radius_a + (radius_b - radius_a) * t});
            last = p;
        }
    }

    const Stomach& stomach_;
    std::vector<Vessel> pieces_;
    std::map<Bucket, std::vector<std::size_t>> buckets_;  // pieces whose walls reach into the cell
};

Shade shade(const Stomach& stomach, const VesselTree& vessels, const Vec3d& p) {
    const Sweep::Near at = stomach.nearest(p);
    const double mottle = fractal3(p * 0.7, 4, 41), fine = fractal3(p * 3.2, 3, 42);
    Colour c = mix(rgb(214, 128, 116), rgb(188, 88, 84), 0.5 + 0.8 * mottle);
    c = mix(c, rgb(232, 168, 150), 0.55 * smooth_step(0.15, 0.6, fractal3(p * 0.4 + Vec3d{7, 3, 1}, 3, 43)));
    c = mix(c, rgb(176, 74, 72), 0.35 * smooth_step(0.72, 0.86, at.along));  // the duodenum is redder
    c = c * (1 + 0.10 * fine);
    const double blood = vessels.strength(p);
    c = mix(c, rgb(128, 26, 38), 0.85 * blood);
    // The cut ends show the lumen.
    const double duodenum = length(p - Vec3d{-9.45, -1.3 * 0.86, -6.3}),
                 gullet = length(p - Vec3d{-0.7, -0.85 * 0.86, 11.6});
    const double lumen = 1 - smooth_step(0.5, 0.68, std::min(duodenum, gullet));
    c = mix(c, rgb(70, 14, 20), lumen);
    const double pores = cells3(p * 3.0, 44).nearest;
    return {c, std::clamp(0.42 + 0.22 * mottle + 0.12 * fine - 0.08 * pores + 0.4 * blood - 0.3 * lumen, 0.0, 1.0)};
}

/// The cloth at (u, v), repeated; the mean of four bilinear looks half a texel apart.
Colour cloth_at(const Picture& cloth, double u, double v) {
    const auto wrap = [](int k, int n) { return (k % n + n) % n; };
    const auto bilinear = [&](double x, double y) {
        const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
        const auto texel = [&](int a, int b) {
            return cloth.colour[cloth.at(wrap(i + a, cloth.width), wrap(j + b, cloth.height))];
        };
        return mix(mix(texel(0, 0), texel(1, 0), x - i), mix(texel(0, 1), texel(1, 1), x - i), y - j);
    };
    const double x = u * cloth.width, y = v * cloth.height;
    return (bilinear(x - 0.25, y - 0.25) + bilinear(x + 0.25, y - 0.25) + bilinear(x - 0.25, y + 0.25) +
            bilinear(x + 0.25, y + 0.25)) /
           4;
}
}  // namespace

Textured make_stomach(int texture_size) {
    const Stomach stomach;
    const Field field = [&stomach](const Vec3d& p) { return stomach.field(p); };
    PolyMesh mesh = mesh_zero_set(field, {{-12.4, -6.2, -10.2}, {11.2, 6.2, 14.2}, 0.40});
    orient_outward(mesh);
    project_to_atlas(mesh, texture_size);
    const VesselTree vessels(stomach);
    Picture picture = paint_atlas(mesh, texture_size, [&](const Vec3d& p) { return shade(stomach, vessels, p); });
    return {"stomach", 0.08, std::move(mesh), std::move(picture)};
}

Picture dress_stomach(const PolyMesh& mesh, const Picture& cloth, int texture_size) {
    constexpr double kTile = 12;   // centimetres of cloth in a tile's height
    constexpr double kAround = 2;  // tiles around the sack
    constexpr double kNarrow = 1;  // and around the oesophagus
    const Stomach stomach;
    return paint_atlas(mesh, texture_size, [&](const Vec3d& p) {
        const double apart = stomach.nearest(p).distance - stomach.nearest_of_oesophagus(p).distance;
        const bool sack = apart < 0;
        const Vec2d at = stomach.wrapped(p, sack ? stomach.sack() : stomach.oesophagus());
        const Colour colour = cloth_at(cloth, at.x * (sack ? kAround : kNarrow), at.y / kTile);
        return Shade{colour * (0.45 + 0.55 * smooth_step(0.02, 0.16, std::abs(apart))), 0.5};
    });
}

}  // namespace dgm::samples
