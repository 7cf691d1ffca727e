// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "baking/bake_report.h"
#include "model/error.h"

namespace dgm::bake {
namespace {

BakeReport example() {
    BakeReport report;
    report.source_name = "stomach.obj";
    report.source_vertices = 4864;
    report.source_faces = (std::uint64_t{1} << 63) + 1;  // beyond a signed or a double-precision integer
    report.error.rms = 0.1;
    report.error.hausdorff = 1.0 / 3.0;
    report.error.diagonal = 100;
    report.repairs = {{"welded vertices", 16}, {"duplicate faces", 2}};
    report.warnings = {"texture missing: skin.png"};
    ChartReport chart;
    chart.method = "stretch";
    chart.domain = "square";
    chart.rows = 257;
    chart.cols = 129;
    chart.map.stretch_l2 = std::nextafter(1.0, 2.0);
    chart.map.flips = 3;
    chart.turned_faces = 17;
    chart.source_topology.genus = -1;
    chart.source_topology.manifold = true;
    chart.candidates = {{"tutte", 61.25, "higher error", 0.125}, {"stretch", 80.5, "chosen", 0.5}};
    report.charts.push_back(chart);
    GridSearch search;
    search.goal = SearchGoal::kMaxError;
    search.kind = ErrorKind::kRms;
    search.asked = 0.2;
    search.trials = {{129, 129, 0.3, std::nan(""), 0, "does not hold", 1.5}};
    search.next = search.trials[0];
    report.search = search;
    report.times = {{"import", 0.25, 0.5}};
    report.cpu_seconds = 5e-324;  // the smallest double
    report.peak_memory_bytes = 123456789;
    return report;
}

TEST(ReportJson, HoldsFieldsAndDerivedErrors) {
    const auto json = nlohmann::json::parse(to_json(example(), true));
    EXPECT_EQ(json["source_name"], "stomach.obj");
    EXPECT_EQ(json["source_faces"].get<std::uint64_t>(), (std::uint64_t{1} << 63) + 1);
    EXPECT_DOUBLE_EQ(json["error"]["rms_percent"].get<double>(), 0.1);
    EXPECT_DOUBLE_EQ(json["error"]["hausdorff_percent"].get<double>(), 100.0 / 300.0);
    EXPECT_NEAR(json["error"]["psnr"].get<double>(), 60.0, 1e-12);  // 20 log10(100 / 0.1)
    EXPECT_EQ(json["repairs"][0]["kind"], "welded vertices");
    EXPECT_EQ(json["repairs"][0]["count"], 16);
    EXPECT_EQ(json["charts"][0]["cols"], 129);
    EXPECT_EQ(json["charts"][0]["map"]["flips"], 3);
    EXPECT_EQ(json["charts"][0]["turned_faces"], 17);
    EXPECT_EQ(json["charts"][0]["source_topology"]["genus"], -1);
    EXPECT_EQ(json["charts"][0]["candidates"][1]["outcome"], "chosen");
    EXPECT_EQ(json["charts"][0]["candidates"][1]["cpu_seconds"], 0.5);
    EXPECT_EQ(json["times"][0]["stage"], "import");
    EXPECT_EQ(json["times"][0]["cpu_seconds"], 0.5);
    EXPECT_EQ(json["search"]["next"]["rows"], 129);
    EXPECT_TRUE(json["search"]["next"]["hausdorff"].is_null());
    EXPECT_EQ(json["search"]["trials"][0]["cpu_seconds"], 1.5);
    EXPECT_FALSE(nlohmann::json::parse(to_json(BakeReport{}, true)).contains("search"));
}

TEST(ReportJson, WithoutTimesHoldsNothingThatDiffersFromRunToRun) {
    BakeReport one = example(), other = example();
    other.times = {};
    other.cpu_seconds = 9;
    other.peak_memory_bytes = 1;
    other.charts[0].candidates[0].cpu_seconds = 7;
    other.search->trials[0].cpu_seconds = 7;
    other.search->next->cpu_seconds = 7;
    EXPECT_EQ(to_json(one, false), to_json(other, false));
    EXPECT_NE(to_json(one, true), to_json(other, true));
}

TEST(ReportJson, ComesBackToTheBit) {
    const std::string text = to_json(example(), true);
    const BakeReport back = report_from_json(text);
    EXPECT_EQ(back.source_faces, example().source_faces);
    EXPECT_EQ(back.error.hausdorff, 1.0 / 3.0);
    EXPECT_EQ(back.charts.at(0).map.stretch_l2, std::nextafter(1.0, 2.0));
    EXPECT_EQ(back.charts[0].turned_faces, 17u);
    EXPECT_EQ(back.charts[0].source_topology, example().charts[0].source_topology);
    EXPECT_EQ(back.charts[0].candidates.at(0).psnr, 61.25);
    EXPECT_EQ(back.repairs, example().repairs);
    ASSERT_TRUE(back.search && back.search->next);
    EXPECT_EQ(back.search->asked, 0.2);
    EXPECT_TRUE(std::isnan(back.search->next->hausdorff));
    EXPECT_EQ(back.cpu_seconds, 5e-324);
    EXPECT_EQ(to_json(back, true), text);
}

TEST(ReportJson, NotFiniteBecomesNullAndNanAgain) {
    BakeReport report = example();
    report.error.rms = std::numeric_limits<double>::quiet_NaN();
    report.error.diagonal = 0;
    report.charts[0].map.stretch_linf = std::numeric_limits<double>::infinity();
    const std::string text = to_json(report, true);
    const auto json = nlohmann::json::parse(text);
    EXPECT_TRUE(json["error"]["rms"].is_null());
    EXPECT_TRUE(json["error"]["rms_percent"].is_null());
    EXPECT_TRUE(json["error"]["hausdorff_percent"].is_null());
    EXPECT_TRUE(json["charts"][0]["map"]["stretch_linf"].is_null());
    const BakeReport back = report_from_json(text);
    EXPECT_TRUE(std::isnan(back.error.rms));
    EXPECT_TRUE(std::isnan(back.charts.at(0).map.stretch_linf));
}

TEST(ReportJson, BytesThatAreNotUtf8DoNotThrow) {
    BakeReport report;
    report.source_name = "caf\xe9.obj";
    EXPECT_EQ(nlohmann::json::parse(to_json(report, false))["source_name"], "caf\xef\xbf\xbd.obj");
}

TEST(ReportJson, RefusesWhatIsNotAReport) {
    for (const char* text : {"", "[]", "{", "{\"source_vertices\":-1}", "{\"source_vertices\":1.5}", "{\"error\":3}",
                             "{\"charts\":[{\"rows\":4294967296}]}", "{\"warnings\":[1]}", "{\"charts\":{}}",
                             "{\"charts\":[{\"source_topology\":{\"genus\":9223372036854775808}}]}"})
        EXPECT_THROW((void)report_from_json(text), model::Error) << text;
}

}  // namespace
}  // namespace dgm::bake
