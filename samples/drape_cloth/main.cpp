// SPDX-License-Identifier: GPL-3.0-or-later
// samples/drape_cloth/main.cpp
// A sheet with mass and material falls on a cushion or a seat, slides, folds and comes to rest.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <dgm/cloth.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr int kFrames = 150;
constexpr int kPictures[] = {0, 12, 20, 30, 45, 149};
constexpr float kThickness = 0.4F, kSmaller = 0.7F;  // centimetres

struct Box {
    dgm::Vec3 low{1e9F, 1e9F, 1e9F}, high{-1e9F, -1e9F, -1e9F};
};
Box box_of(SoftBody& body) {
    Box box;
    for (const Vertex& v : body.vertices()) {
        box.low = {std::min(box.low.x, v.position[0]), std::min(box.low.y, v.position[1]),
                   std::min(box.low.z, v.position[2])};
        box.high = {std::max(box.high.x, v.position[0]), std::max(box.high.y, v.position[1]),
                    std::max(box.high.z, v.position[2])};
    }
    return box;
}

dgm::ClothOptions denim() {
    dgm::ClothOptions options;
    options.metres_per_unit = 0.01;
    options.fabric = {.warp = 800, .weft = 800, .shear = 160, .bending = 4e-5F, .density = 0.3F, .damping = 0.5F};
    options.thickness = kThickness * 0.01F;
    options.self_contact = true;
    return options;
}

void drape(const std::string& sheet_map, const std::string& body_map, float stand, const std::string& picture) {
    SoftBody sheet(sheet_map), body(body_map);
    const Look cloth_look{texture_of(sheet_map), 1, 0.05F}, body_look{texture_of(body_map), 1, 0.2F};
    // The body stays under the middle of the sheet, which is 4 cm above it; the floor is `stand` below the body.
    const Box cloth_box = box_of(sheet), body_box = box_of(body);
    const dgm::Vec3 shift{(cloth_box.low.x + cloth_box.high.x - body_box.low.x - body_box.high.x) / 2,
                          (cloth_box.low.y + cloth_box.high.y - body_box.low.y - body_box.high.y) / 2,
                          cloth_box.low.z - 4 - body_box.high.z};
    const dgm::Vec3 floor{shift.x + (body_box.low.x + body_box.high.x) / 2,
                          shift.y + (body_box.low.y + body_box.high.y) / 2, body_box.low.z + shift.z - stand};

    dgm::Cloth cloth = take(dgm::Cloth::create(sheet.state(), denim()), "cloth");
    dgm::Obstacle things[2];
    things[0].kind = dgm::ObstacleKind::Surface;
    things[0].point = sheet.local(shift - body.local({}));
    things[0].surface = &body.state();
    things[1].point = sheet.local(floor);
    dgm::ClothStep how;
    how.gravity = {0, 0, -9.81F};
    how.friction = 0.4F;
    how.substeps = 4;
    how.obstacles = things;

    Strip strip({25, 18, dgm::render::UpAxis::kZ}, 3, 480);
    // Samples of the cloth stay outside; between them an edge of the body may show, so it is drawn a little smaller.
    std::vector<Vertex> below = body.vertices();
    for (Vertex& v : below) {
        v.position[0] += shift.x - kSmaller * v.normal[0];
        v.position[1] += shift.y - kSmaller * v.normal[1];
        v.position[2] += shift.z - kSmaller * v.normal[2];
    }
    dgm::ClothReport report;
    std::uint32_t touches = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        if (frame > 0) report = take(dgm::step(sheet.state(), cloth, how), "step");
        touches = std::max(touches, report.touches);
        if (std::find(std::begin(kPictures), std::end(kPictures), frame) == std::end(kPictures)) continue;
        sheet.state().update_normals();
        Scene scene;
        scene.add(below, body.triangles(), body_look);
        // The outer side of a skin as thick as that.
        std::vector<Vertex> skin = sheet.vertices();
        for (Vertex& v : skin)
            for (int axis = 0; axis < 3; ++axis) v.position[axis] += 0.5F * kThickness * v.normal[axis];
        scene.add(skin, sheet.triangles(), cloth_look);
        scene.add_table(floor, 75, 2, {190, 180, 165, 255});
        char caption[32];
        std::snprintf(caption, sizeof caption, "%.2f s", frame / 60.0);
        strip.add(std::move(scene), caption);
    }
    strip.write(picture);
    float deepest = 0;
    const dgm::PointView now = sheet.state().positions();
    for (std::uint32_t k = 0; k < now.count; ++k)
        for (const dgm::Obstacle& thing : things)
            deepest = std::max(deepest, -take(dgm::obstacle_distance(thing, now[k]), "distance").distance);
    std::printf("%d frames; at the end %u samples bear, %.1e J of motion, %u places kept apart at most, %.3f cm deep\n",
                kFrames, report.contacts, report.kinetic, touches, double{deepest});
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4 && argc != 5) {
        std::fprintf(stderr, "usage: drape_cloth SHEET.dgm BODY.dgm OUT.png [CENTIMETRES ABOVE THE FLOOR]\n");
        return 1;
    }
    return run_sample("drape_cloth", [&] {
        const float stand = argc == 5 ? std::strtof(argv[4], nullptr) : 0;
        if (!(stand >= 0 && stand <= 1000))
            throw dgm::model::Error(dgm::model::codes::kUsage, "the height is not in 0 .. 1000 cm", argv[4]);
        drape(argv[1], argv[2], stand, argv[3]);
    });
}
