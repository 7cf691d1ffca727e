// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_map.cpp
// Map and fit.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "baking/component/component_bake.h"
#include "baking/component/component_loop.h"
#include "baking/component/component_sizes.h"
#include "baking/search/size_search.h"
#include "baking/stage_log.h"
#include "baking/stages.h"
#include "geometry/fit/fit.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

constexpr std::uint64_t kRefinedSamples = 2;  // times those of the largest component

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

/// The failure of component `c` of `count`.
Error failure_at(const Error& error, std::size_t c, std::size_t count) {
    if (count == 1) return error;
    Error out(error.code(), fmt::format("component {} of {}: {}", c + 1, count, error.what()), error.place());
    return out.with_hint(error.hint());
}

FitOptions fit_options(const BakeOptions& options, bool u16) {
    FitOptions out = options.fit == Fit::kBest ? best_fit() : l2_fit();
    out.split_quads = !options.ablates("diagonals");
    out.on_lattice = u16;
    return out;
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
    for (std::size_t c = 0; c < sizes.size(); ++c) {
        Attempt<ComponentResult> chart = bake_component({source.components[c], sizes[c], full[c], request.use}, options,
                                                        cuts[c], part_of(progress, "map", c, sizes.size()));
        if (!chart) throw failure_at(chart.error(), c, sizes.size());
        out.charts.push_back(std::move(*chart));
    }
    if (options.ablates("diagonals"))
        for (ComponentResult& mapped : out.charts) straighten_diagonals(mapped.chart);
    return out;
}

Fitted fit_source(Mapped mapped, const BakeOptions& options, bool u16, const model::Progress& progress) {
    Fitted out{std::move(mapped.charts), {}};
    if (options.fit == Fit::kSample) return out;
    out.inverted.resize(out.charts.size());
    const FitOptions fit = fit_options(options, u16);
    for_each_component(out.charts.size(), part_of(progress, "fit", 0, 1),
                       [&](std::size_t c, const model::Progress& part) {
                           out.inverted[c] = fit_chart(out.charts[c].chart, fit, part).inverted;
                       });
    return out;
}

Fitted refine_inverted(const Repaired& source, const MapRequest& request, Fitted fitted, const BakeOptions& options,
                       bool u16, std::span<CutMemory> cuts, const model::Progress& progress) {
    const std::vector<GridSize> full = full_sizes(source, request);
    const FitOptions fit = fit_options(options, u16);
    std::uint64_t left = kRefinedSamples * request.largest.rows * request.largest.cols;
    for (std::size_t c = 0; c < fitted.inverted.size(); ++c) {
        GridSize size{fitted.charts[c].chart.m, fitted.charts[c].chart.n};
        while (fitted.inverted[c] > 0 && size != full[c]) {
            size = {std::min(full[c].rows, 2 * size.rows - 1), std::min(full[c].cols, 2 * size.cols - 1)};
            const std::uint64_t samples = std::uint64_t{size.rows} * size.cols;
            if (samples > left) break;
            left -= samples;
            Attempt<ComponentResult> finer =
                bake_component({source.components[c], size, full[c], request.use}, options, cuts[c], progress);
            if (!finer) break;
            const std::size_t inverted = fit_chart(finer->chart, fit, progress).inverted;
            if (inverted >= fitted.inverted[c]) continue;
            fitted.charts[c] = std::move(*finer);
            fitted.inverted[c] = inverted;
        }
    }
    return fitted;
}

}  // namespace dgm::bake
