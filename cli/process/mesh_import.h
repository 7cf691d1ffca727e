// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/mesh_import.h
// formats::read_mesh in a disposable process, for programs that read an untrusted mesh beside their real work: a crash
// of the importer costs them one finding.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/mesh_reader.h"
#include "model/error.h"

namespace dgm::bake {

/// formats::read_mesh, or a test's replacement.
using MeshReader =
    std::function<formats::ImportedMesh(const std::filesystem::path&, const formats::MeshReadLimits& limits)>;

struct ImportLimits {
    double seconds = 600;                                 ///< wall clock
    std::uint64_t memory_bytes = std::uint64_t{8} << 30;  ///< address space of the worker beside its own program
    std::vector<std::filesystem::path> asset_roots = {};  ///< folders beside the mesh's that hold files it may name
};

/// Starts this program again as a worker (ChildProcess), which must call import_worker() first of all, and takes over
/// the mesh that it reads in a sandbox (sandbox.h). Its messages are not trusted: counts, indices and the folders of
/// pictures are checked.
/// Thread-safe.
/// @throws model::Error as read_mesh; kWorkerCrashed, kWorkerTimeout, kWorkerMemory, kWorkerKilled; kSystemBusy
[[nodiscard]] formats::ImportedMesh import_apart(const std::filesystem::path& path, const ImportLimits& limits = {});

/// For main() before anything else: nothing, unless the arguments are those of a worker. Then reads the mesh that the
/// job names, sends it, and gives the exit code.
[[nodiscard]] std::optional<int> import_worker(int argc, const char* const* argv, const MeshReader& read = {});

/// A worker's answer as bytes: a mesh, or an error as encode_error() has it.
[[nodiscard]] std::string encode_import(const formats::ImportedMesh& mesh);
/// nullopt for bytes that are neither, or a mesh whose faces or corners do not fit together.
/// @throws model::Error the one that was sent
[[nodiscard]] std::optional<formats::ImportedMesh> decode_import(std::string_view bytes);

}  // namespace dgm::bake
