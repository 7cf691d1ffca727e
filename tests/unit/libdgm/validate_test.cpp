// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/validate_test.cpp
// Values that open leaves unread: each is refused with its place, by validate_chart and by State::create alike.
#include <gtest/gtest.h>

#include <dgm/validate.h>

#include <functional>
#include <limits>

#include "opened.h"

namespace dgm::test {
namespace {

ChartSpec sound() {
    ChartSpec c = free_chart(9, 8, sheet, {{72 + 1, 72 + 5}, {72 + 2, 72 + 6}, {72 + 1, 72 + 9}});
    c.add("diagonals", ElementType::kU8, {8, 7}, std::vector<std::uint8_t>(56, 1));
    return c;
}

template <class T>
void set(ChartSpec& c, const char* layer, std::size_t index, T value) {
    std::memcpy(c.layer(layer).bytes.data() + index * sizeof(T), &value, sizeof value);
}

void expect_refused(const std::function<void(ChartSpec&)>& spoil, ErrorCode code, const char* layer, std::size_t byte) {
    ChartSpec c = sound();
    spoil(c);
    const Opened opened(build({c}));
    const Error e = validate_chart(opened.chart()).error();
    EXPECT_EQ(error_name(e.code), std::string(error_name(code))) << e.message;
    EXPECT_EQ(e.byte_offset, opened.chart().find(layer).value().file_offset + byte) << e.message;
    const Error s = State::create(opened.chart()).error();
    EXPECT_EQ(s.code, e.code);
    EXPECT_EQ(s.byte_offset, e.byte_offset);
}

TEST(Validate, SoundChartPasses) {
    const Opened opened(build({sound()}));
    EXPECT_TRUE(validate_chart(opened.chart()).ok()) << validate_chart(opened.chart()).error().message;
    EXPECT_TRUE(State::create(opened.chart()).ok());
}

TEST(Validate, EachValueIsChecked) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::uint32_t none = 0xFFFFFFFFu;
    expect_refused([=](ChartSpec& c) { set(c, "geometry", 3 * 9 + 2, nan); }, ErrorCode::NotFinite, "geometry", 12 * 9);
    expect_refused([=](ChartSpec& c) { set(c, "border_geometry", 3 * 4, -INFINITY); }, ErrorCode::NotFinite,
                   "border_geometry", 48);
    expect_refused(
        [](ChartSpec& c) {
            c.scale = {1, 1e300, 1};
            set(c, "geometry", 3 * 9 + 1, 1e30f);
        },
        ErrorCode::NotFinite, "geometry", 12 * 9);
    expect_refused([](ChartSpec& c) { set<std::uint8_t>(c, "mask", 10, 2); }, ErrorCode::BadValue, "mask", 10);
    expect_refused([](ChartSpec& c) { set<std::uint8_t>(c, "diagonals", 55, 255); }, ErrorCode::BadValue, "diagonals",
                   55);
    expect_refused([](ChartSpec& c) { set(c, "border_uv", 3, 1.01f); }, ErrorCode::BadValue, "border_uv", 12);
    expect_refused([=](ChartSpec& c) { set(c, "border_uv", 3, nan); }, ErrorCode::BadValue, "border_uv", 12);
    expect_refused([=](ChartSpec& c) { set(c, "border_faces", 4, none); }, ErrorCode::BadValue, "border_faces", 16);
    expect_refused([](ChartSpec& c) { set(c, "border_faces", 4, 0u); }, ErrorCode::BadValue, "border_faces",
                   16);  // off the surface
    expect_refused(
        [](ChartSpec& c) {
            set(c, "border_faces", 3, 9u);
            set(c, "border_faces", 5, 9u);
        },
        ErrorCode::BadValue, "border_faces", 12);
    expect_refused([=](ChartSpec& c) { set(c, "seams", 3, none); }, ErrorCode::BadSeamTable, "seams", 8);
    expect_refused([](ChartSpec& c) { set(c, "seams", 2, 0u); }, ErrorCode::BadSeamTable, "seams",
                   8);  // off the surface
    expect_refused([](ChartSpec& c) { set(c, "seams", 2, 72u + 6); }, ErrorCode::BadSeamTable, "seams", 8);  // itself
    expect_refused([](ChartSpec& c) { set(c, "seams", 3, 72u + 5); }, ErrorCode::BadSeamTable, "seams",
                   8);  // a copy twice
    expect_refused([](ChartSpec& c) { set(c, "seams", 2, 72u + 5); }, ErrorCode::BadSeamTable, "seams",
                   8);  // copy of a copy
    expect_refused([](ChartSpec& c) { set(c, "border_geometry", 3 * 6 + 1, 0.125f); }, ErrorCode::SeamGap,
                   "border_geometry", 12 * 6);
}

TEST(Validate, OffTheSurfaceAnythingGoes) {
    ChartSpec c = sound();
    set(c, "geometry", 0, std::numeric_limits<float>::quiet_NaN());
    const State state = make_state(c);
    EXPECT_EQ(state.positions()[0].x, 0.0f);
    EXPECT_FALSE(state.on_surface(0));
}

TEST(Validate, MissingTables) {
    ChartSpec c = sound();
    std::erase_if(c.layers, [](const LayerSpec& l) { return l.name == "mask"; });
    EXPECT_EQ(State::create(Opened(build({c})).chart()).error().code, ErrorCode::MissingLayer);
    c = sound();
    std::erase_if(c.layers, [](const LayerSpec& l) { return l.name == "border_geometry"; });
    EXPECT_EQ(State::create(Opened(build({c})).chart()).error().code, ErrorCode::MissingLayer);
    c = sound();
    std::erase_if(c.layers, [](const LayerSpec& l) { return l.name == "geometry"; });
    EXPECT_EQ(validate_chart(Opened(build({c})).chart()).error().code, ErrorCode::MissingLayer);
}

TEST(Validate, StateOptions) {
    const Opened opened(build({sound()}));
    StateOptions options;
    options.max_reach = 0;
    EXPECT_EQ(State::create(opened.chart(), options).error().code, ErrorCode::BadArgument);
    options = {};
    options.max_bytes = 1000;
    EXPECT_EQ(State::create(opened.chart(), options).error().code, ErrorCode::LimitExceeded);
}

TEST(Validate, SeamClassesInOrder) {
    const State state = make_state(sound());
    ASSERT_EQ(state.class_count(), 2u);
    const auto members = state.class_members(0);
    EXPECT_EQ(std::vector<std::uint32_t>(members.begin(), members.end()), (std::vector<std::uint32_t>{73, 77, 81}));
    EXPECT_EQ(state.class_of(78), 1u);
    EXPECT_EQ(state.class_of(72), kNone);
    EXPECT_EQ(state.class_of(kNone), kNone);
    EXPECT_TRUE(state.class_members(2).empty());
}

}  // namespace
}  // namespace dgm::test
