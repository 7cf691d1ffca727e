// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/validation.cpp
#include "validate/validation.h"

#include <fmt/format.h>

#include <limits>

#include "dgm/hash.h"
#include "geometry/metrics/reconstruction.h"
#include "geometry/metrics/turned_faces.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "validate/finding_list.h"
#include "validate/layer_checks.h"
#include "validate/report_checks.h"
#include "validate/surface_checks.h"

namespace dgm::validate {
namespace {
using model::ExitCode;
using model::MapSet;
using model::TriMesh;
namespace codes = model::codes;

/// Adds a chart's surface to one mesh of the whole asset. Corner normals stay only while every chart has them.
void append_mesh(TriMesh& whole, const TriMesh& part) {
    const bool normals = (whole.faces.empty() || !whole.corner_normals.empty()) && !part.corner_normals.empty();
    const auto shift = static_cast<std::uint32_t>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
    for (const model::Face& f : part.faces) whole.faces.push_back({f[0] + shift, f[1] + shift, f[2] + shift});
    if (normals)
        whole.corner_normals.insert(whole.corner_normals.end(), part.corner_normals.begin(), part.corner_normals.end());
    else
        whole.corner_normals.clear();
}

/// The source with the windings that a bake gives it: which side of a face is out is not to be had from the file where
/// its faces disagree.
TriMesh oriented(const TriMesh& mesh) {
    TriMesh out;
    try {
        const bake::RepairedMesh repaired = bake::repair(mesh);
        for (const TriMesh& component : repaired.components) append_mesh(out, component);
        for (model::Vec3d& p : out.positions) p = repaired.frame.centre + p * repaired.frame.diagonal;
    } catch (const model::Error&) { return {}; }
    return out;
}

struct Limits {
    double rms, hausdorff;  // infinity: none
    const char* origin_rms;
    const char* origin_hausdorff;
};

Limits limits_for(const Options& options, const ClaimedError& claimed, double diagonal) {
    // The bake measured the repaired mesh, from other random points: the mean repeats well within 1 %, the maximum of a
    // sample less well. The last term is what storing positions as float may move.
    constexpr double kRmsMargin = 1.01, kHausdorffMargin = 1.05, kFloatRounding = 2e-7;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Limits limits{kNone, kNone, "the report", "the report"};
    if (claimed.rms) limits.rms = *claimed.rms * kRmsMargin + kFloatRounding * diagonal;
    if (claimed.hausdorff) limits.hausdorff = *claimed.hausdorff * kHausdorffMargin + kFloatRounding * diagonal;
    if (options.max_rms_percent) {
        limits.rms = *options.max_rms_percent / 100 * diagonal;
        limits.origin_rms = "--max-rms";
    }
    if (options.max_hausdorff_percent) {
        limits.hausdorff = *options.max_hausdorff_percent / 100 * diagonal;
        limits.origin_hausdorff = "--max-hausdorff";
    }
    return limits;
}

void check_source(const MapSet& maps, const TriMesh& surface, const ClaimedError& claimed, const Options& options,
                  FileValidation& out, FindingList& findings) {
    if (maps.source_hash != options.source->hash)
        findings.warning(codes::kSourceDiffers, "/",
                         fmt::format("the file was baked from `{}` with hash {}, `{}` has {}", maps.source_name,
                                     formats::to_hex(maps.source_hash), options.source->path.filename().string(),
                                     formats::to_hex(options.source->hash)));
    // The repaired source, as the bake measured: a face that stands twice there must not count twice here.
    const model::TriMesh& reference =
        options.source->oriented.faces.empty() ? options.source->mesh : options.source->oriented;
    const bake::SurfaceError error = bake::measure_surface_error(reference, surface, options.sampling);
    out.error = error;
    const Limits limits = limits_for(options, claimed, error.diagonal);
    const auto percent = [&](double x) { return error.diagonal > 0 ? 100 * x / error.diagonal : 0; };
    if (!(error.rms <= limits.rms))
        findings.error(codes::kRmsExceeded, "/charts",
                       fmt::format("rms distance {:.4g} ({:.4g} % of the diagonal) is above the limit of {}", error.rms,
                                   percent(error.rms), limits.origin_rms),
                       {error.rms, limits.rms});
    if (!(error.hausdorff <= limits.hausdorff))
        findings.error(codes::kHausdorffExceeded, "/charts",
                       fmt::format("largest distance {:.4g} ({:.4g} % of the diagonal) is above the limit of {}",
                                   error.hausdorff, percent(error.hausdorff), limits.origin_hausdorff),
                       {error.hausdorff, limits.hausdorff});
    if (options.source->oriented.faces.empty()) return;
    out.turned_faces = bake::count_turned_faces(options.source->oriented, surface);
    if (*out.turned_faces > 0)
        findings.warning(
            codes::kTurnedFaces, "/charts",
            fmt::format("{} of {} triangles look against the source", *out.turned_faces, surface.faces.size()),
            {static_cast<double>(*out.turned_faces), 0});
}

void check_maps(const MapSet& maps, const Options& options, FileValidation& out, FindingList& findings) {
    out.charts = maps.charts.size();
    if (maps.charts.empty()) findings.error(codes::kMissingLayer, "/charts", "the file holds no chart");
    std::vector<std::optional<bake::Topology>> topologies(maps.charts.size());
    TriMesh whole;
    bool complete = !maps.charts.empty();
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        if (!check_layers(maps.charts[k], k, findings)) {
            complete = false;
            continue;
        }
        try {
            const bake::Reconstruction surface = bake::reconstruct(maps.charts[k]);
            topologies[k] = check_surface(maps.charts[k], k, surface, findings);
            if (options.source != nullptr) append_mesh(whole, surface.mesh);
        } catch (const model::Error& error) {
            findings.error(error.code(), layer_path(k, error.place()), error.what());
            complete = false;
        }
    }
    const ClaimedError claimed = check_report(maps, topologies, findings);
    if (options.source != nullptr && complete) check_source(maps, whole, claimed, options, out, findings);
}
}  // namespace

ExitCode FileValidation::exit_code() const {
    ExitCode code = ExitCode::kOk;
    for (const formats::Finding& f : findings)
        if (f.severity == formats::Severity::kError) code = model::worse(code, f.code->exit);
    return code;
}

Source load_source(const std::filesystem::path& path) {
    Source source{path, formats::hash_file(path), formats::read_mesh(path).mesh, {}};
    source.oriented = oriented(source.mesh);
    return source;
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

FileValidation validate_file(const std::filesystem::path& path, const Options& options) {
    FileValidation out;
    out.path = path;
    FindingList findings;
    try {
        findings.append(formats::check_container(path));
        // Values are worth reading only if the bytes are the ones that were written.
        if (!findings.has_errors()) check_maps(formats::read_dgm(path), options, out, findings);
    } catch (const model::Error& error) { findings.error(error.code(), error.place(), error.what()); }
    out.findings = findings.take();
    return out;
}

}  // namespace dgm::validate
