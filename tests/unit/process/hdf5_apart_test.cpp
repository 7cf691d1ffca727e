// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/hdf5_apart_test.cpp
// Hostile files here carry hashes and HDF5 checksums that fit: what anybody can make who has read SPEC.md.
#include "process/hdf5_apart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "dgm/dgm_writer.h"
#include "model/codes.h"
#include "support/rehash.h"
#include "test_maps.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;
using formats::Hdf5Part;

Hdf5Part sample_part() {
    Hdf5Part part;
    part.findings.push_back({&codes::kHashMismatch, formats::Severity::kError, "a \xff message", "/charts/0", 1.5, {}});
    part.generator = "dgm-bake";
    part.source_name = "";
    part.report_json = std::string("{\"a\":\0}", 7);
    part.attributes = {{},
                       {{"text", std::string("x")}, {"doubles", std::vector<double>{-0.0, 1e300}}},
                       {{"words", std::vector<std::uint32_t>{0xFFFFFFFFu}}}};
    return part;
}

TEST(Hdf5Apart, AllComesBack) {
    const Hdf5Part in = sample_part();
    const auto out = decode_hdf5_part(encode_hdf5_part(in));
    ASSERT_TRUE(out);
    ASSERT_EQ(out->findings.size(), 1u);
    EXPECT_EQ(out->findings[0].code, &codes::kHashMismatch);
    EXPECT_EQ(out->findings[0].message, in.findings[0].message);
    EXPECT_EQ(out->findings[0].place, "/charts/0");
    EXPECT_EQ(out->findings[0].measured, 1.5);
    EXPECT_FALSE(out->findings[0].limit);
    EXPECT_EQ(out->generator, in.generator);
    EXPECT_EQ(out->source_name, "");
    EXPECT_EQ(out->report_json, in.report_json);
    EXPECT_EQ(out->attributes, in.attributes);
}

TEST(Hdf5Apart, OtherBytesAreRefused) {
    const std::string bytes = encode_hdf5_part(sample_part());
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_hdf5_part(bytes.substr(0, size))) << size;
    EXPECT_FALSE(decode_hdf5_part(bytes + "x"));
    for (std::size_t k = 0; k < bytes.size(); ++k) {  // whatever is sent: no crash, no memory beyond what came
        std::string other = bytes;
        other[k] = static_cast<char>(other[k] ^ 0x80);
        static_cast<void>(decode_hdf5_part(other));
    }
}

TEST(Hdf5Apart, ReadsWhatIsReadHere) {
    const test::TempFolder folder;
    const model::MapSet maps = test::random_maps(3, 11);
    formats::write_dgm(maps, folder / "a.dgm");
    const model::MapSet here = formats::read_dgm(folder / "a.dgm");
    const Hdf5Apart hdf5;
    EXPECT_EQ(formats::read_dgm(folder / "a.dgm"), here);
    EXPECT_EQ(here, maps);
    EXPECT_TRUE(formats::check_container(folder / "a.dgm").empty());
    test::write_bytes(folder / "bad.dgm", "no map");
    EXPECT_EQ(test::code_of([&] { (void)formats::read_dgm(folder / "bad.dgm"); }), codes::kNotDgm.number);
    EXPECT_EQ(test::code_of([&] { (void)formats::read_dgm(folder / "none.dgm"); }), codes::kFileMissing.number);
}

TEST(Hdf5Apart, AFileThatCrashesHdf5IsAFinding) {
    const Hdf5Apart hdf5;
    const auto findings = formats::check_container(std::filesystem::path(DGM_FIXTURES) / "crashes_hdf5.dgm");
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].code, &codes::kHdf5Unreadable);
    const test::TempFolder folder;  // and the next file is read as ever
    formats::write_dgm(test::random_maps(1, 5), folder / "a.dgm");
    EXPECT_TRUE(formats::check_container(folder / "a.dgm").empty());
}

TEST(Hdf5Apart, SurvivesMutantsWhoseChecksumsFit) {
    const test::TempFolder folder;
    model::MapSet maps = test::random_maps(1, 7);
    maps.charts.resize(1);
    for (int k = 0; maps.charts[0].layers.size() < 12; ++k) {  // enough links for HDF5's dense storage
        model::Layer layer = maps.charts[0].layers.front();
        layer.name = "mask" + std::to_string(k);
        layer.required = false;
        maps.charts[0].layers.push_back(std::move(layer));
    }
    formats::write_dgm(maps, folder / "a.dgm");
    const std::string original = test::read_bytes(folder / "a.dgm");
    const std::vector<test::Hdf5Block> blocks = test::hdf5_blocks(original);
    ASSERT_GT(blocks.size(), 15u);
    const Hdf5Apart hdf5;
    std::mt19937 random(20);
    int crashes = 0, refused = 0;
    for (int mutant = 0; mutant < 150; ++mutant) {
        std::string file = original;
        for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
            const test::Hdf5Block& b = blocks[random() % blocks.size()];
            const std::size_t at = b.begin + 4 + random() % (b.bytes - 4);
            const char values[] = {0, 1, '\x7f', '\xff', static_cast<char>(random())};
            file[at] = values[random() % std::size(values)];
        }
        test::mend_checksums(file, blocks);
        test::mend_hashes(file);
        test::write_bytes(folder / "m.dgm", file);
        const auto findings = formats::check_container(folder / "m.dgm");
        refused += findings.empty() ? 0 : 1;
        for (const formats::Finding& f : findings) crashes += f.message.starts_with("HDF5 crashes") ? 1 : 0;
    }
    EXPECT_GT(refused, 50) << "the mutants do not reach HDF5";
    RecordProperty("crashes", crashes);
}

}  // namespace
}  // namespace dgm::bake
