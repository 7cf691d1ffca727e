// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/bake_mesh.h
// Bakes a mesh from memory, for programs that embed the bake: no process is started and no file is written.
//
//   std::atomic<bool> stop = false;
//   model::Progress progress;
//   progress.on_update = [](std::string_view stage, double share) { ... };
//   progress.cancelled = &stop;
//   const BakeResult result = bake_mesh({mesh, "stomach"}, {.size = {129, 129}}, progress);
//   formats::write_dgm(result.maps, path);  // if a file is wanted
//
// stages.h has the single stages, for callers who stand between two of them.
#pragma once
#include <optional>
#include <string>

#include "baking/bake_options.h"
#include "baking/bake_result.h"
#include "geometry/layers/layers.h"
#include "model/progress.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

struct MeshInMemory {
    model::TriMesh mesh;  ///< source units
    std::string name;     ///< MapSet::source_name; may be empty
    /// Pictures of the materials, and the fabric. nullopt: the files that the materials and options.texture name are
    /// read.
    std::optional<MaterialImages> images = std::nullopt;
};

/// Bakes as bake_asset() does a file: the same mesh and options give the same layers. MapSet::source_hash is the hash
/// of the mesh's content.
///
/// @param options   options.budget_bytes needs options.scratch, a file to measure the size with
/// @param progress  on_update is called with the stage and its share done, one call at a time, but not always on the
///                  caller's thread. `cancelled` may be set from any thread; the bake then ends within 100 ms.
/// @throws model::Error with the stage's name; kInterrupted if it was cancelled, kImportFailed if an index or the
/// length
///         of an array is wrong
[[nodiscard]] BakeResult bake_mesh(MeshInMemory source, const BakeOptions& options = {},
                                   const model::Progress& progress = {});

}  // namespace dgm::bake
