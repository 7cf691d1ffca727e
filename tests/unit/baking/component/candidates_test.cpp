// SPDX-License-Identifier: GPL-3.0-or-later
#include "baking/component/candidates.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "model/codes.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using model::TriMesh;

TEST(Attempt, HoldsTheValueOrTheError) {
    Attempt<int> good = attempt([] { return 7; });
    ASSERT_TRUE(good);
    EXPECT_EQ(*good, 7);
    const Attempt<int> bad = attempt([]() -> int { throw model::Error(codes::kGridTooSmall, "no room"); });
    ASSERT_FALSE(bad);
    EXPECT_STREQ(bad.error().what(), "no room");
    EXPECT_EQ(bad.failure(), Failure::kGridTooSmall);
    EXPECT_EQ(failure_of(model::Error(codes::kMapInvalid, "")), Failure::kMapInvalid);
    EXPECT_EQ(failure_of(model::Error(codes::kMethodUnsuited, "")), Failure::kOther);
}

TEST(Attempt, LetsARequestToStopPass) {
    EXPECT_THROW((void)attempt([]() -> int { throw model::Error(codes::kInterrupted, "stop"); }), model::Error);
}

TEST(Contest, RecordsFailuresAndGivesTheLastOne) {
    const TriMesh triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}, {}, {}, {}, {}};
    Contest contest(triangle);
    contest.enter(Method::kSphere, []() -> SampledChart { throw model::Error(codes::kMethodUnsuited, "no sphere"); });
    contest.enter(Method::kArap, []() -> SampledChart { throw model::Error(codes::kMapInvalid, "flips"); });
    EXPECT_FALSE(contest.has_best());
    EXPECT_TRUE(contest.tried(Method::kArap));
    EXPECT_TRUE(contest.failed(Method::kSphere));
    EXPECT_FALSE(contest.tried(Method::kStretch));
    EXPECT_FALSE(contest.failed(Method::kStretch));
    const Attempt<ComponentResult> result = std::move(contest).result();
    ASSERT_FALSE(result);
    EXPECT_EQ(result.failure(), Failure::kMapInvalid);
}

TEST(CandidateReport, SaysTheOutcomeInWords) {
    const auto words = [](CandidateOutcome outcome, const char* note) {
        return report_of({Method::kArap, outcome, 60, note, 0.5}).outcome;
    };
    EXPECT_EQ(words(CandidateOutcome::kChosen, ""), "chosen");
    EXPECT_EQ(words(CandidateOutcome::kChosen, "convex border"), "chosen; convex border");
    EXPECT_EQ(words(CandidateOutcome::kHigherError, ""), "higher error");
    EXPECT_EQ(words(CandidateOutcome::kMoreInverted, ""), "more inverted faces");
    EXPECT_EQ(words(CandidateOutcome::kFailed, "flips"), "flips");
    EXPECT_EQ(report_of({Method::kArap, CandidateOutcome::kChosen, 60, "", 0.5}).method, "arap");
    const auto directed = [](CandidateOutcome outcome, bool fitted) {
        return report_of({Method::kStretch, outcome, 60, "", 0.5, true, fitted}).outcome;
    };
    EXPECT_EQ(directed(CandidateOutcome::kChosen, false), "chosen; along the directions of curvature");
    EXPECT_EQ(directed(CandidateOutcome::kHigherError, true),
              "higher error after a trial fit; along the directions of curvature");
}

/// A sheet with deep folds along one of its axes, and its charts.
TriMesh folded_sheet(std::uint32_t n) {
    TriMesh mesh = test::grid_sheet(n, n);
    for (model::Vec3d& p : mesh.positions) p.z = 0.05 * std::sin(20 * (p.x + 0.3 * p.y));
    return mesh;
}

SampledChart chart_of(const TriMesh& mesh, std::uint32_t side, Levelling levelling) {
    CutGraph cut(mesh);
    cut.cut_to_disk();
    SampledChart chart = make_square_chart(cut.open(), side, side, 0, *make_stretch_parameterizer(5, levelling), {});
    chart.method = "stretch";
    return chart;
}

