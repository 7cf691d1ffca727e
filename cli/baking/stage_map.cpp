// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_map.cpp
// Map and fit.
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baking/chart_effort.h"
#include "baking/component/chart_fits.h"
#include "baking/component/component_bake.h"
#include "baking/component/component_loop.h"
#include "baking/component/component_sizes.h"
#include "baking/methods.h"
#include "baking/search/size_search.h"
#include "baking/stage_log.h"
#include "baking/stages.h"
#include "baking/time_box.h"
#include "geometry/fit/fit.h"
#include "geometry/fit/local_repair.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

constexpr std::uint64_t kRefinedSamples = 2;  // times those of the largest component
constexpr std::uint64_t kOtherSamples = 3;    // likewise, of other maps
constexpr std::size_t kFittedAgain = 4;       // likewise, in second and third fits of charts
constexpr std::size_t kRemapped = 4;          // likewise, of charts that are mapped anew, however often

/// Faces that the fits of several charts may have looked at together before no more are begun: 25 s of a processor.
constexpr std::uint64_t kLookedOfSeveral = 130'000'000;

/// Limit for all charts together: one of the largest, with 3 GB of layers.
constexpr std::uint64_t kMaxSamples = std::uint64_t{kMaxSide} * kMaxSide;

/// The grids of all components, each as if it were as large as the largest; see component_size.
std::vector<GridSize> full_sizes(const Repaired& source, const MapRequest& request) {
    const GridSize largest = request.largest;
    std::vector<GridSize> out(source.components.size(), largest);
    for (std::size_t c = 0; c < out.size(); ++c)
        if (c != source.largest && request.aspects[c] != 0)
            out[c] = grid_of(std::uint64_t{largest.rows} * largest.cols, request.aspects[c]);
    return out;
}

void check_samples(std::span<const GridSize> sizes) {
    std::uint64_t samples = 0;
    for (const GridSize& size : sizes) samples += std::uint64_t{size.rows} * size.cols;
    if (samples > kMaxSamples)
        throw Error(codes::kTooLarge,
                    fmt::format("{} would need {} samples at this --size; all charts together get at most {}",
                                sizes.size() == 1 ? "the component" : fmt::format("{} components", sizes.size()),
                                samples, kMaxSamples))
            .with_hint("ask for a smaller --size, or join small components");
}

GridSize doubled(GridSize size, GridSize most) {
    return {std::min(most.rows, 2 * size.rows - 1), std::min(most.cols, 2 * size.cols - 1)};
}

// Limbs fold into each other where they have too few samples to be cut open; parts with many cost the search for a cut
// its time again for each size tried. A tree with 256 ends: 20 s a size. So the longest has seconds of its own.
constexpr std::uint32_t kLongestTried = 257;
constexpr double kSecondsOfShorter = 15, kSecondsOfLongest = 25;
constexpr std::string_view kSplit =
    "split the mesh in your modeller into parts with fewer limbs or handles: each part "
    "gets a chart of its own";

/// What to do about component `c`, which has no map at request.largest: names the smallest of some larger sizes at
/// which it has one, as far as the time goes.
std::string hint_of_size(const Repaired& source, MapRequest request, std::size_t c, BakeOptions options,
                         Failure failure, const model::Progress& progress) {
    const GridSize asked = request.largest;
    const GridSize longest{std::max(asked.rows, kLongestTried), std::max(asked.cols, kLongestTried)};
    if (asked == longest) return std::string(kSplit);
    // A free map is the same for each grid: where it has folds, only squares are left to be tried.
    if (failure == Failure::kMapInvalid && options.domain == DomainChoice::kAuto)
        options.domain = DomainChoice::kSquare;
    const auto works_at = [&](const GridSize& size, TimeBox& box) {  // nullopt if the time was used up
        request.largest = size;
        const std::vector<GridSize> full = full_sizes(source, request);
        const GridSize own = component_sizes(full, source.areas, source.largest)[c];
        CutMemory cuts;
        return box.run([&](const model::Progress& part) {
            return static_cast<bool>(
                bake_component({source.components[c], own, full[c], CutUse::kSearch}, options, cuts, part));
        });
    };
    const auto named = [](const GridSize& size, const char* more) {
        return fmt::format("ask for --size {}x{}, at which a map was found{}", size.rows, size.cols, more);
    };
    TimeBox shorter(progress, kSecondsOfShorter);
    for (GridSize next = doubled(asked, longest); next != longest; next = doubled(next, longest)) {
        const std::optional<bool> works = works_at(next, shorter);
        if (!works) break;
        if (*works) return named(next, "");
    }
    TimeBox last(progress, kSecondsOfLongest);
    if (works_at(longest, last).value_or(false))
        return named(longest, shorter.spent() ? "; a smaller one may do, and was not tried to the end" : "");
    return fmt::format("{}; no map was found at larger sizes up to {}x{} either{}", kSplit, longest.rows, longest.cols,
                       shorter.spent() || last.spent() ? " before time ran out" : "");
}

