// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/dgm/dgm_test.cpp
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "dgm/dgm_reader.h"
#include "dgm/dgm_writer.h"
#include "dgm/hash.h"
#include "files/atomic_file.h"
#include "model/codes.h"
#include "unit/formats/test_maps.h"

namespace {

namespace codes = dgm::model::codes;
namespace fs = std::filesystem;
using dgm::formats::check_container;
using dgm::formats::read_and_check;
using dgm::formats::read_dgm;
using dgm::formats::write_dgm;
using dgm::layout::FileHeader;
using dgm::layout::LayerRecord;
using dgm::model::Error;
using dgm::model::MapSet;
using dgm::test::code_of;
using dgm::test::random_chart;
using dgm::test::random_maps;
using dgm::test::read_bytes;
using dgm::test::TempFolder;
using dgm::test::write_bytes;

FileHeader header_of(const std::string& bytes) {
    FileHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    return header;
}

std::vector<LayerRecord> layers_of(const std::string& bytes) {
    const FileHeader header = header_of(bytes);
    std::vector<LayerRecord> out(header.layer_count);
    std::memcpy(out.data(), bytes.data() + header.index_offset + header.chart_count * sizeof(dgm::layout::ChartRecord),
                out.size() * sizeof(LayerRecord));
    return out;
}

/// Puts a header back with a hash that fits, so that only what was changed can be found wrong.
void set_header(std::string& bytes, FileHeader header) {
    const auto hash = dgm::formats::hash_bytes(std::as_bytes(std::span(&header, 1)).first(112));
    std::copy(hash.begin(), hash.end(), header.header_hash);
    std::memcpy(bytes.data(), &header, sizeof header);
}

/// As a file of a writer that gives no hash of HDF5's own structures: they are checked one by one then.
void drop_rest_hash(std::string& bytes) {
    FileHeader header = header_of(bytes);
    std::fill(std::begin(header.rest_hash), std::end(header.rest_hash), std::uint8_t{0});
    set_header(bytes, header);
}

void set_layer(std::string& bytes, std::size_t number, const LayerRecord& record) {
    FileHeader header = header_of(bytes);
    std::memcpy(bytes.data() + header.index_offset + header.chart_count * sizeof(dgm::layout::ChartRecord) +
                    number * sizeof record,
                &record, sizeof record);
    const std::span<const char> records(bytes.data() + header.index_offset, header.index_bytes);
    const auto hash = dgm::formats::hash_bytes(std::as_bytes(records));
    std::copy(hash.begin(), hash.end(), header.index_hash);
    set_header(bytes, header);
}

TEST(DgmFile, ComesBackEqualForChartsOfEveryKind) {
    const TempFolder folder;
    for (const std::size_t charts : {0u, 1u, 3u, 6u}) {
        const MapSet maps = random_maps(charts + 1, charts);
        write_dgm(maps, folder / "a.dgm");
        EXPECT_EQ(read_dgm(folder / "a.dgm"), maps) << charts;
        EXPECT_TRUE(check_container(folder / "a.dgm").empty());
    }
}

TEST(DgmFile, IndexFitsTheUserBlockOrMovesToADataset) {
    const TempFolder folder;
    write_dgm(random_maps(1, 1), folder / "small.dgm");
    EXPECT_EQ(header_of(read_bytes(folder / "small.dgm")).index_offset, sizeof(FileHeader));

    const MapSet many = random_maps(2, 8);  // more than 64 layers
    write_dgm(many, folder / "many.dgm");
    const std::string bytes = read_bytes(folder / "many.dgm");
    const FileHeader header = header_of(bytes);
    ASSERT_GT(header.layer_count, 64u);
    EXPECT_GE(header.index_offset, 4096u);
    EXPECT_EQ(header.index_offset % 64, 0u);
    EXPECT_EQ(header.file_bytes, bytes.size());
    EXPECT_EQ(read_dgm(folder / "many.dgm"), many);
}

// Groups whose names need more than one node, and an index beyond the user block. HDF5 looks for room in a list, so
// that 3,000 charts of layers as small as these take half a minute; those of bakes do not.
TEST(DgmFile, HoldsHundredsOfCharts) {
    const TempFolder folder;
    dgm::test::Random random(7);
    MapSet maps = random_maps(3, 0);
    for (int k = 0; k < 500; ++k) maps.charts.push_back(random_chart(random, {.rows = 3, .cols = 3}));
    write_dgm(maps, folder / "a.dgm");
    EXPECT_EQ(read_dgm(folder / "a.dgm"), maps);
}

// A heap and a tree for every chart take longer to write the more charts there are.
TEST(DgmFile, GroupsOfChartsKeepTheirLinksInTheirHeaders) {
    const TempFolder folder;
    MapSet maps = random_maps(11, 3);
    ASSERT_GT(maps.charts[0].layers.size(), 8u);  // from nine on they would not, if nobody asked
    dgm::model::Layer more = *maps.charts[2].find("normal");
    for (int k = 0; k < 100; ++k) {
        more.name = "extra_" + std::to_string(k);
        maps.charts[2].layers.push_back(more);
    }
    write_dgm(maps, folder / "a.dgm");
    const hid_t file = H5Fopen((folder / "a.dgm").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    for (const char* name : {"/charts/0", "/charts/1"}) {
        H5G_info_t info{};
        ASSERT_GE(H5Gget_info_by_name(file, name, &info, H5P_DEFAULT), 0);
        EXPECT_EQ(info.storage_type, H5G_STORAGE_TYPE_COMPACT) << name;
    }
    ASSERT_GE(H5Fclose(file), 0);
    EXPECT_EQ(read_dgm(folder / "a.dgm"), maps);  // and more of them than a header should hold
}

TEST(DgmFile, LayersStandAtTheirOffsetsAligned) {
    const TempFolder folder;
    MapSet large;
    dgm::test::Random random(12);
    large.charts.push_back(random_chart(random, {.rows = 301, .cols = 299}));
    for (const MapSet& maps : {random_maps(11, 1), random_maps(11, 8), large}) {
        write_dgm(maps, folder / "a.dgm");
        const std::string bytes = read_bytes(folder / "a.dgm");
        const std::vector<LayerRecord> records = layers_of(bytes);
        std::size_t next = 0, all = 0;
        for (const LayerRecord& record : records) all += record.bytes;
        const std::size_t alignment = all >= 16 * 4096 * records.size() && records.size() <= 64 ? 4096 : 64;
        EXPECT_EQ(alignment, maps.charts[0].rows == 301 ? 4096U : 64U);
        // HDF5 keeps eight names a node: the large map has two nodes of them, each on a page of its own.
        EXPECT_LT(bytes.size(), 4096 + all + alignment * records.size() + 48'000 + 2000 * records.size()) << "padding";
        for (const auto& chart : maps.charts)
            for (const auto& layer : chart.layers) {
                const LayerRecord& record = records[next++];
                ASSERT_EQ(std::string(record.name), layer.name);
                EXPECT_EQ(record.offset % alignment, 0u);
                ASSERT_LE(record.offset + layer.bytes.size(), bytes.size());
                const auto stored = std::as_bytes(std::span(bytes)).subspan(record.offset, layer.bytes.size());
                EXPECT_TRUE(std::equal(stored.begin(), stored.end(), layer.bytes.begin()));
            }
    }
}

TEST(DgmFile, SameMapsGiveSameBytes) {
    const TempFolder folder;
    const MapSet maps = random_maps(5, 5);
    write_dgm(maps, folder / "a.dgm");
    // Memory that was used meanwhile must not show.
    const std::vector<std::string> noise(1000, std::string(5000, '\xAB'));
    write_dgm(random_maps(6, 3), folder / "other.dgm");
    write_dgm(maps, folder / "a much longer name.dgm");
    EXPECT_EQ(read_bytes(folder / "a.dgm"), read_bytes(folder / "a much longer name.dgm"));
    write_dgm(maps, folder / "other.dgm");  // over an older file
    EXPECT_EQ(read_bytes(folder / "a.dgm"), read_bytes(folder / "other.dgm"));
}

TEST(DgmFile, HashIsXxh3Canonical) {
    // XXH3_128bits of nothing with seed 0, from the test vectors of the xxHash specification.
    EXPECT_EQ(dgm::formats::to_hex(dgm::formats::hash_bytes({})), "99aa06d3014798d86001c324468d497f");
    const TempFolder folder;
    write_bytes(folder / "a", std::string(3'000'000, 'x'));
    const std::string text(3'000'000, 'x');
    EXPECT_EQ(dgm::formats::hash_file(folder / "a"), dgm::formats::hash_bytes(std::as_bytes(std::span(text))));
}

TEST(DgmFile, EveryFlippedByteThatMattersIsFound) {
    const TempFolder folder;
    const MapSet maps = random_maps(9, 1);
    write_dgm(maps, folder / "good.dgm");
    const std::string good = read_bytes(folder / "good.dgm");
    std::vector<std::size_t> places{8, 16, 24, 60, 100, 120, 130, 200, 300, 400};
    for (const LayerRecord& record : layers_of(good))
        if (record.bytes > 0) places.insert(places.end(), {record.offset, record.offset + record.bytes - 1});
    for (const std::size_t place : places) {
        std::string bad = good;
        bad[place] = static_cast<char>(bad[place] ^ 0x10);
        write_bytes(folder / "bad.dgm", bad);
        EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "bad.dgm"); }), codes::kHashMismatch.number)
            << "byte " << place;
        const auto findings = check_container(folder / "bad.dgm");
        ASSERT_FALSE(findings.empty());
        EXPECT_EQ(findings[0].code->number, codes::kHashMismatch.number);
    }
    std::string bad = good;
    bad[bad.find("1.25e-05")] = '7';
    for (const char* place : {"/", "/report"}) {
        write_bytes(folder / "bad.dgm", bad);
        const auto findings = check_container(folder / "bad.dgm");
        ASSERT_EQ(findings.size(), 1u);
        EXPECT_EQ(findings[0].code->number, codes::kHashMismatch.number);
        EXPECT_EQ(findings[0].place, place);
        drop_rest_hash(bad);
    }
}

