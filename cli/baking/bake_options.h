// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/bake_options.h
// Settings of the bake of one asset. Every field but the output formats enters the settings hash.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <dgm/physics.h>

namespace dgm::bake {

struct GridSize {
    std::uint32_t rows = 257, cols = 257;
    friend bool operator==(const GridSize&, const GridSize&) = default;
};

/// How a component is laid out; methods.h has the table.
enum class Method { kAuto, kStretch, kSphere, kMvc, kAuthalic, kConformal, kTutte, kLscm, kArap, kSlim, kUv };
enum class Fit { kSample, kL2, kBest };
enum class Precision { kF32, kU16, kAuto };
enum class DomainChoice { kAuto, kSquare, kFree };
enum class ExrLayout { kAuto, kMultipart };
enum class ErrorKind { kRms, kHausdorff };

/// --max-error: the error that the grid must hold.
struct ErrorGoal {
    double value = 0;  ///< > 0; % of the source's diagonal, or source units
    bool percent = true;
    ErrorKind kind = ErrorKind::kRms;
    friend bool operator==(const ErrorGoal&, const ErrorGoal&) = default;
};

/// Where a grid is asked for by error or file size alone: as many samples as a square of 2049 a side.
inline constexpr std::uint64_t kLargestSearched = std::uint64_t{2049} * 2049;

/// A line about a mesh, before the long part of its bake begins.
struct Notice {
    /// The name of the same notes about other meshes: "open border (fine for cloth, odd for an organ)". Empty
    /// for warnings, which are told of each mesh.
    std::string kind;
    std::string text;  ///< "note: open border (2 loops): fine for cloth, odd for an organ"
};

struct BakeOptions {
    /// 257x257: each step to a finer grid quarters the rms and takes four times the bytes; there it is 0.001 to 0.01 %
    /// on organs, below a pixel of a screen that the asset fills, for 4 s and 4.6 MB.
    GridSize size;            ///< of the largest chart, 3..8193 a side; the largest grid tried if one is searched
    bool any_aspect = false;  ///< `size` was not asked for: rings and long surfaces get an m x n that suits them
    std::optional<std::uint64_t> auto_samples;  ///< instead of `size`: the best m x n with at most so many samples
    std::optional<ErrorGoal> max_error;         ///< the smallest grid that holds it
    std::optional<std::uint64_t> budget_bytes;  ///< the largest grid whose .dgm is not larger; with max_error: a limit
    /// auto maps onto the square (stretch) first, and tries a free chart where that may be better
    /// (component/component_bake.cpp). On organs (dgm-bench bake) it has the least rms: arap, slim and lscm have two to
    /// four times as much for half to all of the time, the others twenty times and more; and where one method cannot
    /// map a mesh, auto has another.
    Method method = Method::kAuto;
    DomainChoice domain = DomainChoice::kAuto;
    /// Measured (docs/speed-against-error.md): at 257x257 9 to 16 dB less error than kSample for twice the time. kBest
    /// has 1 to 5 dB less again for twice that, but at times a larger error at the worst spot, so it is not the
    /// default.
    Fit fit = Fit::kL2;
    /// kAuto: u16 where max_error is at least three times (hausdorff: six times) the error that rounding alone makes,
    /// so that it costs no more than a few samples; f32 elsewhere.
    /// f32 by default: u16 changes the rms by 1 % and less, but saves a tenth of a file that holds all layers.
    Precision precision = Precision::kF32;
    std::vector<std::string> layers;             ///< empty: all that have data
    std::filesystem::path texture;               ///< fabric image that replaces the materials' textures
    std::optional<GridSize> texture_size;        ///< default: the grid's size
    std::optional<std::uint64_t> texture_bytes;  ///< most of all charts' textures together; they get smaller
    std::optional<double> texel_length;          ///< source units; textures are not made finer than this
    std::optional<GridSize> bump_size;           ///< default: (2m-1) x (2n-1)
    std::optional<double> metres_per_unit;       ///< length of a source unit; nullopt: the map does not say
    std::optional<Material> material;            ///< only with metres_per_unit; nullopt: the map does not say
    std::vector<std::string> ablate;             ///< of kAblateNames: steps left out, to measure their worth
    bool write_dgm = true, write_exr = false;
    ExrLayout exr_layout = ExrLayout::kAuto;

    [[nodiscard]] bool ablates(std::string_view part) const;
    /// Whether `auto` takes a free chart only where the square has none: the runtime's physics and cloth, for which
    /// unit and material are, refuse free charts.
    [[nodiscard]] bool stays_on_square() const { return metres_per_unit && domain == DomainChoice::kAuto; }
    /// Folders beside the mesh's that hold files it may name. Not a setting: what is found there is (inputs_hash).
    std::vector<std::filesystem::path> asset_roots = {};
    /// Where a search by budget may write a file to learn its size; removed again. Not a setting.
    std::filesystem::path scratch;
    std::filesystem::path material_file;  ///< that `material` was read from; may be empty. Not a setting.
    /// Told each warning and note about the mesh once it is imported and repaired. May be empty. Not a setting.
    std::function<void(const Notice& notice)> on_notice;
};

/// 3..8193 a side, of any chart.
inline constexpr std::uint32_t kMinSide = 3, kMaxSide = 8193;

/// The settings as one line of stable text, for MapSet::settings_hash: equal texts mean equal layers from equal meshes.
/// A limit on error, bytes or samples stands in it as it was asked, not as it was answered. Left out: which files are
/// written (a .dgm has the same bytes whether or not an EXR is written beside it) and the path of `texture`, whose
/// content stands there instead (XXH3-128).
/// @throws model::Error kFileMissing, kReadFailed if `texture` cannot be read
[[nodiscard]] std::string canonical_settings(const BakeOptions& options);

}  // namespace dgm::bake
