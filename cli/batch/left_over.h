// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/left_over.h
// Maps of ours that no mesh of a batch becomes any more: its mesh is gone, or has another output now.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "batch/batch_plan.h"
#include "batch/batch_runner.h"

namespace dgm::bake {

struct LeftOver {
    std::filesystem::path path;
    std::string source_name;            ///< of the mesh it was baked from
    std::filesystem::path replacement;  ///< what that mesh becomes now; empty: there is no such mesh any more
    bool removed = false;
};

/// Looks through the output folder of `plan` where it was named (`searches_folder`) and folders or patterns were
/// searched for meshes; else only for other names that the outputs may have had. A file is left over if its content
/// says that dgm-bake made it, no asset has its name, and its mesh is gone from where its place in the output folder
/// says it was, or becomes another file. Sorted by path. Where an input could not be found or searched nothing is left
/// over: a disk may not be mounted.
[[nodiscard]] std::vector<LeftOver> find_left_over(const BatchPlan& plan, bool searches_folder);

/// Removes the files whose mesh is gone, and those whose replacement is in place as `results` of the plan say. What
/// cannot be removed stays, and is not marked.
void prune(std::vector<LeftOver>& files, const std::vector<AssetResult>& results);

}  // namespace dgm::bake
