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

struct BatchPlan {
    std::filesystem::path folder;  ///< where outputs go; made if its parent exists
    std::vector<PlannedAsset> assets;
};

/// Which shard of `count` an asset belongs to, from 1: the one whose hash together with the name is largest (rendezvous
/// hashing [Thaler and Ravishankar 1998]). So an asset stays where it is when others are added, and when there is one
/// shard more, only those that go to it move.
[[nodiscard]] unsigned shard_of(std::string_view name, unsigned count);

/// Leaves the assets of one shard, in their order. Outputs are named as if there were no shards.
void keep_shard(BatchPlan& plan, Shard shard);

/// Folders are searched recursively for OBJ and 3DS files, the formats dgm-bake answers for; other formats that the
/// importer reads (PLY, STL, OFF, glTF, ...) are baked when named. Hidden files and folders are skipped, links to
/// folders not followed, a file met twice is baked once. The order is that of the inputs, inside a folder the byte
/// order of the relative paths.
///
/// An input that does not exist and has `*`, `?` or `[` in it is a pattern, for shells that did not expand it: `**`
/// stands for any number of folders. It names the mesh files it matches, of every format, and is otherwise treated like
/// the folder in front of its first wildcard.
///
/// `a/stomach.obj` becomes `stomach.dgm`; below an input folder the relative path is kept. Where two assets would
/// write the same file, each of them keeps its extension (`x.obj.dgm`, `x.3ds.dgm`); where that is not enough, each
/// goes below a folder named like the input folder (for a file: the folder it is in).
///
/// Every asset gets `options`.
///
/// @throws model::Error kUsage: one output file for several assets, an output that is an input, two assets that still
///         write one file, an output named like a mesh; kReadFailed: an input folder that cannot be listed
[[nodiscard]] BatchPlan plan_batch(const PlanRequest& request, const BakeOptions& options = {});

}  // namespace dgm::bake
