// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/footprint_error.cpp
// footprint_error MAP.dgm CONTACTS SIGMA REACH: footprints beside exact geodesics on the same triangles [Xin and Wang
// 2009, by CGAL], worst case first. Contacts lie all over each chart, on its border and at its corners.
//
// For each footprint and for contacts near the border (within the reach of it, in grid steps) and elsewhere it prints
// one line of JSON: the largest and median error of a weight, in shares of the peak; the farthest sample that moves, in
// reaches; the farthest that moves by more than half the depth, in half radii of the kernel, by straight lines; the
// largest difference between neighbours, over what the kernel's slope allows; touches cut short; torn seams.
//
// Shortest paths no longer than R stay within the ball of radius R around the contact, so the triangles that reach into
// a ball of 1.5 R are enough.
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
#include <cstring>
#include <map>
#include <set>
#include <vector>

namespace {
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Paths = CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>>;

constexpr dgm::Footprint kFootprints[] = {dgm::Footprint::Surface, dgm::Footprint::Geodesic, dgm::Footprint::Grid};
constexpr const char* kNames[] = {"surface", "geodesic", "grid"};

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

struct Worst {
    std::vector<double> errors;  ///< largest of each contact
    double farthest = 0, half = 0, jump = 0;
    std::uint32_t error_at = dgm::kNone, half_at = dgm::kNone, jump_at = dgm::kNone;
    int beyond_two = 0, truncated = 0, torn = 0;
};

class Measured {
 public:
    Measured(dgm::State& state, float sigma, std::uint32_t reach)
        : state_(state), sigma_(sigma), reach_(reach), triangles_(taken(dgm::mesh_counts(state)).indices) {
        dgm::KernelOptions kernel;
        kernel.sigma = sigma;
        kernel.reach = reach;
        kernel.end = dgm::KernelEnd::Compact;
        table_ = new dgm::DeformTable(taken(dgm::DeformTable::create(kernel)));
        static_cast<void>(taken(dgm::reconstruct(state, {}, triangles_)));
        for (float r = 0; r + 0.01f < static_cast<float>(reach); r += 0.01f)
            slope_ = std::max(slope_, std::fabs(table_->profile(r + 0.01f) - table_->profile(r)) / 0.01);
    }
    ~Measured() { delete table_; }
    Measured(const Measured&) = delete;
    Measured& operator=(const Measured&) = delete;

    void measure(std::uint32_t contact) {
        const std::map<std::uint32_t, double> exact = distances(contact);
        const bool border = near_border(contact);
        for (int f = 0; f < 3; ++f) touch(contact, f, exact, worst_[f][border]);
    }
    void print() const {
        for (int f = 0; f < 3; ++f)
            for (int border = 0; border < 2; ++border) {
                Worst w = worst_[f][border];
                if (w.errors.empty()) continue;
                std::sort(w.errors.begin(), w.errors.end());
                std::printf(
                    "{\"footprint\": \"%s\", \"near_border\": %s, \"contacts\": %zu, \"median\": %.5f, "
                    "\"largest\": %.5f, \"largest_at\": %u, \"farthest\": %.4f, \"half\": %.3f, \"half_at\": %u, "
                    "\"beyond_two\": %d, \"jump\": %.3f, \"jump_at\": %u, \"truncated\": %d, \"torn\": %d}\n",
                    kNames[f], border ? "true" : "false", w.errors.size(), w.errors[w.errors.size() / 2],
                    w.errors.back(), w.error_at, w.farthest, w.half, w.half_at, w.beyond_two, w.jump, w.jump_at,
                    w.truncated, w.torn);
            }
    }

 private:
    [[nodiscard]] std::uint32_t representative(std::uint32_t sample) const {
        const std::uint32_t id = state_.class_of(sample);
        return id == dgm::kNone ? sample : state_.class_members(id)[0];
    }
    [[nodiscard]] bool near_border(std::uint32_t contact) const {
        const std::uint32_t grid = state_.rows() * state_.cols();
        if (contact >= grid) return true;
        const std::uint32_t i = contact / state_.cols(), j = contact % state_.cols();
        return i < reach_ || j < reach_ || i + reach_ >= state_.rows() || j + reach_ >= state_.cols();
    }

    /// Exact distances, in kernel steps, of the representatives around; those farther than 1.4 reaches are left out.
    std::map<std::uint32_t, double> distances(std::uint32_t contact) {
        const dgm::PointView rest = state_.rest_positions();
        const double step = state_.mean_step(), radius = step * reach_;
        Mesh mesh;
        std::map<std::uint32_t, Mesh::Vertex_index> index;
        // Flat grids, where ways pass through many samples, bring CGAL's inexact constructions to free what they need.
        const auto generic = [&](std::uint32_t sample, std::uint32_t axis) {
            return 1e-5 * step * (((sample * 3 + axis) * 2654435769u >> 8) / double(1 << 24) - 0.5);
        };
        const auto vertex = [&](std::uint32_t sample) {
            const auto [entry, fresh] = index.try_emplace(representative(sample));
            const dgm::Vec3 p = rest[sample];
            if (fresh)
                entry->second =
                    mesh.add_vertex({p.x + generic(sample, 0), p.y + generic(sample, 1), p.z + generic(sample, 2)});
            return entry->second;
        };
        for (std::size_t t = 0; t < triangles_.size(); t += 3) {
            const std::uint32_t* f = &triangles_[t];
            if (std::none_of(f, f + 3, [&](auto s) { return distance(rest[s], rest[contact]) < 1.5 * radius; }))
                continue;
            if (representative(f[0]) == representative(f[1]) || representative(f[1]) == representative(f[2]) ||
                representative(f[2]) == representative(f[0]))
                continue;
            mesh.add_face(vertex(f[0]), vertex(f[1]), vertex(f[2]));
        }
        std::map<std::uint32_t, double> found;
        const auto source = index.find(representative(contact));
        if (source == index.end() || mesh.is_isolated(source->second)) return found;
        Paths paths(mesh);
        paths.add_source_point(source->second);
        paths.build_sequence_tree();
        for (const auto& [sample, v] : index) {
            if (mesh.is_isolated(v)) continue;
            const double d = paths.shortest_distance_to_source_points(v).first / step;
            if (d >= 0 && d < 1.4 * reach_) found[sample] = d;
        }
        return found;
    }

