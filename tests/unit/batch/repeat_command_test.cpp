// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/repeat_command.h"

#include <gtest/gtest.h>

#include <sstream>

#include "bake/options.h"

namespace dgm::bake {
namespace {

/// Command line that dgm-bake parses from a command without quotes.
CommandLine parsed(const std::string& command) {
    std::istringstream words(command);
    std::vector<std::string> list;
    for (std::string word; words >> word;) list.push_back(word);
    std::vector<const char*> arguments;
    for (const std::string& word : list) arguments.push_back(word.c_str());
    return std::get<CommandLine>(parse_command_line(static_cast<int>(arguments.size()), arguments.data()));
}

void expect_same(const std::string& options, bool exr = false) {
    const CommandLine first = parsed("dgm-bake m.obj " + options);
    const PlannedAsset asset{"m.obj", "out/m.dgm", exr ? "out/m.exr" : "", {}, "m.obj", first.bake};
    const std::string command = repeat_command(asset);
    const CommandLine again = parsed(command);
    EXPECT_EQ(canonical_settings(again.bake), canonical_settings(first.bake)) << command;
    EXPECT_EQ(again.bake.write_exr, exr) << command;
    EXPECT_EQ(again.plan.output, "out/m.dgm");
}

TEST(RepeatCommand, DefaultsAreLeftOut) {
    PlannedAsset asset{"in/m.obj", "out/./m.dgm", "", {}, "m.obj", {}};
    asset.options.any_aspect = true;
    EXPECT_EQ(repeat_command(asset), "dgm-bake in/m.obj -o out/m.dgm");
    asset.options.any_aspect = false;
    EXPECT_EQ(repeat_command(asset), "dgm-bake in/m.obj -o out/m.dgm --size 257x257");
}

TEST(RepeatCommand, GivesTheSameSettings) {
    expect_same("");
    expect_same("--size 257x257");  // of rings too
    expect_same("--size 129x65 --method lscm --fit best --precision u16 --layers normal,texture --bump-size 65");
    expect_same("--size auto:5000 --texture-size 512x256 --domain free --ablate newton,cut-search");
    expect_same("--max-error 0.05% --max-error-kind hausdorff");
    expect_same("--max-error 0.1 --size 257");  // the default size is not the default here
    expect_same("--budget 256KiB --size 129x257");
    expect_same("--budget 1MB --max-error 0.3333333333333333%");
    expect_same("--format dgm,exr --exr-layout multipart", true);
}

TEST(RepeatCommand, AsksForTheSameMeshes) {
    PlannedAsset asset{"m.obj", "", "out/m.exr", {}, "m.obj", {}};
    asset.exports = {"out/m.glb", "out/m.ply"};
    const CommandLine again = parsed(repeat_command(asset));
    EXPECT_FALSE(again.plan.write_dgm);
    EXPECT_TRUE(again.plan.write_exr);
    EXPECT_EQ(again.plan.exports, (std::vector<std::string>{".glb", ".ply"}));
}

TEST(RepeatCommand, NamesAreQuoted) {
    EXPECT_EQ(shell_word("a b"), "'a b'");
    EXPECT_EQ(shell_word("it's; rm $x"), "'it'\\''s; rm $x'");
    EXPECT_EQ(shell_word(""), "''");
    const PlannedAsset asset{"-x.obj", "-x.dgm", "", {}, "-x.obj", {}};
    EXPECT_EQ(repeat_command(asset), "dgm-bake ./-x.obj -o ./-x.dgm --size 257x257");
}

}  // namespace
}  // namespace dgm::bake
