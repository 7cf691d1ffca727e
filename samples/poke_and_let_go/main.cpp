// SPDX-License-Identifier: GPL-3.0-or-later
// samples/poke_and_let_go/main.cpp
// An organ with mass and material: a ball presses into it and leaves, fingers pull at it and let go, and it swings.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <dgm/physics.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr float kBall = 1.2F;  // centimetres
constexpr double kStep = 1e-3;

void replay(const std::string& map, const std::string& path_file, const std::string& picture) {
    SoftBody organ(map);
    const ToolPath path(path_file);
    const Look skin{texture_of(map), 1, 0.3F};
    // Unit and material are those of the file. Flesh is not elastic alone: its swing dies within a few rounds.
    dgm::PhysicsOptions options;
    options.material = dgm::stored_material(organ.state()).material.value_or(dgm::Material{});
    options.material->viscosity = std::max(options.material->viscosity, 2e-3F);
    options.dt = static_cast<float>(kStep);
    dgm::Physics physics = take(dgm::Physics::create(organ.state(), options), "physics");
    dgm::StepOptions how;
    how.cycles = 5;
    how.tool_radius = kBall;

    Strip strip({20, 14, dgm::render::UpAxis::kZ}, 4, 400);
    dgm::StepTool felt[dgm::formats::kMostTools];
    std::vector<Knot> tools;
    double strongest = 0, swelling = 0, most = 0, left = 0, far = 0;
    std::size_t steps = 0;
    path.replay(
        kStep,
        [&](std::span<const Knot> knots, float) {
            tools.assign(knots.begin(), knots.end());
            const dgm::StepReport report =
                take(dgm::step(organ.state(), physics, how, organ.inputs(knots), felt), "step");
            organ.state().update_normals();
            for (std::size_t k = 0; k < knots.size(); ++k)
                strongest = std::max(strongest, std::sqrt(double{dot(felt[k].force, felt[k].force)}));
            swelling = std::max(swelling, std::fabs(report.volume_error));
            left = report.kinetic + report.elastic;
            most = std::max(most, left);
            ++steps;
        },
        [&](const std::string& caption) {
            Scene scene;
            scene.add(organ.vertices(), organ.triangles(), skin);
            for (const Knot& tool : tools)
                if (tool.engaged) scene.add_ball(tool.position, kBall, {206, 210, 216, 255});
            strip.add(std::move(scene), caption);
        });
    strip.write(picture);
    const dgm::PointView now = organ.state().positions(), rest = organ.state().rest_positions();
    for (std::uint32_t k = 0; k < now.count; ++k) {
        const dgm::Vec3 way = now[k] - rest[k];
        far = std::max(far, std::sqrt(double{dot(way, way)}));
    }
    std::printf(
        "%zu steps of 1 ms, strongest force %.2f N, volume kept to %.1e; at the end %.1e of %.1e J left, %.2f cm "
        "from rest\n",
        steps, strongest, swelling, left, most, far);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: poke_and_let_go ORGAN.dgm PATH.txt OUT.png\n");
        return 1;
    }
    return run_sample("poke_and_let_go", [&] { replay(argv[1], argv[2], argv[3]); });
}
