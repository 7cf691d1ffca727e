// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bake/options.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

BakeOptions parsed(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), {"dgm-bake", "x.obj"});
    return std::get<CommandLine>(parse_command_line(static_cast<int>(arguments.size()), arguments.data())).bake;
}

std::string refusal(std::vector<const char*> arguments) {
    try {
        (void)parsed(std::move(arguments));
    } catch (const model::Error& e) {
        EXPECT_EQ(e.code().number, model::codes::kUsage.number);
        return e.what();
    }
    return {};
}

TEST(CommandLine, SizeIsAGridOrANumberOfSamples) {
    EXPECT_EQ(parsed({}).size, (GridSize{257, 257}));
    EXPECT_FALSE(parsed({}).auto_samples);
    EXPECT_TRUE(parsed({}).any_aspect);
    EXPECT_FALSE(parsed({"--size", "257x257"}).any_aspect) << "exact";
    EXPECT_FALSE(parsed({"--size", "auto:66049"}).any_aspect);
    EXPECT_FALSE(parsed({"--max-error", "1%"}).any_aspect);
    EXPECT_EQ(parsed({"--size", "33x65"}).size, (GridSize{33, 65}));
    EXPECT_EQ(parsed({"--size", "auto:66049"}).auto_samples, 66049U);
    for (const char* bad : {"auto:", "auto:8", "auto:66049x", "auto:-1", "auto:99999999999", "auto", "2x9"})
        EXPECT_NE(refusal({"--size", bad}).find("--size"), std::string::npos) << bad;
}

TEST(CommandLine, MaxErrorInPercentOrUnits) {
    const BakeOptions percent = parsed({"--max-error", "0.05%"});
    EXPECT_EQ(percent.max_error, (ErrorGoal{0.05, true, ErrorKind::kRms}));
    EXPECT_EQ(percent.auto_samples, kLargestSearched);  // no --size: the shape decides
    const BakeOptions units = parsed({"--max-error", "2.5e-3", "--max-error-kind", "hausdorff", "--size", "65x129"});
    EXPECT_EQ(units.max_error, (ErrorGoal{2.5e-3, false, ErrorKind::kHausdorff}));
    EXPECT_EQ(units.size, (GridSize{65, 129}));
    EXPECT_FALSE(units.auto_samples);
    for (const char* bad : {"0", "0%", "-1%", "nan", "inf", "%", "5%%", "small", "1 mm"})
        EXPECT_NE(refusal({"--max-error", bad}).find("--max-error"), std::string::npos) << bad;
    EXPECT_NE(refusal({"--max-error-kind", "rms"}).find("needs one"), std::string::npos);
    EXPECT_NE(refusal({"--max-error", "1%", "--max-error-kind", "rsm"}).find("did you mean rms?"), std::string::npos);
}

TEST(CommandLine, UnitAndMaterial) {
    EXPECT_FALSE(parsed({}).metres_per_unit);
    EXPECT_EQ(parsed({"--unit", "cm"}).metres_per_unit, 0.01);
    EXPECT_FALSE(parsed({"--unit", "mm"}).material);
    const BakeOptions denim = parsed({"--unit", "mm", "--material", "denim"});
    ASSERT_TRUE(denim.material);
    EXPECT_EQ(denim.material->density, 0.45f);
    EXPECT_EQ(denim.material->foundation, 0);
    EXPECT_NE(canonical_settings(denim), canonical_settings(parsed({"--unit", "mm"})));
    EXPECT_NE(canonical_settings(denim), canonical_settings(parsed({"--unit", "cm", "--material", "denim"})));
    EXPECT_NE(canonical_settings(denim), canonical_settings(parsed({"--unit", "mm", "--material", "satin"})));
    EXPECT_NE(refusal({"--material", "denim"}).find("add --unit"), std::string::npos);
    EXPECT_NE(refusal({"--unit", "mmm"}).find("did you mean mm?"), std::string::npos);
    EXPECT_NE(refusal({"--unit", "mm", "--material", "demin"}).find("did you mean denim?"), std::string::npos);
}

TEST(CommandLine, MeshesBesideTheMap) {
    EXPECT_NE(refusal({"--format", "glb"}).find("--format dgm,glb"), std::string::npos);
    EXPECT_NE(refusal({"--format", "dgm,gbl"}).find("did you mean glb?"), std::string::npos);
    EXPECT_TRUE(parsed({"--format", "dgm,glb,obj,ply,glb"}).write_dgm);
    EXPECT_FALSE(parsed({"--format", "exr,ply"}).write_dgm);
}

TEST(CommandLine, BudgetInBytes) {
    EXPECT_EQ(parsed({"--budget", "256KiB"}).budget_bytes, 262144U);
    EXPECT_EQ(parsed({"--budget", "1MB"}).budget_bytes, 1000000U);
    EXPECT_EQ(parsed({"--budget", "123456"}).budget_bytes, 123456U);
    EXPECT_EQ(parsed({"--budget", "1MB"}).auto_samples, kLargestSearched);
    for (const char* bad : {"0", "-1", "1XB", "much"})
        EXPECT_NE(refusal({"--budget", bad}).find("--budget"), std::string::npos) << bad;
    EXPECT_NE(refusal({"--budget", "1MB", "--format", "exr"}).find(".dgm"), std::string::npos);
}

}  // namespace
}  // namespace dgm::bake
