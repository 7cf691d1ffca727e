// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/square_chart.cpp
#include "geometry/chart/square_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/cell_rectangle.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/curved_rest_shapes.h"
#include "geometry/parameterize/multilevel_map.h"
#include "geometry/parameterize/rest_shapes.h"
#include "geometry/parameterize/slim.h"
#include "geometry/parameterize/stretch_map.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

constexpr double kCrowded = 2;          // L2 stretch, of 1 at least
constexpr std::size_t kLarge = 25'000;  // faces: a crowded map of more is mended on a coarser level
constexpr std::size_t kLevelSteps = 5;
// The square of an error grows with the fourth power of the stretch, as in multilevel_map.h.
constexpr double kLevelPower = 4, kLevelEpsilon = 2;
constexpr std::size_t kFewFolds = 2;  // of a thousand triangles

class StretchParameterizer final : public Parameterizer {
 public:
    StretchParameterizer(std::size_t newton_steps, Levelling levelling, std::shared_ptr<StretchMemory> memory)
        : newton_steps_(newton_steps),
          levelling_(levelling),
          memory_(memory ? std::move(memory) : std::make_shared<StretchMemory>()) {}
    [[nodiscard]] std::string_view name() const override { return "stretch"; }
    [[nodiscard]] bool fixed_border() const override { return true; }
    [[nodiscard]] std::vector<Vec2d> solve(const DiskView& disk, const model::Progress& progress) const override {
        const CellRectangle cells(disk);
        std::vector<Vec2d> uv = cells.to_square(solved(cells, progress));
        if (disk.aspect == 1 || count_not_positive(disk.faces, uv) == 0) return uv;
        DiskView square = disk;  // rounding may turn faces of next to no area
        square.aspect = 1;
        return solved(CellRectangle(square), progress);
    }

    [[nodiscard]] std::optional<std::vector<Vec2d>> level(const DiskView& disk, const std::vector<Vec2d>& uv,
                                                          std::size_t step,
                                                          const model::Progress& progress) const override {
        const CellRectangle cells(disk);
        std::optional<std::vector<Vec2d>> out = levelled(cells.view(), cells.from_square(uv), step, progress);
        if (out) out = cells.to_square(std::move(*out));
        return out && count_not_positive(disk.faces, *out) == 0 ? std::move(out) : std::nullopt;
    }

 private:
    [[nodiscard]] std::vector<Vec2d> solved(const CellRectangle& cells, const model::Progress& progress) const {
        const DiskView& disk = cells.view();
        if (newton_steps_ == 0) return stretch_map(disk, 0, progress);
        const auto level_out = [&](const DiskView& on, std::vector<Vec2d> uv) {
            return level_map(on, std::move(uv), kLevelSteps, kLevelEpsilon, progress, rest_shapes_of(levelling_, on));
        };
        // The grid has far fewer samples than a large mesh has vertices: where they go is settled on a coarser level.
        // Levelling itself may stretch a map beyond kCrowded, so the map before it is tested.
        MultilevelOptions options;
        if (disk.faces.size() > options.finish_faces) {
            bool sound = true;
            options.finish = [&](const DiskView& on, std::vector<Vec2d> uv) {
                sound = !crowded(on, uv);
                return sound ? level_out(on, std::move(uv)) : uv;
            };
            std::optional<std::vector<Vec2d>> levelled =
                multilevel_stretch_map(disk, options, progress, &memory_->levels);
            if (levelled && sound) return std::move(*levelled);
        }
        std::vector<Vec2d> map = memory_->map ? cells.from_square(*memory_->map) : plain_map(disk, progress);
        if (count_not_positive(disk.faces, map) > 0) return map;  // the caller refuses it
        return level_out(disk, std::move(map));
    }