/// True where another size may help, and the user named the one that does not do.
bool size_may_help(const model::Error& error, const MapRequest& request, const BakeOptions& options) {
    if (request.use != CutUse::kSearch) return false;
    const Failure failure = failure_of(error);
    return failure == Failure::kGridTooSmall || (failure == Failure::kMapInvalid && options.method == Method::kAuto);
}

/// A component without a map. Where it ends the mapping of all, the first one's is the one thrown.
struct Unmapped : Error {
    Unmapped(const Error& error, std::size_t c) : Error(error), component(c) {}
    std::size_t component;
};

/// The failure of component `c` of `count`.
Error failure_at(const Error& error, std::size_t c, std::size_t count) {
    if (count == 1) return error;
    Error out(error.code(), fmt::format("component {} of {}: {}", c + 1, count, error.what()), error.place());
    return out.with_hint(error.hint());
}

constexpr std::size_t kFewComponents = 4;

/// Component `c` on a grid of `size`. A ring that cannot be unrolled there gets another chart.
Attempt<ComponentResult> bake_one(const Repaired& source, const MapRequest& request, std::size_t c, GridSize size,
                                  GridSize most, const BakeOptions& options, std::span<CutMemory> cuts,
                                  const model::Progress& progress) {
    ComponentTask task{source.components[c], size, most, request.use, RingUse::kTried};
    if (!request.rings.empty()) task.rings = request.rings[c];
    task.trials.samples = chart_effort(source.components.size(), 1).trial_samples;
    if (source.components.size() > 1) task.trials.clock = CpuClock::Of::kThread;
    task.is_one_of_many = source.components.size() > kFewComponents;
    Attempt<ComponentResult> out = bake_component(task, options, cuts[c], progress);
    if (out && task.is_one_of_many) out->runner_up.reset();
    if (out || task.rings != RingUse::kOnly) return out;
    task.rings = RingUse::kTried;
    return bake_component(task, options, cuts[c], progress);
}

/// The effort of each of the charts.
ChartEffort effort_of(std::span<const ComponentResult> charts) {
    std::size_t samples = 0, largest = 1;
    for (const ComponentResult& c : charts) {
        samples += c.chart.grid_count();
        largest = std::max(largest, c.chart.grid_count());
    }
    return chart_effort(charts.size(), static_cast<double>(samples) / static_cast<double>(largest));
}

FitOptions fit_options(const BakeOptions& options, bool u16, const ChartEffort& effort) {
    FitOptions out = with_effort(options.fit == Fit::kBest ? best_fit() : l2_fit(), effort);
    out.split_quads = !options.ablates("diagonals");
    out.on_lattice = u16;
    return out;
}

constexpr double kOtherMapPrice = 1.4;            // in rms, of another map with fewer inverted faces: 3 dB
constexpr std::size_t kMostFacesOfMany = 40'000;  // of a component with many inverted faces that is mapped again

bool has_failed(const ComponentResult& mapped, Method method) {
    return std::any_of(mapped.candidates.begin(), mapped.candidates.end(), [&](const Candidate& c) {
        return c.method == method && c.outcome == CandidateOutcome::kFailed;
    });
}

