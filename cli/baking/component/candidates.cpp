// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/candidates.cpp
#include "baking/component/candidates.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "baking/methods.h"
#include "geometry/fit/fit.h"
#include "geometry/mesh/infinity.h"
#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {

using model::Error;

constexpr double kGain = 0.99;  // a later candidate must be 1 % better, and the earlier not exact but for rounding
// Of trial fits along different cuts: one that was 2 % better lost 1.3 dB in the end, 5 to 24 % better ones won.
constexpr double kGainOfOtherCut = 0.97;
constexpr double kExact = 1e-10;  // normalised units
// With two vertices of the source to a sample the error before the fit tells which chart has the lower one after it;
// with one, 1.2 dB do.
constexpr std::size_t kVerticesToTell = 2;
// Of charts along one cut, after the first of three rounds: 1.04 has changed sides by the third, 1.14 to 1.9 never did.
constexpr double kClearlyBehind = 1.15;
constexpr double kSureGain = 0.87, kClearGain = 0.5;
// After a trial fit, of a chart that may be the best one after the fit. A ring is chosen for more than its error.
// Free charts go on gaining (a jacket's had 2.3 times the error of one on the square then, and a sixth in the end).
constexpr double kCloseBehind = 1.6, kFreeGoesOn = 0.64;

struct MeasuredCandidate {
    SampledChart chart;
    SurfaceError error;
};

/// After rounds that gain as the last ones did. Charts that stretch little go on gaining where others have ended: a
/// statue had 2.3 dB less error than on the square after the trial and 9.6 after the fit.
double expected_rms(const TrialFit& fit) {
    return fit.rms * std::min(1.0, fit.rms / fit.first_rms);
}

/// What a chart that was not the best after a trial fit may still come to, beside others.
double promise_of(const SampledChart& chart, const TrialFit& fit) {
    return fit.rms * (chart.domain == layout::Domain::kFree ? kFreeGoesOn : 1);
}

/// The welded grid surface must be the manifold that the component is.
void check_topology(const Topology& source, const SampledChart& chart) {
    const Topology map = welded_topology(chart);
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
        out.outcome = candidate.outcome == CandidateOutcome::kChosen         ? "chosen"
                      : candidate.outcome == CandidateOutcome::kMoreInverted ? "more inverted faces"
                                                                             : "higher error";
        if (candidate.is_finalist)
            out.outcome += " after the fit";
        else if (candidate.fitted)
            out.outcome += " after a trial fit";
        if (candidate.cut == CutKind::kOther) out.outcome += "; along another cut";
        if (candidate.cut == CutKind::kRing) out.outcome += "; loops on opposite sides";
        if (candidate.cut == CutKind::kRefined) out.outcome += "; facets divided";
        if (candidate.cut == CutKind::kLimbs) out.outcome += "; cut to the tips of limbs";
        if (candidate.directed) out.outcome += "; along the directions of curvature";
        if (candidate.remaps > 0) out.outcome += "; more room where the fit left error";
        if (candidate.outcome == CandidateOutcome::kChosen && !candidate.note.empty())
            out.outcome += "; " + candidate.note;
    }
    return out;
}

void Contest::enter(Method method, const std::function<SampledChart()>& make, bool directed) {
    Candidate candidate;
    candidate.method = method;
    candidate.directed = directed;
    judge(std::move(candidate), make, [this](const Entry& entry, Candidate&) { return !best_ || wins(entry); });
}

void Contest::challenge(const std::function<SampledChart()>& make, bool will_be_fitted,
                        const model::Progress& progress) {
    Candidate candidate;
    candidate.method = best_method();
    candidate.directed = true;
    judge(std::move(candidate), make, [&](Entry& entry, Candidate& as) {
        return will_be_fitted ? wins_challenge(entry, as, progress) : wins(entry);
    });
}

std::size_t Contest::take_record(Contest& rival) {
    const std::size_t first = candidates_.size();
    std::move(rival.candidates_.begin(), rival.candidates_.end(), std::back_inserter(candidates_));
    if (rival.second_) retire(std::move(*rival.second_), first + rival.second_index_);
    return first + rival.best_index_;
}

void Contest::crown(Entry&& entry, std::size_t index) {
    if (best_) retire(std::move(*best_), best_index_);
    best_ = std::move(entry);
    best_index_ = index;
}

void Contest::retire(Entry&& entry, std::size_t index) {
    if (!entry.begun || component_.faces.size() > kFewFacets) return;
    if (second_ && promise_of(second_->chart, *second_->begun) <= promise_of(entry.chart, *entry.begun)) return;
    second_ = std::move(entry);
    second_index_ = index;
}

bool Contest::meet(Contest&& rival, bool will_be_fitted, const model::Progress& progress) {
    const CpuClock clock(trials_.clock);
    const std::size_t at = take_record(rival);
    if (!rival.best_) {
        if (!failure_) failure_ = std::move(rival.failure_);
        return false;
    }
    const bool better = !best_ || beats_best(*rival.best_, candidates_[at], will_be_fitted, progress);
    candidates_[at].cpu_seconds += clock.seconds();
    if (better)
        crown(std::move(*rival.best_), at);
    else
        retire(std::move(*rival.best_), at);
    return better;
}