TEST(DgmFile, FindingsNameTheLayer) {
    const TempFolder folder;
    write_dgm(random_maps(9, 2), folder / "a.dgm");
    std::string bytes = read_bytes(folder / "a.dgm");
    for (const LayerRecord& record : layers_of(bytes))
        if (record.chart == 1 && std::string(record.name) == "normal") bytes[record.offset] ^= 1;
    write_bytes(folder / "a.dgm", bytes);
    const auto findings = check_container(folder / "a.dgm");
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].place, "/charts/1/normal");
}

TEST(DgmFile, ChangedLayersAreReadWhenThatIsAskedFor) {
    const TempFolder folder;
    MapSet maps = random_maps(5, 2);
    write_dgm(maps, folder / "a.dgm");
    std::string bytes = read_bytes(folder / "a.dgm");
    const LayerRecord layer = layers_of(bytes)[1];
    ASSERT_GT(layer.bytes, 0u);
    bytes[layer.offset] = static_cast<char>(bytes[layer.offset] ^ 1);
    write_bytes(folder / "a.dgm", bytes);
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "a.dgm"); }), codes::kHashMismatch.number);
    const dgm::formats::ChangedDgm changed = dgm::formats::read_changed_dgm(folder / "a.dgm");
    EXPECT_TRUE(changed.rest_fits);
    for (std::size_t c = 0; c < maps.charts.size(); ++c)
        for (std::size_t l = 0; l < maps.charts[c].layers.size(); ++l)
            EXPECT_EQ(changed.fits[c][l], c != 0 || l != 1) << c << ' ' << l;
    maps.charts[0].layers[1].bytes[0] ^= std::byte{1};
    EXPECT_TRUE(changed.maps == maps);
    // Header and index still have to fit.
    bytes[200] = static_cast<char>(bytes[200] ^ 1);
    write_bytes(folder / "a.dgm", bytes);
    EXPECT_EQ(code_of([&] { (void)dgm::formats::read_changed_dgm(folder / "a.dgm"); }), codes::kHashMismatch.number);
}

