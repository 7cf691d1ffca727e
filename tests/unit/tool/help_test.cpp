// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/tool/help_test.cpp
#include "tool/help.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "model/codes.h"
#include "model/file_errors.h"
#include "tool/option_rows.h"
#include "tool/tool.h"

namespace dgm::tool {
namespace {

constexpr std::array kExamples{Example{"oven pie.obj", "bakes a pie"}, Example{"oven clean --hot", "cleans itself"}};
constexpr std::array kFiles{Term{"PIE.log", "what happened"}};
constexpr std::array kKeys{Term{"filling", "what is in it"}, Term{"heat", "degrees"}};
constexpr std::array kSections{
    Section{"Recipes", "A recipe says what a pie is made of.", "filling = \"plum\"", kKeys, "docs/recipes.md"}};

Manual manual() {
    return {.synopsis = "oven [OPTIONS] PIE...\noven clean [OPTIONS]",
            .sections = kSections,
            .examples = kExamples,
            .files = kFiles,
            .environment = {},
            .exit_codes = "0    baked\n1    burnt",
            .see_also = "grill(1)"};
}

/// A program with one option of each kind and one command.
class Oven : public testing::Test {
 protected:
    Oven() {
        app_.add_option("PIE", pies_, "pies to bake")->type_name("");
        const Group heat(app_, "Heat");
        heat.number("-t,--heat", "N", degrees_, "degrees")->check(CLI::Range(1, 300))->capture_default_str();
        heat.text("--side", "top|bottom", side_, "where it comes from [top]")->check(CLI::IsMember({"top", "bottom"}));
        heat.flag("--fan", fan_, std::string(200, 'x') + " yy");
        CLI::App* clean = app_.add_subcommand("clean", "clean it");
        Group(*clean, "Heat").flag("--hot", hot_, "with pyrolysis");
        present(app_, "oven", manual());
    }
    CLI::App app_{"Bakes pies."};
    std::vector<std::string> pies_;
    int degrees_ = 180;
    std::string side_;
    bool fan_ = false, hot_ = false;
};

bool holds(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST_F(Oven, RowsDropTheRulesOfTheParserAndShowDefaults) {
    const std::vector<OptionRow> rows = option_rows(app_);
    ASSERT_EQ(rows.size(), 5u);  // and -h, -V
    EXPECT_EQ(rows[0].names, (std::vector<std::string>{"-t", "--heat"}));
    EXPECT_EQ(rows[0].value, "N");
    EXPECT_EQ(rows[0].text, "degrees [180]");
    EXPECT_EQ(rows[1].value, "top|bottom");
    EXPECT_EQ(rows[1].text, "where it comes from [top]");
    EXPECT_EQ(rows[2].value, "");
    EXPECT_EQ(groups_of(rows), (std::vector<std::string>{"Heat", kWhatItTells}));
    ASSERT_EQ(argument_rows(app_).size(), 1u);
    EXPECT_EQ(argument_rows(app_)[0].names.front(), "PIE...");
}

TEST_F(Oven, HelpHasItsPartsInOrder) {
    const std::string help = help_text(app_, manual());
    std::size_t at = 0;
    for (const char* part :
         {"Bakes pies.\n", "\nUsage: oven [OPTIONS] PIE...\n       oven clean [OPTIONS]\n", "\nArguments:\n",
          "\nCommands:\n", "oven COMMAND --help\n", "\nHeat:\n", "\n  -t,--heat N                 degrees [180]\n",
          "\nWhat it tells:\n", "\nRecipes:\n", "\n      filling = \"plum\"\n",
          "Keys: filling, heat. Their meanings: man oven, or docs/recipes.md\n", "\nExamples:\n",
          "\n  oven pie.obj\n      bakes a pie\n", "\nFiles:\n", "\nEnvironment:\n  No variable",
          "\nExit codes:\n  0    baked\n  1    burnt\n"}) {
        const std::size_t found = help.find(part, at);
        ASSERT_NE(found, std::string::npos) << part << "\n" << help;
        at = found;
    }
    EXPECT_EQ(app_.help(), help);
}

TEST_F(Oven, HelpBreaksLinesAtSpacesAlone) {
    std::size_t longest = 0, begin = 0;
    const std::string help = help_text(app_, manual());
    for (std::size_t end = help.find('\n'); end != std::string::npos; begin = end + 1, end = help.find('\n', begin)) {
        longest = std::max(longest, end - begin);
        EXPECT_FALSE(end > begin && help[end - 1] == ' ') << help.substr(begin, end - begin);
    }
    EXPECT_EQ(longest, 230u) << "a word of 200 letters stays whole, in its column";
    EXPECT_TRUE(holds(help, std::string(200, 'x') + "\n" + std::string(30, ' ') + "yy\n"));
}

TEST_F(Oven, HelpOfACommandIsAboutThatCommand) {
    const CLI::App* clean = app_.get_subcommand("clean");
    const std::string help = help_text(*clean, manual());
    EXPECT_TRUE(help.starts_with("Clean it.\n\nUsage: oven clean [OPTIONS]\n")) << help;
    EXPECT_TRUE(holds(help, "\n  oven clean --hot\n      cleans itself\n"));
    EXPECT_FALSE(holds(help, "pie.obj"));
    EXPECT_FALSE(holds(help, "--fan"));
    EXPECT_TRUE(holds(help, "\nExit codes:\n"));
}

TEST_F(Oven, PageAndCompletionKnowEveryOption) {
    const std::string page = man_page(app_, manual(), "1.2"), completion = bash_completion(app_);
    for (const OptionRow& row : option_rows(app_)) EXPECT_TRUE(holds(completion, row.names.back())) << row.names.back();
    EXPECT_TRUE(holds(page, ".TP\n\\fB\\-t\\fR, \\fB\\-\\-heat\\fR \\fIN\\fR\ndegrees [180]\n")) << page;
    EXPECT_TRUE(holds(page, ".SH RECIPES\n"));
    EXPECT_TRUE(holds(page, ".TP\n.B filling\nwhat is in it\n"));
    EXPECT_TRUE(holds(page, ".SH COMMANDS\n.SS clean\nclean it\n"));
    EXPECT_TRUE(holds(completion, "--side) COMPREPLY=($(compgen -W \"top bottom\"")) << completion;
}

TEST_F(Oven, UnknownOptionsNameTheNearest) {
    EXPECT_EQ(unknown_option(app_, "--heta=3"),
              "there is no option --heta; did you mean --heat?\nsee all with: oven --help");
    EXPECT_EQ(unknown_option(app_, "--broil"), "there is no option --broil\nsee all with: oven --help");
}

TEST(Words, TwoSlipsAreForgivenThreeAreNot) {
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
    EXPECT_EQ(edit_distance("", "abc"), 3u);
    EXPECT_EQ(nearest("nomral", {"normal", "texture"}), "normal");
    EXPECT_EQ(nearest("nrmola", {"normal"}), "");  // four edits
    EXPECT_EQ(nearest("ab", {"cd"}), "") << "nothing of it is left";
    EXPECT_EQ(unknown_word("fit", "bets", {"l2", "best"}),
              "there is no fit \"bets\"; did you mean best?\nthere are: l2, best");
}

TEST(ErrorText, NamesTheFileOnceAndThePlaceBelow) {
    const model::Error inside(model::codes::kHashMismatch, "stored bytes differ", "/charts/0/normal");
    EXPECT_EQ(error_text("oven", "x.dgm", inside),
              "oven: x.dgm: DGM1003: stored bytes differ\n  at: /charts/0/normal\n  next: " +
                  std::string(model::codes::kHashMismatch.hint) + "\n");
    // A fault of a file is about that file, whichever one was worked on.
    const std::string missing = "oven: y.obj: DGM5001: there is no such file\n  next: check the path\n";
    EXPECT_EQ(error_text("oven", "x.dgm", model::missing_file("y.obj")), missing);
    EXPECT_EQ(error_text("oven", "", model::missing_file("y.obj")), missing);
    EXPECT_EQ(error_text("oven", "", model::Error(model::codes::kUsage, "one\ntwo")),
              "oven: DGM6001: one\n  two\n  next: see --help\n");
}

TEST(Version, IsTheProjectsWithTheCommitIfThereIsOne) {
    EXPECT_TRUE(build_version().starts_with(kVersion));
    EXPECT_EQ(build_version().size() > kVersion.size(), !commit().empty());
    EXPECT_EQ(version_line("oven"), "oven " + build_version());
}

}  // namespace
}  // namespace dgm::tool
