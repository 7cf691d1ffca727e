// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/image/image_test.cpp
#include <gtest/gtest.h>

#include "image/image.h"
#include "model/codes.h"
#include "unit/formats/test_maps.h"

namespace {

namespace codes = dgm::model::codes;
using dgm::formats::encode_png;
using dgm::formats::GrayImage16;
using dgm::formats::Image;
using dgm::test::code_of;
using dgm::test::TempFolder;
using dgm::test::write_bytes;

Image random_image(std::uint32_t width, std::uint32_t height) {
    dgm::test::Random random(width);
    Image image{width, height, {}};
    for (std::size_t k = 0; k < std::size_t{width} * height; ++k) {
        const std::uint64_t bits = random.next();
        image.pixels.push_back({static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                                static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)});
    }
    return image;
}

TEST(Png, ColoursComeBackWithAlpha) {
    const TempFolder folder;
    for (const auto& [width, height] : {std::pair{1u, 1u}, {37u, 5u}, {300u, 200u}}) {
        const Image image = random_image(width, height);
        write_png(folder / "a.png", image);
        EXPECT_EQ(dgm::formats::read_image({folder / "a.png"}), image);
    }
}

TEST(Png, SixteenBitHeightsComeBack) {
    const TempFolder folder;
    GrayImage16 image{256, 256, {}};
    for (unsigned k = 0; k < 65536; ++k) image.pixels.push_back(static_cast<std::uint16_t>(k));
    write_png(folder / "a.png", image);
    const auto heights = dgm::formats::read_height({folder / "a.png"});
    ASSERT_EQ(heights.pixels.size(), 65536u);
    for (unsigned k = 0; k < 65536; ++k) ASSERT_EQ(heights.pixels[k], static_cast<float>(k) / 65535.0f);
}

TEST(Png, EightBitHeightsAreUnits) {
    const TempFolder folder;
    Image image{256, 1, {}};
    for (unsigned k = 0; k < 256; ++k) {
        const auto g = static_cast<std::uint8_t>(k);
        image.pixels.push_back({g, g, g, 255});
    }
    write_png(folder / "a.png", image);
    const auto heights = dgm::formats::read_height({folder / "a.png"});
    for (unsigned k = 0; k < 256; ++k) EXPECT_NEAR(heights.at(k, 0), k / 255.0, 1.0 / 255);
    EXPECT_EQ(heights.at(0, 0), 0.0f);
    EXPECT_EQ(heights.at(255, 0), 1.0f);
}

TEST(Png, HasNoTimeOrText) {
    const auto bytes = encode_png(random_image(64, 64));
    EXPECT_EQ(bytes, encode_png(random_image(64, 64)));
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::vector<std::string> chunks;
    for (std::size_t at = 8; at + 8 <= text.size();) {
        const auto byte = [&](std::size_t k) {
            return static_cast<std::size_t>(static_cast<unsigned char>(text[at + k]));
        };
        const std::size_t length = byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3);
        if (chunks.empty() || chunks.back() != text.substr(at + 4, 4)) chunks.push_back(text.substr(at + 4, 4));
        at += 12 + length;
    }
    EXPECT_EQ(chunks, (std::vector<std::string>{"IHDR", "IDAT", "IEND"}));
}

TEST(ImageFiles, BmpAndTgaAreRead) {
    const TempFolder folder;
    // 2 x 1 pixels, 24 bits: red, then green; rows padded to 4 bytes, blue first.
    std::string bmp("BM\x3E\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x02\0\0\0\x01\0\0\0\x01\0\x18\0", 30);
    bmp += std::string(24, '\0') + std::string("\0\0\xFF\0\xFF\0\0\0", 8);
    write_bytes(folder / "a.bmp", bmp);
    const Image from_bmp = dgm::formats::read_image({folder / "a.bmp"});
    ASSERT_EQ(from_bmp.width, 2u);
    EXPECT_EQ(from_bmp.at(0, 0), (dgm::model::Rgba8{255, 0, 0, 255}));
    EXPECT_EQ(from_bmp.at(1, 0), (dgm::model::Rgba8{0, 255, 0, 255}));
    // TGA, uncompressed, 1 x 2, origin at the lower left: the first row stored is the lower one.
    write_bytes(folder / "a.tga",
                std::string("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\2\0\x18\0", 18) + std::string("\xFF\0\0\0\0\xFF", 6));
    const Image from_tga = dgm::formats::read_image({folder / "a.tga"});
    ASSERT_EQ(from_tga.height, 2u);
    EXPECT_EQ(from_tga.at(0, 0), (dgm::model::Rgba8{255, 0, 0, 255}));
    EXPECT_EQ(from_tga.at(0, 1), (dgm::model::Rgba8{0, 0, 255, 255}));
}

