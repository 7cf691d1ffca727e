// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/repair.cpp
// Corner gluing: union-find over the 3F corners of the soup (see repair.h for the five steps).
//
// Our choice over a polygon-soup library: per-corner normals, UVs and colours must follow every change, and a soup
// library renames points without saying which corner became which.
#include "geometry/repair/repair.h"

#include "geometry/repair/collapse_degenerate.h"
#include "geometry/repair/face_height.h"
#include "geometry/repair/face_soup.h"
#include "geometry/repair/flip_degenerate.h"
#include "geometry/repair/glue_edges.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

bool has_height(const TriMesh& component) {
    for (std::size_t f = 0; f < component.faces.size(); ++f)
        if (!without_height(component.corners(f))) return true;
    return false;
}

/// A component that lies within a line cannot be seen and has no map.
void drop_components_without_height(std::vector<TriMesh>& components, RepairCounts& counts) {
    std::vector<TriMesh> kept;
    std::uint64_t dropped = 0;
    for (TriMesh& component : components) {
        if (has_height(component)) {
            kept.push_back(std::move(component));
        } else {
            dropped += component.faces.size();
        }
    }
    if (kept.empty()) throw Error(codes::kNoFaces, "the faces have no area: all corners lie on one line");
    components = std::move(kept);
    add_count(counts, "zero-height faces apart from all others dropped", dropped);
}

/// Each step makes room for the other: an edge collapsed may leave a face that a neighbour can take in, and a flip
/// a corner whose faces all lie within a line.
void remove_degenerate(TriMesh& component, RepairCounts& counts) {
    constexpr int kMaxRounds = 32;
    for (int round = 0; round < kMaxRounds; ++round) {
        const std::uint64_t flipped = flip_degenerate(component), collapsed = collapse_degenerate(component);
        add_count(counts, "zero-height faces flipped away", flipped);
        add_count(counts, "zero-height faces collapsed", collapsed);
        if (flipped + collapsed == 0) break;
    }
}

void require_area(const std::vector<TriMesh>& components) {
    double area = 0;
    for (const TriMesh& component : components)
        for (std::size_t f = 0; f < component.faces.size(); ++f) area += face_area(component.corners(f));
    constexpr double kLeastArea = 1e-12;  // of the squared diagonal
    if (!(area > kLeastArea)) throw Error(codes::kNoFaces, "the faces have no area: all corners lie on one line");
}

}  // namespace

RepairedMesh repair(const TriMesh& source) {
    RepairedMesh out;
    FaceSoup soup = usable_faces(source, out.counts);
    out.frame = normalise(soup, out.counts);
    weld_open_vertices(soup, out.counts);
    drop_repeated_corners(soup, out.counts);
    drop_duplicate_faces(soup, out.counts);
    if (soup.faces.empty()) throw Error(codes::kNoFaces, "no face with three distinct, finite corners is left");
    const std::vector<std::uint32_t> partner = glue_edges(soup, out.counts);
    const Orientation orientation = orient(soup, partner, out.counts);
    out.components = build_components(source, soup, partner, orientation, out.counts);
    drop_components_without_height(out.components, out.counts);
    for (TriMesh& component : out.components) remove_degenerate(component, out.counts);
    require_area(out.components);
    return out;
}

}  // namespace dgm::bake
