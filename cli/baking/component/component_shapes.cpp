// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_shapes.cpp
#include "baking/component/component_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "baking/cpu_clock.h"
#include "baking/search/size_search.h"

namespace dgm::bake {
namespace {

constexpr std::uint64_t kCheap = 65 * 65, kErrorSamples = 20'000;
constexpr std::uint64_t kLeast = 33 * 33;  // below, 17 samples a side leave no shape to choose
constexpr std::size_t kMostComponents = 16;
constexpr double kTrials = 6;  // of one component, about

}  // namespace

double free_chart_aspect(const SampledChart& chart) {
    // Partial derivatives S_s, S_t as [Sander 2001], squared, times the surface area of the face.
    double along_rows = 0, along_cols = 0;
    for (std::size_t f = 0; f < chart.disk.mesh.faces.size(); ++f) {
        const Face& face = chart.disk.mesh.faces[f];
        const auto q = chart.disk.mesh.corners(f);
        const Vec2d a = chart.uv[face[0]], b = chart.uv[face[1]], c = chart.uv[face[2]];
        const double twice = cross(b - a, c - a);
        if (!(twice > 0)) continue;
        const Vec3d s = (q[0] * (b.y - c.y) + q[1] * (c.y - a.y) + q[2] * (a.y - b.y)) / twice;
        const Vec3d t = (q[0] * (c.x - b.x) + q[1] * (a.x - c.x) + q[2] * (b.x - a.x)) / twice;
        const double area = face_area(q);
        along_rows += area * dot(s, s);
        along_cols += area * dot(t, t);
    }
    return along_cols > 0 ? std::sqrt(along_rows / along_cols) : 1;
}

ComponentShapes choose_component_shapes(std::span<const TriMesh> components, std::span<const double> areas,
                                        std::uint64_t samples, const BakeOptions& options, std::span<CutMemory> cuts,
                                        const model::Progress& progress) {
    ComponentShapes out;
    out.aspects.assign(components.size(), 1.0);
    std::vector<std::size_t> order(components.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return areas[a] > areas[b]; });
    order.resize(std::min(order.size(), kMostComponents));
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::size_t c = order[k];
        const auto share = static_cast<std::uint64_t>(static_cast<double>(samples) * areas[c] / areas[order[0]]);
        if (k > 0 && share < kLeast) break;
        double begun = 0;
        BakeOptions trial_options = options;  // `auto` chooses once: what is compared is the shape
        const auto measure = [&](GridSize size) {
            model::Progress inner;
            inner.cancelled = progress.cancelled;
            inner.on_update = [&, done = begun++](std::string_view stage, double part) {
                const double of_component = std::min(1.0, (done + part) / kTrials);
                progress.update(stage, (static_cast<double>(k) + of_component) / static_cast<double>(order.size()));
            };
            constexpr double kNoMap = std::numeric_limits<double>::infinity();
            AspectTrial trial{size, kNoMap, 0};
            const CpuClock clock;
            const Attempt<ComponentResult> result =
                bake_component({components[c], size, size}, trial_options, cuts[c], inner);
            if (result) {
                trial_options.method = result->method;
                trial.rms = quick_error(components[c], result->chart, kErrorSamples).rms;
                if (result->chart.domain == layout::Domain::kFree)
                    trial.chart_aspect = free_chart_aspect(result->chart);
            } else if (result.failure() == Failure::kOther) {
                throw result.error();
            }
            const std::string outcome = result ? result->chart.method : result.error().what();
            if (k == 0)
                out.trials.push_back({size.rows, size.cols, trial.rms, std::nan(""), 0, outcome, clock.seconds()});
            return trial;
        };
        out.aspects[c] = choose_aspect(std::min(share, kCheap), measure).aspect;
    }
    return out;
}

}  // namespace dgm::bake
