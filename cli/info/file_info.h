// SPDX-License-Identifier: GPL-3.0-or-later
// cli/info/file_info.h
// Facts that a .dgm or an EXR of ours states, as text for people and as JSON for programs.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/error.h"
#include "model/map_set.h"

namespace dgm::info {

struct LayerInfo {
    std::string name;
    model::ElementType type = model::ElementType::kF32;
    std::vector<std::uint64_t> shape;
    std::uint64_t offset = 0, bytes = 0;  ///< absolute offset in the file, 0 in an EXR; bytes as decoded
    std::array<std::uint8_t, 16> hash{};  ///< XXH3-128, canonical
    bool required = false;
};

struct ChartInfo {
    std::uint32_t rows = 0, cols = 0;
    model::Domain domain = model::Domain::kSquare;
    std::string method;
    std::array<double, 6> bbox{};
    std::array<double, 3> offset{}, scale{};
    std::vector<LayerInfo> layers;
    std::vector<float> material;  ///< as the layer `material` has it: nothing, the unit, or the unit and six numbers
};

struct FileInfo {
    std::string file;  ///< as it was named
    std::uint64_t bytes = 0;
    bool is_exr = false;
    std::uint32_t format_version = 0;
    std::string generator, source_name, report_json;
    std::array<std::uint8_t, 16> source_hash{}, settings_hash{};
    std::vector<ChartInfo> charts;
    std::optional<model::Error> fault;  ///< the first error for which dgm-validate refuses the maps
};

/// Reads a .dgm or an EXR, by content. Not thread-safe (HDF5).
/// @throws model::Error as formats::check_map_name, read_dgm and read_exr
[[nodiscard]] model::MapSet read_maps(const std::filesystem::path& path);

/// Reads the whole file, so everything told has been checked against hashes and index.
/// @throws as read_maps
[[nodiscard]] FileInfo read_file_info(const std::filesystem::path& path);

/// Several lines, the last with a line end: header, then each chart with its measured errors and its layers.
[[nodiscard]] std::string to_text(const FileInfo& info);

/// {"files": [...]} with keys in a fixed order, indented by two, with a line end. The bake's report is put in as it is,
/// or as null if it is not JSON.
[[nodiscard]] std::string to_json(std::span<const FileInfo> files);

}  // namespace dgm::info
