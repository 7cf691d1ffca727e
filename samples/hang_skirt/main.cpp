// SPDX-License-Identifier: GPL-3.0-or-later
// samples/hang_skirt/main.cpp
// A skirt hangs from its waist, falls on the hips in it and folds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <dgm/cloth.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr int kFrames = 150;
constexpr int kPictures[] = {0, 8, 16, 30, 60, 149};

void hang(const std::string& skirt_map, const std::string& hips_map, const std::string& picture) {
    SoftBody skirt(skirt_map), hips(hips_map);
    const Look cloth_look{texture_of(skirt_map), 3, 0.05F}, hips_look{texture_of(hips_map), 1, 0.2F};
    dgm::ClothOptions options;
    options.metres_per_unit = 0.01;
    options.fabric = {.warp = 800, .weft = 800, .shear = 160, .bending = 2e-5F, .density = 0.25F, .damping = 1};
    options.thickness = 4e-3F;
    options.self_contact = true;
    dgm::Cloth cloth = take(dgm::Cloth::create(skirt.state(), options), "cloth");
    dgm::Obstacle body;
    body.kind = dgm::ObstacleKind::Surface;
    body.point = skirt.local(dgm::Vec3{} - hips.local({}));
    body.surface = &hips.state();
    // The band at the waist, z = 0 in the mesh's frame, is held; a class by its first sample.
    std::vector<dgm::Pin> band;
    const std::vector<Vertex> rest = skirt.vertices();
    for (std::uint32_t k = 0; k < rest.size(); ++k) {
        const std::uint32_t id = skirt.state().class_of(k);
        const bool first = id == dgm::kNone || skirt.state().class_members(id)[0] == k;
        if (first && rest[k].position[2] > -0.1F) band.push_back({k, skirt.state().positions()[k]});
    }
    dgm::ClothStep how;
    how.gravity = {0, 0, -9.81F};
    how.substeps = 4;
    how.cycles = 2;
    how.obstacles = {&body, 1};
    how.pins = band;

    Strip strip({25, 12, dgm::render::UpAxis::kZ}, 3, 480);
    dgm::ClothReport report;
    std::uint32_t touches = 0;
    const int* next = kPictures;
    for (int frame = 0; frame < kFrames; ++frame) {
        if (frame > 0) report = take(dgm::step(skirt.state(), cloth, how), "step");
        touches = std::max(touches, report.touches);
        if (frame != *next) continue;
        ++next;
        skirt.state().update_normals();
        Scene scene;
        scene.add(hips.vertices(), hips.triangles(), hips_look);
        scene.add(skirt.vertices(), skirt.triangles(), cloth_look);
        char caption[32];
        std::snprintf(caption, sizeof caption, "%.2f s", frame / 60.0);
        strip.add(std::move(scene), caption);
    }
    strip.write(picture);
    double hem = 0;
    const std::vector<Vertex> now = skirt.vertices();
    for (const Vertex& v : now) hem = std::max(hem, std::hypot(double{v.position[0]}, double{v.position[1]}));
    std::printf(
        "%d frames; %zu samples held, widest %.1f cm from the axis, %.1e J of motion, %u places kept apart at most\n",
        kFrames, band.size(), hem, report.kinetic, touches);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: hang_skirt SKIRT.dgm HIPS.dgm OUT.png\n");
        return 1;
    }
    return run_sample("hang_skirt", [&] { hang(argv[1], argv[2], argv[3]); });
}
