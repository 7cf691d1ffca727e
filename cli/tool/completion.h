// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/completion.h
// Shell completions beside the one for bash (help.h): option names with what they are for, words of options whose type
// lists them, file names elsewhere.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace dgm::tool {

/// A function for zsh's completion system, to be installed as _PROGRAM in a folder of $fpath.
[[nodiscard]] std::string zsh_completion(const CLI::App& app);

/// Commands for fish, to be installed as PROGRAM.fish in a folder of $fish_complete_path.
[[nodiscard]] std::string fish_completion(const CLI::App& app);

}  // namespace dgm::tool
