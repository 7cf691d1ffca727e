// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/bake_options.h
// What one asset is baked with. Every field but the output formats enters the settings hash.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dgm::bake {

struct GridSize {
    std::uint32_t rows = 257, cols = 257;
    friend bool operator==(const GridSize&, const GridSize&) = default;
};

enum class Fit { kSample, kL2, kBest };
enum class Precision { kF32, kU16 };
enum class DomainChoice { kAuto, kSquare, kFree };
enum class ExrLayout { kAuto, kMultipart };

struct BakeOptions {
    GridSize size;                ///< samples of each chart; 3..8193 a side
    std::string method = "auto";  ///< auto stretch mvc authalic conformal tutte lscm arap slim uv
    DomainChoice domain = DomainChoice::kAuto;
    Fit fit = Fit::kSample;
    Precision precision = Precision::kF32;
    std::vector<std::string> layers;       ///< empty: all that have data
    std::filesystem::path texture;         ///< fabric image that replaces the materials' textures
    std::optional<GridSize> texture_size;  ///< default: the grid's size
    bool write_dgm = true, write_exr = false;
    ExrLayout exr_layout = ExrLayout::kAuto;
};

/// The settings as one line of stable text, for MapSet::settings_hash: equal texts mean equal layers from equal meshes.
/// Left out: which files are written (a .dgm has the same bytes whether or not an EXR is written beside it) and the
/// path of `texture`, whose content stands there instead (XXH3-128).
/// @throws model::Error kFileMissing, kReadFailed if `texture` cannot be read
[[nodiscard]] std::string canonical_settings(const BakeOptions& options);

}  // namespace dgm::bake
