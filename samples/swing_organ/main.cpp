// SPDX-License-Identifier: GPL-3.0-or-later
// samples/swing_organ/main.cpp
// Fingers hold an organ at one end: it hangs by its weight, and swings as they move.
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/heavy_organ.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr float kFingers = 2;  // centimetres around the fingers that they hold

void replay(const std::string& map, const std::string& path_file, const std::string& picture) {
    HeavyOrgan organ(map);
    organ.how().tool_radius = kFingers;
    organ.how().gravity = {0, 0, -9.81F};
    const ToolPath path(path_file);
    const Look skin{texture_of(map), 1, 0.3F};
    Strip strip({15, 8, dgm::render::UpAxis::kZ}, 6, 300);
    std::vector<Knot> tools;
    dgm::StepReport report;
    path.replay(
        HeavyOrgan::kStep,
        [&](std::span<const Knot> knots, float) {
            tools.assign(knots.begin(), knots.end());
            report = organ.step(knots);
        },
        [&](const std::string& caption) {
            Scene scene;
            scene.add(organ.body().vertices(), organ.body().triangles(), skin);
            for (const Knot& tool : tools) scene.add_ball(tool.position, 0.8F, {206, 210, 216, 255});
            strip.add(std::move(scene), caption);
        });
    strip.write(picture);
    std::printf("%zu steps of 1 ms, strongest force %.2f N, volume kept to %.1e, %.1e J of motion at the end\n",
                organ.steps(), organ.strongest(), organ.swelling(), report.kinetic);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: swing_organ ORGAN.dgm PATH.txt OUT.png\n");
        return 1;
    }
    return run_sample("swing_organ", [&] { replay(argv[1], argv[2], argv[3]); });
}
