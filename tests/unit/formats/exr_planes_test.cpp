// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/exr_planes_test.cpp
#include "exr/exr_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include "exr/exr_files.h"
#include "exr/exr_image.h"
#include "exr/exr_writer.h"
#include "model/codes.h"
#include "model/element.h"
#include "test_maps.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
using test::code_of;
using test::TempFolder;
using Meaning = ExrPlane::Meaning;

double expected(const model::Layer& layer, std::size_t element, Meaning meaning) {
    if (meaning == Meaning::kLow16) return model::element<std::uint32_t>(layer, element) & 0xFFFFu;
    if (meaning == Meaning::kHigh16) return model::element<std::uint32_t>(layer, element) >> 16;
    return model::element_value(layer, element);
}

void expect_planes_of(const model::MapSet& maps, const std::vector<ExrPlane>& planes) {
    for (const ExrPlane& plane : planes) {
        const model::Layer& layer = maps.charts[plane.chart].layers[plane.layer];
        const std::size_t elements = layer.bytes.size() / layout::element_size(layer.type);
        ASSERT_EQ(elements % plane.values.size(), 0u) << layer.name;
        const std::size_t numbers = elements / plane.values.size();
        for (std::size_t k = 0; k < plane.values.size(); ++k) {
            const double is = static_cast<double>(plane.values[k]),
                         wanted = expected(layer, k * numbers + plane.component, plane.meaning);
            ASSERT_TRUE(is == wanted || (std::isnan(is) && std::isnan(wanted))) << layer.name << ' ' << k;
        }
    }
}

TEST(ExrPlanes, AreTheNumbersOfTheLayersInEitherLayout) {
    const TempFolder folder;
    for (const ExrLayout layout : {ExrLayout::kAuto, ExrLayout::kMultipart})
        for (const std::size_t charts : {1u, 2u, 5u}) {
            const model::MapSet maps = test::random_maps(charts + 7, charts);
            write_exr(maps, folder / "a.exr", {layout});
            const std::vector<ExrPlane> planes = read_exr_planes(folder / "a.exr", maps.charts);
            expect_planes_of(maps, planes);
            std::set<std::pair<std::size_t, std::string>> seen;
            for (const ExrPlane& plane : planes)
                seen.emplace(plane.chart, maps.charts[plane.chart].layers[plane.layer].name);
            for (std::size_t c = 0; c < charts; ++c)
                for (const char* name :
                     {"geometry", "normal", "texture", "bump", "deformation", "contact", "diagonals"})
                    EXPECT_TRUE(seen.contains({c, name})) << c << ' ' << name;
        }
}

TEST(ExrPlanes, AFileOfLayersWillDoAndAMissingOneIsNoEdit) {
    const TempFolder folder;
    test::Random random(3);
    model::MapSet maps;
    maps.charts.push_back(test::random_chart(random, {}));
    write_exr(maps, folder / "a.exr");
    const auto names = [&](const char* file) {
        std::set<std::string> out;
        for (const ExrPlane& plane : read_exr_planes(folder / file, maps.charts)) {
            out.insert(maps.charts[0].layers[plane.layer].name);
            EXPECT_EQ(plane.file.extension(), ".exr");
        }
        return out;
    };
    EXPECT_EQ(names("a.texture.exr"), std::set<std::string>{"texture"});
    EXPECT_TRUE(names("a.exr").contains("texture"));
    std::filesystem::remove(folder / "a.texture.exr");
    EXPECT_FALSE(names("a.exr").contains("texture"));
    EXPECT_TRUE(names("a.exr").contains("bump"));
}

TEST(ExrPlanes, APictureOfAnotherSizeOrOfNothingOfTheMapIsRefused) {
    const TempFolder folder;
    test::Random random(3);
    model::MapSet maps;
    maps.charts.push_back(test::random_chart(random, {.rows = 17, .cols = 13}));
    write_exr_image(folder / "small.exr", 3, 3, "RGB", std::vector<float>(27));
    EXPECT_EQ(code_of([&] { (void)read_exr_planes(folder / "small.exr", maps.charts); }), codes::kEditUnrelated.number);
    write_exr_image(folder / "other.exr", 13, 17, "Q", std::vector<float>(13 * 17));
    EXPECT_EQ(code_of([&] { (void)read_exr_planes(folder / "other.exr", maps.charts); }), codes::kEditUnrelated.number);
    test::write_bytes(folder / "text.exr", "no picture");
    EXPECT_EQ(code_of([&] { (void)read_exr_planes(folder / "text.exr", maps.charts); }), codes::kExrUnreadable.number);
    EXPECT_EQ(code_of([&] { (void)read_exr_planes(folder / "no.exr", maps.charts); }), codes::kFileMissing.number);
}

TEST(ExrPicture, HasItsChannelsInOrder) {
    const TempFolder folder;
    const std::vector<float> pixels{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    write_exr_image(folder / "a.exr", 3, 1, "RGBA", pixels);
    const ExrPicture four = read_exr_picture(folder / "a.exr");
    EXPECT_EQ(four.channels, 4u);
    EXPECT_EQ(four.pixels, pixels);
    write_exr_image(folder / "b.exr", 12, 1, "Y", pixels);
    const ExrPicture one = read_exr_picture(folder / "b.exr");
    EXPECT_EQ(one.channels, 1u);
    EXPECT_EQ(one.width, 12u);
    EXPECT_EQ(one.pixels, pixels);
    EXPECT_FALSE(one.is_half);
    write_exr_image(folder / "c.exr", 6, 1, "QZ", pixels);
    EXPECT_EQ(code_of([&] { (void)read_exr_picture(folder / "c.exr"); }), codes::kExrUnreadable.number);
    EXPECT_FALSE(has_exr_description(folder / "a.exr"));
    EXPECT_FALSE(has_exr_description(folder / "no.exr"));
}

}  // namespace
}  // namespace dgm::formats
