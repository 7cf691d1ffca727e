// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/recommend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/bake_sweep.h"
#include "bench/stability_sweep.h"

namespace dgm::bench {
namespace {

Table sweep() {
    Table t;
    t.key = "bake";
    for (const char* key :
         {"asset", "method", "grid", "precision", "fit", "layers", "rms_percent", "bytes", "cpu_seconds"})
        t.columns.push_back({key, key, ""});
    const auto row = [&](const char* method, const char* grid, const char* precision, const char* layers, double rms,
                         double bytes, double seconds) {
        t.rows.push_back(
            {{"x.obj", method, grid, precision, "l2", layers, exactly(rms), exactly(bytes), exactly(seconds)}});
    };
    row("stretch", "65x65", "f32", "all", 0.2, 3e5, 0.5);
    row("stretch", "129x129", "f32", "all", 0.04, 6e5, 0.9);
    row("stretch", "129x129", "u16", "all", 0.04, 3.1e5, 0.9);
    row("stretch", "257x257", "f32", "all", 0.015, 2.4e6, 3);
    row("arap", "129x129", "f32", "all", 0.3, 6e5, 1);
    row("arap", "257x257", "f32", "all", 0.05, 2.4e6, 4);
    row("slim", "257x257", "f32", "all", 0.15, 2.5e6, 9);  // and no other grid
    row("lscm", "257x257", "f32", "all", 3, 2.4e6, 2);
    row("stretch", "65x65", "f32", "geometry", 0.001, 10, 0.1);  // cheaper, but not what was asked for
    row("tutte", "65x65", "f32", "all", std::nan(""), 1, 0.1);   // refused
    return t;
}

TEST(Recommend, NamesTheCheapestThatHoldsAndWhatOthersNeed) {
    EXPECT_EQ(
        recommend(sweep(), "x.obj"),
        (std::vector<std::string>{
            "x.obj: for 0.2 % rms use 65x65 stretch f32 fit l2: 300.0 kB, 0.500 s CPU; arap needs 257x257; slim "
            "needs at most 257x257; lscm does not reach it on the grids tried",
            "x.obj: for 0.05 % rms use 129x129 stretch u16 fit l2: 310.0 kB, 0.900 s CPU; arap needs 257x257; "
            "lscm and slim do not reach it on the grids tried",
            "x.obj: for 0.02 % rms use 257x257 stretch f32 fit l2: 2.4 MB, 3.00 s CPU; arap, lscm and slim do not "
            "reach it on the grids tried"}));
    EXPECT_TRUE(recommend(sweep(), "y.obj").empty());
}

TEST(FailureLines, SayWhoFailsWhereAndWhatTakesOver) {
    Table t;
    for (const char* key : {"family", "level", "method", "outcome", "maps"}) t.columns.push_back({key, key, ""});
    const auto rows = [&](const char* method, std::vector<std::pair<const char*, const char*>> levels) {
        int level = 1;
        for (const auto& [outcome, maps] : levels) {
            t.rows.push_back({{"holes", std::to_string(level), method, outcome, maps}});
            level *= 10;
        }
    };
    rows("auto", {{"ok", "stretch"}, {"ok", "arap"}, {"ok", "arap"}, {"DGM3003 MAP_INVALID", ""}});
    rows("mvc", {{"ok", "mvc"}, {"DGM3003 MAP_INVALID", ""}, {"ok", "mvc"}, {"DGM3003 MAP_INVALID", ""}});
    rows("arap", {{"ok", "arap"}, {"ok", "arap"}, {"ok", "arap"}, {"ok", "arap"}});
    rows("tutte", {{"ok", "tutte"}, {"DGM3003 MAP_INVALID", ""}, {"DGM9003 WORKER_TIMEOUT", ""}, {"ok", "tutte"}});
    rows("slim", {{"ok", "slim"}, {"ok", "slim"}, {"ok", "slim"}, {"DGM9003 WORKER_TIMEOUT", ""}});
    EXPECT_EQ(failure_lines(t),
              (std::vector<std::string>{
                  "holes: mvc and tutte fail at 10 (DGM3003 MAP_INVALID), 2 of 4 levels baked; slim runs out of "
                  "--time-limit at 1000, 3 of 4 levels baked; arap bakes every level; auto takes stretch, from 10 on "
                  "arap, from 1000 on nothing (DGM3003 MAP_INVALID)"}));
}

TEST(BakePoints, OneChoiceAtATimeAndThePaper) {
    BakeSweepOptions o;
    o.methods = {"auto", "arap"};
    o.precisions = {"f32", "u16"};
    o.fits = {"l2", "best"};
    o.layers = {"all"};
    o.sizes = {33, 65, 129, 257};
    const std::vector<BakePoint> points = plan_points(o);
    const auto has = [&](const BakePoint& p) { return std::count(points.begin(), points.end(), p); };
    EXPECT_EQ(has(paper_point()), 1);
    EXPECT_EQ(has(default_point()), 1);
    for (const std::uint32_t side : o.sizes) EXPECT_EQ(has({"auto", side, "f32", "l2", "all"}), 1);
    EXPECT_EQ(has({"arap", 129, "f32", "l2", "all"}), 1);
    EXPECT_EQ(has({"arap", 129, "u16", "l2", "all"}), 0);
    EXPECT_EQ(has({"arap", 257, "f32", "l2", "all"}), 0);
    EXPECT_EQ(points.size(), 4U + 2 + 2 + 2 + 1);  // sizes, arap, best and u16 at 65 and 129, the paper's
    o.compared = {257};
    EXPECT_EQ(plan_points(o).size(), 4U + 1 + 1 + 1 + 1);
    o.compared = {};
    o.sizes = {33};
    EXPECT_EQ(plan_points(o).size(), 1U + 1 + 1 + 1 + 1);
    EXPECT_EQ(repetitions_of({"auto", 257, "f32", "l2", "all"}, 7), 7U);
    EXPECT_EQ(repetitions_of({"auto", 513, "f32", "l2", "all"}, 7), 3U);
    EXPECT_EQ(repetitions_of({"auto", 513, "f32", "l2", "all"}, 1), 1U);
    EXPECT_EQ(repetitions_of({"auto", 1025, "f32", "l2", "all"}, 7), 1U);
    o.full = true;
    o.sizes = {33, 65, 129, 257};
    EXPECT_EQ(plan_points(o).size(), 2U * 4 * 2 * 2 + 1);
}

}  // namespace
}  // namespace dgm::bench
