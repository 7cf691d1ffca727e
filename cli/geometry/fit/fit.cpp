// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit.cpp
#include "geometry/fit/fit.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/fit/edge_snap.h"
#include "geometry/fit/fit_state.h"
#include "geometry/fit/lattice_snap.h"
#include "geometry/fit/local_repair.h"
#include "geometry/fit/normal_equations.h"
#include "geometry/fit/region.h"
#include "geometry/fit/vertex_repair.h"
#include "geometry/metrics/turned_faces.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr double kStartUpright = 0.2;   // cosine to the source below which faces are repaired at the start
constexpr double kGainOfRounds = 3e-3;  // in rms, of two rounds, to go on: 0.03 dB
// Facets of the source a face of the grid, up to which samples go to its edges: beyond, none of many is worth more.
constexpr double kFacets = 2.5, kFacetsOfLargeGrid = 0.4;
constexpr double kRoundsOfDense = 0.64;  // of the rounds for the mean, with the points of a dense source
constexpr double kFarOff = 0.15;         // of the largest error: faces that the rounds for it work on
constexpr double kSureGain = 0.6;        // in rms; ordinary charts reach 0.2
constexpr double kInvertedPrice = 1.25;  // in rms, of faces that a fit inverts
constexpr double kRepairPrice = 1.5, kRepairLargest = 3;  // in rms and in the largest error, of fewer inverted faces
// The same where no more than one in so many is left: a tree of tubes keeps 10 of 1,159 at 1.63 in rms, a Schwarz
// lantern 0 of 1,185 at 1.02 and 3.6.
constexpr double kFewInvertedPrice = 2, kFewInvertedLargest = 5;
constexpr std::size_t kFewInverted = 20;
// The hardest shapes measured, at 65 x 65, take 14,000 faces a sample; 190,000 are allowed there.
constexpr std::uint64_t kLooksPerSample = 40'000, kFewestSamples = 20'000;
constexpr double kPointsOfDense = 16;  // a sample; with 8, `l2` needs 11 rounds for less than it reaches in 7
constexpr double kTrialPoints = 3;     // a sample, and three times as many on small grids
constexpr double kExact = 1e-10;       // normalised units: nothing is left to fit
// Facets a face of a large grid, up to which a fit begins twice: of 8 larger ones one gained 0.1 dB, for a second each.
constexpr double kFacetsBegunTwice = 0.02;
constexpr std::size_t kMostBegunTwice = 300'000;  // samples: two fits at once take twice the memory

/// Options and progress of one fit.
struct Plan {
    const FitOptions& options;
    const model::Progress* progress;

    void begin_round(int round) const {
        constexpr int kRepair = 2;  // rounds that the steps after the last one take as long as
        progress->update("fit", static_cast<double>(round) / (options.rounds + options.worst_rounds + kRepair));
    }
};

bool is_large(const WeldedGrid& grid) {
    return grid.sample_of.size() >= kLargeGrid;
}

/// Rounds that pull hardest where the error is near the largest, at a bounded price in the mean. A round that inverts a
/// face does not count: to repair it would cost more than was gained.
void lower_largest(FitState& fit, const Plan& plan, FitReport& report) {
    fit.look_up_farthest();
    const double allowed = fit.kept.rms * math::pow(10, plan.options.worst_price_db / 20);
    fit.kept.largest = fit.largest();
    const std::vector<std::uint32_t> left = fit.inverted.doubtful_faces(fit.matches, kEndUpright);
    for (int round = 0; round < plan.options.worst_rounds && !fit.is_spent(); ++round) {
        plan.begin_round(plan.options.rounds + round);
        const std::vector<Vec3d> before = fit.grid.surface.positions;
        const Region region =
            is_large(fit.grid) ? around_far(fit.grid, fit.matches, kFarOff * fit.largest()) : Region{};
        fit.step(true, region);
        fit.matches.update(true, region.faces);
        const bool sound =
            fit.take_back(before, [&] { return without(fit.inverted.doubtful_faces(fit.matches, kEndUpright), left); });
        fit.matches.settle_farthest(fit.inverted.source_index());
        const bool closer = fit.largest() < fit.kept.largest && fit.matches.rms <= allowed;
        if (!sound) continue;
        if (!closer && !(fit.largest() <= fit.kept.largest && fit.matches.rms < fit.kept.rms)) continue;
        fit.keep();
        ++report.rounds;
    }
}

