// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/candidates.cpp
#include "baking/component/candidates.h"

#include <algorithm>
#include <utility>

#include "baking/cpu_clock.h"
#include "baking/methods.h"
#include "geometry/fit/fit.h"
#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {

using model::Error;

constexpr double kGain = 0.99;    // a later candidate must be 1 % better, and the earlier not exact but for rounding
constexpr double kExact = 1e-10;  // normalised units
constexpr std::uint64_t kSamples = 20'000;
// With two vertices of the source to a sample the error before the fit tells which chart has the lower one after it;
// with one, 1.2 dB do.
constexpr std::size_t kVerticesToTell = 2;
constexpr double kSureGain = 0.87;

struct MeasuredCandidate {
    SampledChart chart;
    SurfaceError error;
};

/// The welded grid surface must be the manifold that the component is.
void check_topology(const TriMesh& component, const SampledChart& chart) {
    const Topology map = welded_topology(chart);
    const Topology source = measure_topology(component);
    if (holds_topology(map, source)) return;
    throw Error(model::codes::kGridTooSmall,
                chart.method + ": a grid of " + std::to_string(chart.m) + "x" + std::to_string(chart.n) +
                    " does not hold the surface's topology (genus " + std::to_string(source.genus) + ", " +
                    std::to_string(source.boundary_loops) + " borders; the grid has genus " +
                    std::to_string(map.genus) + ", " + std::to_string(map.boundary_loops) + " borders, " +
                    std::to_string(map.degenerate_faces) + " degenerate faces" +
                    (map.manifold ? "" : ", not manifold") + ")");
}

}  // namespace

CandidateReport report_of(const Candidate& candidate) {
    CandidateReport out{std::string(name_of(candidate.method)), candidate.psnr, candidate.note, candidate.cpu_seconds};
    if (candidate.outcome != CandidateOutcome::kFailed) {
        out.outcome = candidate.outcome == CandidateOutcome::kChosen ? "chosen" : "higher error";
        if (candidate.fitted) out.outcome += " after a trial fit";
        if (candidate.directed) out.outcome += "; along the directions of curvature";
        if (candidate.outcome == CandidateOutcome::kChosen && !candidate.note.empty())
            out.outcome += "; " + candidate.note;
    }
    return out;
}

void Contest::enter(Method method, const std::function<SampledChart()>& make) {
    Candidate candidate;
    candidate.method = method;
    judge(std::move(candidate), make,
          [this](const SampledChart& chart, double rms, Candidate&) { return !best_ || wins(chart, rms); });
}

void Contest::challenge(const std::function<SampledChart()>& make, bool will_be_fitted,
                        const model::Progress& progress) {
    Candidate candidate;
    candidate.method = best_method();
    candidate.directed = true;
    judge(std::move(candidate), make, [&](const SampledChart& chart, double rms, Candidate& as) {
        return will_be_fitted ? wins_fitted(chart, rms, as, progress) : wins(chart, rms);
    });
}

void Contest::judge(Candidate candidate, const std::function<SampledChart()>& make, const Wins& wins) {
    const CpuClock clock;
    Attempt<MeasuredCandidate> made = attempt([&] {
        MeasuredCandidate out{make(), {}};
        check_topology(component_, out.chart);
        out.error = quick_error(component_, out.chart, kSamples);
        return out;
    });
    if (made) {
        candidate.psnr = made->error.psnr();
        if (wins(made->chart, made->error.rms, candidate)) {
            if (!candidate.fitted) begun_.reset();
            best_ = std::move(made->chart);
            best_rms_ = made->error.rms;
            best_index_ = candidates_.size();
        }
    } else {
        candidate.outcome = CandidateOutcome::kFailed;
        candidate.note = made.error().what();
        failure_ = made.error();
    }
    candidate.cpu_seconds = clock.seconds();
    candidates_.push_back(std::move(candidate));
}

bool Contest::wins_fitted(const SampledChart& chart, double rms, Candidate& candidate,
                          const model::Progress& progress) {
    if (!(rms < best_rms_)) return false;
    const std::size_t vertices = component_.positions.size();
    if (kVerticesToTell * chart.grid_count() <= vertices) return wins(chart, rms);
    if (chart.grid_count() <= vertices && rms < kSureGain * best_rms_) return true;
    candidate.fitted = true;
    TrialFit challenger = trial_fit(chart, progress), holder = trial_fit(*best_, progress);
    const bool better = challenger.rms < kGain * holder.rms;
    begun_ = std::move(better ? challenger : holder);
    return better;
}

/// Between charts that differ by less than 1 % or by rounding, the one that uses all samples wins, then the earlier
/// one.
bool Contest::wins(const SampledChart& chart, double rms) const {
    if (chart.domain == layout::Domain::kSquare && best_->domain == layout::Domain::kFree)
        return kGain * rms < best_rms_ || rms <= kExact;
    return rms < kGain * best_rms_ && best_rms_ > kExact;
}

bool Contest::tried(Method method) const {
    return std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& c) { return c.method == method; });
}

bool Contest::failed(Method method) const {
    return std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& c) {
        return c.method == method && !c.directed && c.outcome == CandidateOutcome::kFailed;
    });
}

Attempt<ComponentResult> Contest::result() && {
    if (!best_) return *failure_;
    Candidate& chosen = candidates_[best_index_];
    chosen.outcome = CandidateOutcome::kChosen;
    chosen.note = best_->note;
    const Method method = chosen.method;
    return ComponentResult{std::move(*best_), method, std::move(candidates_), std::move(begun_)};
}

}  // namespace dgm::bake
