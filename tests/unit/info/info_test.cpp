// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/info/info_test.cpp
#include "info/file_info.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "model/codes.h"
#include "model/layer_names.h"
#include "unit/render/sample_chart.h"

namespace dgm::info {
namespace {

class Info : public testing::Test {
 protected:
    void SetUp() override {
        file_ = std::filesystem::path(testing::TempDir()) /
                (std::string("dgm_info_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".dgm");
        maps_.generator = "dgm-bake 9.9";
        maps_.source_name = "tor\xffus.obj";  // not UTF-8, as some file systems have it
        maps_.source_hash[0] = 0xab;
        maps_.report_json = R"({"charts":[{"error":{"psnr":81.25,"rms_percent":0.0087},"seam_gap":0}]})";
        maps_.charts = {test::torus_chart(17, 33), test::disc_chart(9)};
        formats::write_dgm(maps_, file_);
    }
    void TearDown() override { std::filesystem::remove(file_); }
    std::filesystem::path file_;
    model::MapSet maps_;
};

TEST_F(Info, OffsetsAndHashesAreThoseOfTheLayersBytes) {
    const FileInfo info = read_file_info(file_);
    std::ifstream stream(file_, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_EQ(info.bytes, bytes.size());
    ASSERT_EQ(info.charts.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
        ASSERT_EQ(info.charts[k].layers.size(), maps_.charts[k].layers.size());
        for (const LayerInfo& layer : info.charts[k].layers) {
            const model::Layer* stored = maps_.charts[k].find(layer.name);
            ASSERT_NE(stored, nullptr) << layer.name;
            ASSERT_EQ(layer.bytes, stored->bytes.size());
            ASSERT_LE(layer.offset + layer.bytes, bytes.size());
            EXPECT_EQ(std::memcmp(bytes.data() + layer.offset, stored->bytes.data(), layer.bytes), 0) << layer.name;
            EXPECT_EQ(layer.hash, formats::hash_bytes(stored->bytes)) << layer.name;
            EXPECT_EQ(layer.shape, stored->shape);
        }
    }
    EXPECT_EQ(info.charts[1].domain, model::Domain::kFree);
}

TEST_F(Info, JsonHasEverythingAndTextTheMeasuredErrors) {
    const FileInfo info = read_file_info(file_);
    const auto json = nlohmann::json::parse(to_json(std::span(&info, 1)));
    const auto& file = json.at("files").at(0);
    EXPECT_EQ(file.at("generator"), "dgm-bake 9.9");
    EXPECT_EQ(file.at("source_hash").get<std::string>().substr(0, 4), "ab00");
    EXPECT_EQ(file.at("charts").at(0).at("rows"), 17);
    EXPECT_EQ(file.at("charts").at(1).at("domain"), "free");
    EXPECT_EQ(file.at("charts").at(0).at("layers").at(0).at("name"), "geometry");
    EXPECT_EQ(file.at("charts").at(0).at("layers").at(0).at("shape"), (std::vector<int>{17, 33, 3}));
    EXPECT_EQ(file.at("report").at("charts").at(0).at("error").at("psnr"), 81.25);
    const std::string text = to_text(info);
    EXPECT_NE(text.find("PSNR 81.25 dB, rms 0.0087 %, seam gap 0"), std::string::npos) << text;
    EXPECT_NE(text.find("chart 1: 9 x 9, free"), std::string::npos) << text;
    EXPECT_EQ(to_json(std::span(&info, 1)), to_json(std::span(&info, 1)));
}

TEST_F(Info, MapsThatTheValidatorRefusesAreToldWithTheirFault) {
    maps_.charts = {test::surface_alone(test::torus_chart(17, 33))};
    maps_.report_json.clear();
    formats::write_dgm(maps_, file_);
    EXPECT_FALSE(read_file_info(file_).fault);
    for (model::Layer& layer : maps_.charts[0].layers)
        if (layer.name == model::layers::kGeometry) {
            const float far = -1e30f;
            std::memcpy(layer.bytes.data(), &far, sizeof far);
        }
    formats::write_dgm(maps_, file_);  // with hashes that fit
    const FileInfo info = read_file_info(file_);
    EXPECT_EQ(info.charts.size(), 1u);
    ASSERT_TRUE(info.fault);
    EXPECT_EQ(info.fault->code().id(), "DGM2007");
    EXPECT_EQ(info.fault->place(), "/charts/0/geometry[0][0][0]");
}

TEST_F(Info, DamagedFilesAreRefusedWithACode) {
    const auto code = [&] {
        try {
            static_cast<void>(read_file_info(file_));
        } catch (const model::Error& error) { return &error.code(); }
        return static_cast<const model::Code*>(nullptr);
    };
    const LayerInfo geometry = read_file_info(file_).charts[0].layers[0];
    {
        std::fstream stream(file_, std::ios::binary | std::ios::in | std::ios::out);
        stream.seekg(static_cast<std::streamoff>(geometry.offset + 40));
        const char flipped = static_cast<char>(stream.get() ^ 4);
        stream.seekp(static_cast<std::streamoff>(geometry.offset + 40));
        stream.put(flipped);
    }
    EXPECT_EQ(code(), &model::codes::kHashMismatch);
    std::filesystem::resize_file(file_, 3000);
    EXPECT_NE(code(), nullptr);
    std::filesystem::remove(file_);
    EXPECT_EQ(code(), &model::codes::kFileMissing);
}

}  // namespace
}  // namespace dgm::info
