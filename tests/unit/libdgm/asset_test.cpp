// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/asset_test.cpp
// An opened asset hands out the bytes that were written.
#include <gtest/gtest.h>

#include <dgm/asset.h>

#include <cstdio>
#include <fstream>
#include <numeric>

#include "opened.h"
#include "platform.h"

namespace dgm::test {
namespace {

template <class T>
std::vector<T> count_up(std::size_t count, T first = T(0)) {
    std::vector<T> values(count);
    for (std::size_t k = 0; k < count; ++k) values[k] = static_cast<T>(first + static_cast<T>(k % 100));
    return values;
}

/// A chart with every layer of docs/design.md section 4, 17 x 26 samples: 2 x 4 leaf tiles, then 1 x 2, then 1 node.
ChartSpec full_chart() {
    ChartSpec c = free_chart(17, 26, sheet);
    c.add("normal", ElementType::kI16, {17, 26, 2}, count_up<std::int16_t>(17 * 26 * 2, -50));
    c.add("texture", ElementType::kU8, {5, 7, 4}, count_up<std::uint8_t>(140));
    c.add("bump", ElementType::kF16, {3, 9}, count_up<std::uint16_t>(27));
    c.add("collision", ElementType::kF32, {2 * 4 + 1 * 2 + 1, 6}, count_up<float>(66, 0.5f));
    c.add("cover", ElementType::kF32, {17, 26}, count_up<float>(17 * 26));
    c.add("deformation", ElementType::kF32, {17, 26, 4}, count_up<float>(17 * 26 * 4));
    c.add("contact", ElementType::kF32, {17, 26, 2}, count_up<float>(17 * 26 * 2));
    c.add("diagonals", ElementType::kU8, {16, 25}, std::vector<std::uint8_t>(400, 1));
    c.add("border_normal", ElementType::kI16, {c.border_samples, 2}, count_up<std::int16_t>(c.border_samples * 2));
    c.add("seams", ElementType::kU32, {0, 2}, std::vector<std::uint32_t>{});
    c.add("sparkle", ElementType::kF32, {3, 2, 1, 2}, count_up<float>(12));  // unknown, optional
    return c;
}

TEST(Asset, RoundTripOfEveryLayer) {
    ChartSpec a = full_chart(), b = grid_chart(2, 3, sheet);
    a.offset = {1e7, -2, 3};
    b.method = "fifteen-letters";
    const Opened opened(build({a, b}));
    ASSERT_TRUE(opened.asset.verify().ok());
    ASSERT_EQ(opened.asset.chart_count(), 2u);
    const std::vector<ChartSpec> charts{a, b};
    for (std::uint32_t k = 0; k < 2; ++k) {
        const Chart chart = opened.chart(k);
        EXPECT_EQ(chart.rows(), charts[k].rows);
        EXPECT_EQ(chart.cols(), charts[k].cols);
        EXPECT_EQ(chart.domain(), charts[k].domain);
        EXPECT_EQ(chart.border_samples(), charts[k].border_samples);
        EXPECT_EQ(chart.sample_count(), charts[k].rows * charts[k].cols + charts[k].border_samples);
        EXPECT_EQ(chart.offset()[0], charts[k].offset[0]);
        EXPECT_EQ(chart.bbox()[3], 1.0);
        EXPECT_EQ(chart.method(), charts[k].method);
        ASSERT_EQ(chart.layer_count(), charts[k].layers.size());
        for (std::uint32_t l = 0; l < chart.layer_count(); ++l) {
            const LayerSpec& want = charts[k].layers[l];
            const LayerView got = chart.layer(l).value();
            EXPECT_EQ(got.name, want.name);
            EXPECT_EQ(got.type, want.type);
            ASSERT_EQ(got.rank, want.shape.size());
            for (std::size_t d = 0; d < want.shape.size(); ++d) EXPECT_EQ(got.shape[d], want.shape[d]);
            ASSERT_EQ(got.bytes, want.bytes.size());
            EXPECT_TRUE(std::equal(got.data, got.data + got.bytes, want.bytes.data())) << want.name;
            EXPECT_EQ(got.known, want.name != "sparkle");
            EXPECT_EQ(chart.find(want.name.c_str()).value().data, got.data);
        }
        EXPECT_EQ(chart.layer(chart.layer_count()).error().code, ErrorCode::BadArgument);
        EXPECT_EQ(chart.find("nothing").error().code, ErrorCode::MissingLayer);
    }
    EXPECT_EQ(opened.asset.chart(2).error().code, ErrorCode::BadArgument);
}

TEST(Asset, TypedViewsAreZeroCopyAndTyped) {
    const Opened opened(build({full_chart()}));
    const LayerView geometry = opened.chart().find("geometry").value();
    const auto floats = geometry.as<float>().value();
    EXPECT_EQ(floats.size(), 17u * 26 * 3);
    EXPECT_EQ(static_cast<const void*>(floats.data()), opened.bytes.data() + geometry.file_offset);
    EXPECT_EQ(floats[3 * 26], 1.0f);  // sample (1, 0) of the sheet
    EXPECT_EQ(geometry.as<std::uint16_t>().error().code, ErrorCode::BadLayer);
    EXPECT_TRUE(opened.chart().find("bump").value().as<std::uint16_t>().ok());
    EXPECT_TRUE(opened.chart().find("seams").value().as<std::uint32_t>().value().empty());
}

TEST(Asset, RecordsBehindTheUserBlock) {
    const std::vector<ChartSpec> charts(30, grid_chart(3, 4, sheet));
    Image image = build(charts);
    ASSERT_GE(image.header.index_offset, layout::kUserBlockBytes);
    const Opened opened(std::move(image));
    EXPECT_EQ(opened.asset.chart_count(), 30u);
    EXPECT_EQ(opened.chart(29).find("geometry").value().as<float>().value()[3], 0.0f);
    EXPECT_TRUE(opened.asset.verify().ok());
}

#if DGM_TEST_FILES
TEST(Asset, FromAFile) {
    const std::string path = testing::TempDir() + "dgm_asset_test.dgm";
    const Image image = build({full_chart()});
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(image.bytes.data()), std::streamsize(image.bytes.size()));
    {
        auto asset = Asset::open(path.c_str());
        ASSERT_TRUE(asset.ok()) << asset.error().message;
        Asset moved = std::move(asset).value();
        EXPECT_TRUE(moved.verify().ok());
        EXPECT_EQ(moved.chart(0).value().rows(), 17u);
    }
    OpenOptions options;
    options.max_file_bytes = image.bytes.size() - 1;
    EXPECT_EQ(Asset::open(path.c_str(), options).error().code, ErrorCode::LimitExceeded);
    std::ofstream(path, std::ios::trunc).close();
    EXPECT_EQ(Asset::open(path.c_str()).error().code, ErrorCode::Truncated);
    std::remove(path.c_str());
    EXPECT_EQ(Asset::open(path.c_str()).error().code, ErrorCode::FileMissing);
    EXPECT_EQ(Asset::open(testing::TempDir().c_str()).error().code, ErrorCode::ReadFailed);
    EXPECT_EQ(Asset::open(nullptr).error().code, ErrorCode::BadArgument);
}
#else
TEST(Asset, FilesAreNotMapped) {
    const Error e = Asset::open("dgm_asset_test.dgm").error();
    EXPECT_EQ(e.code, ErrorCode::Unsupported);
    EXPECT_NE(std::string(e.message).find("open_memory"), std::string::npos) << "what to do instead";
    EXPECT_EQ(Asset::open(nullptr).error().code, ErrorCode::BadArgument);
}
#endif

TEST(Asset, Wishes) {
    Image image = build({full_chart(), grid_chart(4, 4, sheet)});
    const char* const has[] = {"geometry"};
    const char* const lacks[] = {"geometry", "cover"};
    OpenOptions options;
    options.required_layers = has;
    EXPECT_TRUE(Asset::open_memory(image.bytes, options).ok());
    options.required_layers = lacks;
    const Error e = Asset::open_memory(image.bytes, options).error();
    EXPECT_EQ(e.code, ErrorCode::MissingLayer);
    EXPECT_EQ(e.byte_offset, sizeof(layout::FileHeader) + sizeof(layout::ChartRecord));
    options = {};
    options.max_samples = 441;
    EXPECT_EQ(Asset::open_memory(image.bytes, options).error().code, ErrorCode::LimitExceeded);
    options = {};
    options.max_layers = 3;
    EXPECT_EQ(Asset::open_memory(image.bytes, options).error().code, ErrorCode::LimitExceeded);
    options = {};
    options.max_charts = 1;
    EXPECT_EQ(Asset::open_memory(image.bytes, options).error().code, ErrorCode::LimitExceeded);
    // One bit of a layer: open sees it only when asked to hash.
    image.bytes[image.layers[0].offset + 5] ^= std::byte{8};
    EXPECT_TRUE(Asset::open_memory(image.bytes).ok());
    options = {};
    options.verify_hashes = true;
    const Error damaged = Asset::open_memory(image.bytes, options).error();
    EXPECT_EQ(damaged.code, ErrorCode::HashMismatch);
    EXPECT_EQ(damaged.byte_offset, image.layers[0].offset);
    EXPECT_EQ(Asset::open_memory(std::span(image.bytes).subspan(1)).error().code, ErrorCode::BadArgument);
}

}  // namespace
}  // namespace dgm::test