/// Where `auto` has left faces inverted, other maps of the component: they crowd its folds and thin parts elsewhere. A
/// garment of doubled sheets kept 5 inverted faces on the square and has none on a free chart, with 33 dB less error.
/// Each is fitted once, and the first that inverts as many ends it: then the shape is to blame.
/// @param size     of the chart; another map gets no larger one
/// @param looked   at faces by the fits so far
/// @param samples  that may yet be tried, less by those that were
/// @return  inverted faces of the map that is kept
std::size_t try_other_maps(const ComponentTask& task, BakeOptions options, const FitOptions& fit,
                           ComponentResult& mapped, std::size_t inverted, std::uint64_t looked, std::uint64_t& samples,
                           const model::Progress& progress) {
    if (options.method != Method::kAuto) return inverted;
    // Where so many are, limbs are crowded on the square, or walls are thinner than any map can draw: one tells.
    const bool many = inverted > kMostAtAPrice;
    if (many && task.component.faces.size() > kMostFacesOfMany) return inverted;
    const std::initializer_list<Method> where_few = {Method::kLscm, Method::kSlim, Method::kStretch};
    const std::initializer_list<Method> where_many = {Method::kArap};
    const auto error_of = [&](const SampledChart& chart) {
        return quick_error(task.component, chart, kTrialSamples, mapped.source_index()).rms;
    };
    double rms = error_of(mapped.chart);
    const DomainChoice domain = options.stays_on_square() ? DomainChoice::kSquare : options.domain;
    bool has_slim = false;  // an LSCM map that overlaps itself is laid out again by the energy of SLIM
    for (const Method method : many ? where_many : where_few) {
        const std::uint64_t own = std::uint64_t{task.size.rows} * task.size.cols;
        if (inverted == 0 || own > samples || looked > kMostLooked) break;
        if (method == mapped.method || (many && has_failed(mapped, method)) || (method == Method::kSlim && has_slim) ||
            (domain != DomainChoice::kAuto && row_of(method).domain != domain))
            continue;
        samples -= own;
        options.method = method;
        CutMemory cuts;
        Attempt<ComponentResult> other = bake_component(task, options, cuts, progress);
        if (!other) continue;
        has_slim = has_slim || (method == Method::kLscm && !other->chart.note.empty());
        const FitReport report = fit_chart(other->chart, fit, progress);
        const std::size_t left = report.inverted;
        looked += report.looked;
        if (left >= inverted) break;
        const double error = error_of(other->chart);
        if (error > kOtherMapPrice * rms) continue;
        mapped.chart = std::move(other->chart);
        mapped.method = method;
        for (Candidate& tried : mapped.candidates)
            if (tried.outcome == CandidateOutcome::kChosen) tried.outcome = CandidateOutcome::kMoreInverted;
        mapped.candidates.insert(mapped.candidates.end(), other->candidates.begin(), other->candidates.end());
        inverted = left;
        rms = error;
    }
    return inverted;
}

/// Of a dense source it takes as much room as the fit has beside it.
void drop_large_indexes(const Repaired& source, std::span<ComponentResult> charts) {
    constexpr std::size_t kMostFaces = 400'000;
    std::size_t faces = 0;
    for (const TriMesh& component : source.components) faces += component.faces.size();
    if (faces <= kMostFaces) return;
    for (ComponentResult& mapped : charts)
        if (mapped.index) mapped.index->drop();
}

/// Splits all quads alike that may be split either way; those at the border keep the split that the topology needs.
void straighten_diagonals(SampledChart& chart) {
    for (std::uint32_t i = 1; i + 2 < chart.m; ++i)
        for (std::uint32_t j = 1; j + 2 < chart.n; ++j) chart.diagonals[std::size_t{i} * (chart.n - 1) + j] = 0;
}

}  // namespace

Mapped map_source(const Repaired& source, const MapRequest& request, const BakeOptions& options,
                  std::span<CutMemory> cuts, const model::Progress& progress) {
    const std::vector<GridSize> full = full_sizes(source, request);
    const std::vector<GridSize> sizes = component_sizes(full, source.areas, source.largest);
    check_samples(sizes);
    Mapped out;
    out.charts.resize(sizes.size());
    try {
        for_each_component(sizes.size(), progress, [&](std::size_t c, const model::Progress& part) {
            Attempt<ComponentResult> chart =
                bake_one(source, request, c, sizes[c], full[c], options, cuts, part_of(part, "map", 0, 1));
            if (!chart) throw Unmapped(chart.error(), c);
            out.charts[c] = std::move(*chart);
        });
    } catch (Unmapped& error) {
        const std::size_t c = error.component;
        if (size_may_help(error, request, options))
            error.with_hint(hint_of_size(source, request, c, options, failure_of(error), progress));
        throw failure_at(error, c, sizes.size());
    }
    drop_large_indexes(source, out.charts);
    if (options.ablates("diagonals"))
        for (ComponentResult& mapped : out.charts) {
            straighten_diagonals(mapped.chart);
            mapped.begun.reset();
            mapped.runner_up.reset();
        }
    return out;
}

