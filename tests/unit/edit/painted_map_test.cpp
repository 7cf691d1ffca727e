// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/edit/painted_map_test.cpp
#include "edit/painted_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "model/codes.h"
#include "model/element.h"
#include "unit/validate/validation_maps.h"

namespace dgm::edit {
namespace {

namespace codes = model::codes;
using model::element;
using model::Layer;

constexpr std::uint32_t n = test::kTubeCols;

class Paint : public testing::Test {
 protected:
    std::size_t number_of(const char* layer, std::size_t chart = 0) const {
        const auto& layers = maps_.charts[chart].layers;
        return static_cast<std::size_t>(maps_.charts[chart].find(layer) - layers.data());
    }
    PartEdit& edit(const char* layer, std::uint32_t number, std::size_t chart = 0) {
        return *map().edit_of(chart, number_of(layer, chart), number, "painted.exr");
    }
    PaintedMap& map() {
        if (!map_) map_.emplace(maps_, choice_.emplace(maps_, names_));
        return *map_;
    }
    float stiffness(std::size_t sample) {
        return element<float>(*map().maps().charts[0].find("deformation"), 4 * sample + 3);
    }
    static model::Error error_of(const std::function<void()>& action) {
        try {
            action();
        } catch (const model::Error& error) { return error; }
        ADD_FAILURE() << "nothing was thrown";
        return {codes::kInternal, ""};
    }

