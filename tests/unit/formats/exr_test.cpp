// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/exr_test.cpp
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "exr/exr_files.h"
#include "exr/exr_image.h"
#include "exr/exr_reader.h"
#include "exr/exr_writer.h"
#include "model/codes.h"
#include "test_maps.h"

namespace {

namespace codes = dgm::model::codes;
using dgm::formats::ExrLayout;
using dgm::formats::read_exr;
using dgm::formats::write_exr;
using dgm::model::Error;
using dgm::model::Layer;
using dgm::model::MapSet;
using dgm::test::code_of;
using dgm::test::random_maps;
using dgm::test::read_bytes;
using dgm::test::TempFolder;
using dgm::test::write_bytes;

/// Byte 4..7 of an EXR: version 2 and flags; bit 12 says multi-part.
bool is_multipart(const std::string& bytes) {
    return (static_cast<unsigned char>(bytes[5]) & 0x10) != 0;
}

TEST(ExrFile, EveryBitComesBack) {
    const TempFolder folder;
    for (const ExrLayout layout : {ExrLayout::kAuto, ExrLayout::kMultipart})
        for (const std::size_t charts : {0u, 1u, 2u, 6u}) {
            const MapSet maps = random_maps(charts + 40, charts);
            write_exr(maps, folder / "a.exr", {layout});
            EXPECT_TRUE(read_exr(folder / "a.exr") == maps) << charts;
        }
}

TEST(ExrFile, AllTextureCodesAndAlphasComeBack) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 0);
    dgm::test::Random random(1);
    maps.charts.push_back(random_chart(random, {.rows = 16, .cols = 16, .same_size_textures = true}));
    Layer* texture = maps.charts[0].find("texture");
    for (std::size_t k = 0; k < texture->bytes.size(); ++k)
        texture->bytes[k] = static_cast<std::byte>((k / 4 + 64 * (k % 4)) & 255);
    write_exr(maps, folder / "a.exr");
    EXPECT_EQ(read_exr(folder / "a.exr").charts[0].find("texture")->bytes, texture->bytes);
}

TEST(ExrFile, AllOctahedralCodesComeBack) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 0);
    dgm::model::Chart chart;
    chart.rows = chart.cols = 256;
    chart.method = "mvc";
    Layer normal{.name = "normal",
                 .type = dgm::layout::ElementType::kI16,
                 .shape = {256, 256, 2},
                 .bytes = {},
                 .attributes = {}};
    for (unsigned k = 0; k < 65536; ++k)
        for (const unsigned code : {k, 65535 - k})
            normal.bytes.insert(normal.bytes.end(),
                                {static_cast<std::byte>(code & 255), static_cast<std::byte>(code >> 8)});
    chart.layers.push_back(normal);
    maps.charts.push_back(chart);
    write_exr(maps, folder / "a.exr");
    EXPECT_EQ(read_exr(folder / "a.exr"), maps);
}

using Names = std::vector<std::string>;

Names names_of(const std::vector<std::filesystem::path>& files) {
    Names out;
    for (const auto& file : files) out.push_back(file.filename().string());
    std::sort(out.begin(), out.end());
    return out;
}

TEST(ExrFile, OnePartForTheGridAndAFileForEachOtherSize) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 0);
    dgm::test::Random random(1);
    maps.charts.push_back(random_chart(random, {.rows = 9, .cols = 14, .same_size_textures = true}));
    EXPECT_EQ(names_of(write_exr(maps, folder / "one.exr")), Names{"one.exr"});
    EXPECT_FALSE(is_multipart(read_bytes(folder / "one.exr")));
    EXPECT_EQ(names_of(write_exr(maps, folder / "many.exr", {ExrLayout::kMultipart})), Names{"many.exr"});
    EXPECT_TRUE(is_multipart(read_bytes(folder / "many.exr")));
    maps.charts[0] = random_chart(random, {.rows = 9, .cols = 14, .same_size_textures = false});
    EXPECT_EQ(names_of(write_exr(maps, folder / "sizes.exr")),
              (Names{"sizes.bump.exr", "sizes.exr", "sizes.texture.exr"}));
    for (const char* name : {"sizes.bump.exr", "sizes.exr", "sizes.texture.exr"})
        EXPECT_FALSE(is_multipart(read_bytes(folder / name))) << name;
}

