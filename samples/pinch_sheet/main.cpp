// SPDX-License-Identifier: GPL-3.0-or-later
// samples/pinch_sheet/main.cpp
// Paper, Figs. 15 and 16: a flat sheet, pinched up and poked down, once by the circular kernel of eq. 7 and once by an
// elliptic one.
#include <cstdio>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include <dgm/deform.h>
#include <dgm/tick.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr std::uint32_t kReach = 65;  // b of eq. 7, in grid steps

void replay(const std::string& map, const std::string& path_file, const std::string& picture) {
    SoftBody sheet(map);
    const ToolPath path(path_file);
    const Look denim{texture_of(map), 3, 0.05F};
    const dgm::TickOptions options{.d_max = 20, .grasp_distance = 5};
    const dgm::KernelOptions kernels[] = {
        {.end = dgm::KernelEnd::Compact, .sigma = 900, .reach = kReach},
        {.shape = dgm::KernelShape::Elliptic,
         .end = dgm::KernelEnd::Compact,
         .reach = kReach,
         .radius_a = 30,
         .radius_b = 10,
         .angle = std::numbers::pi_v<float> / 4},
    };

    Strip strip({25, 28, dgm::render::UpAxis::kZ}, 2, 640);
    for (const dgm::KernelOptions& kernel : kernels) {
        const auto table = take(dgm::DeformTable::create(kernel), "kernel");
        path.replay(
            1e-3,
            [&](std::span<const Knot> knots, float) {
                static_cast<void>(take(dgm::tick(sheet.state(), table, options, sheet.inputs(knots), {}), "tick"));
            },
            [&](const std::string& caption) {
                Scene scene;
                scene.add(sheet.vertices(), sheet.triangles(), denim);
                strip.add(
                    std::move(scene),
                    (kernel.shape == dgm::KernelShape::Circular ? "circular kernel, " : "elliptic kernel, ") + caption);
            });
        sheet.state().reset();
        std::printf("kernel of reach %u, within %.1e of the formula\n", table.reach(), double{table.error_bound()});
    }
    strip.write(picture);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: pinch_sheet SHEET.dgm PATH.txt OUT.png\n");
        return 1;
    }
    return run_sample("pinch_sheet", [&] { replay(argv[1], argv[2], argv[3]); });
}
