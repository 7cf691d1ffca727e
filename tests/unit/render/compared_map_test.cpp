// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/compared_map_test.cpp
#include "export/compared_map.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>

#include "charts.h"
#include "geometry/metrics/reconstruction.h"
#include "model/half.h"
#include "model/layer_names.h"

namespace dgm::exporter {
namespace {

model::MapSet sheet_at(double z) {
    model::MapSet out;
    out.charts.push_back(render::chart_of(9, 9, [=](double i, double j) { return model::Vec3d{i, j, z}; }));
    return out;
}

TEST(ComparedMap, DistancesStandInTheirScale) {
    const model::MapSet maps = sheet_at(0.25);
    const model::MapSet source = sheet_at(0);
    page::PagedMap map{"sheet", &maps};
    compare_with(bake::reconstruct(source.charts[0]).mesh, map);
    ASSERT_EQ(map.values.size(), 3U);
    const page::PagedValues& distance = map.values[0];
    EXPECT_EQ(distance.name, kDistanceName);
    EXPECT_DOUBLE_EQ(distance.high, 0.25);
    EXPECT_DOUBLE_EQ(distance.low, -0.25);
    EXPECT_EQ(distance.codes, std::vector<std::uint8_t>(81, 255));  // outside by as much as the scale has
    // A plain sheet is stretched nowhere: the middle of one scale, the beginning of the other.
    EXPECT_EQ(map.values[1].codes, std::vector<std::uint8_t>(81, 128));
    EXPECT_EQ(map.values[2].codes, std::vector<std::uint8_t>(81, 0));
    ASSERT_TRUE(map.source);
    EXPECT_EQ(map.source->positions.size(), 81U);
    EXPECT_EQ(map.source->codes, std::vector<std::uint8_t>(81, 255));
}

TEST(ComparedMap, NoBadSpotIsSimplifiedAway) {
    const model::TriMesh mesh = bake::reconstruct(render::hill(257, 257)).mesh;  // beyond kMostSourceVertices
    std::vector<double> distances(mesh.positions.size(), 0.0);
    distances[100 * 257 + 101] = -7;
    render::Scales scales;
    scales.distance = scales.worst = 7;
    const model::MapSet maps;
    page::PagedMap map{"hill", &maps};
    add_comparison({mesh, distances, {}, scales}, map);
    EXPECT_LE(map.source->positions.size(), kMostSourceVertices);
    EXPECT_EQ(*std::min_element(map.source->codes.begin(), map.source->codes.end()), 0);
}

TEST(ComparedMap, BumpIsTheNearestTexel) {
    model::MapSet maps = sheet_at(0);
    model::Layer& bump = maps.charts[0].layers.emplace_back();
    bump.name = model::layers::kBump, bump.type = model::ElementType::kF16, bump.shape = {2, 2};
    for (const float height : {-1.0F, 0.0F, 0.5F, 1.0F}) {
        const std::uint16_t bits = model::half_bits(height);
        const auto* bytes = reinterpret_cast<const std::byte*>(&bits);
        bump.bytes.insert(bump.bytes.end(), bytes, bytes + 2);
    }
    page::PagedMap map{"sheet", &maps};
    add_bump(map);
    ASSERT_EQ(map.values.size(), 1U);
    EXPECT_EQ(map.values[0].high, 1);
    EXPECT_EQ(map.values[0].codes[0], 0);
    EXPECT_EQ(map.values[0].codes[8], 128);
    EXPECT_EQ(map.values[0].codes[72], 191);
    EXPECT_EQ(map.values[0].codes[80], 255);
}

TEST(ComparedMap, ErrorsOfTheReport) {
    const auto report = nlohmann::json::parse(R"({"error": {"rms": 0.5, "hausdorff": 2, "diagonal": 100}})");
    EXPECT_EQ(measured_errors(report), "rms error 0.5 (0.5 % of the diagonal), largest 2 (2 %)");
    for (const char* none : {"null", "{}", "[1]", R"({"error": {"rms": "x"}})", R"({"error": 3})"})
        EXPECT_EQ(measured_errors(nlohmann::json::parse(none)), "");
}

}  // namespace
}  // namespace dgm::exporter
