// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/square_chart.cpp
#include "geometry/chart/square_chart.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/multilevel_map.h"
#include "geometry/parameterize/slim.h"
#include "geometry/parameterize/stretch_map.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

constexpr double kCrowded = 2;  // L2 stretch, of 1 at least
constexpr std::size_t kLevelSteps = 5;
constexpr double kLevelEpsilon = 0.6;

class StretchParameterizer final : public Parameterizer {
 public:
    explicit StretchParameterizer(std::size_t newton_steps) : newton_steps_(newton_steps) {}
    [[nodiscard]] std::string_view name() const override { return "stretch"; }
    [[nodiscard]] bool fixed_border() const override { return true; }
    [[nodiscard]] std::vector<Vec2d> solve(const DiskView& disk, const model::Progress& progress) const override {
        if (newton_steps_ == 0) return stretch_map(disk, 0, progress);
        std::optional<std::vector<Vec2d>> map = multilevel_stretch_map(disk, {}, progress);
        const auto energy = [&](const std::vector<Vec2d>& uv) {
            return stretch_energy(disk.positions, disk.faces, uv);
        };
        double area = 0;
        for (const Face& f : disk.faces)
            area += face_area({disk.positions[f[0]], disk.positions[f[1]], disk.positions[f[2]]});
        // Normalised stretch: the square has area 1.
        if (map && std::sqrt(energy(*map)) <= kCrowded * area) {
            // Faces sheared into slivers cost no stretch, but their samples fold; the other half of the energy levels
            // them.
            SlimOptions options;
            options.energy = FlipFreeEnergy::kStretch;
            options.border_fixed = true;
            options.iterations = kLevelSteps;
            options.stretch_epsilon = kLevelEpsilon;
            return descend_flip_free(disk, std::move(*map), options, progress);
        }
        std::vector<Vec2d> other = stretch_map(disk, newton_steps_, progress);
        return map && energy(*map) <= energy(other) ? std::move(*map) : other;
    }

 private:
    std::size_t newton_steps_;
};

class ReweightedParameterizer final : public Parameterizer {
 public:
    [[nodiscard]] std::string_view name() const override { return "reweighted"; }
    [[nodiscard]] bool fixed_border() const override { return true; }
    [[nodiscard]] std::vector<Vec2d> solve(const DiskView& disk, const model::Progress& progress) const override {
        return reweighted_stretch_map(disk, {}, progress);
    }
};

}  // namespace

std::unique_ptr<Parameterizer> make_reweighted_parameterizer() {
    return std::make_unique<ReweightedParameterizer>();
}

std::unique_ptr<Parameterizer> make_stretch_parameterizer(std::size_t newton_steps) {
    return std::make_unique<StretchParameterizer>(newton_steps);
}

void check_map(const Disk& disk, const std::vector<Vec2d>& uv, std::string_view method) {
    const MapMetrics metrics = measure_map(disk.mesh.positions, disk.mesh.faces, uv);
    const auto fail = [&](const std::string& what) {
        throw model::Error(model::codes::kMapInvalid, std::string(method) + ": " + what);
    };
    if (metrics.not_finite > 0) fail(std::to_string(metrics.not_finite) + " vertices have no finite map coordinates");
    if (metrics.flips > 0) fail(std::to_string(metrics.flips) + " faces are flipped in the map");
    if (metrics.degenerate > 0) fail(std::to_string(metrics.degenerate) + " faces have no area in the map");
}

SampledChart make_square_chart(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                               const Parameterizer& method, const model::Progress& progress) {
    const SquareBorder border = lay_square_border(disk, m, n, rotation);
    SampledChart chart;
    chart.m = m, chart.n = n;
    chart.method = method.name();
    chart.uv = method.solve({disk.mesh.positions, disk.mesh.faces, border.vertices, border.uv}, progress);
    check_map(disk, chart.uv, method.name());
    const SampleGrid fine = rasterize(disk.mesh.faces, chart.uv, 2 * m - 1, 2 * n - 1);
    if (fine.missing > 0)
        throw model::Error(model::codes::kMapInvalid, std::string(method.name()) + ": " + std::to_string(fine.missing) +
                                                          " grid points are covered by no face");
    chart.samples = coarsen(fine, m, n);
    chart.representative.resize(chart.samples.size());
    for (std::uint32_t s = 0; s < chart.representative.size(); ++s) chart.representative[s] = s;
    // The representative of a class is its lowest flat index, whichever place that has in the border cycle.
    std::vector<std::uint32_t> lowest(border.samples.size(), kNone);
    for (const BorderSample& s : border.samples) lowest[s.same_as] = std::min(lowest[s.same_as], s.index);
    for (const BorderSample& s : border.samples) {
        chart.samples[s.index] = s.at;
        chart.representative[s.index] = lowest[s.same_as];
    }
    chart.disk = std::move(disk);
    place_samples(chart);
    choose_diagonals(chart, fine);
    return chart;
}

}  // namespace dgm::bake
