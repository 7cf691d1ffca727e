// SPDX-License-Identifier: GPL-3.0-or-later
// samples/lay_on_table/main.cpp
// Fingers lay an organ on its back on a table and let go: its weight flattens it. Then a ball presses on it.
//
// The organs have their backs at +y, so that is where the table is and where gravity pulls; pictures are turned.
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/heavy_organ.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr float kTable = 4.8F, kBall = 1.5F,
                kHand = 3;  // centimetres: y of the table; radii of the ball and of what is held

dgm::Vec3 turned(dgm::Vec3 v) {
    return {v.x, v.z, kTable - v.y};
}
std::vector<Vertex> turned(std::vector<Vertex> vertices) {
    for (Vertex& v : vertices) {
        const dgm::Vec3 at = turned({v.position[0], v.position[1], v.position[2]});
        const float place[3] = {at.x, at.y, at.z}, normal[3] = {v.normal[0], v.normal[2], -v.normal[1]};
        for (int c = 0; c < 3; ++c) {
            v.position[c] = place[c];
            v.normal[c] = normal[c];
        }
    }
    return vertices;
}

void replay(const std::string& map, const std::string& path_file, const std::string& picture) {
    HeavyOrgan organ(map);
    const dgm::Obstacle table{.point = organ.body().local({0, kTable, 0}), .normal = {0, -1, 0}};
    organ.how().gravity = {0, 9.81F, 0};
    organ.how().obstacles = {&table, 1};
    const ToolPath path = path_of_one_tool(path_file);
    const Look skin{texture_of(map), 1, 0.3F};
    Strip strip({-25, 20, dgm::render::UpAxis::kZ}, 3, 500);
    Knot tool;
    dgm::StepReport report;
    path.replay(
        HeavyOrgan::kStep,
        [&](std::span<const Knot> knots, float) {
            tool = knots[0];
            organ.how().tool_radius = tool.kind == dgm::ToolKind::Grasp ? kHand : kBall;
            report = organ.step(knots);
        },
        [&](const std::string& caption) {
            Scene scene;
            scene.add(turned(organ.body().vertices()), organ.body().triangles(), skin);
            if (tool.engaged)
                scene.add_ball(turned(tool.position), tool.kind == dgm::ToolKind::Grasp ? 0.5F : kBall,
                               {206, 210, 216, 255});
            scene.add_table({0, 2, 0}, 15, 0.8F, {196, 200, 204, 255});
            strip.add(std::move(scene), caption);
            std::printf("%s: %u samples touch, %.1e J of motion\n", caption.c_str(), report.contacts, report.kinetic);
        });
    strip.write(picture);
    std::printf("%zu steps of 1 ms, strongest force %.2f N, volume kept to %.1e\n", organ.steps(), organ.strongest(),
                organ.swelling());
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: lay_on_table ORGAN.dgm PATH.txt OUT.png\n");
        return 1;
    }
    return run_sample("lay_on_table", [&] { replay(argv[1], argv[2], argv[3]); });
}
