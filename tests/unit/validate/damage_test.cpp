// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/damage_test.cpp
// Cut files and flipped bits, all over a small file of every kind of layer: the validator finds each of them, the
// runtime each that its index is made of, and the rest when it is asked to hash.
//
// DGM_DAMAGE_STEP=1 tries every byte instead of one in 64.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include <dgm/asset.h>

#include "dgm/dgm_reader.h"
#include "dgm/dgm_writer.h"
#include "exr/exr_reader.h"
#include "exr/exr_writer.h"
#include "model/codes.h"
#include "raw_dgm.h"
#include "support/asked.h"
#include "support/temp_folder.h"
#include "validate/validation.h"
#include "validation_maps.h"

namespace dgm::validate {
namespace {
namespace codes = model::codes;
namespace fs = std::filesystem;
using test::RawDgm;

std::size_t flip_step() {
    const long step = test::asked("DGM_DAMAGE_STEP", 64);
    return step > 0 ? static_cast<std::size_t>(step) : 64;
}

class Damage : public testing::Test {
 protected:
    static std::string read_bytes(const fs::path& path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    fs::path put(const std::string& bytes) const {
        std::ofstream(folder_ / "bad", std::ios::binary) << bytes;
        return folder_ / "bad";
    }
    std::string good_dgm() const {
        formats::write_dgm(test::good_maps(), folder_ / "good");
        return read_bytes(folder_ / "good");
    }
    std::string good_exr(formats::ExrLayout layout) const {
        // Layers of other sizes stand where those of `put` are looked for.
        formats::write_exr(test::good_maps(), folder_ / "bad", {layout});
        return read_bytes(folder_ / "bad");
    }
    static ErrorCode runtime_opens(const std::string& bytes, bool hashes) {
        std::vector<std::max_align_t> aligned(bytes.size() / sizeof(std::max_align_t) + 1);
        std::memcpy(aligned.data(), bytes.data(), bytes.size());
        OpenOptions options;
        options.verify_hashes = hashes;
        const auto asset = Asset::open_memory(std::as_bytes(std::span(aligned)).first(bytes.size()), options);
        return asset ? ErrorCode{} : asset.error().code;
    }
    const test::TempFolder scratch_;
    const fs::path& folder_ = scratch_.path();
};

TEST_F(Damage, EveryCutIsFound) {
    const std::string good = good_dgm();
    ASSERT_TRUE(validate_file(put(good)).findings.empty());
    ASSERT_EQ(runtime_opens(good, true), ErrorCode{});
    for (std::size_t size = 0; size < good.size(); size += 512) {
        const FileValidation cut = validate_file(put(good.substr(0, size)));
        ASSERT_EQ(cut.findings.size(), 1u) << size;
        EXPECT_EQ(cut.findings[0].code, size == 0 ? &codes::kNotDgm : &codes::kTruncated) << size;
        EXPECT_EQ(cut.exit_code(), model::ExitCode::kInvalid);
        EXPECT_NE(runtime_opens(good.substr(0, size), false), ErrorCode{}) << size;
    }
}

TEST_F(Damage, EveryFlippedBitIsFound) {
    const std::string good = good_dgm();
    const RawDgm raw(good);
    const std::size_t index_end = raw.header.index_offset + raw.header.index_bytes;
    std::map<std::string, int> found;
    for (std::size_t at = 0; at < good.size(); at += flip_step()) {
        std::string bad = good;
        bad[at] = static_cast<char>(bad[at] ^ (1 << (at / flip_step() % 8)));
        const FileValidation flipped = validate_file(put(bad));
        ASSERT_FALSE(flipped.findings.empty()) << "byte " << at;
        EXPECT_NE(flipped.exit_code(), model::ExitCode::kOk) << "byte " << at;
        const std::string& place = flipped.findings[0].place;
        ++found[flipped.findings[0].code->id() + " " + place.substr(0, place.find(' '))];
        const bool in_layer = std::any_of(raw.layers.begin(), raw.layers.end(), [&](const layout::LayerRecord& l) {
            return at >= l.offset && at < l.offset + l.bytes;
        });
        if (in_layer) {
            EXPECT_EQ(flipped.findings[0].code, &codes::kHashMismatch);
            EXPECT_EQ(runtime_opens(bad, false), ErrorCode{}) << "layers are not read when a file is opened";
            EXPECT_EQ(runtime_opens(bad, true), ErrorCode::HashMismatch) << "byte " << at;
        } else if (at < index_end) {
            EXPECT_NE(runtime_opens(bad, false), ErrorCode{}) << "byte " << at;
        }
    }
    // Header, records, stray bytes, HDF5's own structures, and layers by name were all hit.
    for (const char* what :
         {"DGM1003 user", "DGM1005 user", "DGM1003 /", "DGM1003 /charts/0/geometry", "DGM1003 /charts/1/mask"})
        EXPECT_GT(found[what], 0) << what;
}

TEST_F(Damage, HugeSizesInTheIndexAreNeverBelieved) {
    const std::string good = good_dgm();
    const auto both_refuse = [&](const char* what, const model::Code& code, const auto& change) {
        RawDgm raw(good);
        change(raw);
        const std::string bad = raw.bytes();
        const FileValidation validation = validate_file(put(bad));
        ASSERT_FALSE(validation.findings.empty()) << what;
        EXPECT_EQ(validation.findings[0].code->id(), code.id()) << what;
        EXPECT_NE(runtime_opens(bad, false), ErrorCode{}) << what;
    };
    constexpr std::uint64_t kHuge = std::uint64_t{1} << 62;
    both_refuse("shape", codes::kBadIndex, [](RawDgm& r) { r.layer("normal").shape[0] = kHuge; });
    both_refuse("wraps to 0", codes::kBadIndex, [](RawDgm& r) {
        r.layer("seams").shape[0] = kHuge;
        r.layer("seams").shape[1] = kHuge;
        r.layer("seams").bytes = 0;
    });
    both_refuse("offset", codes::kTruncated, [](RawDgm& r) { r.layer("normal").offset = kHuge; });
    both_refuse("offset that wraps", codes::kTruncated, [](RawDgm& r) { r.layer("normal").offset = ~63ull; });
    both_refuse("overlap", codes::kLayersOverlap,
                [](RawDgm& r) { r.layer("normal").offset = r.layer("geometry").offset; });
    both_refuse("index bytes", codes::kBadIndex, [](RawDgm& r) { r.layers[0].bytes = kHuge; });
    both_refuse("border samples of a square", codes::kBadIndex, [](RawDgm& r) { r.charts[0].border_samples = 1; });
    both_refuse("rows", codes::kBadIndex, [](RawDgm& r) { r.charts[0].rows = 65536; });
    both_refuse("file size", codes::kTruncated, [](RawDgm& r) { r.claimed_size = kHuge; });
    both_refuse("small file size", codes::kBadIndex, [](RawDgm& r) { r.claimed_size = 4096; });
}

TEST_F(Damage, HostileCountsCostNothing) {
    // Counts cannot be set through RawDgm, which reads that many records.
    std::string bad = good_dgm();
    layout::FileHeader header;
    std::memcpy(&header, bad.data(), sizeof header);
    for (std::uint32_t layout::FileHeader::*field :
         {&layout::FileHeader::chart_count, &layout::FileHeader::layer_count}) {
        layout::FileHeader hostile = header;
        hostile.*field = 0xFFFFFFFFu;
        const auto hash =
            formats::hash_bytes(std::as_bytes(std::span(&hostile, 1)).first(offsetof(layout::FileHeader, header_hash)));
        std::copy(hash.begin(), hash.end(), hostile.header_hash);
        std::memcpy(bad.data(), &hostile, sizeof hostile);
        const FileValidation validation = validate_file(put(bad));
        ASSERT_EQ(validation.findings.size(), 1u);
        EXPECT_EQ(validation.findings[0].code, &codes::kBadIndex);
        EXPECT_NE(runtime_opens(bad, false), ErrorCode{});
    }
}

TEST_F(Damage, CutExrFilesAreFound) {
    for (const auto layout : {formats::ExrLayout::kAuto, formats::ExrLayout::kMultipart}) {
        const std::string good = good_exr(layout);
        ASSERT_TRUE(validate_file(put(good)).findings.empty());
        for (std::size_t size = 0; size < good.size(); size += 512) {
            const FileValidation cut = validate_file(put(good.substr(0, size)));
            EXPECT_NE(cut.exit_code(), model::ExitCode::kOk) << size;
        }
    }
}

TEST_F(Damage, FlippedBitsInExrFilesAreFoundOrChangeNothing) {
    for (const auto layout : {formats::ExrLayout::kAuto, formats::ExrLayout::kMultipart}) {
        const std::string good = good_exr(layout);
        const model::MapSet maps = test::good_maps();
        std::size_t found = 0, harmless = 0;
        for (std::size_t at = 0; at < good.size(); at += flip_step()) {
            std::string bad = good;
            bad[at] = static_cast<char>(bad[at] ^ (1 << (at / flip_step() % 8)));
            const fs::path file = put(bad);
            if (validate_file(file).exit_code() != model::ExitCode::kOk) {
                ++found;
                continue;
            }
            // OpenEXR does not read it, or it is a standard attribute such as the pixels' aspect.
            EXPECT_EQ(formats::read_exr(file), maps) << "byte " << at;
            ++harmless;
        }
        // The harmless ones are in channels for people, which repeat what others hold, and in OpenEXR's own attributes.
        EXPECT_GT(found, 2 * harmless) << found << " found, " << harmless << " harmless";
    }
}

}  // namespace
}  // namespace dgm::validate
