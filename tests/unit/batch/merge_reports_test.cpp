// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/merge_reports.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "model/codes.h"
#include "process/json_apart.h"

namespace dgm::bake {
namespace {

using nlohmann::json;

json asset(const std::string& source, const std::string& outcome, int exit_code = 0, double seconds = 1) {
    json out{{"source", source}, {"outcome", outcome}, {"outputs", {source + ".dgm"}}, {"seconds", seconds}};
    if (exit_code != 0) out["error"] = {{"exit_code", exit_code}};
    return out;
}

NamedReport report(const std::string& name, std::vector<json> assets, int jobs = 1) {
    return {name, json{{"generator", "dgm-bake 1"},
                       {"report_version", 2},
                       {"run", {{"jobs", jobs}}},
                       {"assets", std::move(assets)}}};
}

std::string outcomes(const MergedReport& merged) {
    std::string out;
    const json all = json::parse(merged.text);
    for (const json& a : all["assets"])
        out += a["source"].get<std::string>() + "=" + a["outcome"].get<std::string>() + " ";
    return out;
}

TEST(MergeReports, BestOutcomeStandsAndTheWorstAssetCounts) {
    const NamedReport one = report("1", {asset("b", "failed", 75), asset("a", "baked"), asset("d", "interrupted")});
    const NamedReport two = report("2", {asset("b", "baked"), asset("c", "refused", 3), asset("d", "failed", 4)});
    const MergedReport merged = merge_reports({one, two});
    EXPECT_EQ(outcomes(merged), "a=baked b=baked c=refused d=failed ");
    EXPECT_EQ(merged.exit, model::ExitCode::kInternal);
    const json all = json::parse(merged.text);
    EXPECT_EQ(all["exit_code"], 4);
    EXPECT_EQ(all["summary"], (json{{"assets", 4},
                                    {"baked", 2},
                                    {"up_to_date", 0},
                                    {"refused", 1},
                                    {"failed", 1},
                                    {"interrupted", 0},
                                    {"not_started", 0}}));
    EXPECT_EQ(all["run"], (json{{"jobs", 1}}));
    EXPECT_EQ(merge_reports({two, one}).text, merged.text);
    EXPECT_EQ(merge_reports({two, one, two, {"again", json::parse(merged.text)}}).text, merged.text);
}

int code_of(const std::string& text) {
    try {
        (void)merge_reports({{"bad.json", parse_json(text, "bad.json")}});
        return 0;
    } catch (const model::Error& error) {
        EXPECT_EQ(error.place(), "bad.json");
        return error.code().number;
    }
}

TEST(MergeReports, DamagedReportsAreRefusedByName) {
    const json good = report("1", {asset("a", "baked")}).report;
    const json bad[] = {nullptr, -1, 7, "x", json::array(), json::object(), json::array({1}), true, 1e300};
    for (const char* key : {"generator", "report_version", "assets"})
        for (const json& value : bad) {
            json damaged = good;
            damaged[key] = value;
            const bool is_good = (std::string(key) == "generator" && value == "x") ||
                                 (std::string(key) == "assets" && value == json::array());
            EXPECT_EQ(code_of(damaged.dump()), is_good ? 0 : model::codes::kReportUnreadable.number) << damaged;
        }
    json removed = good;
    removed["left_over"] = json::array({{{"path", "x"}, {"removed", 1}}, {{"path", "x"}, {"removed", "y"}}});
    EXPECT_EQ(code_of(removed.dump()), 0);
    json strange = good;
    strange["assets"][0]["error"] = {{"exit_code", 99}};
    EXPECT_EQ(merge_reports({{"strange.json", strange}}).exit, model::ExitCode::kInternal);
    std::string bytes = good.dump();
    bytes.replace(bytes.find("a.dgm"), 1, "\xff");
    EXPECT_EQ(code_of(bytes), model::codes::kReportUnreadable.number) << "JSON is UTF-8";
    EXPECT_EQ(code_of(std::string(100'000, '[')), model::codes::kReportUnreadable.number);
    json deep = good;
    deep["assets"][0]["deep"] = 0;
    std::string text = deep.dump();
    text.replace(text.find(":0", text.find("deep")), 2, ":" + std::string(100'000, '[') + std::string(100'000, ']'));
    EXPECT_EQ(code_of(text), model::codes::kReportUnreadable.number);
}

TEST(MergeReports, WhatMayPassStandsAgainstWhatDoesNot) {
    const NamedReport passing = report("1", {asset("a", "failed", 75)}),
                      lasting = report("2", {asset("a", "failed", 4)});
    EXPECT_EQ(merge_reports({passing}).exit, model::ExitCode::kTransient);
    EXPECT_EQ(merge_reports({passing, lasting}).exit, model::ExitCode::kInternal);
}

TEST(MergeReports, EqualOutcomesDoNotDependOnTheOrder) {
    const NamedReport one = report("1", {asset("a", "baked", 0, 2)}), two = report("2", {asset("a", "baked", 0, 1)}, 2);
    EXPECT_EQ(merge_reports({one, two}).text, merge_reports({two, one}).text);
    EXPECT_FALSE(json::parse(merge_reports({one, two}).text).contains("run"));  // they differ
}

TEST(MergeReports, RefusesWhatIsNoReport) {
    EXPECT_THROW((void)merge_reports({}), model::Error);
    for (const char* text : {"", "3", "{}", R"({"report_version":1,"assets":[]})", R"({"report_version":2})",
                             R"({"report_version":2,"assets":[{}]})",
                             R"({"report_version":2,"assets":[{"source":"a","outcome":"fine"}]})"}) {
        try {
            (void)merge_reports({{"r.json", parse_json(text, "r.json")}});
            ADD_FAILURE() << text;
        } catch (const model::Error& error) {
            EXPECT_EQ(error.code().number, model::codes::kReportUnreadable.number) << text;
            EXPECT_EQ(error.place(), "r.json");
        }
    }
    NamedReport other = report("2", {});
    other.report["generator"] = "dgm-bake 2";
    EXPECT_THROW((void)merge_reports({report("1", {}), other}), model::Error);
}

}  // namespace
}  // namespace dgm::bake
