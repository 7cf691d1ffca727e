// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/layer_picture_test.cpp
#include "render/layer_picture.h"

#include <gtest/gtest.h>

#include "model/codes.h"
#include "model/element.h"
#include "render/colour.h"
#include "sample_chart.h"

namespace dgm::render {
namespace {
using model::Rgba8;

const model::Chart& torus() {
    static const model::Chart chart = test::torus_chart(33, 65);
    return chart;
}

const model::Code* code_of(const model::Chart& chart, std::string_view layer) {
    try {
        static_cast<void>(layer_picture(chart, layer));
    } catch (const model::Error& error) { return &error.code(); }
    return nullptr;
}

TEST(LayerPicture, GeometryAndNormalAtKnownSamples) {
    const auto geometry = layer_picture(torus(), "geometry").image;
    ASSERT_EQ(geometry.width, 65u);
    ASSERT_EQ(geometry.height, 33u);
    EXPECT_EQ(geometry.at(0, 0), (Rgba8{255, 128, 128, 255}));   // (1.4, 0, 0)
    EXPECT_EQ(geometry.at(0, 8), (Rgba8{219, 255, 128, 255}));   // (1, 0.4, 0): 255 * 2.4 / 2.8
    EXPECT_EQ(geometry.at(16, 0), (Rgba8{128, 128, 255, 255}));  // (0, 0, 1.4)
    EXPECT_EQ(geometry.at(32, 16).r, 73);                        // (-0.6, 0, 0): 255 * 0.8 / 2.8
    const auto normal = layer_picture(torus(), "normal").image;
    EXPECT_EQ(normal.at(0, 0), (Rgba8{255, 128, 128, 255}));
    EXPECT_EQ(normal.at(0, 8), (Rgba8{128, 255, 128, 255}));
    EXPECT_EQ(normal.at(0, 16).r, 0);
}

TEST(LayerPicture, TextureAsStored) {
    const auto image = layer_picture(torus(), "texture").image;
    ASSERT_EQ(image.width, 129u);
    ASSERT_EQ(image.height, 65u);
    EXPECT_EQ(image.at(5, 60), (Rgba8{220, 30, 40, 255}));
    EXPECT_EQ(image.at(5, 2), (Rgba8{20, 190, 40, 255}));
    EXPECT_EQ(image.at(16, 2), (Rgba8{20, 30, 40, 255}));
}

TEST(LayerPicture, BumpIsRedAboveAndBlueBelow) {
    const auto picture = layer_picture(torus(), "bump");
    EXPECT_EQ(picture.image.at(1, 0), diverging_colour(1));
    EXPECT_EQ(picture.image.at(2, 0), diverging_colour(-1));
    EXPECT_EQ(picture.image.at(3, 0), diverging_colour(0.5));
    EXPECT_EQ(picture.image.at(9, 9), diverging_colour(0));
    EXPECT_EQ(picture.note, "-1 .. 1");
}

TEST(LayerPicture, ASpikeLeavesTheOtherBumpsTheirColours) {
    model::Chart chart = torus();
    model::Layer& bump = *chart.find("bump");
    std::vector<std::uint16_t> heights(std::size_t{33} * 65, 0x2c00);  // 1/16
    heights[0] = 0x4c00;                                               // 16
    bump = test::make_layer("bump", model::ElementType::kF16, {33, 65}, heights);
    const auto picture = layer_picture(chart, "bump");
    EXPECT_EQ(picture.image.at(9, 9), diverging_colour(1));
    EXPECT_EQ(picture.image.at(0, 0), diverging_colour(1));
    EXPECT_EQ(picture.note, "0.0625 .. 16, colours end at 0.062");
}

TEST(LayerPicture, HeatPicturesRunFromLowToHigh) {
    const auto cover = layer_picture(torus(), "cover").image;
    EXPECT_EQ(cover.at(40, 0), sequential_colour(1));   // outer rim: longest steps
    EXPECT_EQ(cover.at(40, 16), sequential_colour(0));  // inner rim: shortest
    const auto deformation = layer_picture(torus(), "deformation").image;
    ASSERT_EQ(deformation.width, 2 * 65 + kTileGap);
    ASSERT_EQ(deformation.height, 2 * 33 + kTileGap);
    EXPECT_EQ(deformation.at(65 + kTileGap + 3, 5), diverging_colour(0));    // F
    EXPECT_EQ(deformation.at(3, 33 + kTileGap), sequential_colour(1));       // G at the outer rim
    EXPECT_EQ(deformation.at(3, 33 + kTileGap + 16), sequential_colour(0));  // G at the inner rim
    const auto contact = layer_picture(torus(), "contact").image;
    EXPECT_EQ(contact.at(65 + kTileGap + 3, 5), (Rgba8{255, 255, 255, 255}));  // mobility 1
    EXPECT_EQ(contact.at(65 + kTileGap + 60, 5), (Rgba8{0, 0, 0, 255}));       // mobility 0
    EXPECT_EQ(contact.at(3, 0), sequential_colour(1));
}

TEST(LayerPicture, CollisionShowsOneBlockATile) {
    const auto image = layer_picture(torus(), "collision").image;
    EXPECT_EQ(image.at(8, 8), image.at(15, 15));
    EXPECT_NE(image.at(8, 0), image.at(8, 8));
    model::Chart short_of_boxes = torus();
    short_of_boxes.find("collision")->shape[0] = 7;
    short_of_boxes.find("collision")->bytes.resize(7 * 24);
    EXPECT_EQ(code_of(short_of_boxes, "collision"), &model::codes::kBadLayerShape);
}

TEST(LayerPicture, SeamMatesShareAColour) {
    const auto image = layer_picture(torus(), "seams").image;
    EXPECT_EQ(image.at(0, 12), image.at(64, 12));
    EXPECT_EQ(image.at(20, 0), image.at(20, 32));
    EXPECT_EQ(image.at(0, 0), image.at(64, 32));
    EXPECT_NE(image.at(20, 0), image.at(20, 16));  // inside: no seam
    EXPECT_NE(image.at(20, 0), image.at(50, 0));
    model::Chart wild = torus();
    const std::uint32_t far = 33 * 65;
    std::memcpy(wild.find("seams")->bytes.data() + 4, &far, 4);
    EXPECT_EQ(code_of(wild, "seams"), &model::codes::kBadSeamTable);
}

TEST(LayerPicture, DiagonalsAndMask) {
    const auto diagonals = layer_picture(torus(), "diagonals").image;
    EXPECT_EQ(diagonals.at(0, 0), sequential_colour(0));
    EXPECT_EQ(diagonals.at(1, 0), sequential_colour(1));
    const model::Chart disc = test::disc_chart(33);
    const auto mask = layer_picture(disc, "mask").image;
    EXPECT_EQ(mask.at(16, 16), (Rgba8{255, 255, 255, 255}));
    EXPECT_EQ(mask.at(0, 0), (Rgba8{0, 0, 0, 255}));
    const auto geometry = layer_picture(disc, "geometry").image;
    EXPECT_EQ(geometry.at(0, 0), kOffSurface);
    EXPECT_NEAR(geometry.at(16, 16).r, 127.5, 0.6);
    EXPECT_EQ(geometry.at(16, 16).b, 128);
}

TEST(LayerPicture, BorderSamplesStandAtTheirUvInTheirPositionsColour) {
    const auto image = layer_picture(test::disc_chart(33), "border_geometry").image;
    // Sample 6: u = 0.92, v = 0.5; position (0.5, 0.92, 0) in the box 0.08..0.92.
    EXPECT_NEAR(image.at(16, 29).r, 127.5, 0.6);
    EXPECT_EQ(image.at(16, 29).g, 255);
    model::Chart broken = test::disc_chart(33);
    const std::uint32_t far = 33 * 33 + 24;
    std::memcpy(broken.find("border_faces")->bytes.data(), &far, 4);
    EXPECT_EQ(code_of(broken, "border_faces"), &model::codes::kBadLayerShape);
}

TEST(LayerPicture, SaysWhatIsWrong) {
    EXPECT_EQ(code_of(torus(), "mask"), &model::codes::kMissingLayer);
    model::Chart chart = torus();
    chart.layers.push_back(test::make_layer<float>("colour_of_dreams", model::ElementType::kF32, {1}, {1}));
    EXPECT_EQ(code_of(chart, "colour_of_dreams"), &model::codes::kUnsupported);
    chart.find("normal")->shape = {65, 33, 2};
    EXPECT_EQ(code_of(chart, "normal"), &model::codes::kBadLayerShape);
    chart.find("cover")->bytes.pop_back();
    EXPECT_EQ(code_of(chart, "cover"), &model::codes::kBadLayerShape);
    chart.find("texture")->shape = {std::uint64_t{1} << 62, 4, 4};
    EXPECT_EQ(code_of(chart, "texture"), &model::codes::kBadLayerShape);
}

TEST(LayerValues, HalfFloats) {
    const auto layer = test::make_layer<std::uint16_t>("bump", model::ElementType::kF16, {6},
                                                       {0x3555, 0x0001, 0xfbff, 0x7c00, 0x7e00, 0x8000});
    EXPECT_EQ(model::element_value(layer, 0), 0.333251953125);
    EXPECT_EQ(model::element_value(layer, 1), 0x1p-24);
    EXPECT_EQ(model::element_value(layer, 2), -65504);
    EXPECT_TRUE(std::isinf(model::element_value(layer, 3)));
    EXPECT_TRUE(std::isnan(model::element_value(layer, 4)));
    EXPECT_TRUE(std::signbit(model::element_value(layer, 5)));
}

}  // namespace
}  // namespace dgm::render
