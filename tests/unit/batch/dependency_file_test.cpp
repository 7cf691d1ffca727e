// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/dependency_file.h"

#include <gtest/gtest.h>

#include "model/codes.h"

namespace dgm::bake {
namespace {

TEST(DependencyFile, OneRuleAnAssetAndEmptyOnesForWhatMayGo) {
    EXPECT_EQ(dependency_file({{{"a.dgm", "a.exr"}, {"a.obj", "a.mtl", "skin.png"}}, {{"b.dgm"}, {"b.obj", "a.mtl"}}}),
              "a.dgm a.exr: \\\n  a.obj \\\n  a.mtl \\\n  skin.png\n"
              "b.dgm: \\\n  b.obj \\\n  a.mtl\n"
              "\na.mtl:\n\nskin.png:\n");
    EXPECT_EQ(dependency_file({{{}, {"refused.obj"}}}), "");
}

TEST(DependencyFile, EscapesWhatBothReadersUnderstand) {
    EXPECT_EQ(dependency_file({{{"a b.dgm"}, {"#1$.obj"}}}), "a\\ b.dgm: \\\n  \\#1$$.obj\n");
    // A backslash stands for itself but before an escaped character, where two stand for one.
    EXPECT_EQ(dependency_file({{{"a\\b.dgm"}, {"a\\ b.obj"}}}), "a\\b.dgm: \\\n  a\\\\\\ b.obj\n");
    EXPECT_THROW((void)dependency_file({{{"a\nb.dgm"}, {"a.obj"}}}), model::Error);
}

}  // namespace
}  // namespace dgm::bake
