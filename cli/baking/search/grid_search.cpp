// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/search/grid_search.cpp
#include "baking/search/grid_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "baking/option_names.h"
#include "baking/search/size_search.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string size_text(GridSize size) {
    return fmt::format("{}x{}", size.rows, size.cols);
}

std::size_t first_of_side(const std::vector<GridSize>& ladder, double side) {
    const auto it = std::find_if(ladder.begin(), ladder.end(),
                                 [&](GridSize s) { return static_cast<double>(s.rows) * s.cols >= side * side; });
    return static_cast<std::size_t>(std::min(it, ladder.end() - 1) - ladder.begin());
}

/// Runs the tries and keeps their record.
class Record {
 public:
    Record(const std::vector<GridSize>& ladder, const GridTries& tries) : ladder_(ladder), tries_(tries) {}

    /// `value` of the trial; `good` says whether it is an answer.
    template <class Value>
    double measure(std::size_t step, Value value, double limit, const char* good, const char* bad) {
        const GridSize size = ladder_[step];
        Attempt<GridTrial> trial = tries_.measure(size);
        if (!trial) {
            if (trial.failure() == Failure::kOther) throw trial.error();
            search.trials.push_back(not_measured(size));
            search.trials.back().outcome = trial.error().what();
            last_error_ = trial.error();
            return kInfinity;
        }
        const double measured = value(*trial);
        trial->outcome = measured <= limit ? good : bad;
        search.trials.push_back(std::move(*trial));
        if (measured <= limit) tries_.keep(size);
        return measured;
    }

    /// Takes over the result and the other measured grids.
    void answer(const SizeSearch& found, std::size_t beside) {
        const GridSize size = ladder_[*found.found];
        search.rows = size.rows;
        search.cols = size.cols;
        for (std::size_t k = 0; k < found.trials.size(); ++k)
            if (found.trials[k].step == beside) search.next = search.trials[k];
    }

    /// No grid had a map: the reason is the mesh's.
    void rethrow_if_no_map(const SizeSearch& found) const {
        const bool any = std::any_of(found.trials.begin(), found.trials.end(),
                                     [](const SizeTrial& t) { return t.value < kInfinity; });
        if (!any && last_error_) throw *last_error_;
    }

    GridSearch search;

 private:
    const std::vector<GridSize>& ladder_;
    const GridTries& tries_;
    std::optional<Error> last_error_;
};

}  // namespace

double error_margin(ErrorKind kind) {
    return kind == ErrorKind::kRms ? 0.01 : 0.05;
}

GridSearch search_by_error(const ErrorGoal& goal, double diagonal, const std::vector<GridSize>& ladder,
                           double first_side, const GridTries& tries) {
    const bool rms = goal.kind == ErrorKind::kRms;
    const double asked = goal.percent ? goal.value / 100 * diagonal : goal.value;
    const double limit = asked / (1 + error_margin(goal.kind));
    const auto value = [&](const GridTrial& trial) { return rms ? trial.rms : trial.hausdorff; };
    Record record(ladder, tries);
    const SizeSearch found = smallest_that_holds(
        ladder, limit, first_of_side(ladder, first_side),
        [&](std::size_t step) { return record.measure(step, value, limit, "holds", "does not hold"); });
    GridSearch& out = record.search;
    out.goal = SearchGoal::kMaxError;
    out.kind = goal.kind;
    out.asked = asked;
    out.asked_percent = 100 * asked / diagonal;
    out.margin = error_margin(goal.kind);
    if (found.found) {
        record.answer(found, *found.found - 1);  // no such step before the first: nothing beside it
        return std::move(out);
    }
    record.rethrow_if_no_map(found);
    const GridTrial* best = nullptr;
    for (const GridTrial& trial : out.trials)
        if (std::isfinite(value(trial)) && (best == nullptr || value(trial) < value(*best))) best = &trial;
    std::string story = fmt::format("{} {:.3g} ({:.3g} % of the diagonal) was asked for; {} reaches {:.3g} ({:.3g} %)",
                                    name_of(kErrorKindNames, goal.kind), asked, out.asked_percent,
                                    size_text({best->rows, best->cols}), value(*best), 100 * value(*best) / diagonal);
    if (found.given_up)
        story += fmt::format("\nthe error falls too slowly for any grid up to {}", size_text(ladder.back()));
    else if (value(*best) <= asked)
        story += fmt::format("\nthat is too close to measure: {:.0f} % is kept in hand", 100 * out.margin);
    else
        story += "\nthat is the largest grid allowed";
    throw Error(codes::kErrorNotReached, story);
}

GridSearch search_by_budget(std::uint64_t budget, const std::vector<GridSize>& ladder, const GridTries& tries) {
    constexpr double kBytesPerSample = 30;  // all layers; only the first guess depends on it
    const double limit = static_cast<double>(budget);
    Record record(ladder, tries);
    const SizeSearch found =
        largest_that_fits(ladder, limit, first_of_side(ladder, std::min(129.0, std::sqrt(limit / kBytesPerSample))),
                          [&](std::size_t step) {
                              return record.measure(
                                  step, [](const GridTrial& trial) { return static_cast<double>(trial.bytes); }, limit,
                                  "fits", "too large");
                          });
    GridSearch& out = record.search;
    out.goal = SearchGoal::kBudget;
    out.asked_bytes = budget;
    if (found.found) {
        record.answer(found, *found.found + 1);
        return std::move(out);
    }
    record.rethrow_if_no_map(found);
    const GridTrial* smallest = nullptr;
    for (const GridTrial& trial : out.trials)
        if (trial.bytes > 0 && (smallest == nullptr || trial.bytes < smallest->bytes)) smallest = &trial;
    throw Error(codes::kBudgetTooSmall,
                fmt::format("{} bytes were asked for; the smallest file, of {}, takes {}", budget,
                            size_text({smallest->rows, smallest->cols}), smallest->bytes));
}

}  // namespace dgm::bake