TEST(ExrFile, ChartsOfOneSizeShareAFile) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 0);
    dgm::test::Random random(1);
    for (const std::uint32_t rows : {9u, 5u, 9u, 5u})
        maps.charts.push_back(random_chart(random, {.rows = rows, .cols = 14, .same_size_textures = true}));
    EXPECT_EQ(names_of(write_exr(maps, folder / "a.exr")), (Names{"a.chart1.exr", "a.exr"}));
    EXPECT_EQ(read_exr(folder / "a.exr"), maps);
}

/// The names of all channels and their types, as they stand in the header.
std::map<std::string, Imf::PixelType> channels_of(const std::filesystem::path& path) {
    std::map<std::string, Imf::PixelType> out;
    const Imf::MultiPartInputFile file(path.c_str());
    for (int part = 0; part < file.parts(); ++part) {
        const Imf::ChannelList& channels = file.header(part).channels();
        for (auto channel = channels.begin(); channel != channels.end(); ++channel)
            EXPECT_TRUE(out.emplace(channel.name(), channel.channel().type).second) << channel.name();
    }
    return out;
}

// Blender, three.js and others: one letter behind the layer's name, no whole numbers, one size, one tight window,
// no two channels of one name in all parts together.
TEST(ExrFile, FilesAreWhatOtherProgramsTake) {
    const TempFolder folder;
    for (const ExrLayout layout : {ExrLayout::kAuto, ExrLayout::kMultipart})
        for (const auto& written : write_exr(random_maps(46, 6), folder / "a.exr", {layout})) {
            for (const auto& [name, type] : channels_of(written)) {
                EXPECT_NE(type, Imf::UINT) << name;
                const std::size_t dot = name.rfind('.');
                EXPECT_EQ(name.size(), dot == std::string::npos ? 1 : dot + 2) << name;
                EXPECT_NE(std::string("RGBAXYZUV").find(name.back()), std::string::npos) << name;
            }
            const Imf::MultiPartInputFile file(written.c_str());
            for (int part = 0; part < file.parts(); ++part) {
                EXPECT_EQ(file.header(part).dataWindow(), file.header(0).dataWindow());
                EXPECT_EQ(file.header(part).displayWindow(), file.header(0).dataWindow());
                for (auto entry = file.header(part).begin(); entry != file.header(part).end(); ++entry)
                    if (std::string(entry.name()).starts_with("dgm")) {
                        EXPECT_TRUE(std::string("int string").find(entry.attribute().typeName()) != std::string::npos);
                    }
            }
        }
}

TEST(ExrFile, ASingleMapShowsPositionsAndItsTextureFirst) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 0);
    dgm::test::Random random(1);
    maps.charts.push_back(random_chart(random, {.rows = 9, .cols = 14}));
    write_exr(maps, folder / "a.exr");
    Names names;
    for (const auto& [name, type] : channels_of(folder / "a.exr")) {
        names.push_back(name);
        EXPECT_EQ(type, Imf::FLOAT) << name;
    }
    EXPECT_EQ(names, (Names{"B", "G", "R", "contact-area.V", "contact-mobility.V", "cover.V", "deformation-stiffness.V",
                            "deformation.X", "deformation.Y", "deformation.Z", "diagonals.V", "normal-code.U",
                            "normal-code.V", "normal.X", "normal.Y", "normal.Z"}));
    using Channels = std::map<std::string, Imf::PixelType>;
    EXPECT_EQ(channels_of(folder / "a.texture.exr"),
              (Channels{{"A", Imf::HALF}, {"B", Imf::HALF}, {"G", Imf::HALF}, {"R", Imf::HALF}}));
    EXPECT_EQ(channels_of(folder / "a.bump.exr"), (Channels{{"Y", Imf::HALF}}));
}

