// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/edit/edit_map_test.cpp
// Whole edits through files, without the command line.
#include "edit/edit_map.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "dgm/dgm_reader.h"
#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "export/plain_maps.h"
#include "exr/exr_writer.h"
#include "image/image.h"
#include "model/codes.h"
#include "model/element.h"
#include "test_maps.h"
#include "unit/validate/validation_maps.h"

namespace dgm::edit {
namespace {

namespace codes = model::codes;
using model::Layer;
using test::code_of;
using test::read_bytes;

constexpr std::uint32_t m = test::kTubeRows, n = test::kTubeCols;

class EditMap : public testing::Test {
 protected:
    void SetUp() override { formats::write_dgm(maps_, map_); }
    [[nodiscard]] EditOptions from(const std::filesystem::path& source) const {
        EditOptions out;
        out.map = map_;
        out.source = source;
        return out;
    }
    static Layer& layer(model::MapSet& maps, const char* name) { return *maps.charts[0].find(name); }
    /// Bytes of the file's layer, changed where it lies, as h5py does.
    template <class T>
    void overwrite(const char* name, std::size_t index, T value) {
        const model::MapSet now = formats::read_dgm(map_);
        std::string bytes = read_bytes(map_);
        const Layer& of = *now.charts[0].find(name);
        const std::string block(reinterpret_cast<const char*>(of.bytes.data()), of.bytes.size());
        const std::size_t at = bytes.find(block);
        ASSERT_NE(at, std::string::npos);
        ASSERT_EQ(bytes.find(block, at + 1), std::string::npos);
        std::memcpy(bytes.data() + at + index * sizeof(T), &value, sizeof(T));
        test::write_bytes(map_, bytes);
    }

