// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/baking/component/chart_fits_test.cpp
// Which further fits a chart gets, and what they leave.
#include "baking/component/chart_fits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>

#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

/// The fits of one chart, with all that they refer to.
struct FitsOf {
    explicit FitsOf(SampledChart chart, Fit fit = Fit::kBest, Method method = Method::kAuto) {
        component = chart.disk->mesh;
        mapped.chart = std::move(chart);
        mapped.method = method == Method::kAuto ? Method::kStretch : method;
        Candidate chosen;
        chosen.method = mapped.method;
        chosen.outcome = CandidateOutcome::kChosen;
        mapped.candidates = {chosen};
        options.method = method;
        options.fit = fit;
        how = fit == Fit::kBest ? best_fit() : l2_fit();
    }
    [[nodiscard]] ChartFits fits() { return {component, mapped, options, how, kTrialSamples}; }
    [[nodiscard]] double rms() const { return quick_error(component, mapped.chart, kTrialSamples).rms; }

    TriMesh component;
    ComponentResult mapped;
    BakeOptions options;
    FitOptions how;
};

TEST(ChartFits, MapAnewWhereTheFitLeftError) {
    FitsOf of(fit_test::rough_corner());
    ChartFits fits = of.fits();
    fits.fit({});
    const double first = of.rms();
    ASSERT_TRUE(fits.may_remap());
    fits.remap({});
    EXPECT_LT(of.rms(), 0.8 * first);
    EXPECT_EQ(fits.inverted(), 0U);
    EXPECT_GE(of.mapped.candidates[0].remaps, 1U);
    EXPECT_NE(report_of(of.mapped.candidates[0]).outcome.find("more room"), std::string::npos);
    EXPECT_FALSE(fits.may_remap()) << "once is enough";
}

TEST(ChartFits, KeepTheFirstFitWhereAnotherMapHasMoreError) {
    // Waves that are alike everywhere: any other map is worse somewhere.
    FitsOf of(
        fit_test::sheet_chart(33, 16, [](double x, double y) { return 0.05 * std::sin(9 * x) * std::sin(9 * y); }));
    ChartFits fits = of.fits();
    fits.fit({});
    const double first = of.rms();
    if (fits.may_remap()) fits.remap({});
    EXPECT_LE(of.rms(), first);
}

TEST(ChartFits, LeaveNamedMethodsAndTextureCoordinatesAlone) {
    for (const Method method : {Method::kStretch, Method::kArap}) {
        FitsOf of(fit_test::rough_corner(), Fit::kBest, method);
        ChartFits fits = of.fits();
        fits.fit({});
        EXPECT_FALSE(fits.may_remap());
    }
    FitsOf of(fit_test::rough_corner());
    of.mapped.method = Method::kUv;
    ChartFits fits = of.fits();
    fits.fit({});
    EXPECT_FALSE(fits.may_remap());
}

TEST(ChartFits, LeaveOutWhatIsAblated) {
    FitsOf of(fit_test::rough_corner());
    of.options.ablate = {"remaps"};
    ChartFits fits = of.fits();
    fits.fit({});
    EXPECT_FALSE(fits.may_remap());
}

/// The chart with less error after the fit is kept, whichever came next.
TEST(ChartFits, TheNextChartIsTakenIfItEndsBetter) {
    const SampledChart rough = fit_test::rough_corner();
    FitsOf of(rough);
    of.fits().fit({});
    const double before = of.rms();
    const std::optional<SampledChart> better =
        Remap(rough, std::nullopt).propose(error_field(of.mapped.chart), RemapShape::kOwn, {});
    ASSERT_TRUE(better);
    for (const bool next_is_better : {true, false}) {
        FitsOf both(next_is_better ? rough : *better);
        both.options.ablate = {"remaps"};
        SampledChart next = next_is_better ? *better : rough;
        TrialFit begun = trial_fit(next, {});
        both.mapped.candidates.emplace_back().method = Method::kArap;
        both.mapped.runner_up = {std::move(next), std::move(begun), 1};
        ChartFits fits = both.fits();
        fits.fit({});
        ASSERT_TRUE(fits.may_lose());
        fits.fit_runner_up({});
        EXPECT_FALSE(fits.may_lose());
        EXPECT_LT(both.rms(), 0.95 * before);
        EXPECT_EQ(both.mapped.method, next_is_better ? Method::kArap : Method::kStretch);
        EXPECT_EQ(report_of(both.mapped.candidates[next_is_better ? 1 : 0]).outcome, "chosen after the fit");
        EXPECT_EQ(report_of(both.mapped.candidates[next_is_better ? 0 : 1]).outcome, "higher error after the fit");
    }
}

TEST(ChartFits, SpareSmallErrors) {
    FitsOf of(fit_test::sheet_chart(33, 2, [](double x, double) { return 1e-7 * std::abs(x - 0.5); }));
    ChartFits fits = of.fits();
    fits.fit({});
    EXPECT_FALSE(fits.may_remap());
}

}  // namespace
}  // namespace dgm::bake
