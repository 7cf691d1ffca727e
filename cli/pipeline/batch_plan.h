// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/batch_plan.h
// Which assets a command line names, and which files they become.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "model/error.h"

namespace dgm::bake {

struct PlanRequest {
    std::vector<std::filesystem::path> inputs;  ///< files and folders, in the order given
    std::filesystem::path output;               ///< -o; empty: the current folder
    bool output_is_folder = false;              ///< -o ended in a slash
    bool write_dgm = true, write_exr = false;
};

struct PlannedAsset {
    std::filesystem::path source;
    std::filesystem::path dgm, exr;       ///< final names; empty: not asked for
    std::optional<model::Error> refusal;  ///< set if there is nothing to start: a missing file, a folder without meshes
};

struct BatchPlan {
    std::filesystem::path folder;  ///< where outputs go; made if its parent exists
    std::vector<PlannedAsset> assets;
};

/// Folders are searched recursively for OBJ and 3DS files, the formats dgm-bake answers for; other formats that the
/// importer reads (PLY, STL, OFF, glTF, ...) are baked when named. Hidden files and folders are skipped, links to
/// folders not followed, a file met twice is baked once. The order is that of the inputs, inside a folder the byte
/// order of the relative paths.
///
/// `a/stomach.obj` becomes `stomach.dgm`; below an input folder the relative path is kept. Where two assets would
/// write the same file, each of them keeps its extension (`x.obj.dgm`, `x.3ds.dgm`); where that is not enough, each
/// goes below a folder named like the input folder (for a file: the folder it is in).
///
/// @throws model::Error kUsage: one output file for several assets, an output that is an input, two assets that still
///         write one file, an output named like a mesh; kReadFailed: an input folder that cannot be listed
[[nodiscard]] BatchPlan plan_batch(const PlanRequest& request);

}  // namespace dgm::bake
