// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/up_to_date.cpp
#include "baking/up_to_date.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <span>
#include <utility>

#include <dgm/layout.h>

#include "dgm/dgm_reader.h"
#include "dgm/hash.h"
#include "export/map_stamp.h"
#include "exr/exr_reader.h"
#include "files/io_failure.h"
#include "files/regular_file.h"
#include "mesh/material_files.h"
#include "mesh/mesh_reader.h"
#include "mesh/source_inputs.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "model/shortage.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
using formats::Hash128;

Hash128 hash_text(const std::string& text) {
    return formats::hash_bytes(std::as_bytes(std::span(text)));
}

/// The contents of files, each hashed once: materials may name a picture thousands of times, by as many names.
class InputHashes {
 public:
    /// The hash in hexadecimal; for a file that no bake reads, why not: larger than any limit, or unreadable.
    std::string of(const fs::path& path) {
        try {
            formats::RegularFile file(path);
            if (file.size() > kMostBytes) return "too large";
            const auto [place, is_new] = known_.try_emplace(file.identity());
            if (is_new) place->second = formats::to_hex(formats::hash_file(file, kMostBytes));
            return place->second;
        } catch (const model::Error& error) {
            if (model::may_pass(error)) throw;
            return "unreadable";
        }
    }

 private:
    static constexpr std::uint64_t kMostBytes = formats::MeshReadLimits{}.max_file_bytes;
    std::map<std::pair<std::uint64_t, std::uint64_t>, std::string> known_;
};

/// From the first bytes, before anything is checked: to pass over a stale file without reading it.
bool header_names(const fs::path& dgm, const Hash128& source, const Hash128& settings) {
    layout::FileHeader header{};
    formats::RegularFile file(dgm);
    return file.read(std::as_writable_bytes(std::span(&header, 1))) == sizeof header &&
           std::memcmp(header.magic, layout::kMagic, sizeof layout::kMagic) == 0 &&
           std::equal(source.begin(), source.end(), header.source_hash) &&
           std::equal(settings.begin(), settings.end(), header.settings_hash);
}

bool is_map(const fs::path& output) {
    return output.extension() == ".dgm" || output.extension() == ".exr";
}

/// A map's description; of an EXR without layers.
model::MapSet read_head(const fs::path& map) {
    return map.extension() == ".exr" ? formats::read_exr_head(map).maps : formats::read_dgm(map);
}

/// The layers that a stored report says were edited; none if it is no report.
std::vector<std::string> layers_in(const std::string& report_json) {
    try {
        return edited_layers(report_from_json(report_json));
    } catch (const model::Error& error) {
        if (model::may_pass(error)) throw;
        return {};
    }
}

/// The origin that a map names; of an EXR without layers.
std::optional<model::MapSet> origin_of(const fs::path& map, const BakeOptions& options) {
    if (map.extension() != ".exr") return formats::read_dgm(map);
    formats::ExrHead head = formats::read_exr_head(map);
    if (head.multipart != (options.exr_layout == ExrLayout::kMultipart)) return std::nullopt;
    return std::move(head.maps);
}

}  // namespace

const char* generator() {
    return "dgm-bake " DGM_VERSION;
}

std::string hash_inputs(const fs::path& mesh_file, std::span<const fs::path> asset_roots) {
    const auto inputs = formats::source_inputs(mesh_file, asset_roots);
    if (!inputs) return {};
    InputHashes hashes;
    std::vector<std::string> files;
    for (const fs::path& file : inputs->files) files.push_back(hashes.of(file) + ' ' + file.filename().string());
    std::sort(files.begin(), files.end());
    std::string text;
    for (const std::string& file : files) text += file + '\n';
    for (const std::string& warning : inputs->missing) text += warning + '\n';
    return formats::to_hex(hash_text(text));
}

