// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/validation.cpp
#include "validate/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "dgm/hash.h"
#include "exr/exr_reader.h"
#include "files/folder_list.h"
#include "files/regular_file.h"
#include "geometry/metrics/reconstruction.h"
#include "mesh/mesh_formats.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "model/shortage.h"
#include "validate/finding_list.h"
#include "validate/layer_checks.h"
#include "validate/report_checks.h"
#include "validate/source_checks.h"
#include "validate/surface_checks.h"

namespace dgm::validate {
namespace {
using model::ExitCode;
using model::MapSet;
using model::TriMesh;
namespace codes = model::codes;

/// A file that no bake would read is none that was baked.
bool has_hash(const std::filesystem::path& file, const formats::Hash128& hash) {
    try {
        return formats::hash_file(file, formats::MeshReadLimits{}.max_file_bytes) == hash;
    } catch (const model::Error& error) {
        if (model::may_pass(error)) throw;
        return false;
    }
}

/// The mesh that the file says it was baked from; nothing, with a finding, if it cannot be read.
std::optional<Source> find_source(const MapSet& maps, const Options& options, FindingList& findings) {
    const std::filesystem::path& folder = options.source_folder;
    // A name from a file must not lead out of the folder. Among several meshes of that name it is the one that was
    // baked.
    std::filesystem::path path = folder / std::filesystem::path(maps.source_name).filename();
    try {
        std::vector<std::filesystem::path> candidates;
        for (const std::filesystem::path& file :
             formats::files_below(folder, std::filesystem::directory_options::skip_permission_denied))
            if (file.filename() == path.filename()) candidates.push_back(folder / file);
        const auto same = std::find_if(candidates.begin(), candidates.end(),
                                       [&](const auto& file) { return has_hash(file, maps.source_hash); });
        if (!candidates.empty()) path = same == candidates.end() ? candidates.front() : *same;
        return load_source(path, options.read_mesh);
    } catch (const model::Error& error) {
        findings.error(error.code(), error.place().empty() ? path.string() : error.place(),
                       fmt::format("the source: {}", error.what()));
        return std::nullopt;
    }
}

void check_maps(const MapSet& maps, Options options, FileValidation& out, FindingList& findings) {
    std::optional<Source> own;
    if (options.source == nullptr && !options.source_folder.empty()) {
        own = find_source(maps, options, findings);
        options.source = own ? &*own : nullptr;
    }
    out.charts = maps.charts.size();
    if (maps.charts.empty()) findings.error(codes::kMissingLayer, "/charts", "the file holds no chart");
    std::vector<std::optional<bake::Topology>> topologies(maps.charts.size());
    TriMesh whole;
    std::vector<char> either_side;  // of its faces
    bool complete = !maps.charts.empty();
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        if (!check_layers(maps.charts[k], k, findings)) {
            complete = false;
            continue;
        }
        try {
            const bake::Reconstruction surface = bake::reconstruct(
                maps.charts[k], options.source != nullptr ? bake::Corners::kFill : bake::Corners::kSkip);
            topologies[k] = check_surface(maps.charts[k], k, surface, findings);
            if (options.source == nullptr) continue;
            const std::vector<char> beside = bake::faces_beside_reversed(surface);
            either_side.insert(either_side.end(), beside.begin(), beside.end());
            append_mesh(whole, surface.mesh);
            either_side.resize(whole.faces.size(), 0);
        } catch (const model::Error& error) {
            findings.error(error.code(), layer_path(k, error.place()), error.what());
            complete = false;
        }
    }
    const ClaimedError claimed = check_report(maps, topologies, findings);
    if (options.source != nullptr && complete)
        check_source({maps, whole, either_side, topologies, claimed}, options, out, findings);
}

bool is_exr(const std::filesystem::path& path) {
    constexpr std::array<char, 4> kMagic{'\x76', '\x2f', '\x31', '\x01'};
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return false;  // the reader says so
    std::array<char, 4> start{};
    return formats::RegularFile(path).read(std::as_writable_bytes(std::span(start))) == start.size() && start == kMagic;
}
}  // namespace

ExitCode FileValidation::exit_code() const {
    ExitCode code = ExitCode::kOk;
    for (const formats::Finding& f : findings)
        if (f.severity == formats::Severity::kError) code = model::worse(code, f.code->exit);
    return code;
}

FileValidation validate_maps(const MapSet& maps, const Options& options) {
    FileValidation out;
    FindingList findings;
    try {
        check_maps(maps, options, out, findings);
    } catch (const model::Error& error) { findings.error(error.code(), error.place(), error.what()); }
    out.findings = findings.take();
    return out;
}

std::optional<model::Error> first_error(const MapSet& maps) {
    for (const formats::Finding& f : validate_maps(maps).findings)
        if (f.severity == formats::Severity::kError) return model::Error(*f.code, f.message, f.place);
    return std::nullopt;
}

FileValidation validate_file(const std::filesystem::path& path, const Options& options) {
    FileValidation out;
    out.path = path;
    FindingList findings;
    try {
        formats::check_map_name(path);
        MapSet maps;
        if (is_exr(path))
            maps = formats::read_exr(path);
        else
            findings.append(formats::read_and_check(path, maps, {.max_total_bytes = options.max_layer_bytes}));
        // Values are worth reading only if the bytes are the ones that were written.
        if (!findings.has_errors()) check_maps(maps, options, out, findings);
    } catch (const model::Error& error) {
        // Readers put the file's name in front, or have no other place.
        std::string place = error.place();
        const std::string name = path.string();
        if (place.starts_with(name)) place.erase(0, place.starts_with(name + ": ") ? name.size() + 2 : name.size());
        findings.error(error.code(), std::move(place), error.what());
    }
    out.findings = findings.take();
    return out;
}

}  // namespace dgm::validate
