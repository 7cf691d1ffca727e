// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/repeat_command.h
#pragma once
#include <string>
#include <string_view>

#include "pipeline/batch_plan.h"

namespace dgm::report {

/// The command line that bakes this asset alone, with these options, into these files: for a POSIX shell in the folder
/// where the batch ran. Options that are at their defaults are left out.
[[nodiscard]] std::string repeat_command(const bake::PlannedAsset& asset);

/// One word of a POSIX shell.
[[nodiscard]] std::string shell_word(std::string_view text);

}  // namespace dgm::report
