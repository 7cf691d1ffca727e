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
#include "geometry/cut/cut_graph.h"
#include "geometry/cut_search/ring_cut.h"
#include "geometry/fit/fit.h"
#include "geometry/mesh/infinity.h"
#include "geometry/mesh/triangle.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr std::uint64_t kCheap = 65 * 65, kErrorSamples = 20'000;
constexpr std::uint64_t kLeast = 33 * 33;  // below, 17 samples a side leave no shape to choose
constexpr std::size_t kMostComponents = 16;
constexpr double kTrials = 6;                // of one component, about
constexpr double kMuchLess = 0.8;            // 2 dB
constexpr std::size_t kMostFaces = 100'000;  // of a surface whose shape is chosen unasked: the trials map all of them
constexpr int kLongestRing = 8;              // 16:1
constexpr int kFirst = 8, kLongest = 12;     // of a long surface: 16:1, 64:1
constexpr double kFreeGain = 0.6;            // that more rounds give a free chart beside a square one
constexpr double kLong = 4;                  // length : width
constexpr double kNear = 0.25;               // of the longest way
constexpr double kExact = 1e-7;              // of the diagonal

/// True if `options` let rings be unrolled and long surfaces be laid out along long grids.
bool by_stretch(const BakeOptions& options) {
    return (options.method == Method::kAuto || options.method == Method::kStretch) &&
           options.domain != DomainChoice::kFree;
}

}  // namespace

