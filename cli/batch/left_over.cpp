// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/left_over.cpp
#include "batch/left_over.h"

#include <algorithm>
#include <optional>
#include <set>
#include <system_error>

#include "baking/up_to_date.h"
#include "files/folder_list.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;

bool is_map_name(const fs::path& path) {
    return path.extension() == ".dgm" || path.extension() == ".exr";
}

/// "out/x" for "out/./x.dgm": an asset may be written in both formats.
fs::path stem_of(const fs::path& output) {
    fs::path out = output.lexically_normal();
    return out.replace_extension();
}

const fs::path& output_of(const PlannedAsset& asset) {
    return asset.dgm.empty() ? asset.exr : asset.dgm;
}

/// Maps below `folder` in byte order; links are not followed, and no hidden file is one.
std::vector<fs::path> maps_below(const fs::path& folder) {
    std::vector<fs::path> out;
    std::error_code error;
    fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
    for (const fs::recursive_directory_iterator end; !error && it != end; it.increment(error)) {
        std::error_code ignored;
        const fs::path name = it->path().filename();
        if (name.native().front() == '.') {
            if (it->is_directory(ignored)) it.disable_recursion_pending();
        } else if (is_map_name(name) && fs::is_regular_file(it->symlink_status(ignored))) {
            out.push_back(it->path());
        }
    }
    formats::sort_paths(out);
    return out;
}

/// The names that outputs had by other rules or beside other meshes: with the mesh's extension, and without.
std::vector<fs::path> other_names(const BatchPlan& plan) {
    std::vector<fs::path> out;
    for (const PlannedAsset& asset : plan.assets) {
        if (output_of(asset).empty()) continue;
        const fs::path stem = output_of(asset).parent_path() / asset.source.stem();
        for (const fs::path& base : {stem, fs::path(stem).concat(asset.source.extension().native())})
            for (const char* extension : {".dgm", ".exr"}) {
                fs::path path = base;
                std::error_code ignored;
                if (fs::is_regular_file(fs::symlink_status(path += extension, ignored))) out.push_back(path);
            }
    }
    formats::sort_paths(out);
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

/// The asset whose mesh `map` was made from, as far as name and place tell.
const PlannedAsset* asset_of(const BatchPlan& plan, const fs::path& map, const std::string& source_name) {
    const fs::path folder = map.parent_path().lexically_normal();
    for (const PlannedAsset& asset : plan.assets)
        if (asset.source.filename() == source_name && output_of(asset).parent_path().lexically_normal() == folder)
            return &asset;
    return nullptr;
}

/// True if a mesh of that name is where the map's place in the output folder says: in one of the folders that were
/// searched, or in one of that name where the output was put below a folder of the input's name.
bool mesh_is_there(const BatchPlan& plan, const fs::path& map, const std::string& source_name) {
    const fs::path place = map.parent_path().lexically_relative(plan.folder);
    // Where the system cannot tell, it is there: its map would be removed.
    const auto may_be = [](const fs::path& mesh) {
        std::error_code error;
        return fs::exists(mesh, error) || error;
    };
    for (const fs::path& root : plan.roots) {
        if (may_be(root / place / source_name)) return true;
        fs::path below;
        for (auto part = place.begin(); part != place.end(); ++part)
            if (part != place.begin()) below /= *part;
        if (may_be(root / below / source_name)) return true;
    }
    return false;
}

}  // namespace

std::vector<LeftOver> find_left_over(const BatchPlan& plan, bool searches_folder) {
    std::vector<LeftOver> out;
    if (plan.names_output) return out;
    std::set<fs::path> planned;
    for (const PlannedAsset& asset : plan.assets) {
        if (asset.refusal) return out;
        for (const fs::path& output : {asset.dgm, asset.exr})
            if (!output.empty()) planned.insert(stem_of(output));
    }
    const bool whole = searches_folder && !plan.roots.empty();
    for (const fs::path& map : whole ? maps_below(plan.folder) : other_names(plan)) {
        if (planned.contains(stem_of(map))) continue;
        const std::optional<std::string> source_name = baked_from(map);
        if (!source_name || source_name->empty()) continue;
        if (const PlannedAsset* asset = asset_of(plan, map, *source_name))
            out.push_back({map, *source_name, output_of(*asset)});
        else if (whole && !mesh_is_there(plan, map, *source_name))
            out.push_back({map, *source_name, {}});
    }
    return out;
}

void prune(std::vector<LeftOver>& files, const std::vector<AssetResult>& results) {
    std::set<fs::path> in_place;
    for (const AssetResult& result : results)
        for (const OutputFile& file : result.files) in_place.insert(file.path);
    for (LeftOver& file : files) {
        if (!file.replacement.empty() && !in_place.contains(file.replacement)) continue;
        std::error_code error;
        file.removed = fs::remove(file.path, error);
    }
}

}  // namespace dgm::bake