    test::TempFolder folder_;
    model::MapSet maps_ = test::good_maps();
    std::filesystem::path map_ = folder_ / "tube.dgm";
};

TEST_F(EditMap, AnEditWithoutPaintLeavesTheFile) {
    formats::write_exr(maps_, folder_ / "tube.exr");
    exporter::export_plain_maps(maps_, folder_ / "maps", "tube", {});
    formats::write_dgm(maps_, folder_ / "copy.dgm");
    const std::string before = read_bytes(map_);
    for (const char* source :
         {"tube.exr", "maps", "maps/tube_maps.json", "maps/tube_chart0_stiffness.exr", "copy.dgm"}) {
        const EditOutcome outcome = edit_map(from(folder_ / source));
        EXPECT_FALSE(outcome.is_changed) << source;
        EXPECT_FALSE(outcome.is_written) << source;
        EXPECT_NE(outcome.lines.find("stiffness    unchanged"), std::string::npos) << outcome.lines;
        EXPECT_EQ(read_bytes(map_), before) << source;
        EditOptions aside = from(folder_ / source);
        aside.output = folder_ / "new.dgm";
        EXPECT_TRUE(edit_map(aside).is_written);
        EXPECT_EQ(read_bytes(folder_ / "new.dgm"), before) << source;
    }
}

TEST_F(EditMap, AnExrBringsItsPaintAndTheReportSaysSo) {
    model::MapSet painted = maps_;
    test::poke(layer(painted, "deformation"), 4 * (5 * n + 4) + 3, 0.25f);
    test::poke(layer(painted, "bump"), 1, std::uint16_t{0x4000});
    formats::write_exr(painted, folder_ / "painted.exr");
    const EditOutcome outcome = edit_map(from(folder_ / "painted.exr"));
    EXPECT_TRUE(outcome.is_written);
    const model::MapSet now = formats::read_dgm(map_);
    EXPECT_EQ(now.charts, painted.charts);
    const auto report = nlohmann::json::parse(now.report_json);
    ASSERT_EQ(report["edits"].size(), 2u);
    EXPECT_EQ(report["edits"][0]["layer"], "bump");
    EXPECT_EQ(report["edits"][0]["source"], "painted.chart0.bump.exr");
    EXPECT_EQ(report["edits"][1]["layer"], "stiffness");
    EXPECT_EQ(report["edits"][1]["samples"], 1);
    EXPECT_EQ(report["edits"][1]["source"], "painted.exr");
    EXPECT_EQ(report["edits"][1]["source_hash"], formats::to_hex(formats::hash_file(folder_ / "painted.exr")));
    EXPECT_EQ(report["charts"], nlohmann::json::parse(maps_.report_json)["charts"]);
}

TEST_F(EditMap, AMapWhoseReportIsNestedTooDeeplyIsRefused) {
    maps_.report_json.insert(1, "\"x\":" + std::string(200'000, '[') + std::string(200'000, ']') + ",");
    formats::write_dgm(maps_, map_);
    model::MapSet painted = maps_;
    test::poke(layer(painted, "deformation"), 4 * (5 * n + 4) + 3, 0.25f);
    formats::write_exr(painted, folder_ / "painted.exr");
    const std::string before = read_bytes(map_);
    EXPECT_EQ(code_of([&] { (void)edit_map(from(folder_ / "painted.exr")); }), codes::kBadReport.number);
    EXPECT_TRUE(read_bytes(map_) == before);
}

TEST_F(EditMap, TheSameEditGivesTheSameBytes) {
    model::MapSet painted = maps_;
    test::poke(layer(painted, "contact"), 2 * 40 + 1, 0.5f);
    formats::write_exr(painted, folder_ / "painted.exr");
    for (const char* name : {"one.dgm", "two.dgm"}) {
        EditOptions options = from(folder_ / "painted.exr");
        options.output = folder_ / name;
        EXPECT_TRUE(edit_map(options).is_written);
    }
    EXPECT_EQ(read_bytes(folder_ / "one.dgm"), read_bytes(folder_ / "two.dgm"));
    EXPECT_NE(read_bytes(folder_ / "one.dgm"), read_bytes(map_));
}

TEST_F(EditMap, APngHoldsTheUnitOrTheRangeOfTheJson) {
    exporter::export_plain_maps(maps_, folder_ / "maps", "tube", {});
    std::filesystem::remove(folder_ / "maps/tube_chart0_stiffness.exr");
    formats::GrayImage16 gray{n, m, std::vector<std::uint16_t>(m * n, 65535)};
    gray.pixels[5 * n + 4] = 13107;  // a fifth
    formats::write_png(folder_ / "maps/tube_chart0_stiffness.png", gray);
    ASSERT_TRUE(edit_map(from(folder_ / "maps")).is_written);
    model::MapSet expected = maps_;
    test::poke(layer(expected, "deformation"), 4 * (5 * n + 4) + 3, 13107.0f / 65535.0f);
    EXPECT_EQ(formats::read_dgm(map_).charts, expected.charts);
}

TEST_F(EditMap, ColourWhereOneNumberIsMeantIsRefused) {
    exporter::export_plain_maps(maps_, folder_ / "maps", "tube", {});
    std::filesystem::remove(folder_ / "maps/tube_chart0_stiffness.exr");
    formats::Image colours{n, m, std::vector<model::Rgba8>(m * n, {255, 255, 255, 255})};
    colours.pixels[7] = {255, 0, 0, 255};
    formats::write_png(folder_ / "maps/tube_chart0_stiffness.png", colours);
    EXPECT_EQ(code_of([&] { (void)edit_map(from(folder_ / "maps")); }), codes::kEditUnrelated.number);
    formats::write_png(folder_ / "maps/tube_chart0_stiffness.png", formats::Image{3, 3, std::vector<model::Rgba8>(9)});
    EXPECT_EQ(code_of([&] { (void)edit_map(from(folder_ / "maps")); }), codes::kEditUnrelated.number);
}

TEST_F(EditMap, ResampledMapsAreComparedButNotPutBack) {
    exporter::export_plain_maps(maps_, folder_ / "maps", "tube", {.chart = {}, .power_of_two = true});
    EXPECT_FALSE(edit_map(from(folder_ / "maps")).is_changed);
    std::filesystem::remove(folder_ / "maps/tube_chart0_mobility.exr");
    formats::write_png(folder_ / "maps/tube_chart0_mobility.png",
                       formats::GrayImage16{16, 16, std::vector<std::uint16_t>(256)});
    EXPECT_EQ(code_of([&] { (void)edit_map(from(folder_ / "maps")); }), codes::kEditUnrelated.number);
}

TEST_F(EditMap, MapsOfAnotherGridAreRefused) {
    model::MapSet other = maps_;
    other.charts = {maps_.charts[1], maps_.charts[0]};
    exporter::export_plain_maps(other, folder_ / "maps", "tube", {});
    formats::write_dgm(other, folder_ / "other.dgm");
    formats::write_exr(other, folder_ / "other.exr");
    for (const char* source : {"maps", "other.dgm", "other.exr"})
        EXPECT_EQ(code_of([&] { (void)edit_map(from(folder_ / source)); }), codes::kEditUnrelated.number) << source;
}

TEST_F(EditMap, ALockedLayerIsRefusedAndNothingIsWritten) {
    const std::string before = read_bytes(map_);
    model::MapSet painted = maps_;
    test::poke(layer(painted, "geometry"), 8, 9.0f);
    test::poke(layer(painted, "deformation"), 3, 0.5f);
    formats::write_exr(painted, folder_ / "painted.exr");
    formats::write_dgm(painted, folder_ / "painted.dgm");
    for (const char* source : {"painted.exr", "painted.dgm"}) {
        EXPECT_EQ(code_of([&] { (void)edit_map(from(folder_ / source)); }), codes::kEditForbidden.number) << source;
        EXPECT_EQ(read_bytes(map_), before);
    }
    EditOptions only = from(folder_ / "painted.dgm");
    only.layers = {"stiffness"};
    EXPECT_TRUE(edit_map(only).is_written);
}

TEST_F(EditMap, RepairTrustsWhatMayBeEdited) {
    overwrite("deformation", 4 * (5 * n + 4) + 3, 0.25f);
    EXPECT_EQ(code_of([&] { (void)formats::read_dgm(map_); }), codes::kHashMismatch.number);
    EXPECT_EQ(code_of([&] { (void)edit_map(from(map_)); }), codes::kHashMismatch.number);
    EditOptions repair = from({});
    repair.repair = true;
    EXPECT_TRUE(edit_map(repair).is_written);
    model::MapSet expected = maps_;
    test::poke(layer(expected, "deformation"), 4 * (5 * n + 4) + 3, 0.25f);
    const model::MapSet now = formats::read_dgm(map_);
    EXPECT_EQ(now.charts, expected.charts);
    EXPECT_EQ(nlohmann::json::parse(now.report_json)["edits"][0]["layer"], "stiffness");
    EXPECT_FALSE(edit_map(repair).is_changed);
}

TEST_F(EditMap, RepairRefusesPositionsAndAMetricThatIsNoneOfTheirs) {
    EditOptions repair = from({});
    repair.repair = true;
    overwrite("deformation", 4 * (5 * n + 4), 9.0f);  // E
    EXPECT_EQ(code_of([&] { (void)edit_map(repair); }), codes::kBadMetric.number);
    formats::write_dgm(maps_, map_);
    overwrite("geometry", 8, 9.0f);
    EXPECT_EQ(code_of([&] { (void)edit_map(repair); }), codes::kEditForbidden.number);
}

TEST_F(EditMap, ADryRunWritesNothing) {
    model::MapSet painted = maps_;
    test::poke(layer(painted, "contact"), 2 * 40 + 1, 0.5f);
    formats::write_dgm(painted, folder_ / "painted.dgm");
    const std::string before = read_bytes(map_);
    EditOptions options = from(folder_ / "painted.dgm");
    options.dry_run = true;
    const EditOutcome outcome = edit_map(options);
    EXPECT_TRUE(outcome.is_changed);
    EXPECT_FALSE(outcome.is_written);
    EXPECT_NE(outcome.lines.find("mobility     1 of 132 samples changed, by at most 0.5\n"), std::string::npos)
        << outcome.lines;
    EXPECT_EQ(read_bytes(map_), before);
}

}  // namespace
}  // namespace dgm::edit
