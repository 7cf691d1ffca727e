// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/broken_index_test.cpp
// Every field of header and records, broken with valid hashes, so that the check behind the hash is the one that
// answers.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "opened.h"

namespace dgm::test {
namespace {

using layout::ChartRecord;
using layout::FileHeader;
using layout::LayerRecord;

Image sound() {
    ChartSpec c = free_chart(9, 9, sheet);
    c.add("cover", ElementType::kF32, {9, 9}, std::vector<float>(81));
    return build({c, grid_chart(5, 6, sheet, tube_seams(5, 6))});
}

struct Broken {
    const char* name;
    ErrorCode code;
    std::uint64_t offset;
    std::function<void(Image&)> spoil;
};

constexpr std::uint64_t chart_at(std::uint64_t k, std::size_t field) {
    return sizeof(FileHeader) + k * sizeof(ChartRecord) + field;
}
constexpr std::uint64_t layer_at(std::uint64_t k, std::size_t field) {
    return sizeof(FileHeader) + 2 * sizeof(ChartRecord) + k * sizeof(LayerRecord) + field;
}

TEST(BrokenIndex, TheSoundFileOpens) {
    EXPECT_TRUE(Asset::open_memory(sound().bytes).ok());
}

TEST(BrokenIndex, EachFieldIsCheckedAndNamed) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto C = ErrorCode::BadIndex;
    const Broken cases[] = {
        {"magic", ErrorCode::NotDgm, 0, [](Image& f) { f.header.magic[3] = 'x'; }},
        {"version 0", ErrorCode::BadVersion, offsetof(FileHeader, format_version), [](Image& f) { f.header.format_version = 0; }},
        {"newer version", ErrorCode::BadVersion, offsetof(FileHeader, format_version), [](Image& f) { f.header.format_version = 2; }},
        {"header length", C, offsetof(FileHeader, header_bytes), [](Image& f) { f.header.header_bytes = 136; }},
        {"file too long", C, offsetof(FileHeader, file_bytes), [](Image& f) { f.header.file_bytes -= 64; }},
        {"no charts", C, offsetof(FileHeader, chart_count), [](Image& f) { f.header.chart_count = 0; }},
        {"chart count", C, offsetof(FileHeader, index_bytes), [](Image& f) { f.header.chart_count = 1; }},
        {"layer count", C, offsetof(FileHeader, index_bytes), [](Image& f) { f.header.layer_count += 1; }},
        {"huge count", ErrorCode::LimitExceeded, offsetof(FileHeader, layer_count), [](Image& f) { f.header.layer_count = ~0u; }},
        {"index length", C, offsetof(FileHeader, index_bytes), [](Image& f) { f.header.index_bytes += 1; }},
        {"index elsewhere in the block", C, offsetof(FileHeader, index_offset), [](Image& f) { f.header.index_offset = 192; }},
        {"index beyond the file", C, offsetof(FileHeader, index_offset), [](Image& f) { f.header.index_offset = ~0ull - 63; }},
        {"index at the file's end", C, offsetof(FileHeader, index_offset), [](Image& f) { f.header.index_offset = f.bytes.size(); }},
        {"rows 1", C, chart_at(0, offsetof(ChartRecord, rows)), [](Image& f) { f.charts[0].rows = 1; }},
        {"rows 65536", C, chart_at(0, offsetof(ChartRecord, rows)), [](Image& f) { f.charts[0].rows = 65536; }},
        {"cols 0", C, chart_at(1, offsetof(ChartRecord, cols)), [](Image& f) { f.charts[1].cols = 0; }},
        {"domain", C, chart_at(0, offsetof(ChartRecord, domain)), [](Image& f) { f.charts[0].domain = 2; }},
        {"border samples of a square", C, chart_at(1, offsetof(ChartRecord, border_samples)), [](Image& f) { f.charts[1].border_samples = 4; }},
        {"too many samples", ErrorCode::LimitExceeded, chart_at(0, 0), [](Image& f) { f.charts[0].border_samples = ~0u; }},
        {"first layer", C, chart_at(1, offsetof(ChartRecord, first_layer)), [](Image& f) { f.charts[1].first_layer += 1; }},
        {"layers of others", C, chart_at(0, offsetof(ChartRecord, first_layer)), [](Image& f) { f.charts[0].layer_count = 100; }},
        {"layers of nobody", C, offsetof(FileHeader, layer_count), [](Image& f) { f.charts[1].layer_count -= 1; }},
        {"bbox NaN", C, chart_at(0, offsetof(ChartRecord, bbox)), [nan](Image& f) { f.charts[0].bbox[2] = nan; }},
        {"bbox inverted", C, chart_at(0, offsetof(ChartRecord, bbox)), [](Image& f) { f.charts[0].bbox[0] = 2; }},
        {"offset NaN", C, chart_at(0, offsetof(ChartRecord, offset)), [nan](Image& f) { f.charts[0].offset[1] = nan; }},
        {"scale 0", C, chart_at(0, offsetof(ChartRecord, scale)), [](Image& f) { f.charts[0].scale[1] = 0; }},
        {"empty name", C, layer_at(0, 0), [](Image& f) { f.layers[0].name[0] = 0; }},
        {"name without end", C, layer_at(0, 0), [](Image& f) { std::memset(f.layers[0].name, 'a', 24); }},
        {"bytes behind the name", C, layer_at(0, 0), [](Image& f) { f.layers[0].name[23] = 'a'; }},
        {"layer's chart", C, layer_at(0, offsetof(LayerRecord, chart)), [](Image& f) { f.layers[0].chart = 1; }},
        {"type 0", C, layer_at(0, offsetof(LayerRecord, type)), [](Image& f) { f.layers[0].type = 0; }},
        {"type 7", C, layer_at(0, offsetof(LayerRecord, type)), [](Image& f) { f.layers[0].type = 7; }},
        {"rank 0", C, layer_at(0, offsetof(LayerRecord, rank)), [](Image& f) { f.layers[0].rank = 0; }},
        {"rank 5", C, layer_at(0, offsetof(LayerRecord, rank)), [](Image& f) { f.layers[0].rank = 5; }},
        {"unused shape", C, layer_at(0, offsetof(LayerRecord, shape) + 24), [](Image& f) { f.layers[0].shape[3] = 1; }},
        {"shape overflow", C, layer_at(0, offsetof(LayerRecord, shape) + 8), [](Image& f) { f.layers[0].shape[0] = f.layers[0].shape[1] = 1ull << 33; }},
        {"byte count", C, layer_at(0, offsetof(LayerRecord, bytes)), [](Image& f) { f.layers[0].bytes -= 4; }},
        {"alignment", C, layer_at(0, offsetof(LayerRecord, offset)), [](Image& f) { f.layers[0].offset += 4; }},
        {"layer in the user block", C, layer_at(0, offsetof(LayerRecord, offset)), [](Image& f) { f.layers[0].offset = 64; }},
        {"layer beyond the file", C, layer_at(0, offsetof(LayerRecord, offset)), [](Image& f) { f.layers[0].offset = f.bytes.size(); }},
        {"layer offset overflow", C, layer_at(0, offsetof(LayerRecord, offset)), [](Image& f) { f.layers[0].offset = ~0ull - 63; }},
        {"overlap", C, layer_at(5, offsetof(LayerRecord, offset)), [](Image& f) { f.layers[5].offset = f.layers[0].offset; }},
        {"a name twice", C, layer_at(7, 0), [](Image& f) {
             std::memcpy(f.layers[7].name, f.layers[6].name, 24);
             f.layers[7].type = f.layers[6].type;
             f.layers[7].rank = 3;
             f.layers[7].shape[0] = 5; f.layers[7].shape[1] = 6; f.layers[7].shape[2] = 3;
             f.layers[7].bytes = f.layers[6].bytes;
             f.layers[7].offset = f.bytes.size();
             f.bytes.resize(f.bytes.size() + 384);
             f.header.file_bytes = f.bytes.size();
         }},
        {"geometry as i16", ErrorCode::BadLayer, layer_at(0, offsetof(LayerRecord, type)), [](Image& f) { f.layers[0].type = 4; f.layers[0].bytes /= 2; }},
        {"cover with rank 1", ErrorCode::BadLayer, layer_at(5, offsetof(LayerRecord, rank)), [](Image& f) { f.layers[5].rank = 1; f.layers[5].shape[0] = 81; f.layers[5].shape[1] = 0; }},
        {"geometry of another grid", ErrorCode::BadLayer, layer_at(6, offsetof(LayerRecord, shape)), [](Image& f) { f.charts[1].rows = 6; }},
        {"border of another count", ErrorCode::BadLayer, layer_at(2, offsetof(LayerRecord, shape)), [](Image& f) { f.charts[0].border_samples -= 1; }},
        {"mask in a square", ErrorCode::BadLayer, layer_at(1, 0), [](Image& f) { f.charts[0].domain = 0; f.charts[0].border_samples = 0; }},
        {"unknown required layer", ErrorCode::UnknownLayer, layer_at(5, 0), [](Image& f) { f.layers[5].name[0] = 'k'; f.layers[5].flags = layout::kLayerRequired; }},
    };
    for (const Broken& c : cases) {
        Image image = sound();
        ASSERT_STREQ(image.layers[5].name, "cover");
        c.spoil(image);
        image.seal();
        const auto opened = Asset::open_memory(image.bytes);
        EXPECT_EQ(error_name(opened.error().code), std::string(error_name(c.code)))
            << c.name << ": " << opened.error().message;
        EXPECT_EQ(opened.error().byte_offset, c.offset) << c.name << ": " << opened.error().message;
    }
}

TEST(BrokenIndex, UnknownOptionalLayerIsSkipped) {
    Image image = sound();
    image.layers[5].name[0] = 'k';
    image.seal();
    const auto opened = Asset::open_memory(image.bytes);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    EXPECT_FALSE(opened.value().chart(0).value().find("kover").value().known);
}

TEST(BrokenIndex, EveryTruncationIsAnError) {
    const Image image = sound();
    for (std::size_t size = 0; size < image.bytes.size(); size += 16) {
        const Bytes cut(image.bytes.begin(), image.bytes.begin() + static_cast<std::ptrdiff_t>(size));
        const Error e = Asset::open_memory(cut).error();
        ASSERT_EQ(e.code, ErrorCode::Truncated) << size;
        ASSERT_EQ(e.byte_offset, size);
    }
    Bytes longer = image.bytes;
    longer.push_back(std::byte{0});
    EXPECT_EQ(Asset::open_memory(longer).error().code, ErrorCode::BadIndex);
}

TEST(BrokenIndex, EveryFlippedBitOfHeaderAndRecordsIsFound) {
    for (const bool beyond : {false, true}) {
        const Image image = beyond ? build(std::vector<ChartSpec>(25, grid_chart(2, 2, sheet))) : sound();
        ASSERT_EQ(beyond, image.header.index_offset != sizeof(FileHeader));
        Bytes bytes = image.bytes;
        const auto check = [&](std::uint64_t begin, std::uint64_t end) {
            for (std::uint64_t k = begin; k < end; ++k)
                for (unsigned bit = 0; bit < 8; ++bit) {
                    bytes[k] ^= static_cast<std::byte>(1u << bit);
                    ASSERT_FALSE(Asset::open_memory(bytes).ok()) << "byte " << k << " bit " << bit;
                    bytes[k] ^= static_cast<std::byte>(1u << bit);
                }
        };
        check(0, sizeof(FileHeader));
        check(image.header.index_offset, image.header.index_offset + image.header.index_bytes);
    }
}

}  // namespace
}  // namespace dgm::test