    void touch(std::uint32_t contact, int f, const std::map<std::uint32_t, double>& exact, Worst& worst) {
        if (exact.size() < 20) return;
        state_.reset();
        dgm::Touch push;
        push.sample = contact;
        push.displacement = {0, 0, 1};
        push.d_max = 1;
        push.footprint = kFootprints[f];
        const dgm::DeformReport done = taken(dgm::deform(state_, *table_, push));
        worst.truncated += done.truncated;
        const dgm::PointView now = state_.positions(), rest = state_.rest_positions();
        // Scaled up, since weights are differences of coordinates.
        const auto weight = [&](std::uint32_t s) { return double{now.z[s]} - double{rest.z[s]}; };
        const double step = state_.mean_step(), half_radius = std::sqrt(0.693 * double{sigma_}) * step;
        double error = 0, half = 0;
        for (std::uint32_t s = 0; s < state_.sample_count(); ++s) {
            const dgm::Vec3 p = now[s], q = now[representative(s)];
            worst.torn += std::memcmp(&p, &q, sizeof p) != 0;
            if (representative(s) != s || !state_.on_surface(s)) continue;
            const double w = weight(s);
            const auto at = exact.find(s);
            const double want = at == exact.end() ? 0 : double{table_->profile(static_cast<float>(at->second))};
            if (std::fabs(w - want) > error) {
                error = std::fabs(w - want);
                if (worst.errors.empty() || error > *std::max_element(worst.errors.begin(), worst.errors.end()))
                    worst.error_at = contact;
            }
            if (std::fabs(w) > 1e-5)
                worst.farthest = std::max(worst.farthest, at == exact.end() ? 99.0 : at->second / reach_);
            if (w > 0.5) half = std::max(half, distance(rest[s], rest[contact]) / half_radius);
        }
        worst.errors.push_back(error);
        if (half > worst.half) {
            worst.half = half;
            worst.half_at = contact;
        }
        worst.beyond_two += half > 2;
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            const std::uint32_t a = triangles_[t], b = triangles_[t % 3 == 2 ? t - 2 : t + 1];
            const double length = distance(rest[a], rest[b]) / step;
            const double jump = std::fabs(weight(a) - weight(b)) / (slope_ * length + 1e-5);
            if (jump > worst.jump) {
                worst.jump = jump;
                worst.jump_at = contact;
            }
        }
    }

    dgm::State& state_;
    float sigma_;
    std::uint32_t reach_;
    std::vector<std::uint32_t> triangles_;
    dgm::DeformTable* table_ = nullptr;
    double slope_ = 0;
    Worst worst_[3][2];
};

/// Samples all over the chart, on the border of its grid, at its corners, and border samples of a free domain.
std::set<std::uint32_t> contacts_of(const dgm::State& state, std::uint32_t count) {
    const std::uint32_t m = state.rows(), n = state.cols(), grid = m * n;
    std::set<std::uint32_t> found = {0, n - 1, grid - n, grid - 1};
    for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t row = static_cast<std::uint32_t>((k + 0.5) / count * m);
        found.insert(row * n + static_cast<std::uint32_t>(0.618034 * n * k) % n);
        if (k % 4 == 0) {
            found.insert(row * n);
            found.insert(row * n + n - 1);
        }
        if (k % 4 == 1) {
            found.insert(row % n);
            found.insert(grid - n + row % n);
        }
        if (k % 4 == 2) found.insert((1 + k % 5) * n + row % n);
        if (state.sample_count() > grid && k % 4 == 3)
            found.insert(grid + static_cast<std::uint32_t>((k + 0.5) / count * (state.sample_count() - grid)));
    }
    for (auto at = found.begin(); at != found.end();) at = state.on_surface(*at) ? std::next(at) : found.erase(at);
    return found;
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) return 1;
    const dgm::Asset asset = taken(dgm::Asset::open(argv[1]));
    for (std::uint32_t c = 0; c < asset.chart_count(); ++c) {
        dgm::State state = taken(dgm::State::create(taken(asset.chart(c))));
        Measured measured(state, static_cast<float>(std::atof(argv[3])),
                          static_cast<std::uint32_t>(std::atoi(argv[4])));
        for (const std::uint32_t contact : contacts_of(state, static_cast<std::uint32_t>(std::atoi(argv[2]))))
            measured.measure(contact);
        measured.print();
    }
    return 0;
}
