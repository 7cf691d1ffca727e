// SPDX-License-Identifier: GPL-3.0-or-later
// samples/swap_cloth/main.cpp
// Paper, Figs. 13 and 14: a body in jeans, then in satin, while a tool presses it and pulls at it. The shape comes from
// one map; each cloth is the texture layer of another one, put on while the body moves.
#include <cstdio>
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

constexpr float kReach = 5;           // centimetres around the contact that follow the tool
constexpr std::uint32_t kSteps = 45;  // the same in steps of the kernel

void replay(const std::string& map, const std::string& path_file, const std::string& picture,
            std::span<char* const> cloths) {
    SoftBody body(map);
    const ToolPath path(path_file);
    const auto table = take(
        dgm::DeformTable::create({.end = dgm::KernelEnd::Compact, .sigma = kSteps * kSteps / 5.0F, .reach = kSteps}),
        "kernel");
    const dgm::TickOptions options{.d_max = 5, .footprint = dgm::Footprint::Geodesic, .step = kReach / kSteps};

    std::vector<Look> wardrobe;
    // Without highlights: cloth has its sheen in its picture, and a white one over dark folds of satin looks like dust.
    for (const char* cloth : cloths) wardrobe.push_back({texture_of(cloth), 1, 0});
    std::size_t pictures = 0;
    for (const Knot& knot : path.knots()) pictures += !knot.caption.empty();
    Strip strip({15, 14, dgm::render::UpAxis::kZ}, static_cast<std::uint32_t>(pictures), 480);
    for (const Look& cloth : wardrobe) {
        std::vector<Knot> tools;
        path.replay(
            1e-3,
            [&](std::span<const Knot> knots, float) {
                tools.assign(knots.begin(), knots.end());
                static_cast<void>(take(dgm::tick(body.state(), table, options, body.inputs(knots), {}), "tick"));
            },
            [&](const std::string& caption) {
                Scene scene;
                scene.add(body.vertices(), body.triangles(), cloth);
                for (const Knot& tool : tools)
                    if (tool.tool == 0 || tool.engaged) scene.add_ball(tool.position, 0.35F, {206, 210, 216, 255});
                strip.add(std::move(scene), caption);
            });
        body.state().reset();
    }
    strip.write(picture);
    std::printf("%zu cloths on %u samples\n", wardrobe.size(), body.state().sample_count());
}
}  // namespace

int main(int argc, char** argv) {
    if (argc < 5) {
        std::fprintf(stderr, "usage: swap_cloth BODY.dgm PATH.txt OUT.png CLOTH.dgm...\n");
        return 1;
    }
    return run_sample("swap_cloth", [&] { replay(argv[1], argv[2], argv[3], std::span(argv + 4, argv + argc)); });
}
