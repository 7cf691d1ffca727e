// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch_plan.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;

/// A folder of empty files; the plan looks at names only.
class BatchPlanTest : public testing::Test {
 protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("dgm-plan-" + std::to_string(getpid()));
        fs::remove_all(root_);
        fs::create_directories(root_);
    }
    void TearDown() override { fs::remove_all(root_); }

    fs::path touch(const fs::path& name) {
        fs::create_directories((root_ / name).parent_path());
        std::ofstream(root_ / name).flush();
        return root_ / name;
    }
    /// "source -> output" relative to the root, or "source: DGMnnnn".
    std::vector<std::string> lines(const PlanRequest& request) {
        std::vector<std::string> out;
        for (const PlannedAsset& a : plan_batch(request).assets) {
            const std::string source = a.source.lexically_relative(root_).string();
            if (a.refusal)
                out.push_back(source + ": " + a.refusal->code().id());
            else
                out.push_back(source + " -> " + (a.dgm.empty() ? a.exr : a.dgm).lexically_relative(root_).string());
        }
        return out;
    }
    int refusal(const PlanRequest& request) {
        try {
            (void)plan_batch(request);
        } catch (const model::Error& error) { return error.code().number; }
        return 0;
    }

    fs::path root_;
};

using Lines = std::vector<std::string>;

TEST_F(BatchPlanTest, FoldersAreSearchedInByteOrder) {
    for (const char* name : {"in/b.obj", "in/a.3DS", "in/B.OBJ", "in/sub/x.obj", "in/c.ply", "in/.git/y.obj",
                             "in/.z.obj", "in/readme.txt"})
        touch(name);
    PlanRequest request{{root_ / "in"}, root_ / "out"};
    EXPECT_EQ(lines(request), (Lines{"in/B.OBJ -> out/B.dgm", "in/a.3DS -> out/a.dgm", "in/b.obj -> out/b.dgm",
                                     "in/c.ply -> out/c.dgm", "in/sub/x.obj -> out/sub/x.dgm"}));
}

TEST_F(BatchPlanTest, WhatAFolderSearchLeavesOutIsListed) {
    for (const char* name : {"in/a.obj", "in/b.fbx", "in/c.blend", "in/sub/d.max", "in/a.mtl", "in/skin.png"})
        touch(name);
    const BatchPlan plan = plan_batch({{root_ / "in"}, root_ / "out"});
    EXPECT_EQ(plan.assets.size(), 2u);
    ASSERT_EQ(plan.left_out.size(), 2u);
    EXPECT_EQ(plan.left_out[0].path, root_ / "in/c.blend");
    EXPECT_NE(plan.left_out[1].why.find("there is no importer"), std::string::npos);
    touch("other/c.blend");
    EXPECT_EQ(plan_batch({{root_ / "other"}, root_ / "out"}).assets.at(0).refusal->what(),
              std::string("the folder holds no meshes that a search takes"));
}

TEST_F(BatchPlanTest, NamedFilesMayHaveAnyFormat) {
    const fs::path mesh = touch("scan.ply");
    EXPECT_EQ(lines({{mesh}, root_ / "out"}), Lines{"scan.ply -> out/scan.dgm"});
    EXPECT_EQ(lines({{mesh}, root_ / "x" / "y.dgm"}), Lines{"scan.ply -> x/y.dgm"});
    EXPECT_EQ(plan_batch({{mesh}, {}}).assets.at(0).dgm, "scan.dgm");
}

TEST_F(BatchPlanTest, BothFormatsShareTheStem) {
    PlanRequest request{{touch("a.obj")}, root_ / "o.v2.dgm"};
    request.write_exr = true;
    const PlannedAsset asset = plan_batch(request).assets.at(0);
    EXPECT_EQ(asset.dgm, root_ / "o.v2.dgm");
    EXPECT_EQ(asset.exr, root_ / "o.v2.exr");
}

TEST_F(BatchPlanTest, ANewSiblingRenamesNothing) {
    touch("in/y.obj");
    const PlanRequest request{{root_ / "in"}, root_ / "out"};
    EXPECT_EQ(lines(request), Lines{"in/y.obj -> out/y.dgm"});
    for (const char* name : {"in/y.3ds", "in/y.glb", "in/y.mtl", "in/y.OBJ"}) touch(name);
    EXPECT_EQ(lines(request), (Lines{"in/y.3ds -> out/y.3ds.dgm", "in/y.OBJ -> out/y.OBJ.dgm",
                                     "in/y.glb -> out/y.glb.dgm", "in/y.obj -> out/y.dgm"}));
}