TEST(DgmFile, ImpossibleRecordsAreRefused) {
    const TempFolder folder;
    write_dgm(random_maps(9, 1), folder / "good.dgm");
    const std::string good = read_bytes(folder / "good.dgm");
    const auto code_with = [&](const std::function<void(LayerRecord&)>& change) {
        std::string bytes = good;
        LayerRecord record = layers_of(bytes)[1];  // normal
        change(record);
        set_layer(bytes, 1, record);
        drop_rest_hash(bytes);
        write_bytes(folder / "bad.dgm", bytes);
        dgm::model::MapSet maps;
        const auto findings = read_and_check(folder / "bad.dgm", maps);
        EXPECT_EQ(findings.size(), check_container(folder / "bad.dgm").size());
        return findings.empty() ? 0 : findings[0].code->number;
    };
    EXPECT_EQ(code_with([](LayerRecord&) {}), 0);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.offset = ~0ull - 63; }), codes::kTruncated.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.offset = 0; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.offset += 1; }), codes::kBadAlignment.number);
    EXPECT_EQ(code_with([&](LayerRecord& r) { r.offset = layers_of(good)[0].offset; }), codes::kLayersOverlap.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.bytes = 1; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.shape[0] = 1ull << 63; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.rank = 5; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.rank = 0; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.type = 77; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { r.chart = 4; }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { std::strcpy(r.name, "../x"); }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) { std::strcpy(r.name, "geometry"); }), codes::kBadIndex.number);
    EXPECT_EQ(code_with([](LayerRecord& r) {
                  r.shape[0] *= r.shape[1];
                  r.shape[1] = 1;
              }),
              codes::kBadLayerShape.number);
    EXPECT_EQ(code_with([](LayerRecord& r) {
                  std::strcpy(r.name, "later");
                  r.flags = dgm::layout::kLayerRequired;
              }),
              codes::kUnknownLayer.number);
    // Other bytes that no other layer holds, with a hash that fits: HDF5 still knows better.
    const auto is_free = [&](std::uint64_t begin, std::uint64_t end) {
        const std::vector<LayerRecord> layers = layers_of(good);
        return std::none_of(layers.begin(), layers.end(), [&](const LayerRecord& l) {
            return l.bytes > 0 && std::string(l.name) != "normal" && begin < l.offset + l.bytes && l.offset < end;
        });
    };
    EXPECT_EQ(code_with([&](LayerRecord& r) {
                  do r.offset += 64;  // over its own end, at least
                  while (!is_free(r.offset, r.offset + r.bytes));
                  if (r.offset + r.bytes > good.size()) throw std::logic_error("no room beside the layers");
                  const auto hash = dgm::formats::hash_bytes(std::as_bytes(std::span(good.data() + r.offset, r.bytes)));
                  std::copy(hash.begin(), hash.end(), r.hash);
              }),
              codes::kIndexDiffers.number);
}