/// The rounds for the largest error, and the diagonals that go with them.
void settle(FitState& fit, const Plan& plan, FitReport& report) {
    lower_largest(fit, plan, report);
    fit.restore();
    if (plan.options.split_quads) {
        fit.matches.update(false);
        fit.split_quads();
        fit.look_up_farthest();
        if (fit.matches.rms < fit.kept.rms && fit.largest() <= fit.kept.largest)
            fit.keep();
        else
            fit.restore();
    }
    fit.matches.update(false);
}

/// @param guarded  corners of faces that it inverts go back
/// @return  false if that does not do
bool lower_mean_once(FitState& fit, bool guarded) {
    std::vector<std::uint32_t> left;
    if (guarded) left = fit.inverted.doubtful_faces(fit.matches, kEndUpright);
    const std::vector<Vec3d> before = fit.grid.surface.positions;
    fit.step(false);
    fit.matches.update(false);
    if (!guarded) return true;
    return fit.take_back(before, [&] { return without(fit.inverted.doubtful_faces(fit.matches, kEndUpright), left); });
}

/// The rounds for the mean error, which may be done in parts.
class MeanRounds {
 public:
    MeanRounds(FitState& fit, const Plan& plan, FitReport& report) : fit_(fit), plan_(plan), report_(report) {
        if (plan.options.split_quads) fit.split_quads();
        if (fit.sliding.occupy_corners()) fit.matches.update(false);
        if (repair_by_vertex(fit.source, fit.grid, fit.matches, fit.fixed, kStartUpright)) fit.matches.update(false);
        fit.keep();
    }

    /// Goes on until so many rounds are done, or they gain nothing.
    void run(int rounds) {
        for (; round_ < rounds && gained_ + gained_before_ > kGainOfRounds && !fit_.is_spent(); ++round_) {
            plan_.begin_round(round_);
            if (plan_.options.split_quads && round_ % 2 == 0) fit_.split_quads();
            kept_ = lower_mean_once(fit_, plan_.options.guarded) && fit_.matches.rms < fit_.kept.rms;
            gained_before_ = gained_;
            gained_ = std::max(0.0, 1 - fit_.matches.rms / fit_.kept.rms);
            if (!kept_) {
                fit_.rest();
                continue;
            }
            fit_.keep();
            ++report_.rounds;
        }
    }

    /// The grid lies in the best state.
    void finish() {
        if (kept_ && plan_.options.worst_rounds <= 0) return;
        fit_.restore();
        fit_.matches.update(false);
    }

 private:
    FitState& fit_;
    const Plan& plan_;
    FitReport& report_;
    int round_ = 0;
    bool kept_ = true;
    double gained_ = 1, gained_before_ = 1;
};

/// Facets of the source a face of the grid.
double facets_per_face(const SampledChart& chart) {
    return static_cast<double>(chart.disk->mesh.faces.size()) / static_cast<double>(chart.faces().size());
}

/// True if samples go to the source's edges. On large grids each snap takes as long as all rounds of a source of many
/// facets, and gains little there.
bool goes_to_edges(const SampledChart& chart, const FitOptions& options) {
    if (options.snaps <= 0 || !options.split_quads) return false;
    const bool is_large = chart.grid_count() >= kLargeGrid;
    return facets_per_face(chart) <= (options.worst_rounds > 0 || !is_large ? kFacets : kFacetsOfLargeGrid);
}

/// True if a fit that may go on from a trial also begins afresh.
bool begins_twice(const SampledChart& chart, const FitOptions& options) {
    const std::size_t samples = chart.grid_count();
    if (samples > kMostBegunTwice || !goes_to_edges(chart, options)) return false;
    return samples < kLargeGrid || facets_per_face(chart) <= kFacetsBegunTwice;
}

/// A fit of a chart from where its samples are, as far as it has come.
struct Course {
    Course(SampledChart& chart, const Plan& its_plan)
        : plan(its_plan), fit(chart, plan.options), goes_to_edges(bake::goes_to_edges(chart, plan.options)) {
        fit.matches.update(false);
        report.start_rms = fit.matches.rms;
        report.start_hausdorff = fit.matches.largest;
        report.was_exact = fit.largest() < kExact;
        if (report.was_exact) fit.keep();
    }

