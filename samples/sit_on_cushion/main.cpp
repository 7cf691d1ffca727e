// SPDX-License-Identifier: GPL-3.0-or-later
// samples/sit_on_cushion/main.cpp
// Paper, Fig. 17: a ball comes down on a cushion, or on a chair's seat, by a recorded path; with a third map, a cover
// lies over the cushion and gives way to both.
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <dgm/contact.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr float kBall = 9, kCloth = 0.3F;  // radius and thickness, centimetres

/// A body, its scratch memory for contacts and how it looks.
struct Pressed {
    explicit Pressed(const std::string& map)
        : body(map), solver(take(dgm::ContactSolver::create(body.state()), map)), look{texture_of(map), 1, 0} {}
    SoftBody body;
    dgm::ContactSolver solver;
    Look look;

    dgm::ContactReport resolve(const dgm::Obstacle& obstacle, const dgm::ContactOptions& options = {}) {
        return take(dgm::resolve_contact(body.state(), solver, obstacle, options), "contact");
    }
    /// The outer side of a skin as thick as that.
    void draw(Scene& scene, float thickness) const {
        std::vector<Vertex> vertices = body.vertices();
        for (Vertex& v : vertices)
            for (int axis = 0; axis < 3; ++axis) v.position[axis] += thickness * v.normal[axis];
        scene.add(vertices, body.triangles(), look);
    }
};

void replay(const std::string& map, const std::string& path_file, const std::string& picture, const char* cover_map) {
    Pressed cushion(map);
    std::unique_ptr<Pressed> cover;
    if (cover_map != nullptr) cover = std::make_unique<Pressed>(cover_map);
    const ToolPath path = path_of_one_tool(path_file);

    Strip strip({25, 26, dgm::render::UpAxis::kZ}, 3, 500);
    dgm::Vec3 ball;
    dgm::ContactReport report;
    const auto draw = [&](const std::string& caption, bool with_ball) {
        Scene scene;
        cushion.draw(scene, cover ? -2 * kCloth : 0);  // what is hidden must not show through
        if (cover) cover->draw(scene, kCloth);
        if (with_ball) scene.add_ball(ball, kBall, {206, 210, 216, 255});
        strip.add(std::move(scene), caption);
    };
    path.replay(
        0.1,
        [&](std::span<const Knot> knots, float) {
            ball = knots[0].position;
            const auto press = [&](Pressed& pressed, float radius, std::uint32_t smoothing) {
                return pressed.resolve(
                    {.kind = dgm::ObstacleKind::Sphere, .point = pressed.body.local(ball), .radius = radius},
                    {.smoothing = smoothing});
            };
            cushion.body.state().release();  // contacts are made anew at every tick, from the shape at rest
            report = press(cushion, cover ? kBall + 2 * kCloth : kBall, 0);
            if (!cover) return;
            cover->body.state().release();
            static_cast<void>(press(*cover, kBall + kCloth, 24));
            static_cast<void>(cover->resolve({.kind = dgm::ObstacleKind::Surface,
                                              .point = cover->body.local(dgm::Vec3{} - cushion.body.local({})),
                                              .surface = &cushion.body.state()}));
        },
        [&](const std::string& caption) {
            draw(caption, true);
            std::printf("%s: %u samples in contact, deepest %.2f cm, volume kept to %.0e of %.1f cm3 removed\n",
                        caption.c_str(), report.samples, double{report.deepest}, report.volume_error, report.removed);
        });
    draw("the same without the ball", false);
    strip.write(picture);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4 && argc != 5) {
        std::fprintf(stderr, "usage: sit_on_cushion CUSHION.dgm PATH.txt OUT.png [COVER.dgm]\n");
        return 1;
    }
    return run_sample("sit_on_cushion", [&] { replay(argv[1], argv[2], argv[3], argc == 5 ? argv[4] : nullptr); });
}
