// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/batch_plan.h
// Which assets a command line names, and which files they become.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baking/bake_options.h"
#include "model/error.h"

namespace dgm::bake {

struct PlanRequest {
    std::vector<std::filesystem::path> inputs;  ///< files, folders and patterns, in the order given
    std::filesystem::path output;               ///< -o; empty: the current folder
    bool output_is_folder = false;              ///< -o ended in a slash
    bool write_dgm = true, write_exr = false;
    std::vector<std::string> exports = {};  ///< meshes beside the map, as extensions: ".glb"
};

/// One job: what is baked, with which options, into which files.
struct PlannedAsset {
    std::filesystem::path source;
    std::filesystem::path dgm, exr;       ///< final names; empty: not asked for
    std::optional<model::Error> refusal;  ///< set if there is nothing to start: a missing file, a folder without meshes
    std::string name;  ///< path below the input folder, the same on every machine: "organs/liver.obj"
    BakeOptions options;
    std::vector<std::filesystem::path> exports = {};  ///< final names of meshes that are made of the map
};

/// Every file that an asset becomes, the map first. What goes beside an .obj (materials, textures) is not among them.
[[nodiscard]] std::vector<std::filesystem::path> outputs_of(const PlannedAsset& asset);

/// One part of a batch that is spread over machines: `number` of `count`, from 1.
struct Shard {
    unsigned number = 1, count = 1;
};

/// A mesh file that a folder or pattern holds and that is not baked.
struct LeftOutFile {
    std::filesystem::path path;
    std::string why;  ///< a remark: "there is no importer for it: export it as GLB, FBX or OBJ"
};

struct BatchPlan {
    std::filesystem::path folder;  ///< where outputs go; made with its parents
    std::vector<PlannedAsset> assets;
    std::vector<LeftOutFile> left_out;         ///< in the order of the search
    std::vector<std::filesystem::path> roots;  ///< folders that were searched, those of patterns too
    bool names_output = false;                 ///< -o names the one output file, so nothing was derived
};

/// Which shard of `count` an asset belongs to, from 1: the one whose hash together with the name is largest (rendezvous
/// hashing [Thaler and Ravishankar 1998]). So an asset stays where it is when others are added, and when there is one
/// shard more, only those that go to it move.
[[nodiscard]] unsigned shard_of(std::string_view name, unsigned count);

/// Leaves the assets of one shard, in their order. Outputs are named as if there were no shards.
void keep_shard(BatchPlan& plan, Shard shard);

/// Folders are searched recursively for meshes of every format that is tested (mesh_formats.h); other mesh files are
/// listed in `left_out`, and baked when named. Hidden files and folders are skipped, links to folders not followed, a
/// file met twice is baked once. The order is that of the inputs, inside a folder the byte order of the relative paths.
///
/// An input that does not exist and has `*`, `?` or `[` in it is a pattern, for shells that did not expand it: `**`
/// stands for any number of folders. It is treated like the folder in front of its first wildcard.
///
/// `a/stomach.obj` becomes `stomach.dgm`; below an input folder the relative path is kept. Where meshes of several
/// formats share a stem, the first in the order of mesh_rank() has the plain name and the others keep their extension:
/// `x.dgm` is made from `x.obj`, `x.3ds.dgm` from `x.3ds`. The files beside a mesh on disk decide that, so its output
/// has the same name whatever else is baked. Where outputs from several folders would still share a name, each goes
/// below a folder named like its input folder (for a file: the folder it is in).
///
/// Every asset gets `options`.
///
/// @throws model::Error kUsage: one output file for several assets, an output that is an input, two assets that still
///         write one file, an output named like a mesh; kReadFailed: an input folder that cannot be listed
[[nodiscard]] BatchPlan plan_batch(const PlanRequest& request, const BakeOptions& options = {});

}  // namespace dgm::bake
