// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/scene/toml_tree_test.cpp
#include "scene/toml_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/codes.h"
#include "support/faults.h"
#include "test_maps.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;
using Kind = TomlNode::Kind;

constexpr char kText[] =
    "z = 5\n"
    "a.b = [ 1.5, true, \"\\u00e9\", nan, 9007199254740993 ]\n"
    "day = 2026-01-01\n"
    "[[asset]]\n"
    "  source = 'x.obj'\n";

bool equal(const TomlNode& a, const TomlNode& b) {
    const auto same_place = [](const TomlPlace& p, const TomlPlace& q) {
        return p.line == q.line && p.column == q.column;
    };
    bool out = a.kind == b.kind && same_place(a.place, b.place) && a.text == b.text && a.integer == b.integer &&
               (a.real == b.real || (std::isnan(a.real) && std::isnan(b.real))) && a.keys == b.keys &&
               a.entries.size() == b.entries.size() && a.key_places.size() == b.key_places.size();
    for (std::size_t k = 0; out && k < a.entries.size(); ++k) out = equal(a.entries[k], b.entries[k]);
    for (std::size_t k = 0; out && k < a.key_places.size(); ++k) out = same_place(a.key_places[k], b.key_places[k]);
    return out;
}

TEST(TomlTree, HoldsWhatTheTextSays) {
    const TomlNode root = parse_toml(kText, "s.toml");
    EXPECT_EQ(root.kind, Kind::kTable);
    EXPECT_EQ(root.keys, (std::vector<std::string>{"a", "asset", "day", "z"}));
    ASSERT_NE(root.get("z"), nullptr);
    EXPECT_EQ(root.get("z")->number(), 5.0);
    EXPECT_EQ(root.get("z")->place.column, 5u);
    EXPECT_EQ(root.get("y"), nullptr);
    EXPECT_EQ(root.get("day")->kind, Kind::kOther);
    const TomlNode& list = *root.get("a")->get("b");
    ASSERT_EQ(list.entries.size(), 5u);
    EXPECT_EQ(list.entries[0].number(), 1.5);
    EXPECT_EQ(list.entries[1].kind, Kind::kBoolean);
    EXPECT_EQ(list.entries[1].integer, 1);
    EXPECT_EQ(list.entries[1].number(), std::nullopt);
    EXPECT_EQ(list.entries[2].text, "\xc3\xa9");
    EXPECT_TRUE(std::isnan(list.entries[3].number().value()));
    EXPECT_EQ(list.entries[4].number(), std::nullopt) << "2^53 + 1 is no double";
    const TomlNode& asset = root.get("asset")->entries.at(0);
    EXPECT_EQ(asset.place.line, 4u);
    EXPECT_EQ(asset.get("source")->place.line, 5u);
    EXPECT_EQ(asset.key_places[0].column, 3u);
}

TEST(TomlTree, AllComesBack) {
    const TomlNode root = parse_toml(kText, "s.toml");
    const std::string bytes = encode_toml(root);
    const std::optional<TomlNode> back = decode_toml(bytes);
    ASSERT_TRUE(back);
    EXPECT_TRUE(equal(*back, root));
    for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(decode_toml(bytes.substr(0, size))) << size;
    EXPECT_FALSE(decode_toml(bytes + "x"));
    std::mt19937 random(20);
    for (int mutant = 0; mutant < 2000; ++mutant) {  // whatever is sent: no crash, no memory beyond what came
        std::string other = bytes;
        for (int changes = 0; changes < 3; ++changes) other[random() % other.size()] = static_cast<char>(random());
        static_cast<void>(decode_toml(other));
    }
}

TEST(TomlTree, EndlessNestsAreRefused) {
    std::string nest;
    for (int level = 0; level < 1'000'000; ++level)
        nest += std::string("\1\0\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0", 17);  // an array of one array of ...
    EXPECT_FALSE(decode_toml(nest));
}

TEST(TomlTree, IsReadApartAsHere) {
    const test::TempFolder folder;
    test::write_bytes(folder / "s.toml", kText);
    EXPECT_TRUE(equal(read_toml_apart(folder / "s.toml"), parse_toml(kText, folder / "s.toml")));
    EXPECT_EQ(test::code_of([&] { (void)read_toml_apart(folder / "none.toml"); }), codes::kFileMissing.number);
    EXPECT_EQ(test::code_of([&] { (void)read_toml_apart(folder.path()); }), codes::kReadFailed.number);
    test::write_bytes(folder / "bad.toml", "a = 1\nb = = 2\n");
    try {
        (void)read_toml_apart(folder / "bad.toml");
        FAIL();
    } catch (const model::Error& error) {
        EXPECT_EQ(&error.code(), &codes::kSceneInvalid);
        EXPECT_EQ(error.place(), (folder / "bad.toml").string() + ":2:5");
    }
}

TEST(TomlTree, WhateverTheParserDoesIsAnErrorOfTheFile) {
    const test::TempFolder folder;
    test::write_bytes(folder / "s.toml", kText);
    for (const auto& [name, fault] : test::faults()) {
        const auto run = [act = fault](std::string_view, const std::filesystem::path&) { return act(), TomlNode(); };
        EXPECT_EQ(test::code_of([&] { (void)read_toml_apart(folder / "s.toml", run); }), codes::kSceneInvalid.number)
            << name;
    }
    EXPECT_NO_THROW((void)read_toml_apart(folder / "s.toml"));
}

}  // namespace
}  // namespace dgm::scene
