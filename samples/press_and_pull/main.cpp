// SPDX-License-Identifier: GPL-3.0-or-later
// samples/press_and_pull/main.cpp
// Paper, Fig. 11: tools press into an organ and pull at it, 1,000 times a second along a recorded path.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <dgm/deform.h>
#include <dgm/tick.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

// Centimetres around the contact that follow the tool, and the farthest it goes, unless the path says so.
constexpr TouchSize kTouch{4.5, 5, false};
constexpr std::uint32_t kSteps = 45;  // the same in steps of the kernel

void replay(const std::string& map, const std::string& path_file, const std::string& picture) {
    SoftBody organ(map);
    const ToolPath path(path_file);
    const Look skin{texture_of(map), 1, 0.3F};
    const TouchSize touch = path.touch_size().value_or(kTouch);
    // A bell that is 0, and lies flat, at the touch's size: no crease where the dent begins.
    const auto table = take(
        dgm::DeformTable::create({.end = dgm::KernelEnd::Compact, .sigma = kSteps * kSteps / 5.0F, .reach = kSteps}),
        "kernel");
    const dgm::TickOptions options{.d_max = static_cast<float>(touch.d_max),
                                   .f_max = 3,  // newtons
                                   .grasp_distance = path.touch_size() ? static_cast<float>(touch.size) : 0,
                                   .footprint = dgm::Footprint::Geodesic,
                                   .mode = touch.stays ? dgm::DeformMode::Plastic : dgm::DeformMode::Elastic,
                                   .step = static_cast<float>(touch.size / kSteps)};

    Strip strip({20, 14, dgm::render::UpAxis::kZ}, 4, 400);
    dgm::ToolOutput felt[dgm::formats::kMostTools];
    std::vector<Knot> tools;
    float strongest = 0;
    std::size_t ticks = 0, moved = 0;
    path.replay(
        1e-3,
        [&](std::span<const Knot> knots, float) {
            tools.assign(knots.begin(), knots.end());
            moved += take(dgm::tick(organ.state(), table, options, organ.inputs(knots), felt), "tick").samples;
            for (std::size_t k = 0; k < knots.size(); ++k)
                strongest = std::max(strongest, std::sqrt(dot(felt[k].force, felt[k].force)));
            ++ticks;
        },
        [&](const std::string& caption) {
            Scene scene;
            scene.add(organ.vertices(), organ.triangles(), skin);
            for (const Knot& tool : tools)  // the first one is drawn wherever it is, others while they touch
                if (tool.tool == 0 || tool.engaged) scene.add_ball(tool.position, 0.35F, {206, 210, 216, 255});
            strip.add(std::move(scene), caption);
        });
    strip.write(picture);
    std::printf("%zu ticks, %zu samples moved in each on the average, strongest force %.2f N\n", ticks, moved / ticks,
                double{strongest});
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: press_and_pull ORGAN.dgm PATH.txt OUT.png\n");
        return 1;
    }
    return run_sample("press_and_pull", [&] { replay(argv[1], argv[2], argv[3]); });
}
