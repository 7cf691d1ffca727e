// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/dependency_file.h
// Inputs of each output, for build systems (-MF).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace dgm::bake {

struct DependencyRule {
    std::vector<std::filesystem::path> outputs, inputs;
};

/// A depfile that GNU Make includes and Ninja reads: one rule for each entry, and an empty one for each input beside
/// the first, so that Make goes on when a texture is deleted. Blanks, `#`, `$`, `%` and `:` in names are escaped as
/// both understand it.
/// @throws model::Error kUnsupported for names with line breaks, which neither can read
[[nodiscard]] std::string dependency_file(const std::vector<DependencyRule>& rules);

}  // namespace dgm::bake
