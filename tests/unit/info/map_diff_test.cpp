// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/info/map_diff_test.cpp
#include "info/map_diff.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "unit/render/sample_chart.h"

namespace dgm::info {
namespace {
using Kind = LayerDifference::Kind;

model::MapSet two_charts() {
    model::MapSet maps;
    maps.charts = {test::torus_chart(17, 33), test::disc_chart(9)};
    return maps;
}

void add_to_geometry(model::Chart& chart, std::size_t number, float by) {
    auto& bytes = chart.find("geometry")->bytes;
    float value;
    std::memcpy(&value, bytes.data() + number * sizeof value, sizeof value);
    value += by;
    std::memcpy(bytes.data() + number * sizeof value, &value, sizeof value);
}

TEST(MapDiff, EqualMapsDifferInNothingWhateverTheirReports) {
    model::MapSet a = two_charts(), b = two_charts();
    a.report_json = "{}";
    b.report_json = R"({"seam_gap":0})";
    a.generator = "dgm-bake 0.1.0";
    b.generator = "dgm-bake 0.2.0";
    const MapDifference found = difference(a, b);
    EXPECT_TRUE(found.empty());
    EXPECT_EQ(to_text(found), "no difference\n");
    EXPECT_EQ(nlohmann::json::parse(to_json(found))["equal"], true);
    EXPECT_EQ(found.largest_move, 0);
}

TEST(MapDiff, CountsNumbersAndMeasuresTheMoveInSourceUnits) {
    const model::MapSet a = two_charts();
    model::MapSet b = a;
    // One sample by (3, 0, 4) stored, another by (0, 1, 0): the first moved farthest, 5 stored.
    add_to_geometry(b.charts[0], 30, 3);
    add_to_geometry(b.charts[0], 32, 4);
    add_to_geometry(b.charts[0], 7, 1);
    const MapDifference found = difference(a, b);
    ASSERT_EQ(found.layers.size(), 1u);
    EXPECT_EQ(found.layers[0].chart, 0u);
    EXPECT_EQ(found.layers[0].layer, "geometry");
    EXPECT_EQ(found.layers[0].kind, Kind::kValues);
    EXPECT_EQ(found.layers[0].changed, 3u);
    EXPECT_EQ(found.layers[0].elements, 17u * 33 * 3);
    EXPECT_NEAR(found.layers[0].largest, 4, 1e-5);
    ASSERT_TRUE(found.largest_move);
    EXPECT_NEAR(*found.largest_move, 5, 1e-5);
    EXPECT_TRUE(found.fields.empty());
}

TEST(MapDiff, OffsetsCountAsMovesAndAreFields) {
    const model::MapSet a = two_charts();
    model::MapSet b = a;
    b.charts[0].offset = {1, 2, 2};
    const MapDifference found = difference(a, b);
    EXPECT_EQ(found.fields, std::vector<std::string>{"chart 0: offset and scale"});
    EXPECT_TRUE(found.layers.empty());
    EXPECT_NEAR(found.largest_move.value(), 3, 1e-12);
}

TEST(MapDiff, TellsOfMissingLayersTypesShapesAndFields) {
    const model::MapSet a = two_charts();
    model::MapSet b = a;
    b.settings_hash[3] = 1;
    b.charts[1].method = "arap";
    model::Layer extra;
    extra.name = "extra";
    extra.type = model::ElementType::kU8;
    extra.shape = {1};
    extra.bytes.resize(1);
    b.charts[0].layers.push_back(extra);
    b.charts[1].find("geometry")->shape[0] += 1;
    std::erase_if(b.charts[0].layers, [](const model::Layer& layer) { return layer.name == "seams"; });
    const MapDifference found = difference(a, b);
    EXPECT_EQ(found.fields, (std::vector<std::string>{"settings hash", "chart 1: method"}));
    ASSERT_EQ(found.layers.size(), 3u);
    EXPECT_EQ(found.layers[0].kind, Kind::kOnlyInFirst);
    EXPECT_EQ(found.layers[0].layer, "seams");
    EXPECT_EQ(found.layers[1].kind, Kind::kOnlyInSecond);
    EXPECT_EQ(found.layers[1].layer, "extra");
    EXPECT_EQ(found.layers[2].kind, Kind::kShape);
    EXPECT_EQ(found.layers[2].chart, 1u);
    const std::string text = to_text(found);
    EXPECT_NE(text.find("settings hash: not equal"), std::string::npos);
    EXPECT_NE(text.find("only in the second file"), std::string::npos);
}

TEST(MapDiff, ANumberThatBecameNanIsAsFarAsCanBe) {
    const model::MapSet a = two_charts();
    model::MapSet b = a;
    add_to_geometry(b.charts[0], 4, std::numeric_limits<float>::quiet_NaN());
    const MapDifference found = difference(a, b);
    ASSERT_EQ(found.layers.size(), 1u);
    EXPECT_EQ(found.layers[0].largest, std::numeric_limits<double>::infinity());
    EXPECT_TRUE(nlohmann::json::parse(to_json(found))["layers"][0]["largest"].is_null());
}

}  // namespace
}  // namespace dgm::info
