// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/search/goal_bake.cpp
#include "baking/search/goal_bake.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "baking/search/grid_search.h"
#include "baking/search/size_search.h"
#include "dgm/dgm_writer.h"
#include "model/codes.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

/// The goal as a length in source units.
double asked_length(const ErrorGoal& goal, double diagonal) {
    return goal.percent ? goal.value / 100 * diagonal : goal.value;
}

std::vector<GridTrial> shapes_of(const PreparedAsset& asset) {
    return asset.shapes ? asset.shapes->shapes : std::vector<GridTrial>{};
}

/// The side that a search by rms begins with, predicted from the cheap bakes of the shapes.
double first_side(const PreparedAsset& asset, const std::vector<GridTrial>& shapes) {
    constexpr double kDefault = 65, kFarthest = 4;
    const ErrorGoal& goal = *asset.options.max_error;
    if (shapes.empty() || asset.source.areas.size() > 1 || goal.kind != ErrorKind::kRms) return kDefault;
    const double asked = asked_length(goal, asset.source.frame.diagonal);
    const auto best = std::min_element(shapes.begin(), shapes.end(),
                                       [](const GridTrial& a, const GridTrial& b) { return a.rms < b.rms; });
    const double side = std::sqrt(static_cast<double>(best->rows) * best->cols);
    return side * std::clamp(std::sqrt(best->rms / asked), 1 / kFarthest, kFarthest);
}

/// Writes the report into the maps, and the maps into options.scratch for a moment. @return the size of the file
std::uint64_t file_bytes(BakeResult& result, const BakeOptions& options) {
    if (options.scratch.empty()) throw Error(codes::kUsage, "a budget needs a .dgm to measure");
    result.maps.report_json = to_json(result.report, false);
    formats::write_dgm(result.maps, options.scratch);
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(options.scratch, error);
    std::filesystem::remove(options.scratch, error);
    if (error) throw Error(codes::kWriteFailed, error.message(), options.scratch.string());
    return bytes;
}

std::string size_text(const GridSearch& search) {
    return std::to_string(search.rows) + "x" + std::to_string(search.cols);
}

/// "129x129 [...] takes 70000 bytes of 65536"
Error too_large(const std::string& what, std::uint64_t bytes, std::uint64_t budget) {
    return {codes::kBudgetTooSmall, what + " takes " + std::to_string(bytes) + " bytes of " + std::to_string(budget)};
}

/// The finished file may be a little larger than its trial was: smaller grids are then baked until one fits.
BakeResult fit_budget(PreparedAsset& asset, BakeResult result, const std::vector<GridSize>& ladder) {
    const std::uint64_t budget = *asset.options.budget_bytes;
    for (;;) {
        const std::uint64_t bytes = file_bytes(result, asset.options);
        if (bytes <= budget) return result;
        GridSearch search = *result.report.search;
        const auto at = std::find(ladder.begin(), ladder.end(), GridSize{search.rows, search.cols});
        if (at == ladder.begin() || at == ladder.end())
            throw too_large("the smallest grid, " + size_text(search) + ",", bytes, budget);
        search.next = not_measured(*at);
        search.next->bytes = bytes;
        search.next->outcome = "too large";
        const GridSize smaller = *(at - 1);
        search.rows = smaller.rows;
        search.cols = smaller.cols;
        result = finish(asset, map_and_fit(asset, smaller, CutUse::kBest), search);
    }
}

}  // namespace

bool stores_u16(const BakeOptions& options, double diagonal) {
    if (options.precision != Precision::kAuto) return options.precision == Precision::kU16;
    if (!options.max_error) return false;
    const ErrorGoal& goal = *options.max_error;
    const double asked = goal.percent ? goal.value / 100 : goal.value / diagonal;
    const double rounding = 1 / (65535.0 * std::sqrt(12.0));
    return asked >= (goal.kind == ErrorKind::kRms ? 3 : 6) * rounding;
}

BakeResult bake_to_error(PreparedAsset& asset, GridSize most) {
    static const std::array<std::string, 1> kGeometryOnly{model::layers::kGeometry};
    const std::vector<GridTrial> shapes = shapes_of(asset);
    std::optional<Fitted> last, kept;
    GridTries tries;
    tries.measure = [&](GridSize size) {
        return asset.log.run_trial(size, [&](GridTrial& trial) {
            last.reset();
            last = map_and_fit(asset, size, CutUse::kReuse);
            const SurfaceError error = store_and_measure(asset, *last, kGeometryOnly, kSurfaceSamples).measured.error;
            trial.rms = error.rms;
            trial.hausdorff = error.hausdorff;
        });
    };
    tries.keep = [&](GridSize) { kept = std::move(last); };
    GridSearch search = in_stage("search", [&] {
        return search_by_error(*asset.options.max_error, asset.source.frame.diagonal, grid_ladder(most, true),
                               first_side(asset, shapes), tries);
    });
    search.shapes = shapes;
    BakeResult out = finish(asset, *kept, search);
    if (!asset.options.budget_bytes) return out;
    out.report.search->asked_bytes = *asset.options.budget_bytes;
    const std::uint64_t bytes = file_bytes(out, asset.options);
    if (bytes > *asset.options.budget_bytes)
        throw too_large(size_text(search) + " is the smallest grid that holds the error; its file", bytes,
                        *asset.options.budget_bytes);
    return out;
}

BakeResult bake_to_budget(PreparedAsset& asset, GridSize most) {
    constexpr std::uint64_t kFewSamples = 1000;
    const std::vector<GridSize> ladder = grid_ladder(most, false);
    GridTries tries;
    tries.keep = [](GridSize) {};
    tries.measure = [&](GridSize size) {
        return asset.log.run_trial(size, [&](GridTrial& trial) {
            const Fitted mapped = map_only(asset, size, CutUse::kReuse);
            BakeResult result =
                result_of(asset, store_and_measure(asset, mapped, asset.options.layers, kFewSamples), asset.shapes);
            trial.bytes = file_bytes(result, asset.options);
        });
    };
    GridSearch search =
        in_stage("search", [&] { return search_by_budget(*asset.options.budget_bytes, ladder, tries); });
    search.shapes = shapes_of(asset);
    const Fitted fitted = map_and_fit(asset, {search.rows, search.cols}, CutUse::kBest);
    return fit_budget(asset, finish(asset, fitted, search), ladder);
}

}  // namespace dgm::bake