Fitted fit_source(const Repaired& source, Mapped mapped, const BakeOptions& options, bool u16,
                  const model::Progress& progress) {
    Fitted out{std::move(mapped.charts), {}};
    if (options.fit == Fit::kSample) return out;
    out.inverted.resize(out.charts.size());
    out.looked.resize(out.charts.size());
    const ChartEffort effort = effort_of(out.charts);
    const FitOptions fit = fit_options(options, u16, effort);
    std::vector<ChartFits> fits;
    fits.reserve(out.charts.size());
    std::size_t largest = 0;
    for (std::size_t c = 0; c < out.charts.size(); ++c) {
        fits.emplace_back(source.components[c], out.charts[c], options, fit, effort.trial_samples);
        largest = std::max(largest, fits[c].samples());
    }
    const model::Progress all = part_of(progress, "fit", 0, 1);
    for_each_component(fits.size(), all, [&](std::size_t c, const model::Progress& part) { fits[c].fit(part); });
    // The others, as far as the effort goes: which they are must not depend on which chart is ready first.
    const auto again = [&](bool (ChartFits::*may_gain)() const, void (ChartFits::*fit_it)(const model::Progress&),
                           std::size_t& left) {
        std::vector<std::size_t> chosen;
        std::uint64_t looked = 0;
        for (const ChartFits& of : fits) looked += of.looked();
        for (std::size_t c = 0; c < fits.size(); ++c) {
            if (!(fits[c].*may_gain)() || fits[c].samples() > left) continue;
            if (fits.size() > 1 && looked + fits[c].looked() > kLookedOfSeveral) continue;
            left -= fits[c].samples();
            looked += fits[c].looked();  // another fit of it takes about as long as those so far
            chosen.push_back(c);
        }
        const model::Progress silent{{}, progress.cancelled};
        for_each_component(chosen.size(), silent,
                           [&](std::size_t k, const model::Progress& part) { (fits[chosen[k]].*fit_it)(part); });
    };
    std::size_t remapped = kRemapped * largest, firmly = kFittedAgain * largest, runners_up = largest;
    again(&ChartFits::may_gain, &ChartFits::fit_firmly, firmly);
    again(&ChartFits::may_gain_guarded, &ChartFits::fit_guarded, firmly);
    again(&ChartFits::may_remap, &ChartFits::remap, remapped);
    again(&ChartFits::may_lose, &ChartFits::fit_runner_up, runners_up);
    for (std::size_t c = 0; c < fits.size(); ++c) {
        out.inverted[c] = fits[c].inverted();
        out.looked[c] = fits[c].looked();
    }
    return out;
}

Fitted refine_inverted(const Repaired& source, const MapRequest& request, Fitted fitted, const BakeOptions& options,
                       bool u16, std::span<CutMemory> cuts, const model::Progress& progress) {
    const std::vector<GridSize> full = full_sizes(source, request);
    const ChartEffort effort = effort_of(fitted.charts);
    const FitOptions fit = fit_options(options, u16, effort);
    std::uint64_t others = kOtherSamples * request.largest.rows * request.largest.cols;
    std::uint64_t left = kRefinedSamples * request.largest.rows * request.largest.cols;
    for (std::size_t c = 0; c < fitted.inverted.size(); ++c) {
        GridSize size{fitted.charts[c].chart.m, fitted.charts[c].chart.n};
        while (fitted.inverted[c] > 0 && size != full[c]) {
            size = doubled(size, full[c]);
            const std::uint64_t samples = std::uint64_t{size.rows} * size.cols;
            if (samples > left) break;
            left -= samples;
            Attempt<ComponentResult> finer = bake_one(source, request, c, size, full[c], options, cuts, progress);
            if (!finer) break;
            const std::size_t inverted =
                fit_component(source.components[c], *finer, options, fit, effort.trial_samples, progress);
            if (inverted >= fitted.inverted[c]) continue;
            fitted.charts[c] = std::move(*finer);
            fitted.inverted[c] = inverted;
        }
        if (fitted.inverted[c] == 0 || source.components[c].positions.size() > kMostFitted) continue;
        size = {fitted.charts[c].chart.m, fitted.charts[c].chart.n};
        ComponentTask task{source.components[c], size, size};
        task.trials.index = fitted.charts[c].index;
        fitted.inverted[c] = try_other_maps(task, options, fit, fitted.charts[c], fitted.inverted[c], fitted.looked[c],
                                            others, progress);
    }
    return fitted;
}

}  // namespace dgm::bake
