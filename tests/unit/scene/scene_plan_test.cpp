// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/scene/scene_plan_test.cpp
#include "scene/scene_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace dgm::scene {
namespace {

using Names = std::vector<std::string>;

TEST(ScenePlan, TurnsPixelsIntoUnits) {
    SceneAsset asset;
    asset.tolerance = {2, ToleranceUnit::kPixels, bake::ErrorKind::kHausdorff};
    asset.distance = 10;
    asset.view = {90, 1000};
    // At 90 degrees the picture is as high as twice the distance: 20 units over 1000 rows.
    const bake::ErrorGoal goal = error_goal(asset);
    EXPECT_FALSE(goal.percent);
    EXPECT_NEAR(goal.value, 2 * 20.0 / 1000, 1e-12);
    EXPECT_EQ(goal.kind, bake::ErrorKind::kHausdorff);
    EXPECT_NEAR(bake_options(asset).texel_length.value(), 0.02, 1e-12) << "a texel need not be finer than a pixel";
    asset.distance = 20;
    EXPECT_NEAR(error_goal(asset).value, 2 * goal.value, 1e-12) << "twice as far, twice the tolerance";
}

TEST(ScenePlan, TakesPercentAndUnitsAsTheyAre) {
    SceneAsset asset;
    asset.tolerance = {0.3, ToleranceUnit::kPercent, bake::ErrorKind::kRms};
    EXPECT_EQ(error_goal(asset), (bake::ErrorGoal{0.3, true, bake::ErrorKind::kRms}));
    asset.tolerance.unit = ToleranceUnit::kSource;
    EXPECT_EQ(error_goal(asset), (bake::ErrorGoal{0.3, false, bake::ErrorKind::kRms}));
    EXPECT_FALSE(bake_options(asset).texel_length.has_value());
}

TEST(ScenePlan, MakesOnlyTheLayersThatAreNeeded) {
    SceneAsset asset;
    EXPECT_EQ(needed_layers(asset), (Names{"geometry", "normal", "texture"}));
    asset.lit = asset.textured = false;
    EXPECT_EQ(needed_layers(asset), (Names{"geometry"}));
    asset.touched = true;
    EXPECT_EQ(needed_layers(asset), (Names{"geometry", "collision", "deformation", "contact"}));
    asset.touched = false;
    asset.contact = true;
    EXPECT_EQ(needed_layers(asset), (Names{"geometry", "contact"}));
    asset.detail = true;
    EXPECT_EQ(needed_layers(asset), (Names{"geometry", "bump", "contact"}));
    asset.layers = {"texture", "geometry"};
    EXPECT_EQ(needed_layers(asset), (Names{"geometry", "texture"})) << "what is named counts alone";
}

TEST(ScenePlan, AsksForTheSmallestFileThatHoldsTheWishes) {
    SceneAsset asset;
    asset.budget = 1000;
    asset.largest = {65, 33};
    asset.texture_budget = 4096;
    const bake::BakeOptions options = bake_options(asset);
    EXPECT_EQ(options.size, asset.largest);
    EXPECT_EQ(options.budget_bytes, 1000U);
    EXPECT_EQ(options.texture_bytes, 4096U);
    EXPECT_EQ(options.precision, bake::Precision::kAuto);
    EXPECT_EQ(options.fit, bake::Fit::kBest);
    asset.precision = bake::Precision::kU16;
    EXPECT_EQ(bake_options(asset).precision, bake::Precision::kU16);
}

BakedLayer layer(const char* name, layout::ElementType type, std::vector<std::uint64_t> shape, std::size_t element) {
    std::uint64_t count = 1;
    for (const std::uint64_t s : shape) count *= s;
    return {name, type, std::move(shape), count * element};
}

TEST(ScenePlan, SavingsAddUp) {
    BakedChart chart{129, 129, {}};
    chart.layers.push_back(layer("geometry", layout::ElementType::kU16, {129, 129, 3}, 2));
    chart.layers.push_back(layer("normal", layout::ElementType::kI16, {129, 129, 2}, 2));
    const Savings s = savings({chart});
    // By hand, per sample of 257 x 257: 12 + 4 + 16 + 8 + cover 4; texture and bump 513 x 513 x (4 + 2);
    // boxes 32^2 + 16^2 + ... + 1 = 1365 of 24 bytes; 256^2 diagonals.
    EXPECT_EQ(s.one_size, 66049U * 44 + 263169U * 6 + 1365U * 24 + 65536U);
    EXPECT_EQ(s.bytes, 16641U * 10);
    const std::int64_t saved = std::accumulate(s.steps.begin(), s.steps.end(), std::int64_t{0},
                                               [](std::int64_t sum, const Saving& step) { return sum + step.bytes; });
    EXPECT_EQ(saved, static_cast<std::int64_t>(s.one_size - s.bytes));
    ASSERT_GE(s.steps.size(), 3U);
    EXPECT_EQ(s.steps[0].choice, "grid 129x129");
    EXPECT_EQ(s.steps[1].choice, "precision u16");
    EXPECT_EQ(s.steps[1].bytes, 16641 * 6);
    EXPECT_EQ(s.steps[2].choice, "without bump, collision, contact, deformation, texture");
}

}  // namespace
}  // namespace dgm::scene