    /// A snap to the source's edges, and the first `rounds` for the mean error.
    void begin(int rounds) {
        if (goes_to_edges) {
            fit.split_quads();
            (void)snap_to_edges(fit);
        }
        mean.emplace(fit, plan, report);
        mean->run(rounds);
    }

    Plan plan;
    FitState fit;
    FitReport report;
    std::optional<MeanRounds> mean;  ///< once begun
    bool goes_to_edges;
};

/// The rounds for the mean error, fewer where many points make each of them better. The grid lies in the best state
/// afterwards.
void lower_mean(Course& course) {
    const int count = course.plan.options.rounds;
    if (!course.mean) course.begin(0);
    course.mean->run(course.fit.has_dense_points ? static_cast<int>(std::lround(kRoundsOfDense * count)) : count);
    course.mean->finish();
}

/// Samples go to edges that the rounds have left faces across, and a few rounds follow. The grid lies in the best state
/// afterwards.
void snap_and_lower_mean(FitState& fit, FitReport& report) {
    constexpr int kRounds = 3;
    fit.rest();
    if (!snap_to_edges(fit)) return;
    const auto keep_if_better = [&] {
        if (!(fit.matches.rms < fit.kept.rms)) return;
        fit.keep();
        ++report.rounds;
    };
    keep_if_better();
    for (int round = 0; round < kRounds && !fit.is_spent(); ++round) {
        (void)lower_mean_once(fit, false);
        keep_if_better();
    }
    fit.restore();
    fit.matches.update(false);
}

/// The rounds for the mean error, with snaps to the source's edges before and after them.
void lower_mean_with_snaps(Course& course) {
    constexpr double kGainOfSnap = 0.97;  // in rms, of one, to go on
    lower_mean(course);
    for (int snap = 0; course.goes_to_edges && snap + 1 < course.plan.options.snaps && !course.fit.is_spent(); ++snap) {
        const double before = course.fit.kept.rms;
        snap_and_lower_mean(course.fit, course.report);
        if (course.fit.kept.rms > kGainOfSnap * before) break;
    }
}

/// The rounds for the mean error, then those for the largest.
void run_rounds(Course& course, LocalRepair& repair) {
    if (course.plan.options.guarded) {
        course.fit.keep();
        repair.repair();
    }
    lower_mean_with_snaps(course);
    if (course.plan.options.worst_rounds <= 0 || course.fit.is_spent()) return;
    repair.repair();
    settle(course.fit, course.plan, course.report);
}

void put_on_lattice(FitState& fit) {
    fit.grid.write_positions(fit.chart);
    const Lattice lattice = lattice_around(fit.chart);
    if (!(lattice.step > 0)) return;
    fit.equations.clear();
    fit.rows.assemble(fit.equations, false, {}, true);
    snap_to_lattice(lattice, fit.equations, fit.rails.freedom(), fit.chart.grid_count(), fit.source, fit.grid,
                    fit.matches, fit.inverted);
    fit.kept.rms = fit.matches.rms;
    fit.kept.largest = fit.largest();
    fit.chart.lattice = lattice;
}

/// The chart takes the fitted positions, and for its samples the closest points of the source.
void write_chart(FitState& fit) {
    fit.grid.write_positions(fit.chart);
    for (std::size_t s = 0; s < fit.chart.samples.size(); ++s) {
        const std::uint32_t c = fit.grid.class_of[s];
        if (c == kNone) continue;
        if (fit.fixed[c]) {
            if (fit.rails.has_moved(c)) fit.chart.samples[s] = fit.rails.sample(c);
            continue;
        }
        const SurfaceHit& hit = fit.matches.classes[c].hit;
        fit.chart.samples[s] = {hit.face, {hit.b[0], hit.b[1], hit.b[2]}};
    }
}

Placement placement_of(const SampledChart& chart) {
    return {chart.positions, chart.diagonals, chart.samples, chart.lattice};
}

/// The chart takes a placement, which takes the chart's.
void swap_placement(SampledChart& chart, Placement& other) {
    chart.positions.swap(other.positions);
    chart.diagonals.swap(other.diagonals);
    chart.samples.swap(other.samples);
    chart.lattice.swap(other.lattice);
}