void Contest::yield_to(Contest&& rival) {
    best_index_ = take_record(rival);
    best_ = std::move(rival.best_);
    second_.reset();
}

/// Of charts along different cuts the error before the fit tells less than of two charts along one: a hat had 1.5 dB
/// less before it and 2 dB more after it.
bool Contest::beats_best(Entry& entry, Candidate& candidate, bool will_be_fitted, const model::Progress& progress) {
    if (best_->rms <= kExact || entry.rms <= kExact || !will_be_fitted) return wins(entry);
    if (entry.chart.grid_count() <= component_.positions.size()) {
        if (entry.rms < kClearGain * best_->rms) return true;
        if (best_->rms < kClearGain * entry.rms) return false;
    }
    return wins_fitted(entry, candidate, kInfinity, progress);
}

void Contest::judge(Candidate candidate, const std::function<SampledChart()>& make, const Wins& wins) {
    const CpuClock clock(trials_.clock);
    candidate.cut = cut_;
    Attempt<MeasuredCandidate> made = attempt([&] {
        MeasuredCandidate out{make(), {}};
        if (!topology_) topology_ = measure_topology(component_);
        check_topology(*topology_, out.chart);
        out.error = quick_error(component_, out.chart, trials_.samples, index_of(trials_.index));
        return out;
    });
    if (made) {
        candidate.psnr = made->error.psnr();
        Entry entry{std::move(made->chart), made->error.rms, {}};
        if (wins(entry, candidate))
            crown(std::move(entry), candidates_.size());
        else
            retire(std::move(entry), candidates_.size());
    } else {
        candidate.outcome = CandidateOutcome::kFailed;
        candidate.note = made.error().what();
        failure_ = made.error();
    }
    candidate.cpu_seconds = clock.seconds();
    candidates_.push_back(std::move(candidate));
}

bool Contest::wins_challenge(Entry& entry, Candidate& candidate, const model::Progress& progress) {
    if (!(entry.rms < best_->rms)) return false;
    const std::size_t vertices = component_.positions.size();
    if (kVerticesToTell * entry.chart.grid_count() <= vertices) return wins(entry);
    if (entry.chart.grid_count() <= vertices && entry.rms < kSureGain * best_->rms) return true;
    return wins_fitted(entry, candidate, kClearlyBehind, progress);
}

bool Contest::wins_fitted(Entry& entry, Candidate& candidate, double clearly, const model::Progress& progress) {
    candidate.fitted = true;
    fit_trials({{{entry.chart, entry.begun}, {best_->chart, best_->begun}}}, clearly, progress);
    // Free charts of whole facets go on gaining beside those of divided ones: a jacket had 1.7 times their error after
    // the trial, and 13 dB less after the fit.
    const bool refined = candidate.cut == CutKind::kRefined;
    if (candidate.cut == CutKind::kFree || (refined && best_->chart.domain == layout::Domain::kFree))
        return expected_rms(*entry.begun) < kGainOfFree * expected_rms(*best_->begun);
    const bool other = refined || candidate.cut == CutKind::kOther || candidate.cut == CutKind::kLimbs;
    return entry.begun->rms < (other ? kGainOfOtherCut : kGain) * best_->begun->rms;
}

/// Between charts that differ by less than 1 % or by rounding, the one that uses all samples wins, then the earlier
/// one.
bool Contest::wins(const Entry& entry) const {
    if (entry.chart.domain == layout::Domain::kSquare && best_->chart.domain == layout::Domain::kFree)
        return kGain * entry.rms < best_->rms || entry.rms <= kExact;
    return entry.rms < kGain * best_->rms && best_->rms > kExact;
}

bool Contest::tried(Method method) const {
    return std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& c) { return c.method == method; });
}

std::optional<double> Contest::best_psnr_of_free() const {
    std::optional<double> best;
    for (const Candidate& c : candidates_) {
        if (c.outcome == CandidateOutcome::kFailed || (c.method != Method::kLscm && c.method != Method::kArap))
            continue;
        best = std::max(c.psnr, best.value_or(c.psnr));
    }
    return best;
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
    chosen.note = best_->chart.note;
    ComponentResult out{std::move(best_->chart), chosen.method, {}, std::move(best_->begun), {}, trials_.index};
    const bool is_close =
        second_ && out.begun && promise_of(second_->chart, *second_->begun) < kCloseBehind * out.begun->rms;
    const bool has_ring = chosen.cut == CutKind::kRing || candidates_[second_index_].cut == CutKind::kRing;
    if (is_close && !has_ring) out.runner_up = {std::move(second_->chart), *std::move(second_->begun), second_index_};
    out.candidates = std::move(candidates_);
    return out;
}

}  // namespace dgm::bake
