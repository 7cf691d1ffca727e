// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/validation_run_test.cpp
// Several files, patterns, baselines and severities.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "dgm/dgm_writer.h"
#include "exr/exr_writer.h"
#include "model/codes.h"
#include "support/temp_folder.h"
#include "validate/file_list.h"
#include "validate/run.h"
#include "validation_maps.h"

namespace dgm::validate {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;
using formats::Severity;

TEST(FilePatterns, StarsStopAtSlashesAndDoubleStarsDoNot) {
    for (const auto& [pattern, text] :
         std::vector<std::pair<std::string, std::string>>{{"a.dgm", "a.dgm"},
                                                          {"*.dgm", "a.dgm"},
                                                          {"*.dgm", ".dgm"},
                                                          {"?.dgm", "a.dgm"},
                                                          {"a*b*c", "aXbYbZc"},
                                                          {"**/*.dgm", "a.dgm"},
                                                          {"**/*.dgm", "x/y/a.dgm"},
                                                          {"x/**/a.dgm", "x/a.dgm"},
                                                          {"x/**/a.dgm", "x/y/z/a.dgm"},
                                                          {"x**", "x/y"},
                                                          {"*/*/*.dgm", "x/y/a.dgm"},
                                                          {"**/b*/*.dgm", "a/b1/c/b2/x.dgm"},
                                                          {"*", ""}})
        EXPECT_TRUE(matches(pattern, text)) << pattern << " " << text;
    for (const auto& [pattern, text] : std::vector<std::pair<std::string, std::string>>{{"*.dgm", "x/a.dgm"},
                                                                                        {"?.dgm", ".dgm"},
                                                                                        {"x?a", "x/a"},
                                                                                        {"*.dgm", "a.dgm2"},
                                                                                        {"x/**/a.dgm", "xa.dgm"},
                                                                                        {"*/*.dgm", "x/y/a.dgm"},
                                                                                        {"", "a"},
                                                                                        {"a", ""},
                                                                                        {"**/b/*.dgm", "a/bb/x.dgm"}})
        EXPECT_FALSE(matches(pattern, text)) << pattern << " " << text;
    // Backtracking stays polynomial.
    EXPECT_FALSE(matches("*a*a*a*a*a*a*a*a*a*a*b", std::string(2000, 'a')));
}

class ValidationRun : public testing::Test {
 protected:
    void SetUp() override {
        fs::create_directories(folder_ / "b" / "deep");
        model::MapSet maps = test::good_maps();
        formats::write_dgm(maps, folder_ / "good.dgm");
        formats::write_exr(maps, folder_ / "b" / "good.exr");
        maps.report_json.clear();
        formats::write_dgm(maps, folder_ / "b" / "no_report.dgm");
        test::poke<float>(*maps.charts[0].find("geometry"), 3 * (4 * test::kTubeCols + 10), 0.4999f);
        formats::write_dgm(maps, folder_ / "b" / "deep" / "torn.dgm");
        std::ofstream(folder_ / "b" / "notes.txt") << "no map\n";
    }
    [[nodiscard]] std::vector<std::string> expand(const std::vector<std::string>& names) const {
        std::vector<std::string> whole, out;
        for (const std::string& name : names) whole.push_back((folder_ / name).string());
        for (const fs::path& file : expand_names(whole)) out.push_back(file.lexically_relative(folder_).string());
        return out;
    }
    [[nodiscard]] RunOptions everything(unsigned jobs = 1) const {
        RunOptions options;
        options.files = expand_names({folder_.string()});
        options.jobs = jobs;
        return options;
    }
    /// "torn.dgm: DGM2011 DGM2004 (DGM1003)", what is known in parentheses.
    static std::vector<std::string> summary(const std::vector<FileValidation>& files) {
        std::vector<std::string> out;
        for (const FileValidation& file : files) {
            std::string& line = out.emplace_back(file.path.filename().string() + ":");
            for (const auto& f : file.findings) line += " " + f.code->id();
            for (const auto& f : file.known) line += " (" + f.code->id() + ")";
        }
        return out;
    }
    const test::TempFolder scratch_;
    const fs::path& folder_ = scratch_.path();
};

TEST_F(ValidationRun, FoldersPatternsAndNamesAreExpandedOnce) {
    using List = std::vector<std::string>;
    EXPECT_EQ(expand({""}), (List{"b/deep/torn.dgm", "b/good.exr", "b/no_report.dgm", "good.dgm"}));
    EXPECT_EQ(expand({"b/*.dgm"}), (List{"b/no_report.dgm"}));
    EXPECT_EQ(expand({"**/*.dgm", "good.dgm"}), (List{"b/deep/torn.dgm", "b/no_report.dgm", "good.dgm"}));
    EXPECT_EQ(expand({"none*.dgm", "absent.dgm"}), (List{"none*.dgm", "absent.dgm"})) << "to be reported as missing";
}

TEST_F(ValidationRun, ResultsComeInOrderWhateverTheThreads) {
    std::vector<std::string> done;
    const auto note = [&](const FileValidation& file) { done.push_back(file.path.filename().string()); };
    const auto one = run_validation(everything(1), note);
    const std::vector<std::string> order = done;
    EXPECT_EQ(summary(one), (std::vector<std::string>{"torn.dgm: DGM2004 DGM2011",
                                                      "good.exr:", "no_report.dgm: DGM2011", "good.dgm:"}));
    EXPECT_EQ(worst_exit(one), model::ExitCode::kInvalid);
    for (const unsigned jobs : {2u, 7u}) {
        done.clear();
        EXPECT_EQ(summary(run_validation(everything(jobs), note)), summary(one));
        EXPECT_EQ(done, order);
    }
}

TEST_F(ValidationRun, WhatTheListenerThrowsStopsTheRun) {
    EXPECT_THROW((void)run_validation(everything(3), [](const FileValidation&) { throw std::runtime_error("full"); }),
                 std::runtime_error);
}

TEST_F(ValidationRun, SeveritiesCanBeChanged) {
    RunOptions options = everything();
    add_severity_rule(options.severities, "SEAM_GAP=warning");
    add_severity_rule(options.severities, "DGM2011=off");
    const auto files = run_validation(options, {});
    EXPECT_EQ(summary(files)[0], "torn.dgm: DGM2004");
    EXPECT_EQ(files[0].findings[0].severity, Severity::kWarning);
    EXPECT_EQ(worst_exit(files), model::ExitCode::kOk);
    add_severity_rule(options.severities, "dgm2011=error");  // the later rule wins
    EXPECT_EQ(worst_exit(run_validation(options, {})), model::ExitCode::kInvalid);
    for (const char* bad : {"DGM2004", "DGM2004=", "DGM2004=fatal", "=off", "NO_SUCH=off"})
        EXPECT_THROW(add_severity_rule(options.severities, bad), model::Error) << bad;
}

TEST_F(ValidationRun, ABaselinePassesWhatIsKnownAndNoMore) {
    const fs::path path = folder_ / "baseline.json";
    std::ofstream(path) << baseline_json(run_validation(everything(), {}), path);
    RunOptions options = everything(2);
    options.baseline = Baseline::read(path);
    auto files = run_validation(options, {});
    EXPECT_EQ(summary(files)[0], "torn.dgm: (DGM2004) (DGM2011)");
    EXPECT_EQ(worst_exit(files), model::ExitCode::kOk);
    // Another element of the same layer is the same finding; another layer is not.
    model::MapSet maps = test::good_maps();
    maps.report_json.clear();
    test::poke<float>(*maps.charts[0].find("geometry"), 3 * (6 * test::kTubeCols + 10), 0.4999f);
    test::poke<float>(*maps.charts[0].find("contact"), 1, 2.f);
    formats::write_dgm(maps, folder_ / "b" / "deep" / "torn.dgm");
    files = run_validation(options, {});
    EXPECT_EQ(summary(files)[0], "torn.dgm: DGM2007 (DGM2004) (DGM2011)");
    EXPECT_EQ(worst_exit(files), model::ExitCode::kInvalid);
    // The same fault of another file is new.
    fs::copy_file(folder_ / "b" / "deep" / "torn.dgm", folder_ / "torn2.dgm");
    options.files = {folder_ / "torn2.dgm"};
    EXPECT_EQ(summary(run_validation(options, {}))[0], "torn2.dgm: DGM2007 DGM2004 DGM2011");
}

TEST_F(ValidationRun, BadBaselinesAreUsageErrors) {
    const fs::path path = folder_ / "x.json";
    for (const char* text :
         {"", "[]", "{}", R"({"dgm_validate_baseline":2,"findings":[]})", R"({"dgm_validate_baseline":1})",
          R"({"dgm_validate_baseline":1,"findings":[{"file":"a"}]})"}) {
        std::ofstream(path, std::ios::trunc) << text;
        try {
            (void)Baseline::read(path);
            ADD_FAILURE() << text;
        } catch (const model::Error& error) { EXPECT_EQ(&error.code(), &codes::kBadBaseline) << text; }
    }
    EXPECT_THROW((void)Baseline::read(folder_ / "absent.json"), model::Error);
}

TEST_F(ValidationRun, ASourceThatCannotBeReadIsAFindingAndTheFilesAreJudged) {
    RunOptions options = everything();
    std::ofstream(folder_ / "bad.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    options.source = folder_ / "bad.obj";
    const auto files = run_validation(options, {});
    ASSERT_EQ(files.size(), options.files.size() + 1);
    EXPECT_EQ(files[0].path, folder_ / "bad.obj");
    ASSERT_EQ(files[0].findings.size(), 1u);
    EXPECT_EQ(files[0].findings[0].code, &codes::kNoFaces);
    EXPECT_EQ(summary(files)[1], "torn.dgm: DGM2004 DGM2011");
}

TEST_F(ValidationRun, AFolderOfSourcesIsSearchedByName) {
    RunOptions options;
    model::MapSet maps = test::good_maps();
    maps.source_name = "flat.obj";
    maps.charts.erase(maps.charts.begin());
    maps.report_json.clear();
    formats::write_dgm(maps, folder_ / "flat.dgm");
    maps.source_name = "absent.obj";
    formats::write_dgm(maps, folder_ / "lost.dgm");
    options.files = {folder_ / "flat.dgm", folder_ / "lost.dgm"};
    fs::create_directory(folder_ / "sources");
    // The flat chart: three quads, and the notch closed by one border sample.
    std::ofstream(folder_ / "sources" / "flat.obj")
        << "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1.75 1.5 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n";
    options.source = folder_ / "sources";
    const auto files = run_validation(options, {});
    EXPECT_EQ(summary(files), (std::vector<std::string>{"flat.dgm: DGM2011 DGM4003", "lost.dgm: DGM5001 DGM2011"}));
    ASSERT_TRUE(files[0].error.has_value());
    EXPECT_LT(files[0].error->rms, 1e-6);
}

}  // namespace
}  // namespace dgm::validate