double strip_length(const TriMesh& component) {
    CutGraph graph(component);
    const double way = graph.longest_way(), area = surface_area(component);
    if (!(way * way > kLong * area)) return 1;
    graph.cut_to_disk();
    std::vector<double> off = graph.distance_to_cut();
    graph.join(static_cast<std::uint32_t>(std::max_element(off.begin(), off.end()) - off.begin()));
    off = graph.distance_to_cut();
    return *std::max_element(off.begin(), off.end()) < kNear * way ? way * way / area : 1;
}

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
        const bool may_shape = by_stretch(options_);
        if (!may_shape || !is_ring(component_))
            return {by_fit(samples, RingUse::kTried, may_shape ? strip_length(component_) : 1, 1).aspect};
        const Plain plain = by_fit(samples, RingUse::kNot, 1, 1);
        return better({plain.aspect}, plain.rms, samples, 1);
    }
    /// 1:1 unless another shape has much less error.
    [[nodiscard]] Shape best_ring(std::uint64_t samples) {
        const double square = judged(grid_of(samples, 1), options_, RingUse::kNot, CutUse::kReuse).trial.rms;
        return better({}, square, samples, kMuchLess);
    }
    /// Likewise for a surface `length` times as long as wide.
    [[nodiscard]] Shape best_long(std::uint64_t samples, double length) {
        return {by_fit(samples, RingUse::kTried, length, kMuchLess).aspect};
    }

    [[nodiscard]] std::vector<GridTrial> trials() && { return std::move(trials_); }

 private:
    struct Plain {
        double aspect, rms;  ///< of its trial
    };
    struct Judged {
        AspectTrial trial;
        Method method = Method::kAuto;  ///< of the chart, if there is one
    };

    /// `plain`, or the best unrolled shape if its error is less than `share` of `rms`, the plain one's.
    [[nodiscard]] Shape better(Shape plain, double rms, std::uint64_t samples, double share) {
        BakeOptions stretch = options_;
        stretch.method = Method::kStretch;
        const AspectChoice unrolled = choose_aspect(
            samples, [&](GridSize size) { return judged(size, stretch, RingUse::kOnly, CutUse::kReuse).trial; },
            {.longest = kLongestRing});
        if (rms <= unrolled.rms && rms < kInfinity) plain.rings = RingUse::kNot;
        if (!(unrolled.rms < share * rms)) return plain;
        return {unrolled.aspect, unrolled.rms < kMuchLess * rms ? RingUse::kOnly : RingUse::kTried};
    }

    /// The best aspect of a surface `length` times as long as wide; 1 unless it has less than `share` of the error
    /// there. Errors before the fit do not tell: a wound tube has its least at 1:1, and after it far less at 1:16.
    [[nodiscard]] Plain by_fit(std::uint64_t samples, RingUse rings, double length, double share) {
        const bool is_long = length > 1;
        AspectRange range;
        if (is_long) {
            const auto own = static_cast<int>(std::lround(2 * math::log(length) / math::log(2.0)));
            range = {.longest = kLongest, .first = std::min(own, kFirst), .near = share == 1};
        }
        BakeOptions trial_options = options_;  // `auto` chooses once: what is compared is the shape
        bool exact = false;
        const AspectChoice choice = choose_aspect(
            samples,
            [&](GridSize size) {
                if (exact) return AspectTrial{size, kInfinity, 0};
                Judged judgement = judged(size, trial_options, rings, CutUse::kSearch);
                AspectTrial& trial = judgement.trial;
                exact = trial.rms < kExact;
                if (trial.rms < kInfinity) trial_options.method = judgement.method;
                if (!is_long || exact || judgement.method == Method::kUv) return trial;
                if (options_.method == Method::kAuto) trial_options.method = Method::kStretch;
                if (trial.chart_aspect > 0) trial.rms *= kFreeGain;  // it has to stand beside long squares
                trial.chart_aspect = 0;
                return trial;
            },
            range);
        const double square = choice.trials.front().rms;
        return choice.rms < share * square ? Plain{choice.aspect, choice.rms} : Plain{1, square};
    }

    /// By the error after a trial fit, where samples will be fitted.
    [[nodiscard]] Judged judged(GridSize size, const BakeOptions& options, RingUse rings, CutUse use) {
        Attempt<ComponentResult> result = baked(size, options, rings, use);
        if (!result) return {{size, kInfinity, 0}};
        const bool is_free = result->chart.domain == layout::Domain::kFree;
        const double aspect = is_free ? free_chart_aspect(result->chart) : 0;
        double& rms = trials_.back().rms;
        rms = 0;
        if (options.fit != Fit::kSample) {
            TrialFit fitted = result->begun ? *std::move(result->begun) : trial_fit(result->chart, silent());
            take_placement(result->chart, std::move(fitted.placement));
            rms = fitted.rms;
        }
        // The points of a fit flatter a chart that folds, as those of a Schwarz lantern do.
        rms = std::max(rms, quick_error(component_, result->chart, kErrorSamples, result->source_index()).rms);
        return {{size, rms, aspect}, result->method};
    }

    /// The error of its trial is left to be measured.
    Attempt<ComponentResult> baked(GridSize size, const BakeOptions& options, RingUse rings, CutUse use) {
        model::Progress inner = silent();
        inner.on_update = [&, done = static_cast<double>(trials_.size())](std::string_view stage, double part) {
            progress_.update(stage, std::min(1.0, (done + part) / kTrials));
        };
        const CpuClock clock;
        ComponentTask task{component_, size, size, use, rings};
        task.trials.index = index_;
        Attempt<ComponentResult> result = bake_component(task, options, cuts_, inner);
        if (!result && result.failure() == Failure::kOther && rings != RingUse::kOnly) throw result.error();
        std::string outcome = result ? result->chart.method : result.error().what();
        if (result && rings == RingUse::kOnly) outcome += ", loops on opposite sides";
        trials_.push_back({size.rows, size.cols, kInfinity, std::nan(""), 0, outcome, clock.seconds()});
        return result;
    }

    [[nodiscard]] model::Progress silent() const {
        model::Progress out;
        out.cancelled = progress_.cancelled;
        return out;
    }

    const TriMesh& component_;
    const std::shared_ptr<LazyIndex> index_ = std::make_shared<LazyIndex>(component_);
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

ComponentShapes choose_component_shapes(std::span<const TriMesh> components, std::span<const double> areas,
                                        std::uint64_t samples, const BakeOptions& options, std::span<CutMemory> cuts,
                                        const model::Progress& progress) {
    return choose_shapes(components, areas, samples, options, cuts, progress,
                         [](ShapeTrials& trials, const TriMesh&, std::uint64_t share) { return trials.best(share); });
}

ComponentShapes choose_unasked_shapes(std::span<const TriMesh> components, std::span<const double> areas,
                                      std::uint64_t samples, const BakeOptions& options, std::span<CutMemory> cuts,
                                      const model::Progress& progress) {
    bool gained = true;  // where one gains nothing, smaller ones, which are like it as a rule, are spared the trials
    const auto choose = [&](ShapeTrials& trials, const TriMesh& component, std::uint64_t share) {
        if (component.faces.size() > kMostFaces || !by_stretch(options)) return Shape{};
        if (is_ring(component)) return trials.best_ring(share);
        const double length = gained ? strip_length(component) : 1;
        if (length == 1) return Shape{};
        const Shape out = trials.best_long(share, length);
        gained = out.aspect != 1;
        return out;
    };
    return choose_shapes(components, areas, samples, options, cuts, progress, choose);
}

}  // namespace dgm::bake
