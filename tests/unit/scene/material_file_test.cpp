// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/scene/material_file_test.cpp
#include "scene/material_file.h"

#include <gtest/gtest.h>

#include <string>

#include "model/codes.h"
#include "test_maps.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;

/// "CODE PLACE MESSAGE" of the refusal; empty if the text is taken.
std::string refusal(const std::string& text) {
    try {
        (void)parse_material(text, "m.toml");
    } catch (const model::Error& e) { return std::to_string(e.code().number) + ' ' + e.place() + ' ' + e.what(); }
    return {};
}

TEST(MaterialFile, HoldsNumbersInSiUnits) {
    const Material all = parse_material(
        "membrane = 150\npoisson = 0.25\nbending = 5e-4\nfoundation = 1e4\ndensity = 4\nviscosity = 1e-3\n", "m.toml");
    EXPECT_EQ(all, (Material{150, 0.25f, 5e-4f, 1e4f, 4, 1e-3f}));
    const Material least = parse_material("density = 0.1\nmembrane = 1e3\nbending = 0\n", "m.toml");
    EXPECT_EQ(least, (Material{1000, 0.3f, 0, 0, 0.1f, 0})) << "nothing pulls it back unless the file says so";
}

TEST(MaterialFile, IsRefusedWithItsPlace) {
    const std::string good = "membrane = 150\nbending = 5e-4\ndensity = 4\n";
    EXPECT_EQ(refusal(good), "");
    const auto expect = [&](const std::string& text, const std::string& place, const std::string& part) {
        const std::string is = refusal(text);
        EXPECT_EQ(is.rfind("6005 m.toml" + place, 0), 0u) << is;
        EXPECT_NE(is.find(part), std::string::npos) << is;
    };
    expect("membrane = 150\ndensity = 4\n", ":1:1", "bending is missing");
    expect(good + "poison = 0.3\n", ":4:1", "did you mean poisson?");
    expect(good + "poisson = 0.5\n", ":4:11", "0 to 0.49");
    expect(good + "viscosity = nan\n", ":4:13", "0 to 1e+06 s");
    expect(good + "viscosity = -1\n", ":4:13", "0 to 1e+06 s");
    expect(good + "foundation = \"soft\"\n", ":4:14", "not a number");
    expect(good + "foundation = [1]\n", ":4:14", "not a number");
    expect("membrane = 0\nbending = 5e-4\ndensity = 4\n", ":1:12", "N/m");
    expect(good + "[more]\n", ":4:2", "there is no key \"more\"");
    expect(good + "density = 4\n", ":4:1", "");
    expect("membrane = = 3", ":1:", "");
    expect(std::string(100'000, '['), ":1:", "nested");
}

TEST(MaterialFile, IsReadInAProcessOfItsOwn) {
    const test::TempFolder folder;
    test::write_bytes(folder / "m.toml", "membrane = 150\nbending = 5e-4\ndensity = 4\n");
    EXPECT_EQ(read_material(folder / "m.toml").membrane, 150);
    EXPECT_EQ(test::code_of([&] { (void)read_material(folder / "none.toml"); }), codes::kFileMissing.number);
    EXPECT_EQ(test::code_of([&] { (void)read_material(folder.path()); }), codes::kReadFailed.number);
    test::write_bytes(folder / "bad.toml", "membrane = ");
    EXPECT_EQ(test::code_of([&] { (void)read_material(folder / "bad.toml"); }), codes::kMaterialInvalid.number);
}

}  // namespace
}  // namespace dgm::scene