std::string hash_inputs(const fs::path& mesh_file, const std::vector<std::string>& inputs,
                        const std::vector<std::string>& missing, std::span<const fs::path> asset_roots) {
    const formats::AssetFolders folders(mesh_file, asset_roots);
    formats::FileFinder finder(mesh_file, asset_roots);
    InputHashes hashes;
    std::string text;
    for (const std::string& name : inputs) {
        const std::optional<fs::path> file = folders.resolve(name);
        if (!file) throw model::missing_file(name);
        text += hashes.of(*file) + ' ' + name + '\n';
    }
    for (const std::string& name : missing) {
        if (finder.find(name)) return {};
        text += "missing " + name + '\n';
    }
    return formats::to_hex(hash_text(text));
}

std::vector<fs::path> input_files(const fs::path& mesh_file, const BakeOptions& options, const BakeReport& report) {
    std::vector<fs::path> out{mesh_file};
    const formats::AssetFolders folders(mesh_file, options.asset_roots);
    if (const auto inputs = formats::source_inputs(mesh_file, options.asset_roots))
        out.insert(out.end(), inputs->files.begin(), inputs->files.end());
    for (const std::string& name : report.inputs)
        if (auto file = folders.resolve(name)) out.push_back(std::move(*file));
    for (const fs::path& file : {options.texture, options.material_file})
        if (!file.empty()) out.push_back(file);
    return out;
}

std::vector<std::string> edited_layers(const BakeReport& report) {
    std::vector<std::string> out;
    for (const MapEdit& edit : report.edits)
        if (std::find(out.begin(), out.end(), edit.layer) == out.end()) out.push_back(edit.layer);
    return out;
}

std::vector<std::string> edited_layers(const fs::path& map) {
    try {
        if (!is_map(map) || !fs::is_regular_file(formats::look_at(map))) return {};
        return layers_in(read_head(map).report_json);
    } catch (const model::Error& error) {
        if (model::may_pass(error)) throw;  // a painted map would be baked over
        return {};
    }
}

std::optional<std::string> baked_from(const fs::path& map) {
    try {
        model::MapSet maps = read_head(map);
        if (!maps.generator.starts_with("dgm-bake ")) return std::nullopt;
        if (!layers_in(maps.report_json).empty()) return std::nullopt;
        return std::move(maps.source_name);
    } catch (const model::Error&) { return std::nullopt; }
}

std::optional<BakeReport> up_to_date(const fs::path& mesh_file, const std::vector<fs::path>& outputs,
                                     const BakeOptions& options) {
    try {
        std::error_code ignored;
        for (const fs::path& output : outputs)
            if (!fs::is_regular_file(output, ignored)) return std::nullopt;
        formats::check_mesh_file(mesh_file);
        const Hash128 settings = hash_text(canonical_settings(options)), source = formats::hash_file(mesh_file);
        for (const fs::path& output : outputs)
            if (output.extension() == ".dgm" && !header_names(output, source, settings)) return std::nullopt;
        const std::string inputs = hash_inputs(mesh_file, options.asset_roots);
        std::optional<BakeReport> report;
        std::string stamp;
        for (const fs::path& output : outputs) {
            if (!is_map(output)) continue;
            const std::optional<model::MapSet> origin = origin_of(output, options);
            if (!origin || origin->generator != generator() || origin->source_hash != source ||
                origin->settings_hash != settings)
                return std::nullopt;
            BakeReport own = report_from_json(origin->report_json);
            const std::string& now =
                inputs.empty() ? hash_inputs(mesh_file, own.inputs, own.missing_inputs, options.asset_roots) : inputs;
            if (now.empty() || own.inputs_hash != now || own.source_name != mesh_file.filename().string())
                return std::nullopt;
            if (report && !report->edits.empty()) continue;  // an EXR beside it may be what was painted
            report = std::move(own);
            stamp = exporter::map_stamp(*origin);
        }
        for (const fs::path& output : outputs)
            if (!is_map(output) && !exporter::carries_stamp(output, stamp)) return std::nullopt;
        return report;
    } catch (const model::Error&) {
        return std::nullopt;  // the bake will report the fault
    }
}

}  // namespace dgm::bake
