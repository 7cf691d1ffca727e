// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/solvers_bench.cpp
// dgm-bench-solvers [--tips N] MESH...: our free-border solvers beside CGAL's, on the same disks, one after the other.
//
// The largest component of each mesh is cut to a disk, and N times more to the vertex farthest from the cut (default
// 0). Times are CPU seconds of this process from the disk to the map, repair of flips included on our side. `energy` is
// what the method lowers: ARAP: area-weighted mean of |J - R|^2; LSCM: mean angle distortion (1 is conformal); SLIM:
// mean of (s1^2 + s2^2 + s1^-2 + s2^-2) / 4 (1 is isometric).
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/cut/cut_graph.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/free_maps.h"
#include "geometry/parameterize/free_methods.h"
#include "geometry/parameterize/slim.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"
#include "reference/cgal_reference.h"

namespace dgm::bake {
namespace {
using Map = std::optional<std::vector<Vec2d>>;

double cpu_seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Timed {
    Map map;
    double seconds = 0;
};

Timed timed(const std::function<Map()>& solve) {
    Timed out;
    const double start = cpu_seconds();
    out.map = solve();
    out.seconds = cpu_seconds() - start;
    return out;
}

std::string row(std::string_view name, const Timed& t, double reference_seconds, double energy, std::size_t flips) {
    const std::string ratio = reference_seconds > 0 ? fmt::format("{:.1f}x", reference_seconds / t.seconds) : "";
    if (!t.map) return fmt::format("  {:<22} {:>9.3f} s {:>8}  failed\n", name, t.seconds, ratio);
    return fmt::format("  {:<22} {:>9.3f} s {:>8}  energy {:<10.6g} flips {}\n", name, t.seconds, ratio, energy, flips);
}

void bench(const std::string& path, int tips) {
    const RepairedMesh repaired = repair(formats::read_mesh(path).mesh);
    const auto largest =
        std::max_element(repaired.components.begin(), repaired.components.end(),
                         [](const TriMesh& a, const TriMesh& b) { return a.faces.size() < b.faces.size(); });
    CutGraph cut(*largest);
    cut.cut_to_disk();
    for (int k = 0; k < tips; ++k) {
        const std::vector<double> distance = cut.distance_to_cut();
        const auto tip = std::max_element(distance.begin(), distance.end());
        if (*tip > 0) cut.join(static_cast<std::uint32_t>(tip - distance.begin()));
    }
    Disk disk = cut.open();
    if (const std::vector<std::uint32_t> edges = disk.border(); edges.size() == 2) disk.split(edges.front(), 0.5);
    std::vector<std::uint32_t> border;
    for (const std::uint32_t h : disk.border()) border.push_back(origin(disk.mesh.faces, h));
    const DiskView view{disk.mesh.positions, disk.mesh.faces, border, {}};
    fmt::print("{}: {} faces, {} vertices, {} on the border\n", path, view.faces.size(), view.positions.size(),
               border.size());

    const auto flips = [&](const Timed& t) { return t.map ? count_not_positive(view.faces, *t.map) : 0; };
    const auto rigid = [&](const Timed& t) { return t.map ? arap_energy(view, *t.map) : 0; };
    const auto angle = [&](const Timed& t) {
        return t.map ? measure_map(view.positions, view.faces, *t.map).angle : 0;
    };
    const auto dirichlet = [&](const Timed& t) {
        return t.map ? measure_map(view.positions, view.faces, *t.map).symmetric_dirichlet : 0;
    };
    const model::Progress silent;
    const auto ours = [&](std::string_view method) {
        return timed([&]() -> Map { return make_free_parameterizer(method)->solve(view, silent); });
    };
    const Timed their_arap = timed([&] { return cgal_default_arap(view); });
    const Timed plain_arap =
        timed([&]() -> Map { return arap_map(view, harmonic_disk_map(view, silent), {}, silent); });
    const Timed our_arap = ours("arap");
    fmt::print("{}", row("ARAP  CGAL default", their_arap, 0, rigid(their_arap), flips(their_arap)));
    fmt::print("{}",
               row("ARAP  ours, unrepaired", plain_arap, their_arap.seconds, rigid(plain_arap), flips(plain_arap)));
    fmt::print("{}", row("ARAP  ours", our_arap, their_arap.seconds, rigid(our_arap), flips(our_arap)));
    const Timed their_lscm = timed([&] { return cgal_default_lscm(view); });
    const Timed our_lscm = ours("lscm");
    fmt::print("{}", row("LSCM  CGAL default", their_lscm, 0, angle(their_lscm), flips(their_lscm)));
    fmt::print("{}", row("LSCM  ours", our_lscm, their_lscm.seconds, angle(our_lscm), flips(our_lscm)));
    const Timed slim = ours("slim");
    fmt::print("{}", row("SLIM  ours", slim, 0, dirichlet(slim), flips(slim)));
    std::fflush(stdout);
}
}  // namespace
}  // namespace dgm::bake

int main(int argc, char** argv) {
    int tips = 0, failed = 0, first = 1;
    if (argc > 3 && std::string(argv[1]) == "--tips") {
        tips = std::clamp(std::atoi(argv[2]), 0, 100);
        first = 3;
    }
    if (first >= argc) {
        fmt::print(stderr, "usage: dgm-bench-solvers [--tips N] MESH...\n");
        return 1;
    }
    for (int k = first; k < argc; ++k) try {
            dgm::bake::bench(argv[k], tips);
        } catch (const std::exception& e) {
            fmt::print(stderr, "{}: {}\n", argv[k], e.what());
            failed = 3;
        }
    return failed;
}
