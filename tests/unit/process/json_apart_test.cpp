// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/process/json_apart_test.cpp
#include "process/json_apart.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "model/codes.h"
#include "support/faults.h"
#include "test_maps.h"

namespace dgm::bake {
namespace {

using nlohmann::json;
namespace codes = model::codes;

constexpr std::uint64_t kMost = 1 << 20;

json every_kind() {
    return {{"null", nullptr},
            {"flag", true},
            {"whole", -7},
            {"large", std::numeric_limits<std::uint64_t>::max()},
            {"real", -0.1},
            {"text", "\u00e9\n\"\\"},
            {"list", {1, json::array(), json::object(), {"a", {{"b", false}}}}}};
}

TEST(JsonApart, ReadsWhatIsReadHere) {
    const test::TempFolder folder;
    test::write_bytes(folder / "a.json", every_kind().dump(2));
    test::write_bytes(folder / "bad.json", "{\"a\": [1, 2");
    test::write_bytes(folder / "deep.json", std::string(65, '[') + std::string(65, ']'));
    test::write_bytes(folder / "large.json", std::string(kMost, ' ') + "1");
    const auto reads = [&] {
        const json value = read_json(folder / "a.json", kMost);
        EXPECT_EQ(value, every_kind());
        EXPECT_EQ(value.dump(), every_kind().dump()) << "kinds of numbers, too";
        const auto code = [&](const char* name) {
            return test::code_of([&] { (void)read_json(folder / name, kMost); });
        };
        EXPECT_EQ(code("bad.json"), codes::kReportUnreadable.number);
        EXPECT_EQ(code("deep.json"), codes::kReportUnreadable.number);
        EXPECT_EQ(code("large.json"), codes::kTooLarge.number);
        EXPECT_EQ(code("none.json"), codes::kFileMissing.number);
        EXPECT_EQ(code(""), codes::kReadFailed.number);
    };
    reads();
    const JsonApart apart;
    reads();
}

TEST(JsonApart, WhateverTheParserDoesIsAnErrorOfTheFile) {
    const test::TempFolder folder;
    test::write_bytes(folder / "a.json", "{}");
    for (const auto& [name, fault] : test::faults()) {
        const JsonApart apart([&](std::string_view, const std::filesystem::path&) {
            fault();
            return json();
        });
        EXPECT_EQ(test::code_of([&] { (void)read_json(folder / "a.json", kMost); }), codes::kReportUnreadable.number)
            << name;
    }
}

TEST(JsonApart, ReportsInsideMapsAreReadApartToo) {
    const auto reads = [&] {
        EXPECT_EQ(read_map_report(every_kind().dump()), every_kind());
        EXPECT_EQ(read_map_report('"' + std::string(100'000, 'x') + '"'), json(std::string(100'000, 'x')));
        for (const std::string& none : {std::string(), std::string("{\"a\": [1, 2"), std::string("{\"a\0\": 1", 9),
                                        std::string(65, '[') + std::string(65, ']')})
            EXPECT_EQ(read_map_report(none), json()) << none;
    };
    reads();
    const JsonApart apart;
    reads();
}

TEST(JsonApart, WhateverTheParserDoesToAReportIsNoReport) {
    for (const auto& [name, fault] : test::faults()) {
        const JsonApart apart([&](std::string_view, const std::filesystem::path&) {
            fault();
            return json("not null");
        });
        EXPECT_EQ(read_map_report("{}"), json()) << name;
    }
}

TEST(JsonApart, TheMessageOfABrokenProcessIsRefusedOrAValue) {
    const std::string bytes = encode_json(every_kind());
    EXPECT_EQ(decode_json(bytes), every_kind());
    for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(decode_json(bytes.substr(0, size))) << size;
    EXPECT_FALSE(decode_json(bytes + '\0'));
    std::mt19937 random(20);
    int refused = 0;
    for (int mutant = 0; mutant < 4000; ++mutant) {
        std::string changed = bytes;
        for (unsigned changes = 1 + random() % 4; changes > 0; --changes)
            changed[random() % changed.size()] = static_cast<char>(random());
        if (const auto value = decode_json(changed))
            (void)value->dump(-1, ' ', false, json::error_handler_t::replace);
        else
            ++refused;
    }
    EXPECT_GT(refused, 400);
    json deep = 1;
    for (int level = 0; level < 64; ++level) deep = json::array({deep});
    EXPECT_EQ(decode_json(encode_json(deep)), deep);
    EXPECT_FALSE(decode_json(encode_json(json::array({deep}))));
}

}  // namespace
}  // namespace dgm::bake