TEST(Contest, AChartAlongTheDirectionsOfCurvatureWinsWhereTheSurfaceBendsOneWay) {
    const TriMesh mesh = folded_sheet(81);
    for (const std::uint32_t side : {25U, 33U, 49U}) {  // twice as many vertices as samples or not, or hardly more
        Contest contest(mesh);
        contest.enter(Method::kStretch, [&] { return chart_of(mesh, side, Levelling::kCurvature); });
        const double before = contest.best_psnr();
        contest.challenge([&] { return chart_of(mesh, side, Levelling::kDirections); }, true, {});
        const Attempt<ComponentResult> result = std::move(contest).result();
        ASSERT_TRUE(result);
        EXPECT_EQ(result->candidates[1].outcome, CandidateOutcome::kChosen) << side;
        EXPECT_TRUE(result->candidates[1].directed);
        EXPECT_GT(result->candidates[1].psnr, before + 1);
    }
}

TEST(Contest, AChallengerMustHaveALowerErrorBeforeTheFitAtLeast) {
    const TriMesh mesh = folded_sheet(41);
    const SampledChart even = chart_of(mesh, 33, Levelling::kArea);
    Contest contest(mesh);
    contest.enter(Method::kStretch, [&] { return even; });
    contest.challenge([&] { return even; }, true, {});  // no better than itself, whichever way it is compared
    contest.challenge([&] { return even; }, false, {});
    contest.challenge([]() -> SampledChart { throw model::Error(codes::kMapInvalid, "flips"); }, true, {});
    EXPECT_FALSE(contest.failed(Method::kStretch)) << "a challenger that fails is no failure of the method";
    const Attempt<ComponentResult> result = std::move(contest).result();
    ASSERT_TRUE(result);
    ASSERT_EQ(result->candidates.size(), 4u);
    EXPECT_EQ(result->candidates[0].outcome, CandidateOutcome::kChosen);
    EXPECT_EQ(result->candidates[1].outcome, CandidateOutcome::kHigherError);
    EXPECT_TRUE(result->candidates[1].directed);
    EXPECT_EQ(result->candidates[3].outcome, CandidateOutcome::kFailed);
}

TEST(CandidateReport, SaysThatLoopsFaceEachOther) {
    const Candidate ring{Method::kStretch, CandidateOutcome::kChosen, 60, "", 0.5, true, true, CutKind::kRing};
    EXPECT_EQ(report_of(ring).outcome,
              "chosen after a trial fit; loops on opposite sides; along the directions of curvature");
}

TEST(CandidateReport, SaysThatTheCutIsAnotherOne) {
    const Candidate other{Method::kStretch, CandidateOutcome::kHigherError, 60, "", 0.5, false, true, CutKind::kOther};
    EXPECT_EQ(report_of(other).outcome, "higher error after a trial fit; along another cut");
    Candidate finalist = other;
    finalist.is_finalist = true;
    EXPECT_EQ(report_of(finalist).outcome, "higher error after the fit; along another cut");
}

TEST(Contest, TheBestOfARivalIsComparedAndItsRecordKept) {
    const TriMesh mesh = folded_sheet(41);
    const SampledChart plain = chart_of(mesh, 17, Levelling::kArea), better = chart_of(mesh, 33, Levelling::kArea);
    for (const bool fitted : {false, true})
        for (const bool rival_is_better : {false, true}) {
            SCOPED_TRACE(fitted);
            Contest contest(mesh);
            contest.enter(Method::kStretch, [&] { return rival_is_better ? plain : better; });
            Contest rival(mesh, CutKind::kRing);
            rival.enter(Method::kStretch, [&] { return rival_is_better ? better : plain; });
            rival.challenge([]() -> SampledChart { throw model::Error(codes::kMapInvalid, "flips"); }, fitted, {});
            contest.meet(std::move(rival), fitted, {});
            const Attempt<ComponentResult> result = std::move(contest).result();
            ASSERT_TRUE(result);
            ASSERT_EQ(result->candidates.size(), 3u);
            EXPECT_EQ(result->candidates[0].cut, CutKind::kFirst);
            EXPECT_EQ(result->candidates[1].cut, CutKind::kRing);
            EXPECT_EQ(result->candidates[1].outcome == CandidateOutcome::kChosen, rival_is_better);
            EXPECT_EQ(result->candidates[0].outcome == CandidateOutcome::kChosen, !rival_is_better);
            EXPECT_EQ(result->candidates[2].outcome, CandidateOutcome::kFailed);
            EXPECT_EQ(result->chart.positions == better.positions, true);
        }
}

