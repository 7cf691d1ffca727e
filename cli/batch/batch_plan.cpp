// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/batch_plan.cpp
#include "batch/batch_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <system_error>

#include "baking/option_names.h"
#include "batch/file_pattern.h"
#include "dgm/hash.h"
#include "files/folder_list.h"
#include "files/io_failure.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

std::string lower_extension(const fs::path& path) {
    std::string out = path.extension().string();
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

struct Found {
    fs::path source;
    fs::path relative;             ///< output path without extension, before collisions are settled
    fs::path group;                ///< folder name that tells it from its namesakes
    bool keeps_extension = false;  ///< a sibling has the plain name
    int level = 0;                 ///< what a collision adds: 1 goes below `group`, 2 keeps the extension in any case

    [[nodiscard]] fs::path output_stem() const {
        fs::path out = level >= 1 ? group / relative : relative;
        if (keeps_extension || level >= 2) out += source.extension();
        return out;
    }
    [[nodiscard]] std::string name() const {
        fs::path out = level >= 1 ? group / relative : relative;
        return (out += source.extension()).generic_string();
    }
};

/// Finds the mesh among its siblings whose output has the plain name. A file's own folder decides that, not the
/// command line: so it has one name, whether it is named alone or found with others.
class Siblings {
 public:
    /// True if a file of the same stem beside `mesh` comes before it.
    bool has_better(const fs::path& mesh) {
        const Key own = key_of(mesh);
        const std::vector<Key>& all = listing(mesh.parent_path())[mesh.stem()];
        return std::any_of(all.begin(), all.end(), [&](const Key& key) { return key < own; });
    }

 private:
    /// By rank; of OBJ and obj, the one in lower case comes first.
    using Key = std::pair<std::size_t, std::string>;
    static Key key_of(const fs::path& mesh) {
        std::string extension = mesh.extension().string();
        for (char& c : extension) c = static_cast<char>(~c);
        return {formats::mesh_rank(mesh), extension};
    }
    std::map<fs::path, std::vector<Key>>& listing(const fs::path& folder) {
        const auto [place, is_new] = listings_.try_emplace(folder);
        if (!is_new) return place->second;
        std::error_code error;  // what cannot be listed has no siblings
        fs::directory_iterator it(folder.empty() ? fs::path(".") : folder, error);
        for (; !error && it != fs::directory_iterator(); it.increment(error)) {
            std::error_code ignored;
            const fs::path name = it->path().filename();
            if (formats::has_mesh_extension(name) && name.native().front() != '.' && it->is_regular_file(ignored))
                place->second[name.stem()].push_back(key_of(name));
        }
        formats::check_look(error, folder);
        return place->second;
    }

    std::map<fs::path, std::map<fs::path, std::vector<Key>>> listings_;
};

fs::path folder_name(const fs::path& folder) {
    std::error_code ignored;
    fs::path full = fs::absolute(folder, ignored).lexically_normal();
    if (!full.has_filename()) full = full.parent_path();
    return full.filename();
}

bool is_layer(std::string_view name) {
    return name == model::layers::kCover ||
           std::find(kLayerNames.begin(), kLayerNames.end(), name) != kLayerNames.end();
}

fs::path true_path(const fs::path& path) {
    std::error_code error;
    fs::path out = fs::weakly_canonical(path, error);
    return error ? fs::absolute(path).lexically_normal() : out;
}

class Planner {
 public:
    Planner(const PlanRequest& request, const BakeOptions& options) : request_(request), options_(options) {}

    BatchPlan plan() {
        for (const fs::path& input : request_.inputs) try_add(input);
        find_target();
        settle_collisions();
        for (const Found& f : found_)
            out_.assets.push_back({f.source, target(f, ".dgm"), target(f, ".exr"), {}, f.name(), options_});
        for (PlannedAsset& asset : out_.assets) {
            if (!request_.write_dgm) asset.dgm.clear();
            if (!request_.write_exr) asset.exr.clear();
        }
        add_exports();
        check_side_files();
        check_inputs_kept();
        for (const auto& [position, asset] : refused_)
            out_.assets.insert(out_.assets.begin() + static_cast<std::ptrdiff_t>(position), asset);
        return std::move(out_);
    }

 private:
    void try_add(const fs::path& input) {
        try {
            add(input);
        } catch (const model::Error& error) { refuse(input, error); }
    }

    void add(const fs::path& input) {
        const fs::file_status status = formats::look_at(input);
        if (!fs::exists(status) && is_pattern(input.native())) return add_pattern(input);
        if (!fs::exists(status)) return refuse(input, {codes::kFileMissing, "there is no such file or folder"});
        if (fs::is_regular_file(status)) return add_file(input);
        if (!fs::is_directory(status)) return refuse(input, {codes::kReadFailed, "it is neither a file nor a folder"});
        add_files(input, input, formats::files_below(input), "the folder holds no meshes");
    }

    /// Takes the meshes among `files`, which lie below `folder`, and remembers those that it cannot take.
    void add_files(const fs::path& input, const fs::path& folder, const std::vector<fs::path>& files,
                   std::string_view nothing) {
        has_folder_ = true;
        out_.roots.push_back(folder);
        const std::size_t left_before = out_.left_out.size();
        std::size_t taken = 0;
        for (const fs::path& relative : files) {
            if (!formats::has_mesh_extension(relative)) {
                const std::string_view why = formats::why_left_out(relative);
                if (!why.empty()) out_.left_out.push_back({folder / relative, std::string(why)});
                continue;
            }
            ++taken;
            fs::path stem = relative;
            add_unique({folder / relative, stem.replace_extension(), folder_name(folder)});
        }
        if (taken > 0) return;
        std::string message(nothing);
        if (out_.left_out.size() > left_before) message += " that a search takes";
        refuse(input, {codes::kNothingToDo, message});
    }

    void add_pattern(const fs::path& pattern) {
        const auto [folder, matches] = files_matching(pattern);
        add_files(pattern, folder, matches, "the pattern matches no meshes");
    }

    void add_file(const fs::path& input) {
        add_unique({input, input.stem(), folder_name(fs::absolute(input).parent_path())});
    }

    void add_unique(Found found) {
        if (!seen_.insert(true_path(found.source)).second) return;
        found.keeps_extension = siblings_.has_better(found.source);
        found_.push_back(std::move(found));
    }

    void refuse(const fs::path& input, const model::Error& error) {
        // Each refusal stands where its assets would have stood; those before it have moved it on already.
        refused_.emplace_back(found_.size() + refused_.size(),
                              PlannedAsset{input, {}, {}, error, input.string(), options_});
    }

    /// Is -o the one output file, or the folder of outputs?
    void find_target() {
        const fs::path& output = request_.output;
        std::error_code ignored;
        const std::string extension = lower_extension(output);
        if (output.empty()) {
            out_.folder = ".";
        } else if (request_.output_is_folder || fs::is_directory(output, ignored)) {
            out_.folder = output;
        } else if (extension == ".dgm" || extension == ".exr") {
            if (has_folder_ || request_.inputs.size() > 1)
                throw model::Error(codes::kUsage, "one output file cannot hold several assets; name a folder with -o",
                                   output.string());
            out_.names_output = true;
            file_stem_ = output.parent_path() / output.stem();
            out_.folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
        } else if (formats::has_mesh_extension(output)) {
            throw model::Error(
                codes::kUsage,
                "the output is named like a mesh; dgm-bake writes FILE.dgm, FILE.exr, or into a folder, and "
                "meshes beside them with --format, such as --format dgm,glb",
                output.string())
                .with_hint("name a .dgm, and make a mesh of it with --format or dgm-export");
        } else {
            out_.folder = output;
        }
    }

    fs::path target(const Found& f, const char* extension) const {
        fs::path out = !file_stem_.empty()       ? file_stem_
                       : request_.output.empty() ? f.output_stem()
                                                 : out_.folder / f.output_stem();
        return out += extension;
    }

    void add_exports() {
        for (std::size_t k = 0; k < found_.size(); ++k)
            for (const std::string& extension : request_.exports)
                out_.assets[k].exports.push_back(target(found_[k], extension.c_str()));
    }

    void settle_collisions() {
        for (int level = 1;; ++level) {
            std::map<fs::path, std::vector<Found*>> by_name;
            for (Found& f : found_) by_name[f.output_stem()].push_back(&f);
            bool changed = false;
            for (auto& [name, group] : by_name) {
                if (group.size() < 2) continue;
                if (level > 2)
                    throw model::Error(
                        codes::kUsage,
                        fmt::format("{} and {} would both become {}.dgm; bake them into different folders",
                                    group[0]->source.string(), group[1]->source.string(), name.string()));
                for (Found* f : group) f->level = level;
                changed = true;
            }
            if (!changed) return;
        }
    }

    /// An EXR may have files of layers beside it. `a.texture.exr` is one of a.exr, so no asset may become that as well.
    void check_side_files() const {
        std::map<fs::path, fs::path> sources;
        for (const PlannedAsset& asset : out_.assets)
            if (!asset.exr.empty()) sources.emplace(asset.exr, asset.source);
        for (const auto& [exr, source] : sources) {
            fs::path stem = fs::path(exr).replace_extension();
            const std::string layer = stem.extension().string();
            if (layer.empty() || !is_layer(layer.substr(1))) continue;
            stem.replace_extension();
            if (stem.extension().native().starts_with(".chart")) stem.replace_extension();
            const auto map = sources.find(stem += ".exr");
            if (map == sources.end()) continue;
            throw model::Error(
                codes::kUsage,
                fmt::format("{} and a layer of {} would both become {}; bake them into different folders",
                            source.string(), map->second.string(), exr.string()));
        }
    }

    void check_inputs_kept() const {
        std::set<fs::path> inputs;
        for (const fs::path& source : seen_) inputs.insert(source);
        for (const PlannedAsset& asset : out_.assets)
            for (const fs::path& output : outputs_of(asset))
                if (inputs.contains(true_path(output)))
                    throw model::Error(codes::kUsage, "the output would overwrite an input", output.string());
    }

    const PlanRequest& request_;
    const BakeOptions& options_;
    BatchPlan out_;
    std::vector<Found> found_;
    std::vector<std::pair<std::size_t, PlannedAsset>> refused_;
    std::set<fs::path> seen_;  ///< canonical sources
    Siblings siblings_;
    bool has_folder_ = false;
    fs::path file_stem_;  ///< of the one output file; empty if outputs go into a folder
};

}  // namespace

std::vector<fs::path> outputs_of(const PlannedAsset& asset) {
    std::vector<fs::path> out;
    for (const fs::path& map : {asset.dgm, asset.exr})
        if (!map.empty()) out.push_back(map);
    out.insert(out.end(), asset.exports.begin(), asset.exports.end());
    return out;
}

BatchPlan plan_batch(const PlanRequest& request, const BakeOptions& options) {
    return Planner(request, options).plan();
}

unsigned shard_of(std::string_view name, unsigned count) {
    unsigned best = 1;
    formats::Hash128 largest{};
    for (unsigned shard = 1; shard <= count; ++shard) {
        const std::string text = fmt::format("{}/{}", shard, name);
        const formats::Hash128 hash = formats::hash_bytes(std::as_bytes(std::span(text)));
        if (shard > 1 && hash <= largest) continue;
        best = shard;
        largest = hash;
    }
    return best;
}

void keep_shard(BatchPlan& plan, Shard shard) {
    std::erase_if(plan.assets,
                  [&](const PlannedAsset& asset) { return shard_of(asset.name, shard.count) != shard.number; });
}

}  // namespace dgm::bake