TEST(DgmFile, WrongFilesHaveTheirCodes) {
    const TempFolder folder;
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "none.dgm"); }), codes::kFileMissing.number);
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder.path()); }), codes::kReadFailed.number);
    write_bytes(folder / "empty.dgm", "");
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "empty.dgm"); }), codes::kNotDgm.number);
    write_bytes(folder / "text.dgm", "v 0 0 0\n");
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "text.dgm"); }), codes::kNotDgm.number);

    write_dgm(random_maps(1, 1), folder / "good.dgm");
    const std::string good = read_bytes(folder / "good.dgm");
    for (const std::size_t size : {9ul, 100ul, 4095ul, 4096ul, good.size() / 2, good.size() - 1}) {
        write_bytes(folder / "cut.dgm", good.substr(0, size));
        EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "cut.dgm"); }), codes::kTruncated.number) << size;
    }
    write_bytes(folder / "long.dgm", good + "x");
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "long.dgm"); }), codes::kBadIndex.number);

    std::string newer = good;
    FileHeader header = header_of(newer);
    header.format_version = 2;
    set_header(newer, header);
    write_bytes(folder / "newer.dgm", newer);
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "newer.dgm"); }), codes::kBadVersion.number);
}

TEST(DgmFile, DamagedHdf5IsAnErrorNotACrash) {
    const TempFolder folder;
    write_dgm(random_maps(21, 2), folder / "good.dgm");
    std::string good = read_bytes(folder / "good.dgm");
    drop_rest_hash(good);
    const std::vector<LayerRecord> layers = layers_of(good);
    const auto in_layer = [&](std::size_t place) {
        return std::any_of(layers.begin(), layers.end(),
                           [&](const LayerRecord& r) { return place >= r.offset && place < r.offset + r.bytes; });
    };
    dgm::test::Random random(1);
    for (int k = 0; k < 300; ++k) {
        std::string bad = good;
        for (int hit = 0; hit < 4; ++hit) {
            const std::size_t place = 4096 + random.below(bad.size() - 4096);
            if (!in_layer(place)) bad[place] = static_cast<char>(random.next());
        }
        write_bytes(folder / "bad.dgm", bad);
        const int code = code_of([&] { (void)read_dgm(folder / "bad.dgm"); });
        EXPECT_TRUE(code == 0 || (code >= 1000 && code < 2000)) << code;
    }
}