    model::MapSet maps_ = test::good_maps();
    std::vector<std::string> names_;
    std::optional<PartChoice> choice_;
    std::optional<PaintedMap> map_;
};

TEST_F(Paint, OnlyPaintedSamplesGetOtherBits) {
    PartEdit& it = edit("deformation", 3);
    for (std::size_t s = 0; s < it.changed.size(); ++s)
        map().offer(it, 3, s, s == 5 * n + 4 ? 0.25 : 1.0, Rounding::exact());
    map().finish();
    EXPECT_EQ(it.samples, 1u);
    EXPECT_DOUBLE_EQ(it.largest, 0.75);
    EXPECT_EQ(stiffness(5 * n + 4), 0.25f);
    const Layer &before = *maps_.charts[0].find("deformation"), &after = *map().maps().charts[0].find("deformation");
    std::size_t other = 0;
    for (std::size_t k = 0; k < before.bytes.size(); ++k) other += before.bytes[k] != after.bytes[k];
    EXPECT_GT(other, 0u);
    EXPECT_LE(other, sizeof(float));
}

TEST_F(Paint, ASeamCopyFollowsThePaintedOne) {
    PartEdit& it = edit("deformation", 3);
    map().offer(it, 3, 3 * n + n - 1, 0.5, Rounding::exact());
    map().finish();
    EXPECT_EQ(it.joined, 1u);
    EXPECT_EQ(stiffness(3 * n), 0.5f);
    EXPECT_EQ(stiffness(3 * n + n - 1), 0.5f);
    EXPECT_EQ(stiffness(4 * n), 1.0f);
}

TEST_F(Paint, CopiesPaintedInTwoWaysGetTheMeanToTheBit) {
    PartEdit& it = edit("deformation", 3);
    map().offer(it, 3, 3 * n, 0.1f, Rounding::exact());
    map().offer(it, 3, 3 * n + n - 1, 0.7f, Rounding::exact());
    map().finish();
    EXPECT_EQ(stiffness(3 * n), static_cast<float>((0.1f + double{0.7f}) / 2));
    EXPECT_EQ(stiffness(3 * n), stiffness(3 * n + n - 1));
}

TEST_F(Paint, NumbersBeyondTheUnitAreClamped) {
    PartEdit& it = edit("contact", 1);
    map().offer(it, 1, 40, -0.5, Rounding::exact());
    map().offer(it, 1, 41, 1.5, Rounding::exact());  // 1 already: nothing to change
    map().finish();
    EXPECT_EQ(it.clamped, 2u);
    EXPECT_EQ(it.samples, 1u);
    EXPECT_EQ(element<float>(*map().maps().charts[0].find("contact"), 2 * 40 + 1), 0.0f);
    EXPECT_EQ(element<float>(*map().maps().charts[0].find("contact"), 2 * 41 + 1), 1.0f);
}

TEST_F(Paint, NoNumberIsRefusedWithItsPlace) {
    const model::Error error = error_of(
        [&] { map().offer(edit("deformation", 3), 3, 2 * n + 6, std::numeric_limits<double>::quiet_NaN(), {}); });
    EXPECT_EQ(error.code().number, codes::kNotFinite.number);
    EXPECT_EQ(error.place(), "/charts/0/deformation[2][6]");
}

TEST_F(Paint, AHeightThatTheLayerCannotHoldIsRefused) {
    const model::Error error = error_of([&] { map().offer(edit("bump", 0), 0, 1, 70000, Rounding::exact()); });
    EXPECT_EQ(error.code().number, codes::kBadValue.number);
}

TEST_F(Paint, WhatMayNotBeEditedIsNamedWithFigures) {
    map().offer(edit("geometry", 1), 1, 4 * n + 2, 3.5, Rounding::exact());
    map().offer(edit("geometry", 2), 2, 4 * n + 2, 3.5, Rounding::exact());
    map().offer(edit("deformation", 0), 0, 7, 9.0, Rounding::exact());
    const model::Error error = error_of([&] { map().finish(); });
    EXPECT_EQ(error.code().number, codes::kEditForbidden.number);
    EXPECT_EQ(error.place(), "/charts/0/geometry");
    const std::string text = error.what();
    EXPECT_NE(text.find("geometry may not be edited"), std::string::npos) << text;
    EXPECT_NE(text.find("1 of 132 samples differ"), std::string::npos) << text;
    EXPECT_NE(text.find("first /charts/0/geometry[4][2]"), std::string::npos) << text;
    EXPECT_NE(text.find("metric may not be edited"), std::string::npos) << text;
    EXPECT_TRUE(map().is_unchanged());
}

TEST_F(Paint, EveryLockedLayerIsRefusedAndEveryOpenOneIsNot) {
    const std::set<std::string> open{"texture", "bump", "stiffness", "mobility", "own"};
    model::Layer own = test::make_layer<float>("own", model::ElementType::kF32, {2, 2}, {0, 0, 0, 0});
    maps_.charts[0].layers.push_back(own);
    std::set<std::string> seen;
    for (std::size_t c = 0; c < maps_.charts.size(); ++c)
        for (std::size_t l = 0; l < maps_.charts[c].layers.size(); ++l)
            for (const MapPart& part : parts_of(maps_.charts[c].layers[l])) {
                const std::vector<std::string> all;
                const PartChoice choice(maps_, all);
                PaintedMap painted(maps_, choice);
                PartEdit& it = *painted.edit_of(c, l, part.first, "x");
                painted.offer(it, part.first, 0, 0.125, Rounding::exact());
                seen.insert(part.name);
                if (open.contains(part.name)) {
                    EXPECT_NO_THROW(painted.finish()) << part.name;
                    EXPECT_FALSE(painted.is_unchanged()) << part.name;
                } else {
                    const model::Error error = error_of([&] { painted.finish(); });
                    EXPECT_EQ(error.code().number, codes::kEditForbidden.number) << part.name;
                    EXPECT_EQ(std::string(error.what()).find(part.name + " may not be edited, since "), 0u);
                }
            }
    EXPECT_EQ(seen.size(), 18u);  // all but border_normal, and the one of our own
}

TEST_F(Paint, ARequiredLayerThatNobodyKnowsIsLocked) {
    model::Layer own = test::make_layer<float>("own", model::ElementType::kF32, {2, 2}, {0, 0, 0, 0});
    own.required = true;
    EXPECT_FALSE(parts_of(own)[0].is_editable);
}

TEST_F(Paint, SamplesOffTheSurfaceAreLeftAlone) {
    maps_.charts[1].layers.push_back(
        test::make_layer<float>("contact", model::ElementType::kF32, {3, 3, 2}, std::vector<float>(18, 1)));
    PartEdit& it = edit("contact", 1, 1);
    map().offer(it, 1, 4, 0.5, Rounding::exact());
    map().offer(it, 1, 8, 0.5, Rounding::exact());  // the corner that the mask leaves out
    map().finish();
    EXPECT_EQ(it.samples, 1u);
    EXPECT_EQ(it.outside, 1u);
    const Layer& contact = *map().maps().charts[1].find("contact");
    EXPECT_EQ(element<float>(contact, 2 * 4 + 1), 0.5f);
    EXPECT_EQ(element<float>(contact, 2 * 8 + 1), 1.0f);
}

TEST_F(Paint, AChoiceLeavesTheRestOut) {
    names_ = {"mobility"};
    EXPECT_EQ(map().edit_of(0, number_of("deformation"), 3, "x"), nullptr);
    EXPECT_EQ(map().edit_of(0, number_of("geometry"), 0, "x"), nullptr);
    EXPECT_NE(map().edit_of(0, number_of("contact"), 1, "x"), nullptr);
    EXPECT_EQ(map().edit_of(0, number_of("contact"), 0, "x"), nullptr);
}

TEST_F(Paint, AChoiceOfWhatIsLockedOrNotThereIsRefused) {
    for (const auto& [name, code] :
         {std::pair{"geometry", codes::kEditForbidden.number}, std::pair{"stifness", codes::kUsage.number}}) {
        const std::vector<std::string> names{name};
        EXPECT_EQ(error_of([&] { const PartChoice choice(maps_, names); }).code().number, code) << name;
    }
    const std::vector<std::string> names{"stifness"};
    EXPECT_NE(std::string(error_of([&] { const PartChoice choice(maps_, names); }).what()).find("stiffness"),
              std::string::npos);
}

TEST_F(Paint, TrustedLayersAgreeOnSeamsAndLockedOnesAreRefused) {
    Layer& deformation = *maps_.charts[0].find("deformation");
    test::poke(deformation, 4 * (3 * n) + 3, 0.5f);
    map().trust(0, number_of("deformation"), "map.dgm");
    map().finish();
    EXPECT_EQ(stiffness(3 * n), 0.75f);  // nobody knows which copy was painted
    EXPECT_EQ(stiffness(3 * n + n - 1), 0.75f);
    map_.reset();
    map().trust(0, number_of("cover"), "map.dgm");
    EXPECT_EQ(error_of([&] { map().finish(); }).code().number, codes::kEditForbidden.number);
}

}  // namespace
}  // namespace dgm::edit