TEST(Contest, OfFewFacetsTheNextChartIsKeptToo) {
    const auto result_of = [](std::uint32_t n, CutKind cut, std::uint32_t rival_side) {
        const TriMesh mesh = folded_sheet(n);
        Contest contest(mesh);
        contest.enter(Method::kStretch, [&] { return chart_of(mesh, 65, Levelling::kCurvature); });
        Contest rival(mesh, cut);
        rival.enter(Method::kStretch, [&] { return chart_of(mesh, rival_side, Levelling::kArea); });
        contest.meet(std::move(rival), true, {});
        return std::move(contest).result();
    };
    const Attempt<ComponentResult> result = result_of(41, CutKind::kOther, 65);  // 3,200 facets
    ASSERT_TRUE(result && result->runner_up);
    EXPECT_NE(result->candidates[result->runner_up->candidate].outcome, CandidateOutcome::kChosen);
    EXPECT_GE(result->runner_up->begun.rms, 0.97 * result->begun->rms);
    EXPECT_NE(result->runner_up->chart.positions, result->chart.positions);
    EXPECT_FALSE(result_of(49, CutKind::kOther, 65)->runner_up) << "4,608 facets";
    EXPECT_FALSE(result_of(41, CutKind::kRing, 65)->runner_up) << "chosen for more than its error";
    EXPECT_FALSE(result_of(41, CutKind::kOther, 17)->runner_up) << "too far behind";
}

TEST(Contest, KnowsHowFreeChartsDid) {
    const TriMesh mesh = folded_sheet(21);
    const SampledChart coarse = chart_of(mesh, 9, Levelling::kArea), fine = chart_of(mesh, 17, Levelling::kArea);
    Contest contest(mesh);
    contest.enter(Method::kStretch, [&] { return fine; });
    contest.enter(Method::kArap, []() -> SampledChart { throw model::Error(codes::kMapInvalid, "flips"); });
    EXPECT_FALSE(contest.best_psnr_of_free());
    contest.enter(Method::kLscm, [&] { return coarse; });
    ASSERT_TRUE(contest.best_psnr_of_free());
    EXPECT_LT(*contest.best_psnr_of_free(), contest.best_psnr());
}

TEST(Contest, ARivalWithoutAChartLeavesTheBest) {
    const TriMesh mesh = folded_sheet(21);
    const SampledChart chart = chart_of(mesh, 17, Levelling::kArea);
    const auto fail = []() -> SampledChart { throw model::Error(codes::kMapInvalid, "flips"); };
    Contest contest(mesh);
    Contest first(mesh, CutKind::kRing);
    first.enter(Method::kStretch, fail);
    contest.meet(std::move(first), true, {});
    EXPECT_FALSE(contest.has_best());
    Contest second(mesh, CutKind::kOther);
    second.enter(Method::kStretch, [&] { return chart; });
    contest.meet(std::move(second), true, {});
    EXPECT_TRUE(contest.has_best()) << "the only one";
    Contest third(mesh, CutKind::kOther);
    third.enter(Method::kStretch, fail);
    contest.meet(std::move(third), true, {});
    const Attempt<ComponentResult> result = std::move(contest).result();
    ASSERT_TRUE(result);
    EXPECT_EQ(result->candidates[1].outcome, CandidateOutcome::kChosen);
}

}  // namespace
}  // namespace dgm::bake