/// Measures the chart as it is and as it was against all faces of the source: walks between matches flatter a map that
/// folds.
bool is_worse_than(Placement& start, FitState& fit, std::uint64_t samples) {
    const TriMesh& mesh = fit.chart.disk->mesh;
    const ClosestPointIndex& source = fit.inverted.source_index();
    const SurfaceError after = quick_error(mesh, fit.chart, samples, &source);
    swap_placement(fit.chart, start);
    const SurfaceError before = quick_error(mesh, fit.chart, samples, &source);
    const TriMesh surface_before = fit.chart.surface();
    swap_placement(fit.chart, start);
    if (kFewInvertedPrice * before.rms < after.rms) return true;
    const std::size_t are = fit.inverted.faces().size();
    if (are == 0 && !(before.rms < after.rms)) return false;
    const std::size_t were =
        find_turned_faces(source, surface_before, kTurnedTie, 0, fit.grid.surface.either_side).size();
    // A small gain is not worth faces that it inverts.
    if (are > were) return before.rms < kInvertedPrice * after.rms;
    if (are == were) return before.rms < after.rms;
    // Repairs may cost something where so many faces were inverted that the start's figures mean little.
    const bool few_left = kFewInverted * are <= were;
    const double largest = few_left ? kFewInvertedLargest : kRepairLargest;
    const double price = after.hausdorff > largest * before.hausdorff ? 1 : few_left ? kFewInvertedPrice : kRepairPrice;
    return before.rms * price < after.rms;
}

}  // namespace

FitOptions l2_fit() {
    FitOptions o;
    o.points_of_dense = kPointsOfDense;
    o.rounds = 11;
    o.snaps = 2;
    return o;
}

FitOptions best_fit() {
    FitOptions o;
    o.rounds = 20;
    o.worst_rounds = 8;
    o.snaps = 4;
    return o;
}

FitOptions guarded(FitOptions options) {
    options.guarded = true;
    options.snaps = 0;
    return options;
}

FitOptions firm(FitOptions options) {
    options.hold = kFirm;
    options.rounds /= 2;
    return options;
}

std::uint64_t most_looks_of(std::size_t samples) {
    return kLooksPerSample * std::max<std::uint64_t>(samples, kFewestSamples);
}

namespace {

/// The rest of a fit, whose chart was at `start` before it and had `start_rms`.
FitReport finish(Course& course, Placement start, double start_rms) {
    FitState& fit = course.fit;
    const FitOptions& options = course.plan.options;
    LocalRepair repair(fit, options.patch_effort);
    FitReport& report = course.report;
    report.start_rms = start_rms;
    if (!report.was_exact) run_rounds(course, repair);
    course.plan.begin_round(options.rounds + options.worst_rounds);
    repair.repair();
    repair.repair_nearly();
    repair.repair_at_a_price();
    if (options.on_lattice) put_on_lattice(fit);
    write_chart(fit);
    report.looked = fit.matches.looked();
    report.ended_early = fit.is_spent();
    report.inverted = fit.inverted.faces().size();
    report.rms = fit.kept.rms;
    report.hausdorff = fit.kept.largest;
    SampledChart& chart = fit.chart;
    const bool moved = chart.positions != start.positions || chart.diagonals != start.diagonals;
    if (moved && fit.kept.rms > kSureGain * report.start_rms && is_worse_than(start, fit, options.trial_samples)) {
        swap_placement(chart, start);
        report.rms = report.start_rms;
        report.hausdorff = report.start_hausdorff;
        report.rounds = 0;
        report.inverted =
            find_turned_faces(fit.inverted.source_index(), chart.surface(), kTurnedTie, 0, fit.grid.surface.either_side)
                .size();
    }
    return report;
}

/// A fit of `chart` from where a trial has left its samples, or from where the map has put them: a trial lets samples
/// slide off the source's edges, which a fit puts them on first. Whichever has the lower error after a few rounds goes
/// on. Of 22 such pairs that told 15; the others lost 0.3 to 2.2 dB (one 14, where a face was inverted), where to go on
/// from the trial had cost up to 11.
FitReport fit_better_start(SampledChart& chart, const Plan& plan, const TrialFit& begun) {
    constexpr int kTold = 3;
    Placement start = placement_of(chart);
    SampledChart moved = chart;
    take_placement(moved, begun.placement);
    const model::Progress silent{{}, plan.progress->cancelled};  // one of two threads reports
    std::optional<Course> afresh, onwards;
    const auto begin = [](std::optional<Course>& course, SampledChart& its_chart, const Plan& its_plan) {
        course.emplace(its_chart, its_plan);
        if (!course->report.was_exact) course->begin(kTold);
    };
    tbb::parallel_invoke([&] { begin(afresh, chart, plan); }, [&] { begin(onwards, moved, {plan.options, &silent}); });
    if (afresh->fit.kept.rms < onwards->fit.kept.rms) {
        onwards.reset();
        return finish(*afresh, std::move(start), begun.start_rms);
    }
    afresh.reset();
    onwards->plan.progress = plan.progress;
    const FitReport report = finish(*onwards, std::move(start), begun.start_rms);
    onwards.reset();
    chart = std::move(moved);
    return report;
}

}  // namespace

