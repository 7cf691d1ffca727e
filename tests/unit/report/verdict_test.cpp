// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/verdict.h"

#include <gtest/gtest.h>

#include <limits>

namespace dgm::report {
namespace {

bake::BakeReport report_with(double rms_percent, double max_percent) {
    bake::BakeReport report;
    report.error.diagonal = 200;
    report.error.rms = 2 * rms_percent;
    report.error.hausdorff = 2 * max_percent;
    bake::ChartReport chart;
    chart.rows = chart.cols = 100;
    report.charts = {chart};
    return report;
}

TEST(Verdict, LimitsOfTheError) {
    EXPECT_EQ(verdict_of(report_with(0.09, 0.9)).grade, Grade::kGood);
    EXPECT_EQ(verdict_of(report_with(0.11, 0.9)).grade, Grade::kLook);
    EXPECT_EQ(verdict_of(report_with(0.09, 1.1)).grade, Grade::kLook);
    EXPECT_EQ(verdict_of(report_with(0.51, 0.9)).grade, Grade::kBad);
    EXPECT_EQ(verdict_of(report_with(0.09, 5.1)).grade, Grade::kBad);
    EXPECT_EQ(verdict_of(report_with(std::numeric_limits<double>::quiet_NaN(), 0.1)).grade, Grade::kBad);
}

TEST(Verdict, SaysItInOneSentence) {
    EXPECT_EQ(verdict_of(report_with(0.01, 0.25)).headline,
              "Good: at most 0.5 (0.25 %) from the mesh, 0.02 (0.01 %) rms.");
}

TEST(Verdict, WorstNoteFirst) {
    bake::BakeReport report = report_with(0.01, 0.1);
    report.warnings = {"texture missing: skin.png"};
    report.charts[0].turned_faces = 20;  // of 20 000 triangles: not too many
    EXPECT_EQ(verdict_of(report).grade, Grade::kLook);
    report.charts[0].seam_gap = 0.5;
    const Verdict verdict = verdict_of(report);
    EXPECT_EQ(verdict.grade, Grade::kBad);
    EXPECT_TRUE(verdict.headline.starts_with("Wrong: "));
    ASSERT_EQ(verdict.notes.size(), 3U);
    EXPECT_EQ(verdict.notes[0], "the seam is open by 0.5");
    EXPECT_EQ(verdict.notes[1], "texture missing: skin.png");
    report.warnings.clear();
    report.charts[0].seam_gap = 0;
    EXPECT_EQ(verdict_of(report).grade, Grade::kGood);
    report.charts[0].turned_faces = 21;
    EXPECT_EQ(verdict_of(report).grade, Grade::kLook);
}

}  // namespace
}  // namespace dgm::report
