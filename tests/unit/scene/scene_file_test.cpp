// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/scene/scene_file_test.cpp
#include "scene/scene_file.h"

#include <gtest/gtest.h>

#include <string>

#include "model/codes.h"

namespace dgm::scene {
namespace {

/// Place and message of the refusal of a text, "LINE:COLUMN: message".
std::string refusal(const std::string& text) {
    try {
        static_cast<void>(parse_scene(text, "ward/scene.toml"));
    } catch (const model::Error& e) {
        EXPECT_EQ(e.code().number, model::codes::kSceneInvalid.number);
        EXPECT_TRUE(e.place().starts_with("ward/scene.toml:")) << e.place();
        return e.place().substr(sizeof "ward/scene.toml") + ": " + e.what();
    }
    return "taken";
}

bool holds(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(SceneFile, DeepNestingIsRefusedAtItsPlace) {
    std::string key = "a";
    for (int k = 0; k < 100'000; ++k) key += ".a";
    for (const std::string& text : {"\n" + key + " = 1\n", "\n[" + key + "]\n", "\nx = " + std::string(100'000, '[')}) {
        try {
            (void)parse_scene(text, "ward/scene.toml");
            ADD_FAILURE();
        } catch (const model::Error& e) {
            EXPECT_EQ(e.code().number, model::codes::kSceneInvalid.number);
            EXPECT_TRUE(e.place().starts_with("ward/scene.toml:2:")) << e.place();
        }
    }
}

TEST(SceneFile, FillsDefaultsIntoAssets) {
    const Scene scene = parse_scene(R"(
[scene]
name = "ward"
budget = "2MiB"
tick_budget = 20

[defaults]
tolerance = "0.1%"
tolerance_kind = "hausdorff"
fov = 40
resolution = 2160
fit = "l2"

[[asset]]
source = "organs/stomach.obj"
touched = true
footprint = "geodesic"
reach = "12.5"

[[asset]]
source = "props/lamp.3ds"
name = "far/lamp"
tolerance = "1.5px"
distance = 20
lit = false
layers = ["texture", "geometry"]
texture_budget = "64KiB"
precision = "f32"
largest = "129x65"
)",
                                    "ward/scene.toml");
    EXPECT_EQ(scene.name, "ward");
    EXPECT_EQ(scene.budget, 2097152U);
    EXPECT_DOUBLE_EQ(scene.tick_budget.value(), 20e-6);
    ASSERT_EQ(scene.assets.size(), 2U);
    const SceneAsset &stomach = scene.assets[0], &lamp = scene.assets[1];
    EXPECT_EQ(stomach.source, "ward/organs/stomach.obj");
    EXPECT_EQ(stomach.name, "stomach");
    EXPECT_EQ(stomach.line, 14);
    EXPECT_EQ(stomach.tolerance.unit, ToleranceUnit::kPercent);
    EXPECT_DOUBLE_EQ(stomach.tolerance.value, 0.1);
    EXPECT_EQ(stomach.tolerance.kind, bake::ErrorKind::kHausdorff);
    EXPECT_TRUE(stomach.touched);
    EXPECT_EQ(stomach.footprint, Footprint::kGeodesic);
    EXPECT_DOUBLE_EQ(stomach.reach.value, 12.5);
    EXPECT_FALSE(stomach.reach.percent);
    EXPECT_EQ(stomach.fit, bake::Fit::kL2);
    EXPECT_FALSE(stomach.precision.has_value());
    EXPECT_EQ(lamp.name, "far/lamp");
    EXPECT_EQ(lamp.tolerance.unit, ToleranceUnit::kPixels);
    EXPECT_EQ(lamp.tolerance.kind, bake::ErrorKind::kHausdorff) << "the kind is another wish than the tolerance";
    EXPECT_EQ(lamp.view.rows, 2160U);
    EXPECT_FALSE(lamp.lit);
    EXPECT_FALSE(lamp.touched) << "an asset's wishes are its own";
    EXPECT_EQ(lamp.texture_budget, 65536U);
    EXPECT_EQ(lamp.largest, (bake::GridSize{129, 65}));
    EXPECT_EQ(lamp.precision, bake::Precision::kF32);
}

TEST(SceneFile, SaysWhereAndWhatIsWrong) {
    const std::string asset = "[[asset]]\nsource = \"a.obj\"\n";
    EXPECT_TRUE(refusal(asset + "tolerence = \"1%\"").starts_with("3:1: "));
    EXPECT_TRUE(holds(refusal(asset + "tolerence = \"1%\""), "did you mean tolerance?"));
    EXPECT_TRUE(holds(refusal("[defaults]\nsource = \"a.obj\"\n" + asset), "source")) << "a source is no default";
    EXPECT_TRUE(holds(refusal("[scene]\nbudgets = \"1MiB\"\n" + asset), "did you mean budget?"));
    EXPECT_TRUE(holds(refusal("[scenes]\n" + asset), "did you mean scene?"));
    EXPECT_TRUE(refusal(asset + "touched = \"yes\"").starts_with("3:11: "));
    EXPECT_TRUE(holds(refusal(asset + "footprint = \"geodesc\""), "did you mean geodesic?"));
    EXPECT_TRUE(holds(refusal(asset + "layers = [\"normals\"]"), "did you mean normal?"));
    EXPECT_TRUE(holds(refusal(asset + "layers = []"), "empty"));
    EXPECT_TRUE(holds(refusal(asset + "tolerance = \"1px\""), "distance"));
    EXPECT_TRUE(holds(refusal("[[asset]]\ntolerance = \"1%\""), "source is missing"));
    EXPECT_TRUE(holds(refusal(asset + asset), "another asset is called a"));
    EXPECT_TRUE(holds(refusal("[scene]\nname = \"empty\""), "[[asset]]"));
    EXPECT_TRUE(refusal("[[asset]\n").starts_with("1:"));
    EXPECT_TRUE(holds(refusal("asset = 3"), "[[asset]]"));
    EXPECT_TRUE(holds(refusal("asset = [3]"), "a table"));
}

TEST(SceneFile, RefusesValuesOutOfRange) {
    const std::string asset = "[[asset]]\nsource = \"a.obj\"\n";
    for (const char* line : {"tolerance = \"0%\"",
                             "tolerance = \"-1\"",
                             "tolerance = \"nan%\"",
                             "tolerance = \"1 elephant\"",
                             "tolerance = 0.1",
                             "distance = 0",
                             "distance = nan",
                             "distance = inf",
                             "fov = 180",
                             "fov = 0",
                             "resolution = 1",
                             "resolution = 1080.5",
                             "reach = \"0%\"",
                             "largest = \"2x2\"",
                             "largest = \"9000x9\"",
                             "budget = \"lots\"",
                             "texture_budget = 12",
                             "name = \"../out\"",
                             "name = \"/out\"",
                             "name = \"\"",
                             "name = \"a/../..\"",
                             "source = \"\"",
                             "fabric = \"\"",
                             "method = \"lcsm\"",
                             "lit = 1"})
        EXPECT_NE(refusal(asset + line), "taken") << line;
}

}  // namespace
}  // namespace dgm::scene
