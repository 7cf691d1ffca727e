// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stages.h
// The stages of a bake, each a function from one value to the next:
//
//   import -> Imported -> repair -> Repaired -> map -> Mapped -> fit -> Fitted -> layers -> Layered -> measure ->
//   Measured
//
// pipeline.h runs them in order. Lengths are in the normalised frame (repair.h) unless they say source units. Every
// stage is deterministic, whatever the number of threads, reports its progress, and throws model::Error kInterrupted
// when the progress asks it to stop.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "baking/component/candidates.h"
#include "baking/component/component_bake.h"
#include "baking/component/cut_memory.h"
#include "geometry/layers/layers.h"
#include "geometry/repair/repair.h"
#include "model/map_set.h"
#include "model/progress.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

/// Facts about the source that outputs and reports state.
struct SourceFacts {
    std::string name;                            ///< of the file, without its folder
    std::array<std::uint8_t, 16> source_hash{};  ///< MapSet::source_hash
    std::string inputs_hash;                     ///< BakeReport::inputs_hash
    std::uint64_t vertices = 0, faces = 0;
    std::vector<std::string> inputs, missing_inputs;  ///< BakeReport's
    std::vector<std::string> warnings, remarks;       ///< in plain language
    RepairCounts repairs;                             ///< changes by import and repair
};

/// A mesh as it came, in source units.
struct Imported {
    model::TriMesh mesh;
    SourceFacts facts;
};

/// Reads and hashes the mesh file, with what it names below its folder and `asset_roots`.
/// @throws model::Error as formats::read_mesh and hash_inputs
[[nodiscard]] Imported import_file(const std::filesystem::path& source,
                                   std::span<const std::filesystem::path> asset_roots = {});
/// Takes a mesh from memory; its content is hashed.
/// @throws model::Error kImportFailed if an index or the length of an array is wrong
[[nodiscard]] Imported import_mesh(model::TriMesh mesh, std::string name);

/// Oriented manifold components, and the pictures of their materials.
struct Repaired {
    Frame frame;
    std::vector<model::TriMesh> components;  ///< not empty; every corner has a normal
    std::vector<double> areas;               ///< of the components
    std::size_t largest = 0;                 ///< component
    std::vector<model::Material> materials;
    MaterialImages images;  ///< empty until load_images()
    SourceFacts facts;
};

/// @throws model::Error as repair(); kScaleOutOfRange
[[nodiscard]] Repaired repair_source(Imported imported);
/// Reads the pictures that the materials name, and `fabric` unless it is empty. A material's picture that cannot be
/// read becomes a warning.
/// @throws model::Error if `fabric` cannot be read
[[nodiscard]] MaterialImages load_images(std::span<const model::Material> materials,
                                         const std::filesystem::path& fabric, std::vector<std::string>& warnings);

/// One sampled chart a component.
struct Mapped {
    std::vector<ComponentResult> charts;
};

struct MapRequest {
    GridSize largest;                 ///< grid of the largest component
    std::span<const double> aspects;  ///< (rows - 1) : (cols - 1) of each component; 0: that of the largest
    CutUse use = CutUse::kSearch;
    std::span<const RingUse> rings{};  ///< of each component; empty: kTried
};

/// Cuts, parameterizes and samples every component. `cuts` has one memory a component.
/// @throws model::Error kTooLarge; the failure of a component that has no map
[[nodiscard]] Mapped map_source(const Repaired& source, const MapRequest& request, const BakeOptions& options,
                                std::span<CutMemory> cuts, const model::Progress& progress);

/// The charts with their samples where they are stored.
struct Fitted {
    std::vector<ComponentResult> charts;
    std::vector<std::size_t> inverted{};  ///< faces against the source, per chart; empty if none was fitted
    std::vector<std::uint64_t> looked{};  ///< at faces by the fits, per chart
};

/// Moves the samples closest to the source, as options.fit says. `u16`: to places that u16 positions have.
[[nodiscard]] Fitted fit_source(const Repaired& source, Mapped mapped, const BakeOptions& options, bool u16,
                                const model::Progress& progress);

/// Gives small components whose fit left inverted faces finer grids, up to the largest component's, and keeps those
/// with fewer inverted: a part that is small beside the rest of its asset may be too much for 17 samples a side. All
/// finer grids that are tried have at most 2 times as many samples as the largest component has.
[[nodiscard]] Fitted refine_inverted(const Repaired& source, const MapRequest& request, Fitted fitted,
                                     const BakeOptions& options, bool u16, std::span<CutMemory> cuts,
                                     const model::Progress& progress);

/// The layers of every chart, in source units.
struct Layered {
    std::vector<model::Chart> charts;
    double worst_quantisation = 0;  ///< half a step, source units; 0 for f32
};

/// Makes the layers `names` (empty: all that have data), and the geometry in any case, because it is measured.
[[nodiscard]] Layered store_layers(const Repaired& source, const Fitted& fitted, std::span<const std::string> names,
                                   const BakeOptions& options, bool u16, const model::Progress& progress);

/// Errors of the stored layers, in source units.
struct Measured {
    SurfaceError error;  ///< all charts against all components
    std::vector<ChartReport> charts;
};

[[nodiscard]] Measured measure_layers(const Repaired& source, const Fitted& fitted, const Layered& layered,
                                      std::uint64_t samples, const model::Progress& progress);

}  // namespace dgm::bake
