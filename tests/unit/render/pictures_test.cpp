// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/pictures_test.cpp
#include "render/pictures.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "model/codes.h"
#include "render/canvas.h"
#include "sample_chart.h"

namespace dgm::render {
namespace {
using model::Rgba8;

std::size_t count(const formats::Image& image, std::uint32_t x0, std::uint32_t x1, bool (*is)(Rgba8)) {
    std::size_t found = 0;
    for (std::uint32_t y = 0; y < image.height; ++y)
        for (std::uint32_t x = x0; x < x1; ++x) found += is(image.at(x, y));
    return found;
}
bool is_red(Rgba8 c) {
    return c.r > 120 && c.g < 90 && c.b < 90;
}
bool is_green(Rgba8 c) {
    return c.g > 90 && c.r < 90;
}
bool is_bright(Rgba8 c) {
    return c.g > 110 && c.g > c.b + 15;
}
bool is_violet(Rgba8 c) {
    return c.b > c.g + 40 && c.r < 120;
}

TEST(Pictures, ComparisonShowsSourceReconstructionGridAndError) {
    const model::Chart coarse = test::torus_chart(17, 33), fine = test::torus_chart(65, 129);
    const ChartSurface map = chart_surface({&coarse, 1}), source = chart_surface({&fine, 1});
    PictureOptions options;
    options.width = 1200;
    options.height = 300;
    options.samples_per_pixel = 4;
    const formats::Image image = comparison_picture(source.mesh, {}, map, options);
    ASSERT_EQ(image.width, 1200u);
    ASSERT_EQ(image.height, 300u);
    EXPECT_EQ(count(image, 0, 300, is_green), 0u);       // the source has no texture here
    EXPECT_GT(count(image, 300, 600, is_green), 2000u);  // the map's texture
    EXPECT_GT(count(image, 600, 900, is_red), 100u);     // the seam
    EXPECT_LT(count(image, 600, 900, is_red), 5000u);
    // Every vertex lies on the source, but the coarse grid's facets cut into it almost evenly: the map is not the
    // violet of no error, but bright.
    EXPECT_LT(count(image, 900, 1200, is_violet), 2000u);
    EXPECT_GT(count(image, 900, 1200, is_bright), 4000u);
    options.height = 1200;
    EXPECT_EQ(comparison_picture(source.mesh, {}, map, options).height, 1200u);
}

TEST(Pictures, ComparisonRefusesWhatItCannotShow) {
    const model::Chart chart = test::torus_chart(9, 9);
    const ChartSurface map = chart_surface({&chart, 1});
    PictureOptions options;
    const auto code_of = [&](const model::TriMesh& source) {
        try {
            static_cast<void>(comparison_picture(source, {}, map, options));
        } catch (const model::Error& error) { return &error.code(); }
        return static_cast<const model::Code*>(nullptr);
    };
    EXPECT_EQ(code_of({}), &model::codes::kNoFaces);
    options.width = 100;
    EXPECT_EQ(code_of(map.mesh), &model::codes::kTooLarge);
}

TEST(Pictures, ContactSheetHasACellForEveryLayer) {
    PictureOptions options;
    options.width = 640;
    options.samples_per_pixel = 1;
    const model::Chart chart = test::torus_chart(17, 33);  // ten layers and the view: three lines
    const formats::Image sheet = contact_sheet(chart, "torus", options);
    model::Chart one = chart;
    one.layers.resize(1);
    const formats::Image small = contact_sheet(one, "torus", options);
    EXPECT_EQ(sheet.width, small.width);
    EXPECT_GT(sheet.height, 2 * small.height);
    EXPECT_GT(count(sheet, 0, sheet.width, is_green), 500u);  // the texture is among them
}

TEST(Canvas, TextIsDrawnWhereItIsMeasured) {
    formats::Image image = blank(200, 40);
    draw_text(image, 10, 10, "Hello \xff 3.14", 2);
    const std::uint32_t width = text_width("Hello \xff 3.14", 2);
    std::uint32_t low = 200, high = 0;
    for (std::uint32_t y = 0; y < 40; ++y)
        for (std::uint32_t x = 0; x < 200; ++x)
            if (image.at(x, y) == kInk) {
                low = std::min(low, x);
                high = std::max(high, x);
            }
    EXPECT_NEAR(low, 10, 3);
    EXPECT_NEAR(high, 10 + width, 6);
    draw_text(image, -500, -500, "outside", 3);  // cut off, not a crash
    draw_text(image, 190, 35, "edge", 3);
}

TEST(Canvas, FittedEnlargesByWholeNumbersAndAveragesDown) {
    formats::Image image{2, 1, {{0, 0, 0, 255}, {255, 255, 255, 255}}};
    const formats::Image large = fitted(image, 7, 9);
    ASSERT_EQ(large.width, 6u);
    ASSERT_EQ(large.height, 3u);
    EXPECT_EQ(large.at(2, 2), image.at(0, 0));
    EXPECT_EQ(large.at(3, 0), image.at(1, 0));
    const formats::Image small = fitted(image, 1, 1);
    EXPECT_EQ(small.at(0, 0), (Rgba8{188, 188, 188, 255}));  // half the light of white
}

TEST(Canvas, PasteBlendsInLinearLightAndCutsOff) {
    formats::Image image = blank(2, 2, {0, 0, 0, 255});
    paste(image, {2, 2, std::vector<Rgba8>(4, Rgba8{255, 255, 255, 128})}, 1, -1);
    EXPECT_EQ(image.at(0, 0), (Rgba8{0, 0, 0, 255}));
    EXPECT_EQ(image.at(1, 0), (Rgba8{188, 188, 188, 255}));
    EXPECT_EQ(image.at(1, 1), (Rgba8{0, 0, 0, 255}));
}

}  // namespace
}  // namespace dgm::render