TEST_F(BatchPlanTest, AFileHasTheNameThatItsFolderGivesIt) {
    for (const char* name : {"in/y.3ds", "in/y.obj", "in/z.fbx", "in/z.dae", "in/scan.ply"}) touch(name);
    const Lines whole = lines({{root_ / "in"}, root_ / "out"});
    Lines one_by_one;
    for (const char* name : {"scan.ply", "y.3ds", "y.obj", "z.dae", "z.fbx"})
        one_by_one.push_back(lines({{root_ / "in" / name}, root_ / "out"}).at(0));
    EXPECT_EQ(whole, one_by_one);
    EXPECT_EQ(whole, (Lines{"in/scan.ply -> out/scan.dgm", "in/y.3ds -> out/y.3ds.dgm", "in/y.obj -> out/y.dgm",
                            "in/z.dae -> out/z.dgm", "in/z.fbx -> out/z.fbx.dgm"}));
}

TEST_F(BatchPlanTest, CollisionsOfFoldersGoBelowTheirNames) {
    PlanRequest request{{touch("one/x.obj"), touch("one/x.3ds"), touch("two/x.obj"), touch("two/y.obj")},
                        root_ / "out"};
    EXPECT_EQ(lines(request), (Lines{"one/x.obj -> out/one/x.dgm", "one/x.3ds -> out/x.3ds.dgm",
                                     "two/x.obj -> out/two/x.dgm", "two/y.obj -> out/y.dgm"}));
    request.inputs = {touch("odd/a.3ds.obj"), touch("odd/a.3ds"), touch("odd/a.obj")};
    EXPECT_EQ(lines(request), (Lines{"odd/a.3ds.obj -> out/odd/a.3ds.obj.dgm", "odd/a.3ds -> out/odd/a.3ds.dgm",
                                     "odd/a.obj -> out/a.dgm"}));
    request.inputs = {touch("a/one/x.obj"), touch("b/one/x.obj")};
    EXPECT_EQ(refusal(request), model::codes::kUsage.number);
}

TEST_F(BatchPlanTest, RefusalsStandWhereTheirAssetsWouldStand) {
    fs::create_directories(root_ / "empty");
    const PlanRequest request{
        {root_ / "gone.obj", touch("a.obj"), root_ / "empty", root_ / "gone2.obj", touch("b.obj")}, root_ / "out"};
    EXPECT_EQ(lines(request), (Lines{"gone.obj: DGM5001", "a.obj -> out/a.dgm", "empty: DGM5004", "gone2.obj: DGM5001",
                                     "b.obj -> out/b.dgm"}));
}

TEST_F(BatchPlanTest, DevicesAreNotRead) {
    EXPECT_EQ(plan_batch({{"/dev/zero"}, {}}).assets.at(0).refusal->code().number, model::codes::kReadFailed.number);
}

TEST_F(BatchPlanTest, LinkedFoldersDoNotLoop) {
    touch("in/a.obj");
    fs::create_directory_symlink(root_ / "in", root_ / "in" / "again");
    EXPECT_EQ(lines({{root_ / "in"}, root_ / "out"}), Lines{"in/a.obj -> out/a.dgm"});
}

TEST_F(BatchPlanTest, NoAssetBecomesALayerOfAnother) {
    PlanRequest request{{touch("in/a.obj"), touch("in/a.texture.obj"), touch("in/a.chart2.bump.obj")}, root_ / "out"};
    EXPECT_EQ(lines(request).size(), 3U) << "maps in a .dgm have no files beside them";
    request.write_exr = true;
    EXPECT_EQ(refusal(request), model::codes::kUsage.number);
    request.inputs = {root_ / "in/a.obj", root_ / "in/a.chart2.bump.obj"};
    EXPECT_EQ(refusal(request), model::codes::kUsage.number);
    request.inputs = {root_ / "in/a.texture.obj", touch("in/a.painted.obj"), touch("in/b.texture.obj")};
    EXPECT_EQ(lines(request).size(), 3U);
}

TEST_F(BatchPlanTest, InputsAreNeverOutputs) {
    const fs::path mesh = touch("a.dgm");
    fs::create_directory_symlink(root_, root_ / "link");
    EXPECT_EQ(refusal({{mesh}, root_ / "link" / "a.dgm"}), model::codes::kUsage.number);
    EXPECT_EQ(refusal({{touch("a.obj")}, root_ / "b.stl"}), model::codes::kUsage.number);
    EXPECT_EQ(refusal({{touch("a.obj"), touch("b.obj")}, root_ / "both.dgm"}), model::codes::kUsage.number);
}

}  // namespace
}  // namespace dgm::bake