/// The header and one row of nothing of a GIF whose sides are 256 `side_high`.
std::string empty_gif(std::uint8_t side_high) {
    std::string gif("GIF89a\0\0\0\0\x80\0\0\0\0\0\xFF\xFF\xFF,\0\0\0\0\0\0\0\0\0\2\1\x44\0;", 34);
    for (const std::size_t at : {7u, 9u, 25u, 27u}) gif[at] = static_cast<char>(side_high);
    return gif;
}

TEST(ImageFiles, FewBytesPromiseNoPictureOfGigabytes) {
    const TempFolder folder;
    write_bytes(folder / "a.gif", empty_gif(1));  // 256 x 256
    EXPECT_EQ(dgm::formats::read_image({folder / "a.gif"}).pixels.size(), 65536u);
    write_bytes(folder / "a.gif", empty_gif(0x3C));  // 15360 x 15360, 0.9 GB decoded
    EXPECT_EQ(code_of([&] { (void)dgm::formats::read_image({folder / "a.gif"}); }), codes::kImageUnreadable.number);
    // A real picture of one colour.
    const Image flat{1024, 1024, std::vector<dgm::model::Rgba8>(1024 * 1024)};
    write_png(folder / "a.png", flat);
    EXPECT_EQ(dgm::formats::read_image({folder / "a.png"}).width, 1024u);
}

TEST(ImageFiles, BadOnesHaveTheirCodes) {
    const TempFolder folder;
    const auto read = [&](const std::string& bytes) {
        write_bytes(folder / "bad", bytes);
        return code_of([&] { (void)dgm::formats::read_image({folder / "bad"}); });
    };
    EXPECT_EQ(code_of([&] { (void)dgm::formats::read_image({folder / "none"}); }), codes::kFileMissing.number);
    EXPECT_EQ(code_of([&] { (void)dgm::formats::read_image({folder.path()}); }), codes::kReadFailed.number);
    EXPECT_EQ(read(""), codes::kImageUnreadable.number);
    EXPECT_EQ(read("no picture at all"), codes::kImageUnreadable.number);
    for (const char* head : {"P5 2 1 65535\n", "P6 2 1 65535\n"})  // of 16 bits
        EXPECT_EQ(read(head + std::string(12, '\x40')), codes::kImageUnreadable.number);
    EXPECT_EQ(read("P5 2 1 255\n@@"), 0);
    EXPECT_EQ(read("P5 # long\n2 000000001 255\n@@"), 0);
    EXPECT_EQ(read("P6 2 # long\n2222222222222222 255\n@@"), codes::kImageUnreadable.number);  // more than an int
    const auto bytes = encode_png(random_image(50, 50));
    const std::string png(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_EQ(read(png.substr(0, 500)), codes::kImageUnreadable.number);
    std::string huge = png;
    huge.replace(16, 8, std::string("\0\0\x40\x01\0\0\x40\x01", 8));  // 16385 x 16385
    EXPECT_NE(read(huge), 0);
    EXPECT_EQ(code_of([&] { (void)encode_png(Image{}); }), codes::kTooLarge.number);
    EXPECT_EQ(code_of([&] { (void)encode_png(Image{2, 2, {}}); }), codes::kInternal.number);
    EXPECT_EQ(code_of([&] { write_png(folder / "none/a.png", random_image(2, 2)); }), codes::kWriteFailed.number);
    EXPECT_EQ(code_of([&] { write_png(folder.path(), random_image(2, 2)); }), codes::kWriteFailed.number);
    EXPECT_TRUE(std::filesystem::is_directory(folder.path()));
}

}  // namespace
