// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/report_text.h"

#include <gtest/gtest.h>

#include "model/codes.h"

namespace dgm::bake {
namespace {

AssetResult stomach() {
    AssetResult result;
    result.outcome = Outcome::kBaked;
    result.files = {{"out/./stomach.dgm", 1'234'567}};
    result.seconds = 3.44;
    result.report.error.diagonal = 200;
    result.report.error.rms = 0.02;       // 0.01 %, 80 dB
    result.report.error.hausdorff = 0.1;  // 0.05 %
    ChartReport chart;
    chart.method = "stretch";
    chart.rows = 257;
    chart.cols = 129;
    result.report.charts = {chart};
    return result;
}

TEST(ReportText, OneLineSaysWhatMatters) {
    EXPECT_EQ(result_line(stomach()),
              "out/stomach.dgm: stretch 257x129, 80.0 dB, rms 0.02 (0.01 %), max 0.1 (0.05 %), 0 flips, seam "
              "gap 0, 1.2 MB, 3.4 s");
}

TEST(ReportText, SeveralChartsAddUp) {
    AssetResult result = stomach();
    result.files.push_back({"out/stomach.exr", 999'000});
    result.report.charts.push_back(result.report.charts[0]);
    result.report.charts[1].method = "uv";
    result.report.charts[1].map.flips = 1;
    result.report.charts[1].seam_gap = 0.5;
    result.report.charts.push_back(result.report.charts[0]);
    result.report.charts[2].turned_faces = 2;
    result.report.warnings = {"texture missing: skin.png"};
    EXPECT_EQ(result_line(result),
              "out/stomach.dgm, out/stomach.exr: 3 charts, stretch 257x129, uv 257x129, 80.0 dB, rms 0.02 (0.01 %), "
              "max 0.1 (0.05 %), 1 flip, seam gap 0.5, 2.2 MB, 3.4 s, 2 turned faces, 1 warning");
}

TEST(ReportText, AFailureIsOneStory) {
    model::Error error(model::codes::kNonOrientable, "component 2 has one side\nits first face is 771", "band.obj:12");
    error.with_stage("repair");
    EXPECT_EQ(failure_story("band.obj", error, "noise of a library\n"),
              "dgm-bake: band.obj: repair: DGM3002: component 2 has one side\n"
              "  its first face is 771\n"
              "  at: band.obj:12\n"
              "  next: cut the surface open in your modeller so that it has an inside and an outside\n");
}

TEST(ReportText, ACrashQuotesTheLastWords) {
    const model::Error error(model::codes::kWorkerCrashed, "signal 6");
    const std::string story = failure_story("a.obj", error, "one\ntwo\nthree\n\x1b[2Jfour\n");
    EXPECT_EQ(story.find("one"), std::string::npos);
    EXPECT_NE(story.find("  it said: two\n  it said: three\n  it said: \\x1b[2Jfour\n"), std::string::npos);
}

TEST(ReportText, NamesCannotSteerTheTerminal) {
    EXPECT_EQ(printable("a\x1b[31m\nb\x7f\xc3\xa9"), "a\\x1b[31m\\x0ab\\x7f\xc3\xa9");
}

TEST(ReportText, TheWorstAssetGivesTheExitCode) {
    const auto failed = [](const model::Code& code) {
        AssetResult result;
        result.outcome = Outcome::kFailed;
        result.error = model::Error(code, "");
        return result;
    };
    std::vector<AssetResult> results{stomach()};
    EXPECT_EQ(worst_exit(results), model::ExitCode::kOk);
    const std::pair<const model::Code*, model::ExitCode> rising[] = {
        {&model::codes::kUnsupported, model::ExitCode::kUnsupported},
        {&model::codes::kNoFaces, model::ExitCode::kInvalid},
        {&model::codes::kFileMissing, model::ExitCode::kIo},
        {&model::codes::kWorkerCrashed, model::ExitCode::kInternal}};
    for (const auto& [code, exit] : rising) {
        results.insert(results.begin(), failed(*code));
        EXPECT_EQ(worst_exit(results), exit);
    }
    results.emplace_back().outcome = Outcome::kInterrupted;
    EXPECT_EQ(worst_exit(results), model::ExitCode::kInterrupted);
    EXPECT_EQ(summary_line(results), "6 assets: 1 baked, 4 failed, 1 interrupted");
}

}  // namespace
}  // namespace dgm::bake
