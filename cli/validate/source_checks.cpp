// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/source_checks.cpp
#include "validate/source_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <tuple>
#include <vector>

#include "dgm/hash.h"
#include "geometry/metrics/turned_faces.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "validate/layer_checks.h"

namespace dgm::validate {
namespace {
using bake::Topology;
using model::TriMesh;
namespace codes = model::codes;

/// Components, boundary loops, genus; whether the genus counts crosscaps.
using Shape = std::tuple<std::uint64_t, std::uint64_t, std::int64_t, bool>;
Shape shape_of(const Topology& t) {
    return {t.components, t.boundary_loops, t.genus, !t.oriented};
}
std::string shapes_text(const std::vector<Shape>& shapes) {
    constexpr std::size_t kMost = 4;
    std::string text;
    for (std::size_t k = 0; k < std::min(shapes.size(), kMost); ++k)
        text += fmt::format("{}{} {} with {} borders", k == 0 ? "" : ", ",
                            std::get<3>(shapes[k]) ? "one side, genus" : "genus", std::get<2>(shapes[k]),
                            std::get<1>(shapes[k]));
    return text + (shapes.size() > kMost ? fmt::format(" and {} more", shapes.size() - kMost) : "");
}

/// Each piece of the repaired source has one chart with its topology, and each chart its piece.
void check_source_topology(const SourceComparison& file, const Source& source, FindingList& findings) {
    std::vector<Shape> charts, pieces;
    for (const auto& topology : file.topologies) {
        if (!topology || !topology->manifold) return;  // reported with its chart
        charts.push_back(shape_of(*topology));
    }
    for (const Topology& topology : source.topologies) pieces.push_back(shape_of(topology));
    std::sort(charts.begin(), charts.end());
    std::sort(pieces.begin(), pieces.end());
    if (charts == pieces) return;
    std::vector<Shape> added, missing;
    std::set_difference(charts.begin(), charts.end(), pieces.begin(), pieces.end(), std::back_inserter(added));
    std::set_difference(pieces.begin(), pieces.end(), charts.begin(), charts.end(), std::back_inserter(missing));
    findings.error(codes::kTopologyDiffers, "/charts",
                   fmt::format("{} charts, {} pieces of the source; only in the file: {}; only in the source: {}",
                               charts.size(), pieces.size(), added.empty() ? "nothing" : shapes_text(added),
                               missing.empty() ? "nothing" : shapes_text(missing)),
                   {static_cast<double>(charts.size()), static_cast<double>(pieces.size())});
}

struct Limits {
    double rms, hausdorff;  // infinity: none
    const char* origin_rms;
    const char* origin_hausdorff;
};

Limits limits_for(const Options& options, const ClaimedError& claimed, double diagonal) {
    // The bake measured the repaired mesh, from other random points: the mean repeats well within 1 %, the maximum of a
    // sample less well. The last term is the rounding of positions to float.
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

std::string coordinates(const model::Vec3d& p) {
    return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x, p.y, p.z);
}

/// Where to look for a face of all charts: on the grid and in space.
std::string place_of(const SourceComparison& file, std::uint32_t face) {
    const auto [a, b, c] = file.surface.corners(face);
    const model::Vec3d middle = (a + b + c) / 3;
    std::size_t chart = 0;
    std::uint64_t sample = file.surface.faces[face][0];
    const auto grid = [&] { return std::uint64_t{file.maps.charts[chart].rows} * file.maps.charts[chart].cols; };
    for (; sample >= grid() + border_samples(file.maps.charts[chart]); ++chart)
        sample -= grid() + border_samples(file.maps.charts[chart]);
    const std::uint32_t cols = file.maps.charts[chart].cols;
    return fmt::format("chart {} at {}, near {}", chart,
                       sample < grid() ? fmt::format("row {}, column {}", sample / cols, sample % cols)
                                       : fmt::format("border sample {}", sample - grid()),
                       coordinates(middle));
}

}  // namespace

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

Source load_source(const std::filesystem::path& path, const MeshReader& read) {
    formats::check_mesh_file(path);
    Source source{path, formats::hash_file(path), read ? read(path) : formats::read_mesh(path).mesh, {}, {}};
    try {
        const bake::RepairedMesh repaired = bake::repair(source.mesh);
        for (const TriMesh& component : repaired.components) {
            source.topologies.push_back(bake::measure_topology(component));
            append_mesh(source.oriented, component);
        }
        for (model::Vec3d& p : source.oriented.positions) p = repaired.frame.centre + p * repaired.frame.diagonal;
    } catch (const model::Error&) {
        source.oriented = {};
        source.topologies.clear();
    }
    return source;
}

void check_source(const SourceComparison& file, const Options& options, FileValidation& out, FindingList& findings) {
    const model::MapSet& maps = file.maps;
    const bool same = maps.source_hash == options.source->hash;
    if (!same)
        findings.warning(codes::kSourceDiffers, "/",
                         fmt::format("the file was baked from `{}` with hash {}, `{}` has {}", maps.source_name,
                                     formats::to_hex(maps.source_hash), options.source->path.filename().string(),
                                     formats::to_hex(options.source->hash)));
    // The repaired source, as the bake measured: a face that stands twice there must not count twice here.
    const TriMesh& reference = options.source->oriented.faces.empty() ? options.source->mesh : options.source->oriented;
    const bake::SurfaceError error = bake::measure_surface_error(reference, file.surface, options.sampling);
    out.error = error;
    const Limits limits = limits_for(options, file.claimed, error.diagonal);
    const auto percent = [&](double x) { return error.diagonal > 0 ? 100 * x / error.diagonal : 0; };
    if (!(error.rms <= limits.rms))
        findings.error(codes::kRmsExceeded, "/charts",
                       fmt::format("rms distance {:.4g} ({:.4g} % of the diagonal) is above the limit of {}", error.rms,
                                   percent(error.rms), limits.origin_rms),
                       {error.rms, limits.rms});
    if (!(error.hausdorff <= limits.hausdorff))
        findings.error(
            codes::kHausdorffExceeded, "/charts",
            fmt::format("largest distance {:.4g} ({:.4g} % of the diagonal), near {}, is above the limit of {}",
                        error.hausdorff, percent(error.hausdorff), coordinates(error.hausdorff_at),
                        limits.origin_hausdorff),
            {error.hausdorff, limits.hausdorff});
    // Limits of the caller's do not make a wrong report right.
    const Limits claims = limits_for({}, file.claimed, error.diagonal);
    if (same && options.max_rms_percent && !(error.rms <= claims.rms))
        findings.error(codes::kBadReport, "/report error.rms", "the distance is larger than the report says",
                       {error.rms, claims.rms});
    if (same && options.max_hausdorff_percent && !(error.hausdorff <= claims.hausdorff))
        findings.error(codes::kBadReport, "/report error.hausdorff", "the distance is larger than the report says",
                       {error.hausdorff, claims.hausdorff});
    if (options.source->oriented.faces.empty()) return;
    check_source_topology(file, *options.source, findings);
    const bake::ClosestPointIndex index(options.source->oriented.positions, options.source->oriented.faces);
    const std::vector<std::uint32_t> turned =
        bake::find_turned_faces(index, file.surface, bake::kTurnedTie, 0, file.either_side);
    out.turned_faces = turned.size();
    if (!turned.empty())
        findings.warning(codes::kTurnedFaces, "/charts",
                         fmt::format("{} of {} triangles look against the source, the first in {}", turned.size(),
                                     file.surface.faces.size(), place_of(file, turned.front())),
                         {static_cast<double>(turned.size()), 0});
}

}  // namespace dgm::validate
