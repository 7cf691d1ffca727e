// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/page/page_map_test.cpp
#include "page/page_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "model/codes.h"
#include "model/element.h"
#include "model/error.h"

namespace dgm::page {
namespace {
using model::Chart;
using model::ElementType;
using model::Layer;

template <class T>
Layer layer(const char* name, ElementType type, std::vector<std::uint64_t> shape, const std::vector<T>& values) {
    Layer out{.name = name, .type = type, .shape = std::move(shape), .bytes = {}, .attributes = {}};
    out.bytes.resize(values.size() * sizeof(T));
    std::memcpy(out.bytes.data(), values.data(), out.bytes.size());
    return out;
}

/// 2 x 3 samples of 32 bits, with all that a page leaves out or keeps.
model::MapSet map_of(float mobility) {
    model::MapSet maps;
    Chart& chart = maps.charts.emplace_back();
    chart.rows = 2, chart.cols = 3;
    chart.offset = {10, 20, 30};
    std::vector<float> places;
    for (int k = 0; k < 18; ++k) places.push_back(std::sin(static_cast<float>(k)) * 4);
    chart.layers.push_back(layer("geometry", ElementType::kF32, {2, 3, 3}, places));
    chart.layers.push_back(layer("normal", ElementType::kI16, {2, 3, 2}, std::vector<std::int16_t>(12)));
    chart.layers.push_back(layer("seams", ElementType::kU32, {1, 2}, std::vector<std::uint32_t>{0, 2}));
    std::vector<float> contact(12, 1);
    contact[3] = mobility;
    chart.layers.push_back(layer("contact", ElementType::kF32, {2, 3, 2}, contact));
    std::vector<float> deformation(24, 0.5F);
    for (std::size_t k = 3; k < 24; k += 4) deformation[k] = 1;
    chart.layers.push_back(layer("deformation", ElementType::kF32, {2, 3, 4}, deformation));
    return maps;
}

TEST(PageMap, PositionsMoveByHalfAStepAtMost) {
    const model::MapSet maps = map_of(1), page = touch_layers(maps);
    const Chart &before = maps.charts[0], &after = page.charts[0];
    const Layer &exact = *before.find("geometry"), &codes = *after.find("geometry");
    ASSERT_EQ(codes.type, ElementType::kU16);
    EXPECT_EQ(after.scale[0], after.scale[1]);
    double low = 1e9, high = -1e9;
    for (std::size_t k = 0; k < 18; ++k) {
        const double wanted = before.offset[k % 3] + model::element_value(exact, k);
        const double found = after.offset[k % 3] + after.scale[k % 3] * model::element_value(codes, k);
        EXPECT_NEAR(found, wanted, 0.5001 * after.scale[0]);
        low = std::min(low, model::element_value(exact, k)), high = std::max(high, model::element_value(exact, k));
    }
    EXPECT_LE(after.scale[0], (high - low) / 65535 * 1.0001);
}

TEST(PageMap, LayersThatSayNothingStayOut) {
    const Chart free = touch_layers(map_of(1)).charts[0], held = touch_layers(map_of(0.25F)).charts[0];
    EXPECT_EQ(free.find("contact"), nullptr);
    EXPECT_EQ(free.find("deformation"), nullptr);
    EXPECT_EQ(free.find("normal"), nullptr);
    EXPECT_NE(free.find("seams"), nullptr);
    EXPECT_NE(held.find("contact"), nullptr);
}

TEST(PageMap, CodesOfSixteenBitsStay) {
    const model::MapSet once = touch_layers(map_of(1)), twice = touch_layers(once);
    EXPECT_EQ(once.charts, twice.charts);
}

TEST(PageMap, RefusesAGeometryOfAnotherShape) {
    model::MapSet maps = map_of(1);
    maps.charts[0].rows = 3;
    try {
        static_cast<void>(touch_layers(maps));
        FAIL();
    } catch (const model::Error& error) { EXPECT_EQ(&error.code(), &model::codes::kBadLayerShape); }
    maps.charts[0].layers.clear();
    try {
        static_cast<void>(touch_layers(maps));
        FAIL();
    } catch (const model::Error& error) { EXPECT_EQ(&error.code(), &model::codes::kMissingLayer); }
}

}  // namespace
}  // namespace dgm::page
