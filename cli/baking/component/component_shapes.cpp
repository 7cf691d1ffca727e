// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_shapes.cpp
#include "baking/component/component_shapes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>

#include "baking/cpu_clock.h"
#include "baking/search/size_search.h"
#include "geometry/cut_search/ring_cut.h"
#include "geometry/fit/fit.h"
#include "geometry/mesh/infinity.h"

namespace dgm::bake {
namespace {

constexpr std::uint64_t kCheap = 65 * 65, kErrorSamples = 20'000;
constexpr std::uint64_t kLeast = 33 * 33;  // below, 17 samples a side leave no shape to choose
constexpr std::size_t kMostComponents = 16;
constexpr double kTrials = 6;                // of one component, about
constexpr double kMuchLess = 0.8;            // 2 dB
constexpr std::size_t kMostFaces = 100'000;  // of a ring whose shape is chosen unasked: the trials map all of them
constexpr int kLongestRing = 8;              // 16:1

}  // namespace

double free_chart_aspect(const SampledChart& chart) {
    // Partial derivatives S_s, S_t as [Sander 2001], squared, times the surface area of the face.
    double along_rows = 0, along_cols = 0;
    for (std::size_t f = 0; f < chart.disk->mesh.faces.size(); ++f) {
        const Face& face = chart.disk->mesh.faces[f];
        const auto q = chart.disk->mesh.corners(f);
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

namespace {

struct Shape {
    double aspect = 1;
    RingUse rings = RingUse::kTried;
};

/// Cheap bakes of one component, whose record becomes part of the report.
class ShapeTrials {
 public:
    /// All must outlive the object.
    ShapeTrials(const TriMesh& component, const BakeOptions& options, CutMemory& cuts, const model::Progress& progress)
        : component_(component), options_(options), cuts_(cuts), progress_(progress) {}

    /// @throws model::Error of a component that cannot be baked for another reason than the grid; kInterrupted
    [[nodiscard]] Shape best(std::uint64_t samples) {
        if (!may_unroll(component_, options_)) return {by_map(samples, RingUse::kTried).aspect};
        const AspectChoice plain = by_map(samples, RingUse::kNot);
        return better({plain.aspect}, judged(grid_of(samples, plain.aspect), options_, RingUse::kNot), samples, 1);
    }
    [[nodiscard]] Shape best_ring(std::uint64_t samples) {
        if (component_.faces.size() > kMostFaces) return {};
        return better({}, judged(grid_of(samples, 1), options_, RingUse::kNot), samples, kMuchLess);
    }

    [[nodiscard]] std::vector<GridTrial> trials() && { return std::move(trials_); }

 private:
    /// `plain`, or the best unrolled shape if its error is less than `share` of the plain one's.
    [[nodiscard]] Shape better(Shape plain, const AspectTrial& trial, std::uint64_t samples, double share) {
        BakeOptions stretch = options_;
        stretch.method = Method::kStretch;
        const AspectChoice unrolled = choose_aspect(
            samples, [&](GridSize size) { return judged(size, stretch, RingUse::kOnly); }, kLongestRing);
        if (trial.rms <= unrolled.rms && trial.rms < kInfinity) plain.rings = RingUse::kNot;
        if (!(unrolled.rms < share * trial.rms)) return plain;
        return {unrolled.aspect, unrolled.rms < kMuchLess * trial.rms ? RingUse::kOnly : RingUse::kTried};
    }

    /// By the error before the fit.
    [[nodiscard]] AspectChoice by_map(std::uint64_t samples, RingUse rings) {
        BakeOptions trial_options = options_;  // `auto` chooses once: what is compared is the shape
        return choose_aspect(samples, [&](GridSize size) {
            AspectTrial trial{size, kInfinity, 0};
            const Attempt<ComponentResult> result = baked(size, trial_options, rings, CutUse::kSearch);
            if (!result) return trial;
            trial_options.method = result->method;
            trial.rms = trials_.back().rms;
            if (result->chart.domain == layout::Domain::kFree) trial.chart_aspect = free_chart_aspect(result->chart);
            return trial;
        });
    }

    /// By the error after a trial fit, where samples will be fitted.
    [[nodiscard]] AspectTrial judged(GridSize size, const BakeOptions& options, RingUse rings) {
        Attempt<ComponentResult> result = baked(size, options, rings, CutUse::kReuse);
        if (!result) return {size, kInfinity, 0};
        if (options.fit == Fit::kSample) return {size, trials_.back().rms, 0};
        return {size, result->begun ? result->begun->rms : trial_fit(result->chart, silent()).rms, 0};
    }

    Attempt<ComponentResult> baked(GridSize size, const BakeOptions& options, RingUse rings, CutUse use) {
        model::Progress inner = silent();
        inner.on_update = [&, done = static_cast<double>(trials_.size())](std::string_view stage, double part) {
            progress_.update(stage, std::min(1.0, (done + part) / kTrials));
        };
        const CpuClock clock;
        Attempt<ComponentResult> result = bake_component({component_, size, size, use, rings}, options, cuts_, inner);
        if (!result && result.failure() == Failure::kOther && rings != RingUse::kOnly) throw result.error();
        const double rms = result ? quick_error(component_, result->chart, kErrorSamples).rms : kInfinity;
        std::string outcome = result ? result->chart.method : result.error().what();
        if (result && rings == RingUse::kOnly) outcome += ", loops on opposite sides";
        trials_.push_back({size.rows, size.cols, rms, std::nan(""), 0, outcome, clock.seconds()});
        return result;
    }

    [[nodiscard]] model::Progress silent() const {
        model::Progress out;
        out.cancelled = progress_.cancelled;
        return out;
    }

    const TriMesh& component_;
    const BakeOptions& options_;
    CutMemory& cuts_;
    const model::Progress& progress_;
    std::vector<GridTrial> trials_;
};

/// Calls choose(trials, samples) for the largest components, of which small ones stay square.
template <class Choose>
ComponentShapes choose_shapes(std::span<const TriMesh> components, std::span<const double> areas, std::uint64_t samples,
                              const BakeOptions& options, std::span<CutMemory> cuts, const model::Progress& progress,
                              const Choose& choose) {
    ComponentShapes out;
    out.aspects.assign(components.size(), 1.0);
    out.rings.assign(components.size(), RingUse::kTried);
    std::vector<std::size_t> order(components.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return areas[a] > areas[b]; });
    order.resize(std::min(order.size(), kMostComponents));
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::size_t c = order[k];
        const auto share = static_cast<std::uint64_t>(static_cast<double>(samples) * areas[c] / areas[order[0]]);
        if (k > 0 && share < kLeast) break;
        model::Progress part;
        part.cancelled = progress.cancelled;
        part.on_update = [&](std::string_view stage, double done) {
            progress.update(stage, (static_cast<double>(k) + done) / static_cast<double>(order.size()));
        };
        ShapeTrials trials(components[c], options, cuts[c], part);
        const Shape shape = choose(trials, components[c], std::min(share, kCheap));
        out.aspects[c] = shape.aspect;
        out.rings[c] = shape.rings;
        if (k == 0) out.trials = std::move(trials).trials();
    }
    return out;
}

}  // namespace

bool may_unroll(const TriMesh& component, const BakeOptions& options) {
    const bool by_stretch = options.method == Method::kAuto || options.method == Method::kStretch;
    return by_stretch && options.domain != DomainChoice::kFree && is_ring(component);
}

ComponentShapes choose_component_shapes(std::span<const TriMesh> components, std::span<const double> areas,
                                        std::uint64_t samples, const BakeOptions& options, std::span<CutMemory> cuts,
                                        const model::Progress& progress) {
    return choose_shapes(components, areas, samples, options, cuts, progress,
                         [](ShapeTrials& trials, const TriMesh&, std::uint64_t share) { return trials.best(share); });
}

ComponentShapes choose_ring_shapes(std::span<const TriMesh> components, std::span<const double> areas,
                                   std::uint64_t samples, const BakeOptions& options, std::span<CutMemory> cuts,
                                   const model::Progress& progress) {
    return choose_shapes(components, areas, samples, options, cuts, progress,
                         [&](ShapeTrials& trials, const TriMesh& component, std::uint64_t share) {
                             return may_unroll(component, options) ? trials.best_ring(share) : Shape{};
                         });
}

}  // namespace dgm::bake