void take_placement(SampledChart& chart, Placement from) {
    swap_placement(chart, from);
}

FitReport fit_chart(SampledChart& chart, const FitOptions& options, const model::Progress& progress,
                    const TrialFit* begun) {
    const Plan plan{options, &progress};
    if (begun != nullptr && begins_twice(chart, options)) return fit_better_start(chart, plan, *begun);
    Placement start = placement_of(chart);
    if (begun != nullptr) take_placement(chart, begun->placement);
    Course course(chart, plan);
    const double start_rms = begun != nullptr ? begun->start_rms : course.report.start_rms;
    return finish(course, std::move(start), start_rms);
}

namespace {

FitOptions trial_options() {
    FitOptions out;
    out.points_per_sample = kTrialPoints;
    return out;
}

/// A trial fit while it goes on.
class TrialRounds {
 public:
    TrialRounds(SampledChart& chart, const model::Progress& progress)
        : chart_(chart), start_(placement_of(chart)), plan_{options_, &progress}, fit_(chart, options_) {
        fit_.matches.update(false);
        out_.start_rms = fit_.matches.rms;
        rounds_.emplace(fit_, plan_, report_);
        rounds_->run(1);
        out_.first_rms = fit_.kept.rms;
    }
    [[nodiscard]] double first_rms() const { return out_.first_rms; }
    void run_all() { rounds_->run(options_.rounds); }
    /// The chart is as before afterwards.
    [[nodiscard]] TrialFit result() && {
        rounds_->finish();
        write_chart(fit_);
        swap_placement(chart_, start_);
        out_.placement = std::move(start_);
        out_.rms = fit_.kept.rms;
        return std::move(out_);
    }

 private:
    SampledChart& chart_;
    Placement start_;
    FitOptions options_ = trial_options();
    Plan plan_;
    FitState fit_;
    FitReport report_;
    std::optional<MeanRounds> rounds_;
    TrialFit out_;
};

}  // namespace

TrialFit trial_fit(SampledChart& chart, const model::Progress& progress) {
    TrialRounds rounds(chart, progress);
    rounds.run_all();
    return std::move(rounds).result();
}

void fit_trials(const std::array<TrialOf, 2>& trials, double clearly, const model::Progress& progress) {
    const model::Progress silent{{}, progress.cancelled};  // one of two threads reports
    std::array<std::optional<TrialRounds>, 2> rounds;
    std::array<double, 2> first{};
    const auto begin = [&](std::size_t k) {
        if (!trials[k].fit)
            first[k] = rounds[k].emplace(trials[k].chart, k == 0 ? progress : silent).first_rms();
        else
            first[k] = trials[k].fit->first_rms;
    };
    const auto end = [&](std::size_t k) {
        if (!rounds[k]) return;
        if (!(first[k] > clearly * first[1 - k])) rounds[k]->run_all();
        trials[k].fit = std::move(*rounds[k]).result();
    };
    tbb::parallel_invoke([&] { begin(0); }, [&] { begin(1); });
    tbb::parallel_invoke([&] { end(0); }, [&] { end(1); });
}

}  // namespace dgm::bake
