// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/material_file.cpp
#include "scene/material_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include <dgm/limits.h>

#include "baking/materials.h"
#include "model/codes.h"
#include "scene/toml_tree.h"
#include "tool/help.h"

namespace dgm::scene {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

[[noreturn]] void wrong(const fs::path& file, const TomlPlace& at, const std::string& message) {
    throw model::Error(codes::kMaterialInvalid, message, fmt::format("{}:{}:{}", file.string(), at.line, at.column));
}

float number_of(const TomlNode& node, std::size_t key, const fs::path& file) {
    const bake::MaterialKey& row = bake::kMaterialKeys[key];
    const double low = double{kMaterialLow[key + 1]}, high = double{kMaterialHigh[key + 1]};
    const std::optional<double> value = node.number();
    if (!value) wrong(file, node.place, fmt::format("{}: this is not a number", row.name));
    if (!(*value >= low && *value <= high))
        wrong(file, node.place,
              fmt::format("{} is {:g} to {:g}{}{}", row.name, low, high, row.unit.empty() ? "" : " ", row.unit));
    return static_cast<float>(*value);
}

Material material_of(const TomlNode& root, const fs::path& file) {
    std::vector<std::string> known;
    known.reserve(std::size(bake::kMaterialKeys));
    for (const bake::MaterialKey& row : bake::kMaterialKeys) known.emplace_back(row.name);
    for (std::size_t k = 0; k < root.keys.size(); ++k)
        if (std::find(known.begin(), known.end(), root.keys[k]) == known.end())
            wrong(file, root.key_places[k], tool::unknown_word("key", root.keys[k], known));
    Material out;
    out.foundation = 0;
    for (std::size_t k = 0; k < known.size(); ++k) {
        const bake::MaterialKey& row = bake::kMaterialKeys[k];
        if (const TomlNode* node = root.get(row.name))
            out.*row.field = number_of(*node, k, file);
        else if (row.needed)
            wrong(file, {1, 1}, fmt::format("{} is missing: {}, in {}", row.name, row.meaning, row.unit));
    }
    return out;
}

/// The parser of TOML serves scene files, too, and throws their code.
template <class Parse>
TomlNode parsed(const Parse& parse) {
    try {
        return parse();
    } catch (const model::Error& error) {
        if (error.code().number != codes::kSceneInvalid.number) throw;
        throw model::Error(codes::kMaterialInvalid, error.what(), error.place());
    }
}

}  // namespace

Material parse_material(std::string_view text, const fs::path& file) {
    return material_of(parsed([&] { return parse_toml(text, file); }), file);
}

Material read_material(const fs::path& file) {
    return material_of(parsed([&] { return read_toml_apart(file); }), file);
}

}  // namespace dgm::scene
