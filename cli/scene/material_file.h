// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/material_file.h
// A material file: TOML with the numbers of a material in SI units (docs/options.md).
#pragma once
#include <filesystem>
#include <string_view>

#include <dgm/physics.h>

namespace dgm::scene {

/// Reads a material file, which is parsed in a process of its own (read_toml_apart()). The program must have one
/// thread.
/// @throws model::Error kFileMissing, kReadFailed, kSystemBusy; kMaterialInvalid with FILE:LINE:COLUMN as its place: no
///         TOML, an unknown key (with the one that was meant), a key that is missing, a value that is no number or out
///         of its range
[[nodiscard]] Material read_material(const std::filesystem::path& file);

/// The same from text; `file` is for messages. Made for tests and fuzzing.
[[nodiscard]] Material parse_material(std::string_view text, const std::filesystem::path& file);

}  // namespace dgm::scene
