// SPDX-License-Identifier: GPL-3.0-or-later
// samples/set_on_plane/main.cpp
// Paper, Fig. 12: a stomach is laid on its back on a table by a recorded path (in its own frame the table rises). The
// volume below the table bulges out around the contact: the volume of the stomach stays.
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <dgm/contact.h>

#include "support/soft_body.h"
#include "support/strip.h"

namespace {
using namespace dgm::samples;

/// The organs have their backs at +y: turned about x, the back is below, and the table is where the eye keeps it.
std::vector<Vertex> lying(std::vector<Vertex> vertices, float table) {
    for (Vertex& v : vertices) {
        for (float* p : {v.position, v.normal}) {
            const float y = p[1];
            p[1] = p[2];
            p[2] = -y;
        }
        v.position[2] += table;
    }
    return vertices;
}

void replay(const std::string& map, const std::string& path_file, const std::string& picture) {
    SoftBody organ(map);
    const auto solver = take(dgm::ContactSolver::create(organ.state()), "contact");
    const ToolPath path = path_of_one_tool(path_file);
    const Look skin{texture_of(map), 1, 0.3F};
    const double volume = solver.volume(organ.state());

    Strip strip({-25, 24, dgm::render::UpAxis::kZ}, 3, 500);
    dgm::ContactReport report;
    dgm::Vec3 table;
    path.replay(
        1e-2,
        [&](std::span<const Knot> knots, float) {
            table = knots[0].position;
            organ.state().release();  // the contact is made anew at every tick, from the shape at rest
            report = take(dgm::resolve_contact(
                              organ.state(), solver,
                              {.kind = dgm::ObstacleKind::Plane, .point = organ.local(table), .normal = {0, -1, 0}}),
                          "contact");
            if (report.status == dgm::ContactStatus::Contact && !report.volume_kept)
                std::fprintf(stderr, "volume error %g at %g s\n", report.volume_error, knots[0].seconds);
        },
        [&](const std::string& caption) {
            Scene scene;
            scene.add(lying(organ.vertices(), table.y), organ.triangles(), skin);
            scene.add_table({0, 2, 0}, 14, 0.8F, {196, 200, 204, 255});
            strip.add(std::move(scene), caption);
            std::printf("%s: %u samples on the table, deepest %.2f cm, volume %.3f of %.3f cm3\n", caption.c_str(),
                        report.samples, double{report.deepest}, solver.volume(organ.state()), volume);
        });
    strip.write(picture);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: set_on_plane ORGAN.dgm PATH.txt OUT.png\n");
        return 1;
    }
    return run_sample("set_on_plane", [&] { replay(argv[1], argv[2], argv[3]); });
}
