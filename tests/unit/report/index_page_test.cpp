// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/index_page.h"

#include <gtest/gtest.h>

#include <regex>

#include "batch/report_text.h"
#include "model/codes.h"

namespace dgm::report {
namespace {
using bake::AssetResult;
using bake::BatchPlan;
using bake::Outcome;
using nlohmann::json;

struct Batch {
    BatchPlan plan;
    std::vector<AssetResult> results;
    void add(const std::string& name, Outcome outcome, double rms_percent) {
        bake::PlannedAsset asset;
        asset.source = "in/" + name;
        asset.dgm = "out/" + name + ".dgm";
        asset.name = name;
        plan.assets.push_back(asset);
        AssetResult result;
        result.outcome = outcome;
        result.seconds = 2;
        if (outcome == Outcome::kRefused) {
            result.error.emplace(model::codes::kNonOrientable, "has <one> side", "face 3");
        } else {
            result.files = {{asset.dgm, 1000}};
            result.report.error.diagonal = 100;
            result.report.error.rms = rms_percent;
            result.report.error.hausdorff = 2 * rms_percent;
            result.report.charts.resize(1);
        }
        results.push_back(result);
    }
    [[nodiscard]] json report() const { return json::parse(batch_report_json(plan, {}, results, "dgm-bake 1")); }
};

std::size_t place_of(const std::string& page, const std::string& text) {
    const std::size_t at = page.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    return at;
}

Batch some() {
    Batch batch;
    batch.add("good.obj", Outcome::kBaked, 0.01);
    batch.add("bad.obj", Outcome::kBaked, 0.9);
    batch.add("band.obj", Outcome::kRefused, 0);
    batch.add("fair.obj", Outcome::kUpToDate, 0.3);
    batch.add("also-good.obj", Outcome::kBaked, 0.01);
    return batch;
}

TEST(IndexPage, WorstFirstAndFailuresOnTop) {
    const Batch batch = some();
    const std::string page = index_page(batch.report(), std::vector<PageState>(5));
    const std::vector<std::string> order{"<h3>band.obj: refused</h3>", "data-text=\"bad.obj\"",
                                         "data-text=\"fair.obj\"", "data-text=\"also-good.obj\"",
                                         "data-text=\"good.obj\""};
    for (std::size_t k = 0; k + 1 < order.size(); ++k)
        EXPECT_LT(place_of(page, order[k]), place_of(page, order[k + 1])) << order[k];
    EXPECT_NE(page.find("<b>DGM3002</b> has &lt;one&gt; side"), std::string::npos);
    EXPECT_NE(page.find("<b>Next:</b> bake it with this version"), std::string::npos);
    EXPECT_NE(page.find("<tr class=\"bad\" data-text=\"bad.obj\">"), std::string::npos);
    EXPECT_NE(page.find("<tr class=\"look\" data-text=\"fair.obj\">"), std::string::npos);
    EXPECT_NE(page.find(">5 assets<"), std::string::npos);
    EXPECT_NE(page.find(">1 refused<"), std::string::npos);
}

TEST(IndexPage, AnErrorThatIsNoNumberIsTheWorst) {
    Batch batch = some();
    batch.add("lost.obj", Outcome::kBaked, std::numeric_limits<double>::quiet_NaN());
    const std::string page = index_page(batch.report(), {});
    EXPECT_LT(place_of(page, "data-text=\"lost.obj\""), place_of(page, "data-text=\"bad.obj\""));
}

TEST(IndexPage, HoldsTheReportItself) {
    const json report = some().report();
    const std::string page = index_page(report, {});
    std::smatch match;
    ASSERT_TRUE(std::regex_search(page, match, std::regex("id=\"report\" class=\"run\">([^<]*)</script>")));
    EXPECT_EQ(json::parse(match[1].str()), report);
}

TEST(IndexPage, NamesAndMessagesStayText) {
    Batch batch;
    const std::string evil = "</script><img src=x onerror=alert(1)>\"'.obj";
    batch.add(evil, Outcome::kBaked, 0.1);
    batch.add(evil, Outcome::kRefused, 0.1);
    batch.results[0].report.warnings = {evil};
    batch.results[1].error.emplace(model::codes::kWorkerCrashed, evil, evil);
    batch.results[1].worker_output = evil;
    PageState state;
    state.problem = evil;
    const std::string page = index_page(batch.report(), {state, {}});
    EXPECT_EQ(page.find("<img src=x"), std::string::npos);
    EXPECT_EQ(page.find("onerror=alert(1)>\""), std::string::npos);
    const std::regex script("</script>");
    EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), script), std::sregex_iterator()), 2);
}

TEST(IndexPage, SaysWhyThereIsNoPage) {
    Batch batch;
    batch.add("a.obj", Outcome::kBaked, 0.1);
    batch.add("b.obj", Outcome::kBaked, 0.2);
    PageState made{"assets/a.obj.html", "data:image/jpeg;base64,/9j/", "", ""}, lost;
    lost.problem = "DGM9002: the worker process was ended by signal 11";
    const std::string page = index_page(batch.report(), {made, lost});
    EXPECT_NE(page.find("<a href=\"assets/a.obj.html\">a.obj</a>"), std::string::npos);
    EXPECT_NE(page.find("<img src=\"data:image/jpeg;base64,/9j/\""), std::string::npos);
    EXPECT_NE(page.find("no page: DGM9002: the worker"), std::string::npos);
    EXPECT_EQ(page.find("<a href=\"\""), std::string::npos);
}

TEST(IndexPage, WhatIsNoReportIsAnError) {
    EXPECT_ANY_THROW((void)index_page(json::object(), {}));
    EXPECT_ANY_THROW((void)index_page(json{{"assets", {{{"report", 3}}}}}, {}));
}

}  // namespace
}  // namespace dgm::report
