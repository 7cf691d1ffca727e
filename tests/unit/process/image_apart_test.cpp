// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/image_apart_test.cpp
#include "process/image_apart.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <cstring>
#include <memory>
#include <random>

#include "model/codes.h"
#include "support/faults.h"
#include "test_maps.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

formats::Image stripes() {
    formats::Image out{5, 3, {}};
    for (std::uint8_t k = 0; k < 15; ++k) out.pixels.push_back({k, std::uint8_t(2 * k), std::uint8_t(255 - k), 255});
    return out;
}

TEST(ImageApart, ReadsWhatIsReadHere) {
    const test::TempFolder folder;
    formats::write_png(folder / "a.png", stripes());
    formats::write_png(folder / "h.png", formats::GrayImage16{2, 2, {0, 1, 32768, 65535}});
    const std::vector<std::byte> png = formats::encode_png(stripes());
    const auto bytes = std::make_shared<const std::string>(reinterpret_cast<const char*>(png.data()), png.size());
    const formats::FloatImage heights = formats::read_height({folder / "h.png"});
    const ImageApart images;
    EXPECT_EQ(formats::read_image({folder / "a.png"}), stripes());
    EXPECT_EQ(formats::read_image({"inside a mesh", bytes}), stripes());
    EXPECT_EQ(formats::read_height({folder / "h.png"}), heights);
    EXPECT_EQ(heights.pixels[2], 32768 / 65535.0f);
    EXPECT_EQ(formats::image_bits({folder / "h.png"}), 16u);
    EXPECT_EQ(formats::image_bits({folder / "a.png"}), 8u);
    test::write_bytes(folder / "bad.png", "no picture");
    EXPECT_EQ(test::code_of([&] { (void)formats::read_image({folder / "bad.png"}); }), codes::kImageUnreadable.number);
    EXPECT_EQ(test::code_of([&] { (void)formats::read_image({folder / "none.png"}); }), codes::kFileMissing.number);
    EXPECT_EQ(test::code_of([&] { (void)formats::read_image({folder.path()}); }), codes::kReadFailed.number);
}

TEST(ImageApart, SurvivesMutants) {
    const std::vector<std::byte> png = formats::encode_png(stripes());
    const ImageApart images;
    std::mt19937 random(20);
    int refused = 0;
    for (int mutant = 0; mutant < 100; ++mutant) {
        std::string file(reinterpret_cast<const char*>(png.data()), png.size());
        for (unsigned changes = 1 + random() % 8; changes > 0; --changes)
            file[random() % file.size()] = static_cast<char>(random());
        const int code = test::code_of([&] { (void)formats::read_image({"m", std::make_shared<std::string>(file)}); });
        EXPECT_TRUE(code == 0 || code == codes::kImageUnreadable.number || code == codes::kTooLarge.number) << code;
        refused += code != 0 ? 1 : 0;
    }
    EXPECT_GT(refused, 20);
}

TEST(ImageApart, WhateverTheDecoderDoesIsAnErrorOfThePicture) {
    const test::TempFolder folder;
    test::write_bytes(folder / "a.png", "x");
    for (const auto& [name, fault] : test::faults()) {
        formats::ImageReader decoder = formats::image_reader_here();
        decoder.image = [&](const model::PictureFile&) {
            fault();
            return stripes();
        };
        const ImageApart images(decoder);
        EXPECT_EQ(test::code_of([&] { (void)formats::read_image({folder / "a.png"}); }), codes::kImageUnreadable.number)
            << name;
    }
}

// By somebody, or by a system that is short of memory.
TEST(ImageApart, ADecoderKilledFromOutsideSaysNothingOfThePicture) {
    formats::ImageReader decoder = formats::image_reader_here();
    decoder.bits = [](const model::PictureFile&) -> unsigned {
        raise(SIGKILL);
        return 0;
    };
    const ImageApart images(decoder);
    EXPECT_EQ(test::code_of([&] { (void)formats::image_bits({"a.png"}); }), codes::kWorkerKilled.number);
}

TEST(ImageApart, AShortageOfMemoryIsNoFaultOfThePicture) {
    formats::ImageReader decoder = formats::image_reader_here();
    decoder.bits = [&](const model::PictureFile&) -> unsigned {
        std::vector<std::unique_ptr<char[]>> taken;
        for (;;) taken.push_back(std::unique_ptr<char[]>(new char[std::size_t{1} << 30]));
    };
#if defined(__SANITIZE_ADDRESS__)
    GTEST_SKIP() << "the sanitizer needs unlimited address space";
#endif
    const ImageApart images(decoder);
    EXPECT_THROW((void)formats::image_bits({"a.png"}), std::bad_alloc);
}

TEST(ImageApart, SizesThatDoNotFitAreRefused) {
    formats::ImageReader decoder = formats::image_reader_here();
    formats::Image wrong;
    decoder.image = [&](const model::PictureFile&) { return wrong; };
    for (const auto& [width, height, pixels] :
         {std::tuple(0u, 1u, 0u), std::tuple(2u, 2u, 3u), std::tuple(1u << 15, 1u, 1u << 15)}) {
        wrong = {width, height, std::vector<model::Rgba8>(pixels)};
        const ImageApart images(decoder);
        EXPECT_EQ(test::code_of([&] { (void)formats::read_image({"a.png"}); }), codes::kImageUnreadable.number);
    }
}

}  // namespace
}  // namespace dgm::bake
