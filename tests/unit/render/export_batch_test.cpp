// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/export_batch_test.cpp
#include "export/program/export_batch.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "dgm/dgm_writer.h"
#include "model/codes.h"
#include "model/layer_names.h"
#include "sample_chart.h"

namespace dgm::exporter {
namespace {
using std::filesystem::path;

class ExportBatch : public testing::Test {
 protected:
    void SetUp() override {
        folder_ = path(testing::TempDir()) /
                  (std::string("dgm_export_batch_") + testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void touch(const std::string& name) const {
        std::filesystem::create_directories((folder_ / name).parent_path());
        std::ofstream(folder_ / name) << "no map";
    }
    /// "source -> output output", or "source: code", below the test's folder.
    std::vector<std::string> planned(std::vector<std::string> inputs, const std::string& output,
                                     const std::vector<std::string>& formats) const {
        for (std::string& input : inputs) input = (folder_ / input).string();
        std::vector<std::string> out;
        for (const ExportJob& job : plan_exports({inputs, (folder_ / output).string(), formats}).jobs) {
            std::string& line = out.emplace_back(job.source.lexically_relative(folder_).string());
            line += job.refusal ? ": " + job.refusal->code().id() : " ->";
            for (const path& other : job.others) line += " +" + other.lexically_relative(folder_).string();
            for (const path& file : job.outputs) line += " " + file.lexically_relative(folder_).string();
        }
        return out;
    }
    const model::Code* failure(const std::vector<std::string>& inputs, const std::string& output,
                               const std::vector<std::string>& formats) const {
        try {
            static_cast<void>(planned(inputs, output, formats));
        } catch (const model::Error& error) { return &error.code(); }
        return nullptr;
    }
    path folder_;
};
using Lines = std::vector<std::string>;

TEST_F(ExportBatch, APageHoldsAllMaps) {
    for (const char* name : {"in/a.dgm", "in/b.dgm", "c.dgm"}) touch(name);
    EXPECT_EQ(planned({"in", "c.dgm"}, "x.html", {}), (Lines{"in/a.dgm -> +in/b.dgm +c.dgm x.html"}));
    EXPECT_EQ(planned({"in"}, "out", {".html"}), (Lines{"in/a.dgm -> out/a.html", "in/b.dgm -> out/b.html"}));
}

TEST_F(ExportBatch, FoldersKeepTheirPaths) {
    for (const char* name : {"in/b.dgm", "in/sub/a.exr", "in/a.obj", "in/.hidden.dgm", "in/.git/c.dgm", "[x]/d.dgm"})
        touch(name);
    EXPECT_EQ(planned({"in"}, "out", {".glb", ".obj"}),
              (Lines{"in/b.dgm -> out/b.glb out/b.obj", "in/sub/a.exr -> out/sub/a.glb out/sub/a.obj"}));
    EXPECT_EQ(planned({"in/**/*.exr"}, "out", {".ply"}), (Lines{"in/sub/a.exr -> out/sub/a.ply"}));
    EXPECT_EQ(planned({"[x]"}, "out/", {".ply"}), (Lines{"[x]/d.dgm -> out/d.ply"}));
    EXPECT_EQ(planned({"in/b.dgm", "in"}, "out", {".ply"}),  // met twice, exported once
              (Lines{"in/b.dgm -> out/b.ply", "in/sub/a.exr -> out/sub/a.ply"}));
}

TEST_F(ExportBatch, NamesakesStayApartAndStable) {
    for (const char* name : {"one/a.dgm", "one/a.exr", "two/a.dgm"}) touch(name);
    EXPECT_EQ(planned({"one"}, "out", {".glb"}), (Lines{"one/a.dgm -> out/a.glb", "one/a.exr -> out/a.exr.glb"}));
    EXPECT_EQ(planned({"one/a.dgm", "two/a.dgm"}, "out", {".glb"}),
              (Lines{"one/a.dgm -> out/one/a.glb", "two/a.dgm -> out/two/a.glb"}));
    touch("three/one/a.dgm");
    EXPECT_EQ(failure({"one/a.dgm", "three/one/a.dgm"}, "out", {".glb"}), &model::codes::kUsage);
}

TEST_F(ExportBatch, WhatIsMissingHasItsPlace) {
    for (const char* name : {"a.dgm", "b.dgm", "empty/a.obj"}) touch(name);
    EXPECT_EQ(
        planned({"none.dgm", "a.dgm", "empty", "x*.dgm", "b.dgm"}, "out", {".glb"}),
        (Lines{"none.dgm: DGM5001", "a.dgm -> out/a.glb", "empty: DGM5001", "x*.dgm: DGM5001", "b.dgm -> out/b.glb"}));
}

TEST_F(ExportBatch, OneFileForOneMap) {
    for (const char* name : {"in/a.dgm", "in/b.dgm"}) touch(name);
    EXPECT_EQ(planned({"in/a.dgm"}, "x.glb", {}), (Lines{"in/a.dgm -> x.glb"}));
    EXPECT_EQ(planned({"in/a.dgm"}, "x.docx", {}), (Lines{"in/a.dgm -> x.docx"}));  // refused when it is written
    EXPECT_EQ(failure({"in/a.dgm", "in/b.dgm"}, "x.glb", {}), &model::codes::kUsage);
    EXPECT_EQ(failure({"in"}, "x.glb", {}), &model::codes::kUsage);
    EXPECT_EQ(failure({"in/a.dgm"}, "x.glb", {".glb"}), &model::codes::kUsage);
    EXPECT_EQ(failure({"in/a.dgm"}, "in", {}), &model::codes::kUsage);        // into a folder, but as what?
    EXPECT_EQ(failure({"in/a.dgm"}, "in", {".dgm"}), &model::codes::kUsage);  // onto itself
}

TEST_F(ExportBatch, OneBadFileNeverStopsTheRest) {
    model::MapSet maps;
    maps.source_name = "torus.obj";
    maps.charts = {test::surface_alone(test::torus_chart(9, 9))};
    touch("in/broken.dgm");
    formats::write_dgm(maps, folder_ / "in/a.dgm");
    formats::write_dgm(maps, folder_ / "in/z.dgm");
    std::vector<std::string> written, failed;
    const ExportListener listener{[&](const path& file) { written.push_back(file.filename()); },
                                  [&](const path& file, const model::Error&) { failed.push_back(file.filename()); },
                                  [](const std::string&) {}};
    ExportOptions options;
    options.quantize = true;  // of the .glb alone
    const ExportPlan plan = plan_exports({{(folder_ / "in").string()}, (folder_ / "out").string(), {".glb", ".obj"}});
    const ExportOutcome outcome = run_exports(plan, options, listener);
    EXPECT_EQ(written, (Lines{"a.glb", "a.obj", "z.glb", "z.obj"}));
    EXPECT_EQ(failed, (Lines{"broken.dgm"}));
    EXPECT_EQ(outcome.exit, model::ExitCode::kInvalid);
    EXPECT_EQ(summary_line(outcome), "3 maps: 2 exported, 1 failed");
    EXPECT_NE(failure_list(outcome).find("1 of 3 maps failed:\n"), std::string::npos);
    EXPECT_NE(failure_list(outcome).find("broken.dgm: DGM1001: "), std::string::npos);
    // With one format the option goes with nothing, and that is said.
    const ExportPlan alone = plan_exports({{(folder_ / "in/a.dgm").string()}, (folder_ / "x.obj").string(), {}});
    EXPECT_EQ(run_exports(alone, options, listener).exit, model::ExitCode::kUsage);
}

TEST_F(ExportBatch, MapsThatTheValidatorRefusesAreNotExported) {
    model::MapSet maps;
    maps.source_name = "torus.obj";
    maps.charts = {test::surface_alone(test::torus_chart(9, 9))};
    formats::write_dgm(maps, folder_ / "sound.dgm");
    for (model::Layer& layer : maps.charts[0].layers)
        if (layer.name == model::layers::kGeometry) {
            const float far = 1e30f;
            std::memcpy(layer.bytes.data(), &far, sizeof far);
        }
    formats::write_dgm(maps, folder_ / "far.dgm");  // with hashes that fit
    std::vector<std::string> failed;
    const ExportListener listener{
        [](const path&) {},
        [&](const path& file, const model::Error& error) {
            failed.push_back(file.filename().string() + " " + error.code().id() + " " + error.place());
        },
        [](const std::string&) {}};
    const auto exported = [&](const char* name, const std::string& output) {
        return run_exports(plan_exports({{(folder_ / name).string()}, (folder_ / output).string(), {}}), {}, listener);
    };
    EXPECT_EQ(exported("sound.dgm", "sound.obj").exit, model::ExitCode::kOk);
    for (const char* output : {"far.obj", "far.glb", "far.exr", "copy.dgm", "far.html"}) {
        EXPECT_EQ(exported("far.dgm", output).exit, model::ExitCode::kInvalid) << output;
        EXPECT_FALSE(std::filesystem::exists(folder_ / output)) << output;
    }
    EXPECT_EQ(failed, Lines(5, "far.dgm DGM2007 /charts/0/geometry[0][0][0]"));
    const ExportPlan page = plan_exports(
        {{(folder_ / "sound.dgm").string(), (folder_ / "far.dgm").string()}, (folder_ / "both.html").string(), {}});
    EXPECT_EQ(run_exports(page, {}, listener).exit, model::ExitCode::kInvalid);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "both.html"));
}

}  // namespace
}  // namespace dgm::exporter
