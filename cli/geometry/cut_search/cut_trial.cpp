// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_trial.cpp
#include "geometry/cut_search/cut_trial.h"

#include <algorithm>
#include <utility>

#include "geometry/chart/square_chart.h"
#include "geometry/cut_search/trial_map.h"
#include "model/shortage.h"

namespace dgm::bake {
namespace {

/// A trial need not be as good as the bake, only as good as the other trials.
MultilevelOptions trial_options() {
    MultilevelOptions options;
    options.newton_steps = 8;
    options.coarsest_sweeps = 30;
    options.sweeps = 6;
    return options;
}

}  // namespace

CutTrials::CutTrials(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress)
    : component_(component),
      options_(options),
      progress_(progress),
      method_(options.reweighted ? make_reweighted_parameterizer() : make_stretch_parameterizer(0)),
      index_(component),
      topology_(measure_topology(component)) {}

Trial CutTrials::attempt(Disk disk, std::optional<std::uint32_t> rotation, BorderShares shares) {
    progress_.update("cut", std::min(0.95, count_ / (2.0 * options_.patience + options_.rotations + 6.0)));
    ++count_;
    Trial failed;
    try {
        failed.rotation = rotation ? *rotation : candidate_rotations(disk, options_.m, options_.n, 1).front();
        return options_.measured ? measured(std::move(disk), failed.rotation, shares)
                                 : predicted(std::move(disk), failed.rotation, shares);
    } catch (const model::Error& e) { note(e); }
    return failed;
}

void CutTrials::note(const model::Error& failure) {
    if (failure.code().number == model::codes::kInterrupted.number || model::is_shortage(failure)) throw failure;
    if (!failure_) failure_ = failure;
}

Trial CutTrials::predicted(Disk disk, std::uint32_t rotation, BorderShares shares) const {
    TrialMap map = make_trial_map(std::move(disk), options_.m, options_.n, rotation, trial_options(), {}, shares);
    return {map.rms, rotation, std::move(map.disk), std::move(map.uv)};
}

Trial CutTrials::measured(Disk disk, std::uint32_t rotation, BorderShares shares) {
    SampledChart chart = make_square_chart(std::move(disk), options_.m, options_.n, rotation, *method_, {}, shares);
    if (!holds_topology(welded_topology(chart), topology_))
        throw model::Error(model::codes::kGridTooSmall, "the grid does not hold the topology of the cut");
    const double rms = quick_error(component_, chart, options_.samples, &index_.get()).rms;
    return {rms, rotation, *chart.disk, std::move(chart.uv)};
}

}  // namespace dgm::bake
