// SPDX-License-Identifier: GPL-3.0-or-later
// samples/record_path/main.cpp
// Writes down where over a map a tool went: the recording that `dgm-bench run` replays on any mesh.
//
//   dgm-bake stomach.obj -o stomach.dgm
//   record_path stomach.dgm paths/stomach_press_and_pull.txt > paths/recorded_touch.csv
#include <cmath>
#include <cstdio>
#include <span>
#include <string>

#include <dgm/collide.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

constexpr double kStep = 0.01;  // seconds a line; the replay goes straight between two

void record(const std::string& map, const std::string& path_file) {
    SoftBody body(map);
    const dgm::Chart chart = body.chart();
    const auto box = chart.bbox();
    const double diagonal = std::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
    const std::uint32_t grid = chart.rows() * chart.cols();
    std::printf(
        "# seconds, u, v: place in the map; height over the surface there, %% of the diagonal. By record_path.\n");
    double seconds = 0;
    path_of_one_tool(path_file).replay(
        kStep,
        [&](std::span<const Knot> knots, float dt) {
            const dgm::Vec3 tool = body.local(knots[0].position);
            const std::uint32_t s = take(dgm::nearest_sample(body.state(), tool), "nearest sample").sample;
            const double height = dot(tool - body.state().rest_positions()[s], body.state().normal(s));
            if (s < grid)  // border samples of a free chart have no row and column
                std::printf("%.3f,%.4f,%.4f,%.3f\n", seconds, double(s / chart.cols()) / (chart.rows() - 1),
                            double(s % chart.cols()) / (chart.cols() - 1), 100 * height / diagonal);
            seconds += double{dt};
        },
        [](const std::string&) {});
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: record_path ORGAN.dgm PATH.txt > RECORDED.csv\n");
        return 1;
    }
    return run_sample("record_path", [&] { record(argv[1], argv[2]); });
}
