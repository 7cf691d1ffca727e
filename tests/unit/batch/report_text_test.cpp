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
              "out/stomach.dgm: good, max 0.05 % (0.1 units), rms 0.01 % (0.02 units), stretch 257x129, 1.2 MB, 3.4 s");
    EXPECT_EQ(detail_lines(stomach().report).at(0), "  80.0 dB, 0 flips, 0 turned faces, seam gap 0");
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
              "out/stomach.dgm, out/stomach.exr: wrong, max 0.05 % (0.1 units), rms 0.01 % (0.02 units), 3 charts, "
              "stretch 257x129, uv 257x129, 2.2 MB, 3.4 s, 1 flip, seam gap 0.5, 2 turned faces, 1 warning");
}

TEST(ReportText, TheVerdictGoesByTheFigures) {
    AssetResult result = stomach();
    const auto word = [&] {
        const std::string line = result_line(result);
        return line.substr(17, line.find(',') - 17);
    };
    EXPECT_EQ(word(), "good");
    result.report.warnings = {"texture missing"};
    EXPECT_EQ(word(), "worth a look");
    result.report.error.hausdorff = 12;  // 6 %
    EXPECT_EQ(word(), "far from the mesh");
    result = stomach();
    result.report.charts[0].map_topology.genus = 1;
    EXPECT_EQ(word(), "worth a look");
    EXPECT_NE(result_line(result).find(", another topology than the mesh"), std::string::npos);
    result.outcome = Outcome::kUpToDate;
    EXPECT_EQ(up_to_date_line(result),
              "out/stomach.dgm: up to date, worth a look, max 0.05 % (0.1 units), rms 0.01 % (0.02 units), 1.2 MB");
}

TEST(ReportText, FilesLeftOutAreCountedByKind) {
    const std::vector<LeftOutFile> files{
        {"in/a.max", "no importer"}, {"in/b.max", "no importer"}, {"in/c.md3", "untested"}};
    EXPECT_EQ(left_out_lines(files, false),
              (std::vector<std::string>{"left out: 2 .max files: no importer", "left out: 1 .md3 file: untested"}));
    EXPECT_EQ(left_out_lines(files, true).at(1), "left out: in/b.max: no importer");
}

TEST(ReportText, FilesLeftOverSayWhyAndHowToRemoveThem) {
    std::vector<LeftOver> files{{"out/y.3ds.dgm", "y.3ds", {}}, {"out/y.obj.dgm", "y.obj", "out/y.dgm"}};
    EXPECT_EQ(left_over_lines(files),
              (std::vector<std::string>{"left over: out/y.3ds.dgm: its mesh y.3ds is gone",
                                        "left over: out/y.obj.dgm: its mesh y.obj becomes out/y.dgm now",
                                        "--prune removes them"}));
    files[0].removed = true;
    EXPECT_EQ(left_over_lines(files).at(0), "removed: out/y.3ds.dgm: its mesh y.3ds is gone");
    EXPECT_TRUE(left_over_lines({}).empty());
}

TEST(ReportText, AFailureIsOneStory) {
    model::Error error(model::codes::kNonOrientable, "component 2 has one side\nits first face is 771", "band.obj:12");
    error.with_stage("repair");
    EXPECT_EQ(failure_story("band.obj", error, "noise of a library\n"),
              "dgm-bake: band.obj: repair: DGM3002: component 2 has one side\n"
              "  its first face is 771\n"
              "  at: band.obj:12\n"
              "  next: bake it with this version, which opens such a surface along a seam and warns (DGM3017)\n");
}

TEST(ReportText, AFailureMayHaveAHintOfItsOwn) {
    model::Error error(model::codes::kTooLarge, "67 samples at this --size");
    error.with_hint("ask for a smaller --size");
    EXPECT_NE(failure_story("a.obj", error).find("  next: ask for a smaller --size\n"), std::string::npos);
    error.with_hint({});
    EXPECT_NE(failure_story("a.obj", error).find(model::codes::kTooLarge.hint), std::string::npos);
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
