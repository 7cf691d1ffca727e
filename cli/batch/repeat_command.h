// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/repeat_command.h
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "batch/batch_plan.h"

namespace dgm::bake {

/// The command line that bakes this asset alone, with these options, into these files: for a POSIX shell in the folder
/// where the batch ran. Options that are at their defaults are left out.
[[nodiscard]] std::string repeat_command(const PlannedAsset& asset);

/// The same for an asset of a scene file, whose wishes have no options: the whole scene, which leaves alone what is up
/// to date.
[[nodiscard]] std::string repeat_scene_command(const std::filesystem::path& scene, const std::filesystem::path& folder);

/// One word of a POSIX shell.
[[nodiscard]] std::string shell_word(std::string_view text);

}  // namespace dgm::bake
