// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/layers.h
// Turns a sampled chart into the layers of the file (docs/design.md section 4, formats/SPEC.md): one .cpp per layer.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/repair/repair.h"
#include "image/image.h"
#include "model/map_set.h"
#include "model/octahedral.h"
#include "model/progress.h"

namespace dgm::bake {

struct MatchedPoint;  // source_match.h

/// How positions are stored: source = offset + scale * stored. Local coordinates are scale * stored, in source units.
struct StoredFrame {
    std::array<double, 3> offset{};
    std::array<double, 3> scale{1, 1, 1};
    bool quantised = false;  ///< u16 rather than f32
};

/// f32: scale 1, offset 0 unless the asset lies farther from the origin than 8 diagonals, then its centre.
/// u16: one step per chart, offset its lowest corner. Asset-wide input, so that the charts of an asset share a frame.
[[nodiscard]] StoredFrame choose_frame(const Frame& frame, const SampledChart& chart, bool quantised);

/// Images of the asset's materials, decoded once; entries may be empty (no texture, or missing).
struct MaterialImages {
    std::vector<std::optional<formats::Image>> colour;       ///< per material
    std::vector<std::optional<formats::FloatImage>> height;  ///< per material; 0..1
    std::optional<formats::Image> fabric;                    ///< --texture: replaces colour, laid once over the chart
};

struct LayerInput {
    const SampledChart& chart;
    const Frame& frame;
    const StoredFrame& stored;
    const MaterialImages& images;
    const SampleGrid& fine;  ///< where the surface at (2m-1) x (2n-1) lies on the source
    std::optional<std::pair<std::uint32_t, std::uint32_t>> texture_size;
    /// Samples have moved off the map (fit.h): look up by closest point, not by (u, v), and fit the other layers too.
    bool fitted = false;
    std::optional<std::pair<std::uint32_t, std::uint32_t>> bump_size = std::nullopt;  ///< default: that of `fine`
};

/// Stored positions of all samples, and their decoded values: local coordinates, source units, equal bits within a
/// class.
struct StoredPositions {
    model::Layer geometry;                        ///< [m][n][3]
    std::optional<model::Layer> border_geometry;  ///< [k][3] f32, free domain
    std::vector<Vec3d> local;                     ///< per sample, border samples after the grid
    double worst_quantisation = 0;                ///< half a step, source units; 0 for f32
};
[[nodiscard]] StoredPositions store_positions(const LayerInput& in);

/// Gives every corner without a normal the area-weighted normal of its vertex, so that edges split later interpolate
/// it.
void complete_normals(TriMesh& mesh);

/// Unit normals of all samples, decoded from their octahedral codes, and the layers `normal`, `border_normal`.
struct StoredNormals {
    model::Layer normal;
    std::optional<model::Layer> border_normal;
    std::vector<Vec3d> decoded;
};
[[nodiscard]] StoredNormals store_normals(const LayerInput& in);
/// The code of a sample by that of its representative: of the opposite direction where the copy is reversed.
[[nodiscard]] model::OctahedralCode sample_code(const SampledChart& chart, std::size_t sample,
                                                model::OctahedralCode code);

/// u8 [mt][nt][4]; nothing if the asset has neither textures nor colours nor a material colour.
/// Fitted to `points` if there are any.
[[nodiscard]] std::optional<model::Layer> make_texture(const LayerInput& in, std::span<const MatchedPoint> points = {});
/// True if there is something to colour the texels from that is read from the source.
[[nodiscard]] bool has_texture(const LayerInput& in);
/// Texels of the layer `texture`, rows and columns.
[[nodiscard]] std::pair<std::uint32_t, std::uint32_t> texture_shape(const LayerInput& in);
/// f16 [mb][nb]: height of the mapped surface over the stored grid surface along the decoded normal, least-squares
/// fitted to `points` (source_match.h) if there are any, plus the material's height map (`-bm` source units from black
/// to white; 1 % of the diagonal where the file does not say).
[[nodiscard]] model::Layer make_bump(const LayerInput& in, const StoredPositions& positions,
                                     const StoredNormals& normals, std::span<const MatchedPoint> points = {});
/// f32 [nodes][6], attribute `levels`.
[[nodiscard]] model::Layer make_collision(const SampledChart& chart, std::span<const Vec3d> local);
/// f32 [m][n], rounded up.
[[nodiscard]] model::Layer make_cover(const SampledChart& chart, std::span<const Vec3d> local);
/// f32 [m][n][4]: E, F, G by central differences over the seam, and stiffness (vertex alpha, else 1).
[[nodiscard]] model::Layer make_deformation(const SampledChart& chart, std::span<const Vec3d> local);
/// f32 [m][n][2]: area (a third of each triangle to each corner; border samples hand theirs to a grid sample) and
/// mobility.
[[nodiscard]] model::Layer make_contact(const SampledChart& chart, std::span<const Vec3d> local);
/// Adds f32 [1 + n], the length of a unit and the `material`, n numbers or none, and the attribute `metres_per_unit` of
/// geometry.
void add_material(model::Chart& chart, double metres_per_unit, std::span<const float> material);
/// seams, diagonals, and for a free domain mask, border_uv, border_faces. Every reader of geometry needs them.
[[nodiscard]] std::vector<model::Layer> make_tables(const SampledChart& chart);

/// A layer of the given type and shape with its bytes zeroed.
[[nodiscard]] model::Layer empty_layer(std::string name, model::ElementType type, std::vector<std::uint64_t> shape);
template <class T>
[[nodiscard]] std::span<T> values(model::Layer& layer) {
    return {reinterpret_cast<T*>(layer.bytes.data()), layer.bytes.size() / sizeof(T)};
}

/// True if the layers asked for (empty: all) include `name`.
[[nodiscard]] bool wants(std::span<const std::string> asked, std::string_view name);

/// The layers `asked` for (empty: all that have data) in file order; geometry and the tables always.
struct ChartLayers {
    model::Chart chart;
    double worst_quantisation = 0;
};
/// Reports its share of stage "layers". @throws model::Error kInterrupted
[[nodiscard]] ChartLayers make_layers(const LayerInput& in, std::span<const std::string> asked,
                                      const model::Progress& progress = {});

}  // namespace dgm::bake
