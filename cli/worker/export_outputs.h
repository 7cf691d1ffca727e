// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/export_outputs.h
// Meshes that a bake writes beside its map. A mesh may be several files, whose names only its writer knows: a worker
// puts them into a folder of their own, from which the parent takes them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "model/map_set.h"

namespace dgm::bake {

/// Writes `maps` to each of `exports` (.obj, .ply, .glb), with what goes beside it. @throws as exporter::export_maps;
/// kNoSpace or kIoTrouble where that is why
void write_exports(const model::MapSet& maps, const std::vector<std::filesystem::path>& exports);

struct ExportedFile {
    std::filesystem::path temporary, final_path;
    std::uint64_t bytes = 0;
};

/// The files that a worker left in `folder` for the output `final_path`, in the order of their names but that one last,
/// since it names the others.
/// @throws model::Error kWriteFailed if that one is not there; kUsage if one of `inputs` would be overwritten
[[nodiscard]] std::vector<ExportedFile> exported_files(const std::filesystem::path& folder,
                                                       const std::filesystem::path& final_path,
                                                       const std::vector<std::filesystem::path>& inputs);

}  // namespace dgm::bake
