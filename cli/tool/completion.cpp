// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/completion.cpp
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tool/help.h"
#include "tool/option_rows.h"

namespace dgm::tool {
namespace {

/// The words after `--` of a program or of one of its commands, and for bash the cases of options that take a value.
struct Completion {
    std::string words, cases;
};

Completion completion_of(const CLI::App& app) {
    Completion out;
    for (const OptionRow& row : option_rows(app)) {
        out.words += fmt::format("{}{}", out.words.empty() ? "" : " ", fmt::join(row.names, " "));
        if (row.value.empty()) continue;
        const std::vector<std::string> listed = listed_words(row);
        out.cases += fmt::format("        {}) ", fmt::join(row.names, "|"));
        if (!listed.empty())
            out.cases += fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$current\"))", fmt::join(listed, " "));
        else
            out.cases +=
                takes_file(row)
                    ? "local IFS=$'\\n'; COMPREPLY=($(compgen -f -- \"$current\")); compopt -o filenames 2>/dev/null"
                    : "COMPREPLY=()";
        out.cases += "; return ;;\n";
    }
    return out;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
    const std::string& name = app.get_name();
    std::string function = "_" + name;
    std::replace(function.begin(), function.end(), '-', '_');
    const Completion own = completion_of(app);
    std::string text = "# Completion of " + name + " for bash.\n" + function +
                       "() {\n    local current=\"$2\" previous=\"$3\" words=\"" + own.words + "\"\n" +
                       "    case \"$previous\" in\n" + own.cases + "    esac\n";
    const std::vector<const CLI::App*> commands = commands_of(app);
    std::string names;
    if (!commands.empty()) text += "    case \"${COMP_WORDS[1]}\" in\n";
    for (const CLI::App* command : commands) {
        const Completion its = completion_of(*command);
        names += (names.empty() ? "" : " ") + command->get_name();
        text += "    " + command->get_name() + ")\n    words=\"" + its.words + "\"\n    case \"$previous\" in\n" +
                its.cases + "    esac ;;\n";
    }
    if (!commands.empty())
        text +=
            "    esac\n    if [[ \"$COMP_CWORD\" == 1 && \"$current\" != -* ]]; then\n        COMPREPLY=($(compgen -W "
            "\"" +
            names + "\" -- \"$current\"))\n        return\n    fi\n";
    return text +
           "    if [[ \"$current\" == -* ]]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n" +
           "    else\n        local IFS=$'\\n'; COMPREPLY=($(compgen -f -- \"$current\"))\n" +
           "        compopt -o filenames 2>/dev/null\n    fi\n}\ncomplete -F " + function + " " + name + "\n";
}

}  // namespace dgm::tool