TEST(DgmFile, ASoftLinkIsNotFollowed) {
    const TempFolder folder;
    MapSet maps = random_maps(1, 1);
    write_dgm(maps, folder / "a.dgm");
    const hid_t file = H5Fopen((folder / "a.dgm").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    ASSERT_GE(H5Ldelete(file, "/charts/0/normal", H5P_DEFAULT), 0);
    ASSERT_GE(H5Lcreate_soft("/charts/0/geometry", file, "/charts/0/normal", H5P_DEFAULT, H5P_DEFAULT), 0);
    ASSERT_GE(H5Fclose(file), 0);
    // Only links have changed; where the file has grown, the index has to follow for the check to get there.
    std::string bytes = read_bytes(folder / "a.dgm");
    FileHeader header = header_of(bytes);
    header.file_bytes = bytes.size();
    set_header(bytes, header);
    drop_rest_hash(bytes);
    write_bytes(folder / "a.dgm", bytes);
    EXPECT_EQ(code_of([&] { (void)read_dgm(folder / "a.dgm"); }), codes::kForeignStorage.number);
}

TEST(DgmWriter, RefusesWhatTheFormatCannotHold) {
    const TempFolder folder;
    const auto code_with = [&](const std::function<void(dgm::model::Chart&)>& change) {
        MapSet maps = random_maps(1, 1);
        change(maps.charts[0]);
        const int code = code_of([&] { write_dgm(maps, folder / "a.dgm"); });
        EXPECT_FALSE(fs::exists(folder / "a.dgm"));
        return code;
    };
    using dgm::model::Chart;
    constexpr int kBad = codes::kBadLayerShape.number;
    EXPECT_EQ(code_with([](Chart& c) { c.layers[0].bytes.pop_back(); }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.layers[0].name = ""; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.layers[0].name = std::string(24, 'x'); }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.layers[0].name = "a/b"; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.layers[1].name = c.layers[0].name; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { ++c.rows; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.method = "a method of many letters"; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.bbox[0] = 1.0 / 0.0; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.layers[0].shape = {}; }), kBad);
    EXPECT_EQ(code_with([](Chart& c) { c.layers.back().shape = {1ull << 63, 1ull << 63}; }), kBad);
}

TEST(DgmWriter, SaysWhyAFileCannotBeMade) {
    const TempFolder folder;
    try {
        write_dgm(random_maps(1, 1), folder / "no such folder/a.dgm");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code().number, codes::kWriteFailed.number);
        EXPECT_NE(std::string(error.what()).find("No such file"), std::string::npos) << error.what();
    }
    EXPECT_EQ(code_of([&] { write_dgm(random_maps(1, 1), folder.path()); }), codes::kWriteFailed.number);
    EXPECT_TRUE(fs::is_directory(folder.path()));
}

TEST(AtomicFile, PublishReplacesTheOldFile) {
    const TempFolder folder;
    write_bytes(folder / "final", "old");
    write_bytes(folder / "temporary", "new");
    dgm::formats::publish_file(folder / "temporary", folder / "final");
    EXPECT_EQ(read_bytes(folder / "final"), "new");
    EXPECT_FALSE(fs::exists(folder / "temporary"));
    EXPECT_EQ(code_of([&] { dgm::formats::publish_file(folder / "none", folder / "final"); }),
              codes::kWriteFailed.number);
    EXPECT_EQ(read_bytes(folder / "final"), "new");
}

}  // namespace