TEST(ExrFile, AFileOfLayersNamesItsMap) {
    const TempFolder folder;
    const auto files = write_exr(random_maps(40, 1), folder / "a.exr");
    ASSERT_GT(files.size(), 1u);
    EXPECT_FALSE(dgm::formats::is_exr_side_file(folder / "a.exr"));
    for (std::size_t k = 0; k + 1 < files.size(); ++k) {
        EXPECT_TRUE(dgm::formats::is_exr_side_file(files[k]));
        EXPECT_EQ(code_of([&] { (void)read_exr(files[k]); }), codes::kExrUnreadable.number);
    }
    std::filesystem::remove(folder / "a.texture.exr");
    EXPECT_EQ(code_of([&] { (void)read_exr(folder / "a.exr"); }), codes::kFileMissing.number);
    EXPECT_EQ(code_of([&] { (void)dgm::formats::read_exr_head(folder / "a.exr"); }), codes::kFileMissing.number);
}

TEST(ExrFile, LayersOfAnotherBakeAreRefused) {
    const TempFolder folder;
    write_exr(random_maps(40, 1), folder / "a.exr");
    MapSet other = random_maps(40, 1);
    other.charts[0].find("texture")->bytes[5] ^= std::byte{1};
    write_exr(other, folder / "b.exr");
    std::filesystem::copy_file(folder / "b.texture.exr", folder / "a.texture.exr",
                               std::filesystem::copy_options::overwrite_existing);
    EXPECT_EQ(code_of([&] { (void)read_exr(folder / "a.exr"); }), codes::kHashMismatch.number);
}

TEST(ExrFile, SameMapsGiveSameBytesWithoutADate) {
    const TempFolder folder;
    const MapSet maps = random_maps(3, 3);
    write_exr(maps, folder / "a.exr");
    write_exr(random_maps(4, 2), folder / "b.exr");
    write_exr(maps, folder / "b.exr");
    EXPECT_EQ(read_bytes(folder / "a.exr"), read_bytes(folder / "b.exr"));
    EXPECT_EQ(read_bytes(folder / "a.exr").find("capDate"), std::string::npos);
}

TEST(ExrFile, LargeTablesGetTheirOwnFile) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 1);
    Layer* seams = maps.charts[0].find("seams");
    seams->shape = {1'100'000, 2};
    seams->bytes.assign(8'800'000, std::byte{0x5A});
    for (std::size_t k = 0; k < seams->bytes.size(); ++k) seams->bytes[k] = static_cast<std::byte>(k * k >> 3 & 255);
    write_exr(maps, folder / "a.exr");
    EXPECT_TRUE(std::filesystem::exists(folder / "a.seams.exr"));
    EXPECT_TRUE(read_exr(folder / "a.exr") == maps);
}

TEST(ExrFile, DamageIsAnErrorNotACrash) {
    const TempFolder folder;
    EXPECT_EQ(code_of([&] { (void)read_exr(folder / "none.exr"); }), codes::kFileMissing.number);
    EXPECT_EQ(code_of([&] { (void)read_exr(folder.path()); }), codes::kReadFailed.number);
    write_bytes(folder / "bad.exr", "not an EXR");
    EXPECT_EQ(code_of([&] { (void)read_exr(folder / "bad.exr"); }), codes::kExrUnreadable.number);
    write_exr(random_maps(5, 2), folder / "good.exr");
    const std::string good = read_bytes(folder / "good.exr");
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        if (const std::string name = entry.path().filename(); name.starts_with("good.") && name != "good.exr")
            std::filesystem::copy_file(entry.path(), folder / ("bad" + name.substr(4)));
    write_bytes(folder / "bad.exr", good);
    EXPECT_EQ(code_of([&] { (void)read_exr(folder / "bad.exr"); }), 0);
    for (std::size_t size = 0; size < good.size(); size += 97) {
        write_bytes(folder / "bad.exr", good.substr(0, size));
        EXPECT_EQ(code_of([&] { (void)read_exr(folder / "bad.exr"); }), codes::kExrUnreadable.number) << size;
    }
    dgm::test::Random random(2);
    for (int k = 0; k < 500; ++k) {
        std::string bad = good;
        for (int hit = 0; hit < 3; ++hit)
            bad[random.below(std::min<std::size_t>(bad.size(), k % 2 ? 4000 : bad.size()))] =
                static_cast<char>(random.next());
        write_bytes(folder / "bad.exr", bad);
        const int code = code_of([&] { (void)read_exr(folder / "bad.exr"); });
        EXPECT_TRUE(code == 0 || code == codes::kExrUnreadable.number || code == codes::kBadVersion.number ||
                    code == codes::kHashMismatch.number || code == codes::kMissingChannel.number ||
                    code == codes::kFileMissing.number)
            << code;
    }
}

