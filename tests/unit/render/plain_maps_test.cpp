// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/plain_maps_test.cpp
#include "export/plain_maps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "export/resample_plane.h"
#include "model/codes.h"
#include "sample_chart.h"

namespace dgm::exporter {
namespace {
namespace fs = std::filesystem;

Plane ramp(std::uint32_t width, std::uint32_t height) {
    Plane out{width, height, 2, {}};
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            out.values.insert(out.values.end(), {double{1.0} * x / (width - 1), double{1.0} * y / (height - 1)});
    return out;
}

TEST(ResampledPlane, ARampStaysARampWhereItGrows) {
    const Plane out = resampled(ramp(5, 9), {}, 16, 32);
    const Plane expected = ramp(16, 32);
    ASSERT_EQ(out.values.size(), expected.values.size());
    for (std::size_t k = 0; k < out.values.size(); ++k) EXPECT_NEAR(out.values[k], expected.values[k], 1e-14) << k;
}

TEST(ResampledPlane, TheSameSizeIsTheSamePlane) {
    const Plane plane = ramp(5, 9);
    EXPECT_EQ(resampled(plane, {}, 5, 9).values, plane.values);
}

TEST(ResampledPlane, ShrinkingAveragesWhatIsBetween) {
    // A checkerboard of single pixels; one pixel of 17 in 33 reads three, the middle one half.
    Plane board{33, 33, 1, {}};
    for (std::uint32_t k = 0; k < 33 * 33; ++k) board.values.push_back((k / 33 + k % 33) % 2);
    for (const double value : resampled(board, {}, 17, 17).values) EXPECT_NEAR(value, 0.5, 0.06);
    EXPECT_NEAR(resampled(board, {}, 17, 17).values[8 * 17 + 8], 0.5, 1e-14);
}

TEST(ResampledPlane, PixelsWithoutWeightDoNotCount) {
    Plane plane = ramp(5, 5);
    Plane weights{5, 5, 1, std::vector<double>(25, 1.0)};
    for (std::size_t k = 0; k < 25; ++k)
        if (k % 5 >= 3) {
            weights.values[k] = 0;
            plane.values[2 * k] = NAN;
        }
    const Plane out = resampled(plane, weights, 9, 9);
    for (std::size_t k = 0; k < 81; ++k) {
        const double x = static_cast<double>(k % 9) / 8;
        EXPECT_NEAR(out.values[2 * k], k % 9 <= 4 ? x : k % 9 == 5 ? 0.5 : 0, 1e-14) << k;
    }
}

class PlainMaps : public testing::Test {
 protected:
    void SetUp() override {
        folder_ = fs::path(testing::TempDir()) /
                  (std::string("dgm_maps_") + testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    [[nodiscard]] std::set<std::string> names() const {
        std::set<std::string> out;
        for (const auto& entry : fs::directory_iterator(folder_)) out.insert(entry.path().filename());
        return out;
    }
    [[nodiscard]] std::string bytes(const std::string& name) const {
        std::ifstream file(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    fs::path folder_;
};

TEST_F(PlainMaps, SeveralChartsAreNumberedAndTheSameTwice) {
    model::MapSet maps;
    maps.charts = {test::torus_chart(9, 17), test::torus_chart(9, 9)};
    export_plain_maps(maps, folder_, "a", {});
    const std::set<std::string> first = names();
    EXPECT_TRUE(first.contains("a_maps.json"));
    EXPECT_TRUE(first.contains("a_chart0_position.exr"));
    EXPECT_TRUE(first.contains("a_chart1_position.exr"));
    EXPECT_TRUE(first.contains("a_chart1_texture_full.png"));
    const std::string position = bytes("a_chart0_position.exr"), json = bytes("a_maps.json");
    export_plain_maps(maps, folder_, "a", {});
    EXPECT_EQ(names(), first);
    EXPECT_EQ(bytes("a_chart0_position.exr"), position);
    EXPECT_EQ(bytes("a_maps.json"), json);
    EXPECT_EQ(position.find("capDate"), std::string::npos);
}

TEST_F(PlainMaps, AFailureLeavesNothing) {
    model::MapSet maps;
    maps.charts = {test::torus_chart(9, 17)};
    maps.charts[0].find("normal")->shape = {17, 9, 2};
    try {
        export_plain_maps(maps, folder_, "a", {});
        FAIL() << "it was written";
    } catch (const model::Error& error) { EXPECT_EQ(error.code().number, model::codes::kBadLayerShape.number); }
    EXPECT_EQ(names(), std::set<std::string>{});
}

}  // namespace
}  // namespace dgm::exporter