    [[nodiscard]] std::optional<std::vector<Vec2d>> levelled(const DiskView& disk, const std::vector<Vec2d>& uv,
                                                             std::size_t step, const model::Progress& progress) const {
        constexpr std::array<double, 3> kEpsilons{6, 20, 60};
        constexpr std::size_t kSteps = 12;
        if (newton_steps_ == 0 || step >= kEpsilons.size()) return std::nullopt;
        MultilevelOptions options;
        // Levelling for curvature is given up; to give up its directions would be to make the plain map again.
        const auto rest = [&](const DiskView& on) {
            return levelling_ == Levelling::kDirections ? rest_shapes_of(levelling_, on) : std::vector<RestShape>{};
        };
        if (disk.faces.size() <= options.finish_faces)
            return level_map(disk, uv, kSteps, kEpsilons[step], progress, rest(disk));
        // As solve(): on a coarser level, where all steps up to this one cost less than one at full size.
        options.finish = [&](const DiskView& on, std::vector<Vec2d> coarse) {
            coarse =
                level_map(on, std::move(coarse), kLevelSteps, kLevelEpsilon, progress, rest_shapes_of(levelling_, on));
            for (std::size_t k = 0; k <= step; ++k)
                coarse = level_map(on, std::move(coarse), kSteps, kEpsilons[k], progress, rest(on));
            return coarse;
        };
        return multilevel_stretch_map(disk, options, progress, &memory_->levels);
    }

    static bool crowded(const DiskView& on, const std::vector<Vec2d>& uv) {
        return l2_stretch(on.positions, on.faces, uv) > kCrowded;
    }

    /// The room for limbs is found on a coarser level, where a step costs less than a tenth of one at full size.
    [[nodiscard]] static std::optional<std::vector<Vec2d>> uncrowded_coarsely(const DiskView& disk,
                                                                              std::size_t newton_steps,
                                                                              const model::Progress& progress) {
        MultilevelOptions options;
        options.map_coarsest = [&](const DiskView& on) -> std::optional<std::vector<Vec2d>> {
            try {
                return stretch_map(on, newton_steps, progress);
            } catch (const model::Error& e) {
                if (e.code().number != model::codes::kMapInvalid.number) throw;
                return std::nullopt;
            }
        };
        options.finish_faces = kLarge;
        options.finish = [&](const DiskView& on, std::vector<Vec2d> uv) {
            return uncrowd(on, std::move(uv), kCrowded, progress);
        };
        return multilevel_stretch_map(disk, options, progress);
    }

    /// The map before it is levelled.
    [[nodiscard]] std::vector<Vec2d> plain_map(const DiskView& disk, const model::Progress& progress) const {
        std::optional<std::vector<Vec2d>> map = multilevel_stretch_map(disk, {}, progress, &memory_->levels);
        if (map && !crowded(disk, *map)) return std::move(*map);
        const auto energy = [&](const std::vector<Vec2d>& uv) {
            return stretch_energy(disk.positions, disk.faces, uv);
        };
        if (disk.faces.size() > kLarge) {
            std::optional<std::vector<Vec2d>> other = uncrowded_coarsely(disk, newton_steps_, progress);
            if (other && map && energy(*map) <= energy(*other)) other.reset();
            if (other) return std::move(*other);
            if (map) return std::move(*map);
        }
        std::vector<Vec2d> other = stretch_map(disk, newton_steps_, progress);
        if (map && energy(*map) <= energy(other)) other = std::move(*map);
        return count_not_positive(disk.faces, other) > 0 ? other : uncrowd(disk, std::move(other), kCrowded, progress);
    }

    std::size_t newton_steps_;
    Levelling levelling_;
    std::shared_ptr<StretchMemory> memory_;
};

class ReweightedParameterizer final : public Parameterizer {
 public:
    [[nodiscard]] std::string_view name() const override { return "reweighted"; }
    [[nodiscard]] bool fixed_border() const override { return true; }
    [[nodiscard]] std::vector<Vec2d> solve(const DiskView& disk, const model::Progress& progress) const override {
        const CellRectangle cells(disk);
        return cells.to_square(reweighted_stretch_map(cells.view(), {}, progress));
    }
};

}  // namespace

std::vector<RestShape> rest_shapes_of(Levelling levelling, const DiskView& disk) {
    switch (levelling) {
        case Levelling::kCurvature:
            return curved_rest_shapes(disk);
        case Levelling::kDirections:
            return directed_rest_shapes(disk);
        case Levelling::kArea:
            break;
    }
    return {};
}