/// Where the value of an attribute begins; its size is in the four bytes before.
std::size_t value_of(const std::string& bytes, const std::string& name, const std::string& type) {
    const std::string entry = name + '\0' + type + '\0';
    const std::size_t at = bytes.find(entry);
    EXPECT_NE(at, std::string::npos) << name;
    return at + entry.size() + 4;
}

void put(std::string& bytes, std::size_t at, std::int32_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

long peak_megabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss >> 10;
}

// Each of these made OpenEXR take up to 2 GB for a file of some kilobytes, or would if the walk over the header lost
// step.
TEST(ExrFile, ClaimedSizesTakeNoMemory) {
    const TempFolder folder;
    write_exr(random_maps(5, 1), folder / "good.exr");
    const std::string good = read_bytes(folder / "good.exr");
    ASSERT_LT(good.size(), 1u << 20);
    const std::size_t report = value_of(good, "dgmReport", "string");
    const std::size_t window = value_of(good, "dataWindow", "box2i");
    const std::size_t channels = value_of(good, "channels", "chlist");
    constexpr std::int32_t kHuge = 0x6FFFFFFF;
    std::vector<std::pair<const char*, std::string>> bad;
    const auto add = [&](const char* what, std::size_t at, std::int32_t value) {
        put(bad.emplace_back(what, good).second, at, value);
    };
    add("a string of 1.8 GB", report - 4, kHuge);
    add("a negative size", report - 4, -1);
    add("a string to behind the end", report - 4, static_cast<std::int32_t>(good.size() - report + 1));
    add("rows of 65536 samples", window + 8, 65535);
    add("rows without number", window + 8, kHuge);
    add("sixteen million rows", window + 12, (1 << 24) - 1);
    add("a channel list that is longer than it says", channels - 4, 3);
    bad.emplace_back("an attribute of unknown type", good).second.replace(report - 11, 7, std::string("strung\0", 7));
    put(bad.back().second, report - 4, kHuge);
    // OpenEXR reads 16 bytes of a window whatever its size says: a string behind them would be seen by OpenEXR alone.
    std::string hidden = std::string("hidden\0string\0", 14) + std::string("\xFF\xFF\xFF\x6F", 4);
    bad.emplace_back("a string inside a window", good).second.insert(window + 16, hidden);
    put(bad.back().second, window - 4, static_cast<std::int32_t>(16 + hidden.size()));
    bad.emplace_back("tiles", good).second[5] |= 2;
    bad.emplace_back("deep pixels", good).second[5] |= 8;
    for (const auto& [what, bytes] : bad) {
        write_bytes(folder / "bad.exr", bytes);
        const long before = peak_megabytes();
        EXPECT_EQ(code_of([&] { (void)read_exr(folder / "bad.exr"); }), codes::kExrUnreadable.number) << what;
        EXPECT_LT(peak_megabytes() - before, 64) << what;
    }
}

TEST(ExrFile, WriterRefusesAndCleansUp) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 1);
    maps.charts[0].layers[0].bytes.pop_back();
    EXPECT_EQ(code_of([&] { write_exr(maps, folder / "a.exr"); }), codes::kBadLayerShape.number);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.exr"));
    EXPECT_EQ(code_of([&] { write_exr(random_maps(1, 1), folder / "none/a.exr"); }), codes::kWriteFailed.number);
}

/// All of a small file goes out at its end, where OpenEXR no longer looks.
TEST(ExrFile, AFullDiskIsNoticedAtTheLastByte) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
    const std::vector<float> pixels(4, 1);
    EXPECT_EQ(code_of([&] { dgm::formats::write_exr_image("/dev/full", 2, 2, "Y", pixels); }), codes::kNoSpace.number);
    EXPECT_EQ(code_of([&] { write_exr(random_maps(1, 1), "/dev/full"); }), codes::kNoSpace.number);
}

}  // namespace
