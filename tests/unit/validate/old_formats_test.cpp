// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/old_formats_test.cpp
// Files of every format version that was released load for ever: tests/fixtures.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <dgm/asset.h>
#include <dgm/reconstruct.h>
#include <dgm/state.h>
#include <dgm/validate.h>

#include "dgm/dgm_reader.h"
#include "dgm/hash.h"
#include "exr/exr_reader.h"
#include "model/codes.h"
#include "validate/validation.h"

namespace dgm::validate {
namespace {
namespace fs = std::filesystem;

const fs::path kFixtures = DGM_FIXTURES;

TEST(OldFormats, TheFilesAreTheOnesThatWereReleased) {
    EXPECT_EQ(formats::to_hex(formats::hash_file(kFixtures / "format_v1.dgm")), "30304d8e1907043fb7b7412a391d76dd");
    EXPECT_EQ(formats::to_hex(formats::hash_file(kFixtures / "format_v1.exr")), "65e7253b1210a1e3d0c4454cf444c353");
}

TEST(OldFormats, Version1IsValidAgainstItsSource) {
    const Source source = load_source(kFixtures / "format_v1.obj");
    Options options;
    options.source = &source;
    options.sampling.samples = 20'000;
    for (const char* name : {"format_v1.dgm", "format_v1_exr2.exr"}) {
        const FileValidation validation = validate_file(kFixtures / name, options);
        for (const formats::Finding& f : validation.findings)
            ADD_FAILURE() << name << ": " << f.code->id() << " " << f.place << ": " << f.message;
        EXPECT_EQ(validation.charts, 2u);
    }
}

TEST(OldFormats, Version1HoldsWhatItHeld) {
    const model::MapSet maps = formats::read_dgm(kFixtures / "format_v1.dgm");
    EXPECT_EQ(maps.format_version, 1u);
    EXPECT_EQ(maps.source_name, "format_v1.obj");
    EXPECT_EQ(maps.source_hash, formats::hash_file(kFixtures / "format_v1.obj"));
    ASSERT_EQ(maps.charts.size(), 2u);
    EXPECT_EQ(maps.charts[0].domain, model::Domain::kSquare);
    EXPECT_EQ(maps.charts[1].domain, model::Domain::kFree);
    EXPECT_EQ(maps.charts[0].method, "stretch");
    EXPECT_EQ(maps.charts[1].method, "uv");
    std::vector<std::string> names;
    for (const model::Chart& chart : maps.charts)
        for (const model::Layer& layer : chart.layers) names.push_back(layer.name);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    EXPECT_EQ(names, (std::vector<std::string>{"border_faces", "border_geometry", "border_normal", "border_uv", "bump",
                                               "collision", "contact", "cover", "deformation", "diagonals", "geometry",
                                               "mask", "normal", "seams", "texture"}));
    EXPECT_TRUE(formats::read_exr(kFixtures / "format_v1_exr2.exr") == maps) << "the EXR is the same to the bit";
}

TEST(OldFormats, ExrLayout1IsRefusedByName) {
    try {
        (void)formats::read_exr(kFixtures / "format_v1.exr");
        FAIL() << "it was read";
    } catch (const model::Error& error) {
        EXPECT_EQ(error.code().number, model::codes::kExrUnreadable.number);
        EXPECT_NE(std::string(error.what()).find("EXR layout 1"), std::string::npos) << error.what();
    }
}

TEST(OldFormats, TheRuntimeOpensVersion1) {
    OpenOptions options;
    options.verify_hashes = true;
    const auto asset = Asset::open((kFixtures / "format_v1.dgm").c_str(), options);
    ASSERT_TRUE(asset) << asset.error().message;
    ASSERT_EQ(asset.value().chart_count(), 2u);
    for (std::uint32_t k = 0; k < 2; ++k) {
        const Chart chart = asset.value().chart(k).value();
        const auto valid = validate_chart(chart);
        EXPECT_TRUE(valid) << valid.error().message;
        auto state = State::create(chart);
        ASSERT_TRUE(state) << state.error().message;
        const auto counts = mesh_counts(state.value());
        ASSERT_TRUE(counts);
        EXPECT_GT(counts.value().indices, 0u);
    }
}

}  // namespace
}  // namespace dgm::validate
