// SPDX-License-Identifier: GPL-3.0-or-later
// samples/walk_in_skirt/main.cpp
// A skirt on hips that start to walk: its waistband is pinned to them, its folds are carried by the thighs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <dgm/cloth.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr int kHangs = 90, kWalks = 150;  // frames
constexpr int kPictures[] = {0, 89, 125, 143, 160, 177, 193, 227};
constexpr float kThickness = 0.4F;                             // centimetres
constexpr double kSteps = 0.9, kStride = 0.5, kWaddle = 0.15;  // Hz, radians
constexpr dgm::model::Rgba8 kSkin{205, 170, 150, 255};

/// A pelvis and two thighs, in centimetres; the waist is at z = 0.
class Hips {
 public:
    /// After so many seconds of walking; the first of them make the way longer.
    void place(double t) {
        const double phase = 6.283185307179586 * kSteps * t, part = std::min(1.0, t);
        turn_ = kWaddle * part * std::sin(phase);
        limbs_[0] = capsule(at({-6, 0, -6}), at({6, 0, -6}), 9.5F);
        for (const int side : {-1, 1}) {
            const double swing = side * kStride * part * std::sin(phase);
            const dgm::Vec3 hip{side * 7.0F, 0, -10};
            const dgm::Vec3 thigh{0, float(-40 * std::sin(swing)), float(-40 * std::cos(swing))};
            limbs_[side < 0 ? 1 : 2] = capsule(at(hip), at(hip + thigh), 7.5F);
        }
    }
    /// Where what was there at rest is now.
    [[nodiscard]] dgm::Vec3 at(dgm::Vec3 p) const {
        const double c = std::cos(turn_), s = std::sin(turn_), x = double{p.x}, y = double{p.y};
        return {float(c * x - s * y), float(s * x + c * y), p.z};
    }
    [[nodiscard]] const dgm::Obstacle (&limbs() const)[3] { return limbs_; }

 private:
    static dgm::Obstacle capsule(dgm::Vec3 a, dgm::Vec3 b, float radius) {
        return {.kind = dgm::ObstacleKind::Capsule, .point = a, .end = b, .radius = radius};
    }
    double turn_ = 0;
    dgm::Obstacle limbs_[3];
};

/// Samples of the waist, one of each class: copies of a seam are in the same place.
std::vector<dgm::Pin> waist_of(const dgm::State& skirt, dgm::Vec3 origin) {
    std::vector<dgm::Pin> pins;
    std::set<std::tuple<float, float, float>> places;
    const dgm::PointView rest = skirt.positions();
    for (std::uint32_t k = 0; k < rest.count; ++k)
        if (rest[k].z - origin.z > -0.25F && places.emplace(rest[k].x, rest[k].y, rest[k].z).second)
            pins.push_back({k, rest[k]});
    return pins;
}

void walk(const std::string& map, const std::string& picture) {
    SoftBody skirt(map);
    const dgm::Vec3 origin = skirt.local({});
    const Look look{texture_of(map), 1, 0.05F};
    dgm::ClothOptions options;
    options.metres_per_unit = 0.01;
    options.fabric = {.warp = 400, .weft = 400, .shear = 80, .bending = 1e-5F, .density = 0.25F, .damping = 0.5F};
    options.thickness = kThickness * 0.01F;
    options.self_contact = true;
    dgm::Cloth cloth = take(dgm::Cloth::create(skirt.state(), options), "cloth");

    Hips hips;
    const std::vector<dgm::Pin> waist = waist_of(skirt.state(), origin);
    std::vector<dgm::Pin> pins = waist;
    dgm::ClothStep how;
    how.gravity = {0, 0, -9.81F};
    how.friction = 0.4F;
    how.substeps = 4;
    how.cycles = 2;
    Strip strip({25, 12, dgm::render::UpAxis::kZ}, 4, 400);
    std::uint32_t most = 0;
    float deepest = 0, lowest = 0, highest = -1e9F;
    for (int frame = 0; frame < kHangs + kWalks; ++frame) {
        hips.place(std::max(0, frame - kHangs + 1) / 60.0);
        dgm::Obstacle limbs[3];
        std::copy(std::begin(hips.limbs()), std::end(hips.limbs()), limbs);
        for (dgm::Obstacle& limb : limbs) {
            limb.point = limb.point + origin;
            limb.end = limb.end + origin;
        }
        for (std::size_t k = 0; k < pins.size(); ++k) pins[k].position = hips.at(waist[k].position - origin) + origin;
        how.pins = pins;
        how.obstacles = limbs;
        most = std::max(most, take(dgm::step(skirt.state(), cloth, how), "step").contacts);
        const dgm::PointView now = skirt.state().positions();
        float hem = 1e9F;
        for (std::uint32_t k = 0; k < now.count; ++k) {
            hem = std::min(hem, now[k].z - origin.z);
            for (const dgm::Obstacle& limb : limbs)
                deepest = std::max(deepest, -take(dgm::obstacle_distance(limb, now[k]), "distance").distance);
        }
        if (frame >= kHangs) {
            lowest = std::min(lowest, hem);
            highest = std::max(highest, hem);
        }
        if (std::find(std::begin(kPictures), std::end(kPictures), frame) == std::end(kPictures)) continue;
        skirt.state().update_normals();
        Scene scene;
        for (const dgm::Obstacle& limb : hips.limbs()) scene.add_rod(limb.point, limb.end, limb.radius, kSkin);
        scene.add(skirt.vertices(), skirt.triangles(), look);
        char caption[32];
        std::snprintf(caption, sizeof caption, "%.2f s", (frame + 1) / 60.0);
        strip.add(std::move(scene), caption);
    }
    strip.write(picture);
    std::printf("%d frames; at most %u samples bear, %.3f cm deep; hem between %.1f and %.1f cm\n", kHangs + kWalks,
                most, double{deepest}, double{lowest}, double{highest});
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: walk_in_skirt SKIRT.dgm OUT.png\n");
        return 1;
    }
    return run_sample("walk_in_skirt", [&] { walk(argv[1], argv[2]); });
}
