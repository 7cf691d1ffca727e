// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/mesh_files.h
// Maps as files of triangles: OBJ with materials, PLY, GLB.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "export/export_files.h"
#include "export/staging_folder.h"

namespace dgm::exporter {

/// Writes `maps`, whose charts are called `names`, as an .obj, .ply or .glb, by the extension of `output`, and what
/// goes beside it. @throws as export_maps
void write_mesh_files(const model::MapSet& maps, const std::vector<std::string>& names,
                      const std::filesystem::path& output, const ExportOptions& options, StagingFolder& staging);

/// The options that a mesh file's bytes depend on, as a stable text; empty for the defaults.
[[nodiscard]] std::string mesh_settings(const ExportOptions& options);

}  // namespace dgm::exporter
