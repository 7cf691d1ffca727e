// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/geodesic_error.cpp
// geodesic_error MAP.dgm CONTACTS: how far weights of Footprint::Geodesic are from those of exact geodesics on the same
// triangles [Xin and Wang 2009, by CGAL], about a thousand samples in reach of each of some contacts all over the
// chart. Prints, of the largest error of every contact: the median, the 90th percentile and the largest, in shares of
// the peak.
//
// Shortest paths no longer than R stay within the ball of radius R around the contact, so the triangles that reach into
// a ball of 1.3 R are enough.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>
#include <dgm/deform.h>
#include <dgm/reconstruct.h>
#include <dgm/state.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

namespace {
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Paths = CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>>;

constexpr std::uint32_t kReach = 17;  // pi 17.5^2 = 962 samples where the grid is even
constexpr float kSigma = 72;

template <class T>
T taken(dgm::Result<T> result) {
    if (!result) {
        std::fprintf(stderr, "%s\n", result.error().message);
        std::exit(3);
    }
    return std::move(result).value();
}

double distance(dgm::Vec3 a, dgm::Vec3 b) {
    return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

class Measured {
 public:
    explicit Measured(dgm::State& state)
        : state_(state),
          table_(taken(dgm::DeformTable::create({.sigma = kSigma, .reach = kReach}))),
          triangles_(taken(dgm::mesh_counts(state)).indices) {
        static_cast<void>(taken(dgm::reconstruct(state, {}, triangles_)));
    }

    /// Largest difference of weights around `contact`; negative if fewer than 300 samples are in reach.
    double error_at(std::uint32_t contact) {
        const float step = state_.mean_step();
        const double radius = double{step} * kReach;
        const dgm::PointView rest = state_.rest_positions();
        state_.reset();
        const auto done = taken(dgm::deform(state_, table_,
                                            {.sample = contact,
                                             .displacement = {0, 0, 1},
                                             .d_max = 1,
                                             .footprint = dgm::Footprint::Geodesic,
                                             .step = step}));
        if (done.samples < 300 || done.truncated) return -1;

        Mesh mesh;
        std::map<std::uint32_t, Mesh::Vertex_index> index;  // by representative
        const auto vertex = [&](std::uint32_t sample) {
            const auto [entry, fresh] = index.try_emplace(representative(sample));
            const dgm::Vec3 p = rest[sample];
            if (fresh) entry->second = mesh.add_vertex({p.x, p.y, p.z});
            return entry->second;
        };
        for (std::size_t t = 0; t < triangles_.size(); t += 3) {
            const std::uint32_t* f = &triangles_[t];
            if (std::none_of(f, f + 3, [&](auto s) { return distance(rest[s], rest[contact]) < 1.3 * radius; }))
                continue;
            if (representative(f[0]) == representative(f[1]) || representative(f[1]) == representative(f[2]) ||
                representative(f[2]) == representative(f[0]))
                continue;
            mesh.add_face(vertex(f[0]), vertex(f[1]), vertex(f[2]));
        }
        Paths paths(mesh);
        paths.add_source_point(index.at(representative(contact)));
        paths.build_sequence_tree();
        double worst = 0;
        for (const auto& [sample, v] : index) {
            if (mesh.is_isolated(v)) continue;
            const double d = paths.shortest_distance_to_source_points(v).first / double{step};
            if (!(d >= 0) || std::fabs(d - kReach) < 0.3) continue;  // at the window's rim the kernel has its step
            const double want = d < kReach ? std::exp(-d * d / double{kSigma}) : 0;
            const double got = double{state_.positions()[sample].z} - double{rest[sample].z};
            worst = std::max(worst, std::fabs(got - want));
        }
        return worst;
    }

 private:
    [[nodiscard]] std::uint32_t representative(std::uint32_t sample) const {
        const std::uint32_t id = state_.class_of(sample);
        return id == dgm::kNone ? sample : state_.class_members(id)[0];
    }

    dgm::State& state_;
    dgm::DeformTable table_;
    std::vector<std::uint32_t> triangles_;
};
}  // namespace

int main(int argc, char** argv) {
    const int contacts = argc == 3 ? std::atoi(argv[2]) : 0;
    if (contacts < 1) return 1;
    const dgm::Asset asset = taken(dgm::Asset::open(argv[1]));
    dgm::State state = taken(dgm::State::create(taken(asset.chart(0))));
    Measured measured(state);
    std::vector<double> errors;
    for (int k = 0; k < contacts; ++k) {
        const auto sample = static_cast<std::uint32_t>((k + 0.5) / contacts * state.sample_count());
        const std::uint32_t across = static_cast<std::uint32_t>(0.618034 * state.cols() * k) % state.cols();
        const std::uint32_t contact = std::min(sample - sample % state.cols() + across, state.sample_count() - 1);
        if (!state.on_surface(contact)) continue;
        const double error = measured.error_at(contact);
        if (error >= 0) errors.push_back(error);
    }
    if (errors.empty()) return 3;
    std::sort(errors.begin(), errors.end());
    std::printf("%zu %.5f %.5f %.5f\n", errors.size(), errors[errors.size() / 2], errors[errors.size() * 9 / 10],
                errors.back());
    return 0;
}
