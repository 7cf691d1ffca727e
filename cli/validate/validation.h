// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/validation.h
// Every check of a .dgm, as a list of findings.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dgm/dgm_reader.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/metrics/surface_error.h"
#include "model/tri_mesh.h"

namespace dgm::validate {

/// The mesh that a file is compared with.
struct Source {
    std::filesystem::path path;
    std::array<std::uint8_t, 16> hash{};  ///< XXH3-128 of the file
    model::TriMesh mesh;
    model::TriMesh oriented;  ///< repaired, windings made to agree, as a bake sees it; empty where repair refuses
    std::vector<bake::Topology> topologies;  ///< of each piece of `oriented`
};
/// Reads a mesh file: formats::read_mesh, or the same in a process of its own.
using MeshReader = std::function<model::TriMesh(const std::filesystem::path&)>;
/// @throws model::Error as formats::read_mesh, or as `read`
[[nodiscard]] Source load_source(const std::filesystem::path& path, const MeshReader& read = {});

struct Options {
    const Source* source = nullptr;       ///< null: no comparison with a source
    std::filesystem::path source_folder;  ///< else, if not empty: where the mesh called source_name lies
    MeshReader read_mesh;                 ///< for meshes of `source_folder`; none: formats::read_mesh
    std::optional<double> max_rms_percent, max_hausdorff_percent;  ///< of the source's bounding-box diagonal
    bake::SurfaceErrorOptions sampling;
    std::uint64_t max_layer_bytes = std::uint64_t{64} << 30;  ///< of all layers of a .dgm together
};

/// Outcome for one file.
struct FileValidation {
    std::filesystem::path path;
    std::vector<formats::Finding> findings;   ///< in the order of the checks; empty for a good file
    std::vector<formats::Finding> known;      ///< findings that a baseline lists: printed, but not counted
    std::size_t charts = 0;                   ///< 0 if the container could not be read
    std::optional<bake::SurfaceError> error;  ///< measured, if there was a source
    std::optional<std::size_t> turned_faces;  ///< the same, if its faces can be oriented
    /// kOk if no finding is an error; else that of the worst.
    [[nodiscard]] model::ExitCode exit_code() const;
};

/// Container and hashes, then each layer, the reconstruction, the report, and the distance to the source: each step
/// only if its input passed the one before. Without limits in `options` the distance may reach the report's claim plus
/// 1 % (rms) or 5 % (hausdorff).
///
/// A file that starts like an EXR is read as one. Never throws model::Error: a file that is missing or unreadable is a
/// finding too. Deterministic. Thread-safe; HDF5 reads one file at a time.
[[nodiscard]] FileValidation validate_file(const std::filesystem::path& path, const Options& options = {});

/// The same from the layers on, for maps in memory: a baker checks its own result by it. `path` stays empty.
[[nodiscard]] FileValidation validate_maps(const model::MapSet& maps, const Options& options = {});

/// The first error that validate_maps() finds, for programs that use maps of strangers; nothing if they are sound. Maps
/// of 257 x 257 samples take 50 ms.
[[nodiscard]] std::optional<model::Error> first_error(const model::MapSet& maps);

}  // namespace dgm::validate
