// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/side_checks_test.cpp
// A surface with one side is sound if the layer `reversed` says so, and says it of the right copies.
#include "validate/side_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/codes.h"
#include "model/octahedral.h"
#include "unit/geometry/metrics/test_charts.h"
#include "validate/surface_checks.h"

namespace dgm::validate {
namespace {
using model::Chart;
using model::ElementType;

constexpr std::uint32_t kRows = 17, kCols = 5;

/// A Moebius strip: the last row lies on the first one, upside down. Its normals go by `reversed`.
Chart strip(const std::vector<std::uint8_t>& reversed) {
    Chart chart;
    chart.rows = kRows;
    chart.cols = kCols;
    chart.method = "tutte";
    std::vector<float> xyz;
    std::vector<std::int16_t> normals;
    std::vector<std::uint32_t> pairs;
    for (std::uint32_t i = 0; i < kRows; ++i)
        for (std::uint32_t j = 0; j < kCols; ++j) {
            const std::uint32_t row = i + 1 == kRows ? 0 : i, col = i + 1 == kRows ? kCols - 1 - j : j;
            const double a = 2 * std::numbers::pi * row / (kRows - 1), w = 0.5 * (2.0 * col / (kCols - 1) - 1);
            const double r = 1 + w * std::cos(a / 2);
            for (const double x : {r * std::cos(a), r * std::sin(a), w * std::sin(a / 2)})
                xyz.push_back(static_cast<float>(x));
            model::OctahedralCode code = model::encode_octahedral(
                {std::sin(a / 2) * std::cos(a), std::sin(a / 2) * std::sin(a), -std::cos(a / 2)});
            if (i + 1 == kRows && !reversed.empty() && reversed[kCols - 1 - j] == 1)
                code = model::encode_octahedral(-model::decode_octahedral(code));
            normals.insert(normals.end(), {code[0], code[1]});
        }
    for (std::uint32_t j = 0; j < kCols; ++j) pairs.insert(pairs.end(), {j, kRows * kCols - 1 - j});
    chart.layers.push_back(test::make_layer<float>("geometry", ElementType::kF32, {kRows, kCols, 3}, xyz));
    chart.layers.push_back(test::make_layer<std::int16_t>("normal", ElementType::kI16, {kRows, kCols, 2}, normals));
    chart.layers.push_back(test::make_layer<std::uint32_t>("seams", ElementType::kU32, {kCols, 2}, pairs));
    if (!reversed.empty())
        chart.layers.push_back(
            test::make_layer<std::uint8_t>("reversed", ElementType::kU8, {reversed.size()}, reversed));
    const bake::Reconstruction surface = bake::reconstruct(chart);
    for (int k = 0; k < 3; ++k) {
        chart.bbox[k] = chart.bbox[k + 3] = surface.mesh.positions[0][k];
        for (const model::Vec3d& p : surface.mesh.positions) {
            chart.bbox[k] = std::min(chart.bbox[k], p[k]);
            chart.bbox[k + 3] = std::max(chart.bbox[k + 3], p[k]);
        }
    }
    return chart;
}

std::vector<int> codes_of(const Chart& chart) {
    FindingList findings;
    (void)check_surface(chart, 0, bake::reconstruct(chart), findings);
    std::vector<int> out;
    for (const formats::Finding& f : findings.take()) out.push_back(f.code->number);
    return out;
}

TEST(SideChecks, AStripThatTellsOfItsSideIsSound) {
    EXPECT_EQ(codes_of(strip({1, 1, 1, 1, 1})), std::vector<int>{});
    FindingList findings;
    const Chart chart = strip({1, 1, 1, 1, 1});
    const bake::Topology t = check_surface(chart, 0, bake::reconstruct(chart), findings);
    EXPECT_TRUE(t.manifold);
    EXPECT_FALSE(t.oriented);
    EXPECT_EQ(t.boundary_loops, 1u);
    EXPECT_EQ(t.genus, 1);
}

TEST(SideChecks, WithoutTheLayerTheTopologyIsBad) {
    EXPECT_EQ(codes_of(strip({})), std::vector<int>{model::codes::kBadTopology.number});
}

TEST(SideChecks, EveryWrongEntryIsFound) {
    for (std::size_t k = 0; k < kCols; ++k) {
        std::vector<std::uint8_t> reversed(kCols, 1);
        reversed[k] = 0;
        EXPECT_EQ(codes_of(strip(reversed)), std::vector<int>{model::codes::kBadReversed.number}) << k;
        reversed[k] = 2;
        const std::vector<int> codes = codes_of(strip(reversed));
        ASSERT_FALSE(codes.empty());
        EXPECT_EQ(codes[0], model::codes::kBadReversed.number) << k;
    }
}

TEST(SideChecks, NormalsOfReversedCopiesAreOpposite) {
    Chart chart = strip({1, 1, 1, 1, 1});
    model::Layer& normal = *chart.find("normal");
    std::copy_n(normal.bytes.begin(), 4, normal.bytes.end() - 4);  // as the representative of the last pair has it
    EXPECT_EQ(codes_of(chart), std::vector<int>{model::codes::kSeamGap.number});
}

TEST(SideChecks, ALayerOfAnotherLengthIsRefused) {
    try {
        (void)bake::reconstruct(strip({1, 1, 1, 1}));
        FAIL() << "accepted";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kBadLayerShape.number); }
}

}  // namespace
}  // namespace dgm::validate
