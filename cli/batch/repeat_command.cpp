// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/repeat_command.cpp
#include "batch/repeat_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "baking/materials.h"
#include "baking/option_names.h"

namespace dgm::bake {
namespace {

std::string size_text(const GridSize& size) {
    return fmt::format("{}x{}", size.rows, size.cols);
}

/// A file name that is not read as an option.
std::string file_word(const std::filesystem::path& path) {
    const std::string text = path.string();
    return shell_word(text.starts_with('-') ? "./" + text : text);
}

void add_grid(const BakeOptions& options, std::string& out) {
    const bool has_goal = options.max_error || options.budget_bytes;
    if (options.auto_samples) {
        if (!has_goal || *options.auto_samples != kLargestSearched)
            out += fmt::format(" --size auto:{}", *options.auto_samples);
    } else if (has_goal || !options.any_aspect) {
        out += " --size " + size_text(options.size);
    }
    if (options.max_error) {
        out += fmt::format(" --max-error {}{}", options.max_error->value, options.max_error->percent ? "%" : "");
        if (options.max_error->kind != ErrorKind::kRms)
            out += fmt::format(" --max-error-kind {}", name_of(kErrorKindNames, options.max_error->kind));
    }
    if (options.budget_bytes) out += fmt::format(" --budget {}", *options.budget_bytes);
}

std::string joined(const std::vector<std::string>& words) {
    std::string out;
    for (const std::string& word : words) out += (out.empty() ? "" : ",") + word;
    return out;
}
}  // namespace

std::string shell_word(std::string_view text) {
    const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               std::string_view("_-./+,:=@%").find(c) != std::string_view::npos;
    });
    if (plain) return std::string(text);
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

std::string repeat_command(const PlannedAsset& asset) {
    const BakeOptions &options = asset.options, defaults;
    std::string out = "dgm-bake " + file_word(asset.source);
    out += " -o " + file_word((asset.dgm.empty() ? asset.exr : asset.dgm).lexically_normal());
    std::string formats = asset.dgm.empty() ? "exr" : asset.exr.empty() ? "dgm" : "dgm,exr";
    for (const std::filesystem::path& output : asset.exports) formats += "," + output.extension().string().substr(1);
    if (formats.find(',') != std::string::npos) out += " --format " + formats;
    add_grid(options, out);
    if (options.precision != defaults.precision)
        out += fmt::format(" --precision {}", name_of(kPrecisionNames, options.precision));
    if (!options.layers.empty()) out += " --layers " + joined(options.layers);
    if (!options.texture.empty()) out += " --texture " + file_word(options.texture);
    for (const std::filesystem::path& root : options.asset_roots) out += " --asset-root " + file_word(root);
    if (options.texture_size) out += " --texture-size " + size_text(*options.texture_size);
    if (options.bump_size) out += " --bump-size " + size_text(*options.bump_size);
    if (options.metres_per_unit) out += fmt::format(" --unit {}", name_of(kUnitNames, *options.metres_per_unit));
    if (!options.material_file.empty())
        out += " --material " + file_word(options.material_file);
    else if (options.material)
        out += fmt::format(" --material {}", name_of(kMaterialNames, *options.material));
    if (options.exr_layout != defaults.exr_layout)
        out += fmt::format(" --exr-layout {}", name_of(kExrLayoutNames, options.exr_layout));
    if (options.method != defaults.method) out += " --method " + shell_word(name_of(options.method));
    if (options.domain != defaults.domain) out += fmt::format(" --domain {}", name_of(kDomainNames, options.domain));
    if (options.fit != defaults.fit) out += fmt::format(" --fit {}", name_of(kFitNames, options.fit));
    if (!options.ablate.empty()) out += " --ablate " + joined(options.ablate);
    return out;
}

std::string repeat_scene_command(const std::filesystem::path& scene, const std::filesystem::path& folder) {
    return "dgm-bake " + file_word(scene) + " -o " + file_word(folder.lexically_normal());
}

}  // namespace dgm::bake
