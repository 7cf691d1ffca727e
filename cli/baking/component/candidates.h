// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/candidates.h
// Compares the charts that several methods make of one component, by measured error.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baking/attempt.h"
#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "baking/chart_effort.h"
#include "baking/cpu_clock.h"
#include "geometry/chart/sampled_chart.h"
#include "geometry/fit/fit.h"
#include "geometry/spatial/lazy_index.h"

namespace dgm::bake {

enum class CandidateOutcome {
    kChosen,
    kHigherError,
    kMoreInverted,  ///< was the best by its error; after the fit another one had fewer inverted faces
    kFailed
};

/// The cut along which a chart was opened.
enum class CutKind {
    kFirst,    ///< the search's own
    kOther,    ///< searched from another beginning, or by prediction where the first one was measured
    kRing,     ///< of a ring, whose loops lie on opposite sides of the square
    kRefined,  ///< searched on the component with its facets divided
    kLimbs,    ///< to the tips of all limbs
    kFree      ///< of a free chart beside a square one
};

/// One method that was tried.
struct Candidate {
    Method method = Method::kAuto;
    CandidateOutcome outcome = CandidateOutcome::kHigherError;
    double psnr = 0;         ///< before the fit; 0 if it failed
    std::string note;        ///< kFailed: why; kChosen: the chart's note about itself, may be empty
    double cpu_seconds = 0;  ///< map and measurement, without the cut that candidates share; see Trials::clock
    bool directed = false;   ///< levelled to the directions of curvature
    bool fitted = false;     ///< compared with the one before after a trial fit of both
    CutKind cut = CutKind::kFirst;
    std::size_t remaps = 0;    ///< times that it was mapped anew where its fit had left error
    bool is_finalist = false;  ///< compared with another one after all fits of both
};

/// The same in words.
[[nodiscard]] CandidateReport report_of(const Candidate& candidate);

/// Facets up to which a map is also looked for with facets divided, and the two charts that are best after trial fits
/// are fitted: where grids are finer than facets, errors after the fit are 1 to 16 dB from what trials let expect.
inline constexpr std::size_t kFewFacets = 3500;

/// In rms. A free chart leaves samples unused, and the runtime's physics refuses it: it must be 3 dB better than one on
/// the square.
inline constexpr double kGainOfFree = 0.7;

/// The chart that came next to the one that was kept.
struct RunnerUp {
    SampledChart chart;
    TrialFit begun;
    std::size_t candidate = 0;  ///< its place in ComponentResult::candidates
};

/// The chart that was kept.
struct ComponentResult {
    SampledChart chart;
    Method method = Method::kAuto;      ///< that made it
    std::vector<Candidate> candidates;  ///< in the order tried
    std::optional<TrialFit> begun;      ///< of the chart, if there was a trial fit of it
    std::optional<RunnerUp> runner_up;  ///< of few facets, if there was a trial fit of both
    std::shared_ptr<LazyIndex> index;   ///< of the component, for those who measure the chart again

    [[nodiscard]] const ClosestPointIndex* source_index() const { return index_of(index); }
};

/// How candidates are measured.
struct Trials {
    std::uint64_t samples = kTrialSamples;        ///< points on each surface; ChartEffort's
    CpuClock::Of clock = CpuClock::Of::kProcess;  ///< their times
    std::shared_ptr<LazyIndex> index;             ///< of the component; null: one is built for each
};

/// Holds the best chart so far, and the record of all.
class Contest {
 public:
    /// `component` must outlive it.
    /// @param cut  of its charts
    explicit Contest(const TriMesh& component, CutKind cut = CutKind::kFirst, const Trials& trials = {})
        : component_(component), cut_(cut), trials_(trials) {}

    /// Makes a chart and measures it. The chart must have the component's topology. A failure is recorded.
    /// @param directed  its samples follow the directions of curvature
    /// @throws model::Error kInterrupted
    void enter(Method method, const std::function<SampledChart()>& make, bool directed = false);
    /// As enter(), for a chart of the best one's method and cut whose samples follow the directions of curvature. Where
    /// a fit is going to move them, its error before that says less the more samples there are on each facet: unless
    /// the chart is clearly better or worse, both are fitted for a few rounds and then compared.
    /// @param will_be_fitted  false: the samples stay where the map puts them
    /// There must be a best chart.
    void challenge(const std::function<SampledChart()>& make, bool will_be_fitted, const model::Progress& progress);
    /// Compares the best chart of `rival`, a contest about the same component, with the best one here and takes it over
    /// if it is better. Where a fit is going to move the samples, both are fitted as in challenge() unless their errors
    /// differ clearly. Takes over the record of the rival's charts in any case.
    /// @return  true if the rival's is the best now
    bool meet(Contest&& rival, bool will_be_fitted, const model::Progress& progress);
    /// Takes over the best chart of `rival`, which has one, whatever its error, and the record.
    void yield_to(Contest&& rival);
    /// Records that no chart of the next candidates could be tried.
    void fail(const model::Error& error) { failure_ = error; }

    [[nodiscard]] bool has_best() const { return best_.has_value(); }
    [[nodiscard]] double best_psnr() const { return candidates_[best_index_].psnr; }
    /// Before a fit, normalised units.
    [[nodiscard]] double best_rms() const { return best_->rms; }
    [[nodiscard]] const SampledChart& best_chart() const { return best_->chart; }
    [[nodiscard]] Method best_method() const { return candidates_[best_index_].method; }
    [[nodiscard]] bool best_is_directed() const { return candidates_[best_index_].directed; }
    [[nodiscard]] bool tried(Method method) const;
    /// The highest PSNR before a fit of charts by LSCM and ARAP; nothing if there is none.
    [[nodiscard]] std::optional<double> best_psnr_of_free() const;
    /// True if enter() had no chart of it.
    [[nodiscard]] bool failed(Method method) const;
    /// The best chart, or the last failure if there is none.
    [[nodiscard]] Attempt<ComponentResult> result() &&;

 private:
    struct Entry {
        SampledChart chart;
        double rms = 0;                   ///< as the map has it
        std::optional<TrialFit> begun{};  ///< once there was a trial fit
    };
    using Wins = std::function<bool(Entry& entry, Candidate& candidate)>;

    /// Takes over the record of the rival's charts, and its runner-up if that is the better one.
    /// @return  the place that the record of its best chart has here
    std::size_t take_record(Contest& rival);
    /// The best chart from now on.
    void crown(Entry&& entry, std::size_t index);
    /// Keeps a chart that was not the best if none that was not had less error after its trial fit.
    void retire(Entry&& entry, std::size_t index);
    void judge(Candidate candidate, const std::function<SampledChart()>& make, const Wins& wins);
    [[nodiscard]] bool wins(const Entry& entry) const;
    [[nodiscard]] bool wins_challenge(Entry& entry, Candidate& candidate, const model::Progress& progress);
    [[nodiscard]] bool beats_best(Entry& entry, Candidate& candidate, bool will_be_fitted,
                                  const model::Progress& progress);
    /// @param clearly  as fit_trials()
    [[nodiscard]] bool wins_fitted(Entry& entry, Candidate& candidate, double clearly, const model::Progress& progress);

    const TriMesh& component_;
    CutKind cut_;
    Trials trials_;
    std::vector<Candidate> candidates_;
    std::optional<Entry> best_, second_;
    std::optional<model::Error> failure_;
    std::optional<Topology> topology_;  ///< of the component, once a chart is compared with it
    std::size_t best_index_ = 0, second_index_ = 0;
};

}  // namespace dgm::bake
