// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_search.cpp
#include "geometry/cut_search/cut_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/cut_search/component_search.h"
#include "geometry/cut_search/cut_transfer.h"
#include "geometry/cut_search/limb_cut.h"
#include "geometry/cut_search/straight_cut.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/simplify/simplify.h"
#include "math/portable.h"
#include "model/codes.h"
#include "model/shortage.h"

namespace dgm::bake {
namespace {

struct GridSides {
    std::uint32_t m, n;
};

bool are_same(GridSides a, GridSides b) {
    return a.m == b.m && a.n == b.n;
}

/// An m x n grid shrunk to `longest` samples along its longer side.
GridSides shrink(GridSides grid, double longest) {
    const double share = std::min(1.0, (longest - 1) / (std::max(grid.m, grid.n) - 1));
    const auto side = [&](std::uint32_t samples) {
        return std::max(std::min(samples, 3u), 1 + static_cast<std::uint32_t>(std::lround((samples - 1) * share)));
    };
    return {side(grid.m), side(grid.n)};
}

std::uint32_t scaled_rotation(const Disk& disk, GridSides from, std::uint32_t rotation, GridSides to) {
    if (are_same(from, to)) return rotation;
    const double share = static_cast<double>(rotation) / BorderGrid{from.m, from.n}.count();
    return nearest_rotation(disk, to.m, to.n,
                            static_cast<std::uint32_t>(std::lround(share * BorderGrid{to.m, to.n}.count())));
}

CutSearchResult search_measured(const TriMesh& component, const CutSearchOptions& options, GridSides wanted,
                                const model::Progress& progress) {
    CutSearchOptions on_itself = options;
    on_itself.measured = true;
    on_itself.stars = 0;
    // The cut hardly depends on the resolution from here on, its cost does.
    const GridSides grid = shrink(wanted, 257);
    on_itself.m = grid.m;
    on_itself.n = grid.n;
    CutSearchResult out = search_component(component, on_itself, progress).result;
    out.rotation = scaled_rotation(out.disk, grid, out.rotation, wanted);
    return out;
}

// Faces of a component. Where there are more and the search on a simplified one fails, its limbs are cut: to measure
// cuts one by one takes minutes.
constexpr std::size_t kMostMeasured = 40'000;

/// Corners of the real border: a simplified border must keep them, they are nodes of it.
std::vector<char> border_corners(const TriMesh& mesh) {
    std::vector<char> corners(mesh.positions.size(), 0);
    const std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
    const auto direction = [&](std::uint32_t h) {
        return normalized(mesh.positions[target(mesh.faces, h)] - mesh.positions[origin(mesh.faces, h)], Vec3d{});
    };
    const double limit = math::cos(50 * M_PI / 180);  // as Disk::paths
    for (std::uint32_t h = 0; h < opposite.size(); ++h)
        if (opposite[h] == kNone)
            if (dot(direction(h), direction(next_border_half_edge(opposite, h))) < limit)
                corners[target(mesh.faces, h)] = 1;
    return corners;
}

bool is_sphere(const TriMesh& mesh) {
    const Topology topology = measure_topology(mesh.positions.size(), mesh.faces);
    return topology.boundary_loops == 0 && topology.genus == 0;
}

/// A component with fewer faces, and the way back.
struct Coarse {
    Simplified steps;
    CompactMesh compact;
};

/// Nothing if the component is small enough to be searched itself.
std::optional<Coarse> simplified(const TriMesh& component, const CutSearchOptions& options,
                                 const model::Progress& progress) {
    if (component.faces.size() <= options.coarse_faces + options.coarse_faces / 2) return std::nullopt;
    const std::vector<char> corners = border_corners(component);
    SimplifyOptions simplify_options;
    simplify_options.locked = corners;
    Coarse out;
    out.steps = simplify(component, options.coarse_faces, simplify_options, progress);
    out.compact = compact(component.positions, out.steps.faces);
    return out;
}

/// As many samples a vertex of `mesh` as the whole bake has of the component's, within limits.
GridSides trial_grid(const TriMesh& component, const TriMesh& mesh, const CutSearchOptions& options) {
    const GridSides wanted{options.m, options.n};
    const double share = std::sqrt(static_cast<double>(mesh.positions.size()) / component.positions.size());
    const double longest = (std::max(wanted.m, wanted.n) - 1) * share + 1;
    const double largest = options.largest_side;
    const GridSides grid = shrink(wanted, std::clamp(longest, 0.5 * largest, largest));
    // A network of 6g - 3 paths about g handles stands twice on the border; a path wants two intervals.
    const Topology shape = measure_topology(component.positions.size(), component.faces);
    const double intervals = 4 * (6.0 * static_cast<double>(shape.genus) - 3);
    return BorderGrid{grid.m, grid.n}.count() < intervals ? wanted : grid;
}

/// A cut found on the grid of the trials, for the component and the grid that are baked.
CutSearchResult carried_over(const TriMesh& component, const std::optional<Coarse>& coarse, ComponentCut found,
                             GridSides grid, GridSides wanted) {
    CutSearchResult out = std::move(found.result);
    const bool laid_out = out.shares != BorderShares::kByLength;  // its rotation is not heeded
    if (!coarse) {
        if (!laid_out) out.rotation = scaled_rotation(out.disk, grid, out.rotation, wanted);
        return out;
    }
    const std::vector<std::uint32_t>& original = coarse->compact.original;
    CutGraph fine(component);
    if (!transfer_cut(found.cut, original, coarse->steps, fine))
        throw model::Error(model::codes::kMapInvalid, "the cut of the simplified mesh could not be carried over");
    const Disk coarse_disk = std::move(out.disk);
    const double finer =
        std::sqrt(static_cast<double>(component.faces.size()) / static_cast<double>(coarse->steps.faces.size()));
    out.disk = found.straight ? open_straight(fine, kStraightReach * finer) : fine.open();
    out.cut_length = length_of_cut(out.disk);
    if (laid_out) return out;
    const auto rotation =
        transfer_rotation(coarse_disk, grid.m, grid.n, out.rotation, original, out.disk, wanted.m, wanted.n);
    out.rotation = rotation ? *rotation : candidate_rotations(out.disk, wanted.m, wanted.n, 1).front();
    return out;
}

/// The search on a component or the simplified one. On `grid`, which becomes the wanted one if its border has no room
/// for the paths that many loops and handles need.
ComponentCut search_on(const TriMesh& mesh, CutSearchOptions options, GridSides& grid, GridSides wanted,
                       const model::Progress& progress) {
    const auto search = [&] {
        options.m = grid.m;
        options.n = grid.n;
        return search_component(mesh, options, progress);
    };
    try {
        return search();
    } catch (const model::Error& e) {
        if (e.code().number != model::codes::kGridTooSmall.number || are_same(grid, wanted)) throw;
    }
    grid = wanted;
    return search();
}

}  // namespace

std::vector<CutSearchResult> search_other_cuts(const TriMesh& component, const CutSearchOptions& options,
                                               double most_rms, const model::Progress& progress) {
    constexpr std::array kStarts{CutStart::kAside, CutStart::kShort};
    constexpr int kPatience = 4;  // twice that and trials without branches took longer and gained nothing
    const GridSides wanted{options.m, options.n};
    const std::optional<Coarse> coarse = simplified(component, options, progress);
    const TriMesh& mesh = coarse ? coarse->compact.mesh : component;
    const GridSides grid = trial_grid(component, mesh, options);
    std::array<std::optional<CutSearchResult>, kStarts.size()> found;
    tbb::parallel_for(std::size_t{0}, kStarts.size(), [&](std::size_t k) {
        CutSearchOptions trial = options;
        GridSides tried_on = grid;
        trial.stars = 0;
        trial.start = kStarts[k];
        trial.patience = kPatience;
        trial.drops = 0;
        const model::Progress silent{{}, progress.cancelled};
        try {
            ComponentCut cut = search_on(mesh, trial, tried_on, wanted, silent);
            if (cut.result.rms <= most_rms)
                found[k] = carried_over(component, coarse, std::move(cut), tried_on, wanted);
        } catch (const model::Error& e) {
            if (e.code().number == model::codes::kInterrupted.number || model::is_shortage(e)) throw;
        }
    });
    std::vector<CutSearchResult> out;
    for (std::optional<CutSearchResult>& cut : found)
        if (cut) out.push_back(std::move(*cut));
    return out;
}

CutSearchResult search_cut(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress) {
    const GridSides wanted{options.m, options.n};
    const bool even = wanted.m % 2 == 0 || wanted.n % 2 == 0;
    if (options.only_stars && even)
        throw model::Error(model::codes::kMethodUnsuited,
                           "sphere: each side of the square folds at its middle sample, which even numbers of samples "
                           "do not have");
    if (options.measured) return search_measured(component, options, wanted, progress);
    const std::optional<Coarse> coarse = simplified(component, options, progress);
    const TriMesh& mesh = coarse ? coarse->compact.mesh : component;
    CutSearchOptions trial = options;
    if (!options.only_stars && (even || !is_sphere(mesh))) trial.stars = 0;
    GridSides grid = trial_grid(component, mesh, options);
    if (trial.stars > 0) grid = {grid.m | 1u, grid.n | 1u};
    try {
        ComponentCut found = search_on(mesh, trial, grid, wanted, progress);
        return carried_over(component, coarse, std::move(found), grid, wanted);
    } catch (const model::Error& e) {
        if (e.code().number == model::codes::kInterrupted.number || options.only_stars || model::is_shortage(e)) throw;
        if (options.only_simplified && trial.stars == 0) throw;
        // Where the border has no room for the paths of a simplified mesh, the whole one will find no more.
        if (trial.stars == 0 && e.code().number == model::codes::kGridTooSmall.number && are_same(grid, wanted)) throw;
    }
    if (trial.stars > 0) {  // another cut may succeed where a star fails
        CutSearchOptions others = options;
        others.stars = 0;
        return search_cut(component, others, progress);
    }
    if (component.faces.size() > kMostMeasured)
        if (std::optional<CutSearchResult> limbs = open_limbs(component, wanted.m, wanted.n, progress))
            return std::move(*limbs);
    return search_measured(component, options, wanted, progress);
}

}  // namespace dgm::bake