std::vector<Vec2d> level_map(const DiskView& disk, std::vector<Vec2d> uv, std::size_t steps, double epsilon,
                             const model::Progress& progress, std::span<const RestShape> rest) {
    SlimOptions options;
    options.rest = rest;
    options.energy = FlipFreeEnergy::kStretch;
    options.border_fixed = true;
    options.iterations = steps;
    options.stretch_power = kLevelPower;
    options.stretch_epsilon = epsilon;
    return descend_flip_free(disk, std::move(uv), options, progress);
}

std::unique_ptr<Parameterizer> make_reweighted_parameterizer() {
    return std::make_unique<ReweightedParameterizer>();
}

std::unique_ptr<Parameterizer> make_stretch_parameterizer(std::size_t newton_steps, Levelling levelling,
                                                          std::shared_ptr<StretchMemory> memory) {
    return std::make_unique<StretchParameterizer>(newton_steps, levelling, std::move(memory));
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

namespace {

/// Samples the map of `chart`, and places and splits the quads.
void sample_map(SampledChart& chart, const SquareBorder& border) {
    check_map(*chart.disk, chart.uv, chart.method);
    const SampleGrid fine = rasterize(chart.disk->mesh.faces, chart.uv, 2 * chart.m - 1, 2 * chart.n - 1);
    if (fine.missing > 0)
        throw model::Error(model::codes::kMapInvalid,
                           chart.method + ": " + std::to_string(fine.missing) + " grid points are covered by no face");
    chart.samples = coarsen(fine, chart.m, chart.n);
    chart.representative.resize(chart.samples.size());
    for (std::uint32_t s = 0; s < chart.representative.size(); ++s) chart.representative[s] = s;
    // The representative of a class is its lowest flat index, whichever place that has in the border cycle.
    std::vector<std::uint32_t> lowest(border.samples.size(), kNone);
    for (const BorderSample& s : border.samples) lowest[s.same_as] = std::min(lowest[s.same_as], s.index);
    const bool any_reversed =
        std::any_of(border.samples.begin(), border.samples.end(), [](const BorderSample& s) { return s.reversed; });
    chart.reversed.assign(any_reversed ? chart.samples.size() : 0, 0);
    std::vector<char> lowest_reversed(border.samples.size(), 0);
    for (const BorderSample& s : border.samples)
        if (s.index == lowest[s.same_as]) lowest_reversed[s.same_as] = s.reversed;
    for (const BorderSample& s : border.samples) {
        if (any_reversed) chart.reversed[s.index] = s.reversed != (lowest_reversed[s.same_as] != 0);
        chart.samples[s.index] = s.at;
        chart.representative[s.index] = lowest[s.same_as];
    }
    place_samples(chart);
    choose_diagonals(chart, fine);
}

}  // namespace

LaidDisk lay_disk(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation, BorderShares shares) {
    SquareBorder border = lay_square_border(disk, m, n, rotation, shares);
    return {m, n, std::move(disk), std::move(border)};
}

SampledChart make_square_chart(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                               const Parameterizer& method, const model::Progress& progress, BorderShares shares) {
    return make_square_chart(lay_disk(std::move(disk), m, n, rotation, shares), method, progress);
}

SampledChart make_square_chart(const LaidDisk& laid, const Parameterizer& method, const model::Progress& progress) {
    const auto& [m, n, disk, border] = laid;
    SampledChart chart;
    chart.m = m;
    chart.n = n;
    chart.method = method.name();
    chart.disk = disk;
    const DiskView view{chart.disk->mesh.positions, chart.disk->mesh.faces, border.vertices, border.uv,
                        (m - 1.0) / (n - 1.0)};
    chart.uv = method.solve(view, progress);
    sample_map(chart, border);
    // The fit mends the few folds that are left.
    const std::size_t few = kFewFolds * 2 * std::size_t{m - 1} * (n - 1) / 1000;
    std::size_t folded = count_folded(chart);
    for (std::size_t step = 0; folded > few; ++step) {
        std::optional<std::vector<Vec2d>> uv = method.level(view, chart.uv, step, progress);
        if (!uv) break;
        chart.uv.swap(*uv);
        sample_map(chart, border);
        const std::size_t left = count_folded(chart);
        if (left >= folded) {
            chart.uv.swap(*uv);
            sample_map(chart, border);
            break;
        }
        folded = left;
    }
    return chart;
}

}  // namespace dgm::bake
