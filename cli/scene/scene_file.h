// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_file.h
// A scene file: TOML that states the demands of a scene on its assets (docs/scenes.md).
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baking/bake_options.h"
#include "baking/option_names.h"

namespace dgm::scene {

/// The viewer of the assets. A length L at distance d takes L * rows / (2 d tan(fov / 2)) pixels.
struct View {
    double fov_degrees = 60;    ///< vertical field of view, 1..170
    std::uint32_t rows = 1080;  ///< pixels of the picture's height
};

enum class ToleranceUnit { kPercent, kSource, kPixels };

/// The distance that a reconstruction may keep from its source.
struct Tolerance {
    double value = 0.05;  ///< > 0; % of the diagonal, source units, or pixels at the asset's nearest distance
    ToleranceUnit unit = ToleranceUnit::kPercent;
    bake::ErrorKind kind = bake::ErrorKind::kRms;
};

/// How far a touch reaches: the radius of the footprint.
struct Reach {
    double value = 5;  ///< > 0; % of the diagonal, or source units
    bool percent = true;
};

enum class Footprint { kSurface, kMetric, kGeodesic, kGrid };
inline constexpr std::array kFootprintNames{bake::NamedValue<Footprint>{"surface", Footprint::kSurface},
                                            bake::NamedValue<Footprint>{"metric", Footprint::kMetric},
                                            bake::NamedValue<Footprint>{"geodesic", Footprint::kGeodesic},
                                            bake::NamedValue<Footprint>{"grid", Footprint::kGrid}};

/// One asset, with the scene's defaults filled in.
struct SceneAsset {
    std::string name;              ///< unique; of the output file, without extension
    std::filesystem::path source;  ///< taken from the folder of the scene file
    int line = 0;                  ///< of its [[asset]] in the scene file
    Tolerance tolerance;
    std::optional<double> distance;  ///< the nearest that a viewer comes, source units
    View view;
    bool touched = false;  ///< tools press and pull it
    Footprint footprint = Footprint::kSurface;
    Reach reach;
    bool contact = false;                         ///< it is set down on things, or things on it
    bool lit = true;                              ///< normals of the source are needed
    bool textured = true;                         ///< colours are needed
    bool detail = false;                          ///< bump: heights that the grid misses, for shading
    std::vector<std::string> layers;              ///< not empty: exactly these, whatever the wishes above say
    std::optional<std::uint64_t> texture_budget;  ///< bytes of the texture layer
    std::filesystem::path fabric;                 ///< picture instead of the source's textures
    std::optional<std::uint64_t> budget;          ///< bytes of its file
    bake::GridSize largest{1025, 1025};           ///< the largest grid tried
    bake::Method method = bake::Method::kAuto;
    bake::DomainChoice domain = bake::DomainChoice::kAuto;
    bake::Fit fit = bake::Fit::kBest;
    std::optional<double> metres_per_unit;     ///< length of a unit of the source
    std::optional<Material> material;          ///< only with metres_per_unit
    std::filesystem::path material_file;       ///< read_scene() reads it, parse_scene() does not
    std::optional<bake::Precision> precision;  ///< nullopt: the smaller one that holds the tolerance
};

struct Scene {
    std::string name;
    std::optional<std::uint64_t> budget;  ///< bytes of all files
    std::optional<double> tick_budget;    ///< seconds of the haptic tick, of each touched asset
    std::vector<SceneAsset> assets;       ///< in the order of the file; at least one
};

/// Reads and checks a scene file, which is parsed in a process of its own (read_toml_apart()). Files named in it are
/// not looked at. The program must have one thread.
/// @throws model::Error kFileMissing, kReadFailed, kSystemBusy; kSceneInvalid with FILE:LINE:COLUMN as its place: no
///         TOML, an unknown key (with the one that was meant), a value of the wrong type or out of its range, a pixel
///         tolerance without a distance, two assets of one name, no asset
[[nodiscard]] Scene read_scene(const std::filesystem::path& file);

/// The same from text; `file` is for messages, and its folder is where sources are taken from. Made for tests and
/// fuzzing.
[[nodiscard]] Scene parse_scene(std::string_view text, const std::filesystem::path& file);

}  // namespace dgm::scene
