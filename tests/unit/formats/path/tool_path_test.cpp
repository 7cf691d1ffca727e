// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/path/tool_path_test.cpp
#include "path/tool_path.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "model/codes.h"
#include "model/error.h"

namespace dgm::formats {
namespace {

ToolPath path_of(const std::string& text) {
    std::istringstream in(text);
    return ToolPath(in, "strokes.txt");
}

/// The message and place of the refusal; empty: it was taken.
std::string refusal(const std::string& text) {
    try {
        path_of(text);
    } catch (const model::Error& error) { return error.place() + ": " + error.what(); }
    return {};
}

TEST(ToolPathFile, OneToolIsAsEver) {
    const ToolPath path = path_of("# Size 3, d_max 4\n\n0.5 1 2 3 touch at rest\n0.7 1 2 5 grasp\n0.8 0 0 0 away\n");
    ASSERT_EQ(path.tool_count(), 1u);
    EXPECT_EQ(path.knots()[0].caption, "at rest");
    EXPECT_EQ(path.touch_size()->size, 3);
    const Knot between = path.at(0.6);
    EXPECT_EQ(between.kind, ToolKind::Touch);  // what the knot behind it says
    EXPECT_FLOAT_EQ(between.position.z, 4);
    EXPECT_TRUE(between.caption.empty());
    EXPECT_TRUE(path.at(0.75).engaged);
    EXPECT_FALSE(path.at(0.8).engaged);
}

TEST(ToolPathFile, ToolsMoveOnTheirOwn) {
    const ToolPath path =
        path_of("0 0 0 0 touch\n0.2 8 0 0 grasp:3\n0.4 4 0 0 touch\n0.4 8 2 0 grasp:3 both\n0.6 8 2 0 away:3\n");
    ASSERT_EQ(path.tool_count(), 3u);
    EXPECT_FLOAT_EQ(path.at(0.3, 0).position.x, 3);
    EXPECT_FLOAT_EQ(path.at(0.3, 2).position.y, 1);
    EXPECT_EQ(path.at(0.3, 2).kind, ToolKind::Grasp);
    EXPECT_EQ(path.at(0.3, 2).tool, 2u);
    // A tool is away before its first knot, and stays where its last one left it; one without knots is always away.
    EXPECT_FALSE(path.at(0.1, 2).engaged);
    EXPECT_FLOAT_EQ(path.at(0.1, 2).position.x, 8);
    EXPECT_TRUE(path.at(0.6, 0).engaged);
    EXPECT_FLOAT_EQ(path.at(0.6, 0).position.x, 4);
    EXPECT_FALSE(path.at(0.3, 1).engaged);
}

TEST(ToolPathFile, ReplayGivesAKnotToEachToolAndCaptionsOfAll) {
    const ToolPath path = path_of("0 0 0 0 touch first\n0.1 0 0 0 poke:2\n0.2 0 0 1 poke:2 second\n0.3 3 0 0 touch\n");
    std::size_t ticks = 0;
    std::string said;
    path.replay(
        0.1,
        [&](std::span<const Knot> tools, float) {
            ASSERT_EQ(tools.size(), 2u);
            EXPECT_FLOAT_EQ(tools[0].position.x, static_cast<float>(ticks));
            EXPECT_EQ(tools[1].engaged, ticks > 0);
            ++ticks;
        },
        [&](const std::string& caption) { said += caption + " after " + std::to_string(ticks) + ". "; });
    EXPECT_EQ(ticks, 4u);
    EXPECT_EQ(said, "first after 1. second after 3. ");
}

TEST(ToolPathFile, SaysWhichLineIsWrong) {
    EXPECT_EQ(refusal("0 0 0 0 touch\n0 0 0 1 grasp:2\n"), "");  // at the same time
    const std::string good = "0 0 0 0 touch\n0.5 0 0 1 grasp:2\n";
    for (const auto& [line, why] : {std::pair{"0.4 0 0 1 touch", "go back"},
                                    {"0.5 0 0 1 grasp:2", "increase"},
                                    {"0.6 0 0 1 grasp:5", "\"grasp:5\""},
                                    {"0.6 0 0 1 grasp:0", "\"grasp:0\""},
                                    {"0.6 0 0 1 grasp:", "\"grasp:\""},
                                    {"0.6 0 0 1 grasp:2x", "\"grasp:2x\""},
                                    {"0.6 0 0 1 :2", "\":2\""},
                                    {"0.6 0 0 1 hold:2", "\"hold:2\""},
                                    {"0.6 0 0 grasp:2", "SECONDS X Y Z KIND"},
                                    {"9999 0 0 0 touch", "hour"}}) {
        const std::string said = refusal(good + line + "\n");
        EXPECT_NE(said.find("strokes.txt:3"), std::string::npos) << line << ": " << said;
        EXPECT_NE(said.find(why), std::string::npos) << line << ": " << said;
    }
    EXPECT_NE(refusal("# nothing\n").find("empty"), std::string::npos);
}

}  // namespace
}  // namespace dgm::formats
