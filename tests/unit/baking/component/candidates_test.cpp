// SPDX-License-Identifier: GPL-3.0-or-later
#include "baking/component/candidates.h"

#include <gtest/gtest.h>

#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

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
    EXPECT_EQ(words(CandidateOutcome::kFailed, "flips"), "flips");
    EXPECT_EQ(report_of({Method::kArap, CandidateOutcome::kChosen, 60, "", 0.5}).method, "arap");
}

}  // namespace
}  // namespace dgm::bake
