// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/chart_fits.cpp
#include "baking/component/chart_fits.h"

#include <algorithm>
#include <utility>

#include "geometry/fit/local_repair.h"

namespace dgm::bake {
namespace {

constexpr double kOrdinaryGain = 0.35;  // in rms; crowded maps of wrinkled cloth may gain little
constexpr double kLittleGain = 0.4;     // likewise, where the source has at least kManyFacets a face of the grid
constexpr double kManyFacets = 0.5;
constexpr double kBelowStored = 1e-8;               // normalised units: positions that are stored are rounded to more
constexpr double kInvertedPrice = 1.25;             // in rms, of fewer inverted faces
constexpr std::uint64_t kMuchLooked = 100'000'000;  // at faces by fits: no guarded one then ...
constexpr std::uint64_t kLookedOfOne = 50'000'000;  // ... and none of a runner-up where the first chart took as many
constexpr std::size_t kHopeless = 24;               // more than one inverted face to so many samples

// A map is made anew where the fit has left error ...
constexpr double kSmallError = 3e-6;  // ... above 110 dB, in diagonals
constexpr double kAtFewPlaces = 0.8;  // ... and this share of it in a twentieth of the cells: 1 to 7 dB on 11 of 12
constexpr double kDenseFacets = 4;    // ... or the source is so dense that the first map took longer than the fit
// A sample, or a vertex of the source if those are more: fits of ordinary charts take 300 to 2,300, of hard ones
// 10,000.
constexpr std::uint64_t kMostLooks = 2500;
constexpr int kTriesOfBest = 4;
constexpr double kConcentrated = 0.5;  // share of the error in a twentieth of the cells, for a second failure
constexpr double kGainOfRemap = 0.99;  // in rms, by both measures
constexpr double kGainToGoOn = 0.96;   // in rms
constexpr double kLargestPrice = 1.2;  // in the largest error, of less rms

}  // namespace

/// Of the source, to a face of the grid.
double ChartFits::facets() const {
    return static_cast<double>(component_.faces.size()) / (2.0 * static_cast<double>(samples()));
}

SurfaceError ChartFits::error_of(const SampledChart& chart) const {
    return quick_error(component_, chart, trial_samples_, mapped_.source_index());
}

const SurfaceError& ChartFits::measured() {
    if (!error_) error_ = error_of(mapped_.chart);
    return *error_;
}

Candidate* ChartFits::chosen() const {
    const auto found = std::find_if(mapped_.candidates.begin(), mapped_.candidates.end(),
                                    [](const Candidate& c) { return c.outcome == CandidateOutcome::kChosen; });
    return found == mapped_.candidates.end() ? nullptr : &*found;
}

void ChartFits::keep(SampledChart&& chart, const FitReport& report, const SurfaceError& error) {
    mapped_.chart = std::move(chart);
    report_ = report;
    error_ = error;
}

void ChartFits::fit(const model::Progress& progress) {
    if (component_.positions.size() <= kMostFitted) start_ = mapped_.chart;
    report_ = fit_chart(mapped_.chart, fit_, progress, mapped_.begun ? &*mapped_.begun : nullptr);
    looked_ += report_.looked;
    mapped_.begun.reset();
    if (!may_remap() && !may_gain()) start_.reset();
}

bool ChartFits::may_remap() const {
    if (!start_ || options_.ablates("remaps") || report_.was_exact || report_.inverted > 0) return false;
    // A method that is named is asked for as it is, and so are texture coordinates.
    if (options_.method != Method::kAuto || mapped_.method == Method::kUv) return false;
    if (report_.rms < kSmallError) return false;
    if (report_.looked > kMostLooks * std::max(samples(), component_.positions.size())) return false;
    if (samples() >= kLargeGrid) return false;
    return options_.fit == Fit::kBest || facets() < kManyFacets || facets() >= kDenseFacets;
}

/// How much more error a chart with so many inverted faces may have.
double ChartFits::price_of(std::size_t inverted) const {
    if (inverted == report_.inverted) return 1;
    return inverted < report_.inverted ? kInvertedPrice : 1 / kInvertedPrice;
}

/// What the map was levelled to; nothing if it was not made by stretch.
std::optional<Levelling> ChartFits::levelling() const {
    if (mapped_.method != Method::kStretch && mapped_.method != Method::kSphere) return std::nullopt;
    if (options_.ablates("curvature") || options_.ablates("newton")) return std::nullopt;
    const bool directed = chosen() != nullptr && chosen()->directed;
    return directed ? Levelling::kDirections : Levelling::kCurvature;
}

/// @return  true if the chart is better than the one so far, and has taken its place
bool ChartFits::fit_remapped(SampledChart& chart, const model::Progress& progress) {
    const FitReport report = fit_chart(chart, held_firmly_ ? firm(fit_) : fit_, progress);
    looked_ += report.looked;
    const SurfaceError error = error_of(chart);
    // Where the error is at few places, points miss some of them: those of the fit, which are more, have a say too.
    const double ratio = std::max(error.rms / measured().rms, report.rms / report_.rms);
    if (report.inverted > 0 || !(ratio < kGainOfRemap)) return false;
    if (error.hausdorff > kLargestPrice * measured().hausdorff) return false;
    if (report.hausdorff > kLargestPrice * report_.hausdorff) return false;
    keep(std::move(chart), report, error);
    return true;
}

void ChartFits::remap(const model::Progress& progress) {
    ErrorField left = error_field(mapped_.chart);
    const bool is_best = options_.fit == Fit::kBest;
    if (!is_best && facets() < kDenseFacets && left.worst_share < kAtFewPlaces) return;
    Remap maps(*std::exchange(start_, std::nullopt), levelling());
    const int tries = is_best ? kTriesOfBest : 1;
    const int most_failures = maps.may_be_levelled() && left.worst_share >= kConcentrated ? 2 : 1;
    std::size_t accepted = 0;
    for (int k = 0, failures = 0; k < tries && failures < most_failures; ++k) {
        const bool own = !maps.may_be_levelled() || failures % 2 == 1;
        std::optional<SampledChart> chart =
            maps.propose(left, own ? RemapShape::kOwn : RemapShape::kLevelled, progress);
        const double before = measured().rms;
        if (!chart || !fit_remapped(*chart, progress)) {
            ++failures;
            continue;
        }
        failures = 0;
        maps.accept();
        ++accepted;
        if (k + 1 == tries || measured().rms > kGainToGoOn * before) break;
        left = error_field(mapped_.chart);
    }
    if (Candidate* const of = chosen()) of->remaps = accepted;
}

bool ChartFits::may_gain() const {
    if (!start_) return false;
    // Samples that are held firmly keep to edges of large facets. Where facets are small, a good map leaves little
    // to gain: on 121 meshes at 65 x 65 and 129 x 129, 13 such fits lay between the two shares, and the other fit
    // was 0.5 to 1.3 dB worse each time.
    const double ordinary = report_.inverted == 0 && facets() >= kManyFacets ? kLittleGain : kOrdinaryGain;
    const bool good = report_.was_exact || report_.rms < kBelowStored || report_.rms < ordinary * report_.start_rms;
    // Where so many are, limbs have no room, and another fit takes as long and has as many.
    const bool hopeless = kHopeless * report_.inverted > samples();
    return (report_.inverted > 0 || !good) && !hopeless;
}

void ChartFits::fit_firmly(const model::Progress& progress) {
    held_firmly_ = fit_again(firm(fit_), progress);
}

bool ChartFits::may_gain_guarded() const {
    return may_gain() && report_.inverted > 0 && report_.inverted <= kMostAtAPrice && looked_ < kMuchLooked;
}

void ChartFits::fit_guarded(const model::Progress& progress) {
    if (fit_again(guarded(fit_), progress)) held_firmly_ = false;
}

/// @return  true if the fit is better than the one so far, and has taken its place
bool ChartFits::fit_again(const FitOptions& options, const model::Progress& progress) {
    SampledChart chart = *start_;
    const FitReport report = fit_chart(chart, options, progress);
    looked_ += report.looked;
    if (options.guarded && report.inverted > report_.inverted) return false;
    const SurfaceError error = error_of(chart);
    if (!(error.rms < price_of(report.inverted) * measured().rms)) return false;
    keep(std::move(chart), report, error);
    return true;
}

bool ChartFits::may_lose() const {
    if (!mapped_.runner_up || report_.was_exact || looked_ > kLookedOfOne) return false;
    return report_.rms > kSmallError || report_.inverted > 0;
}

void ChartFits::fit_runner_up(const model::Progress& progress) {
    RunnerUp next = *std::exchange(mapped_.runner_up, std::nullopt);
    const auto place = static_cast<std::size_t>(chosen() - mapped_.candidates.data());
    mapped_.candidates[place].is_finalist = mapped_.candidates[next.candidate].is_finalist = true;
    ComponentResult other;
    other.chart = std::move(next.chart);
    other.candidates = mapped_.candidates;
    other.candidates[place].outcome = CandidateOutcome::kHigherError;
    other.candidates[next.candidate].outcome = CandidateOutcome::kChosen;
    other.candidates[next.candidate].note = other.chart.note;
    other.method = other.candidates[next.candidate].method;
    other.begun = std::move(next.begun);
    other.index = mapped_.index;
    ChartFits fits(component_, other, options_, fit_, trial_samples_);
    const model::Progress silent{{}, progress.cancelled};
    fits.fit(silent);
    if (fits.inverted() <= inverted()) fits.fit_further(silent);
    looked_ += fits.looked_;
    if (fits.inverted() > inverted()) return;
    const auto is_free = [](const SampledChart& chart) { return chart.domain == layout::Domain::kFree; };
    double price = price_of(fits.inverted());
    if (is_free(other.chart) && !is_free(mapped_.chart)) price *= kGainOfFree;
    if (is_free(mapped_.chart) && !is_free(other.chart)) price /= kGainOfFree;
    const SurfaceError error = fits.measured();
    if (!(error.rms < price * measured().rms)) return;
    const FitReport report = fits.report_;
    mapped_ = std::move(other);
    report_ = report;
    error_ = error;
}

void ChartFits::fit_further(const model::Progress& progress) {
    if (may_gain()) fit_firmly(progress);
    if (may_gain_guarded()) fit_guarded(progress);
    if (may_remap()) remap(progress);
}

std::size_t fit_component(const model::TriMesh& component, ComponentResult& mapped, const BakeOptions& options,
                          const FitOptions& fit, std::uint64_t trial_samples, const model::Progress& progress) {
    ChartFits fits(component, mapped, options, fit, trial_samples);
    fits.fit(progress);
    fits.fit_further(progress);
    if (fits.may_lose()) fits.fit_runner_up(progress);
    return fits.inverted();
}

}  // namespace dgm::bake
