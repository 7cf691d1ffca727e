// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/edge_snap.cpp
#include "geometry/fit/edge_snap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "geometry/fit/grid_cells.h"
#include "geometry/fit/pieces.h"
#include "geometry/fit/ring_error.h"
#include "geometry/fit/source_edges.h"
#include "geometry/mesh/infinity.h"
#include "geometry/mesh/triangle.h"

namespace dgm::bake {
namespace {

// Chosen by measurement on clothes, organs and characters of 150 to 5,000 vertices.
constexpr double kWorth = 0.3;                 // of the mean error, around a sample that is tried
constexpr double kGain = 0.98;                 // of the error around a sample, that a place has to be below
constexpr double kGridShare = 0.5;             // weight of the grid's faces in all, against the source's points
constexpr RingBounds kBounds{0.3, 0.04};       // of faces around a place ...
constexpr double kTilt = 0.1, kThinner = 0.5;  // ... and what those may lose that are beyond them already
constexpr std::size_t kPointsPerClass = 8;     // of the source, that errors are measured at
constexpr int kSweeps = 4;

/// A place, and by how much it lowers the error.
struct Offer {
    RingPlace place;
    double gain = 0;
};

class EdgeSnap {
 public:
    explicit EdgeSnap(FitState& fit);
    /// @return  true if a sample moved
    bool run();

 private:
    void deal_points();
    void find_flips();
    [[nodiscard]] std::array<Vec3d, 3> corners(const Face& classes) const {
        return {positions_[classes[0]], positions_[classes[1]], positions_[classes[2]]};
    }
    [[nodiscard]] bool is_worth_trying(std::uint32_t c) const;
    [[nodiscard]] std::vector<Offer> best_places(const std::vector<std::uint32_t>& classes);
    [[nodiscard]] Offer best_place(std::uint32_t c, RingError& ring) const;
    std::size_t take(const std::vector<std::uint32_t>& classes, const std::vector<Offer>& offers);
    void move(std::uint32_t c, const RingPlace& place);
    void deal_again(std::span<const std::uint32_t> around);

    FitState& fit_;
    std::vector<Vec3d>& positions_;
    GridCells cells_;
    double mean_ = 0, spacing_ = 0;                   // squared distance of a point; of samples
    std::vector<std::vector<std::uint32_t>> points_;  // per cell: matches over it
    std::vector<char> may_flip_;                      // per cell
    std::vector<char> settled_;                       // per class: nothing around it has changed since it was tried
    RingSurroundings surroundings_;
    std::optional<SourceEdges> edges_;
};

EdgeSnap::EdgeSnap(FitState& fit)
    : fit_(fit),
      positions_(fit.grid.surface.positions),
      cells_(fit.chart, fit.grid),
      settled_(positions_.size(), 0),
      surroundings_{fit.source, cells_, positions_, fit.matches, points_, may_flip_, 0} {
    deal_points();
    find_flips();
    edges_.emplace(fit, std::sqrt(mean_), spacing_);
}

/// Some of the area-uniform points, and the source's vertices where they are fewer than half as many.
void EdgeSnap::deal_points() {
    const Matches& matches = fit_.matches;
    const std::size_t enough = kPointsPerClass * positions_.size();
    const std::size_t stride = 1 + (std::max<std::size_t>(matches.area_points, 1) - 1) / enough;
    const bool vertices = matches.points.size() - matches.area_points < enough / 2;
    points_.resize(cells_.size());
    double sum = 0;
    for (std::uint32_t k = 0; k < matches.points.size(); ++k) {
        const Match& m = matches.points[k];
        if (k < matches.area_points) sum += m.hit.squared;
        if (k < matches.area_points ? k % stride == 0 : vertices) points_[cells_.cell_of(m.hit.face)].push_back(k);
    }
    mean_ = sum / static_cast<double>(std::max<std::size_t>(1, matches.area_points));
    const double area = surface_area(fit_.grid.surface);
    spacing_ = std::sqrt(area / static_cast<double>(positions_.size()));
    const auto counted = static_cast<double>(matches.area_points / stride);
    surroundings_.per_area = area > 0 ? kGridShare * counted / area : 0;
}

/// A quad may be split the other way where the welded surface has no such edge, and no other quad asks for it.
void EdgeSnap::find_flips() {
    std::vector<std::pair<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>> wanted;
    may_flip_.assign(cells_.size(), 0);
    for (std::uint32_t cell = 0; cell < cells_.size() && cells_.is_quad(cell); ++cell)
        wanted.emplace_back(cells_.ends(cell, 1 - cells_.diagonal(cell)), cell);
    std::sort(wanted.begin(), wanted.end());
    auto edge = fit_.grid.edges.begin();
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        const auto& [ends, cell] = wanted[k];
        while (edge != fit_.grid.edges.end() && *edge < ends) ++edge;
        const bool is_edge = edge != fit_.grid.edges.end() && *edge == ends;
        const bool alone =
            (k == 0 || wanted[k - 1].first != ends) && (k + 1 == wanted.size() || wanted[k + 1].first != ends);
        may_flip_[cell] = ends.first != ends.second && alone && !is_edge;
    }
}

bool EdgeSnap::run() {
    bool any = false;
    for (int sweep = 0; sweep < kSweeps && !fit_.is_spent(); ++sweep) {
        std::vector<std::uint32_t> tried;
        for (std::uint32_t c = 0; c < positions_.size(); ++c)
            if (is_worth_trying(c)) tried.push_back(c);
        if (take(tried, best_places(tried)) == 0) break;
        any = true;
    }
    return any;
}

bool EdgeSnap::is_worth_trying(std::uint32_t c) const {
    const auto around = cells_.around(c);
    if (fit_.fixed[c] || settled_[c] || !edges_->has_any(c) || around.size() > RingPlace::kMostCells) return false;
    double sum = 0;
    std::size_t count = 1;
    for (const std::uint32_t cell : around) {
        count += points_[cell].size();
        for (const std::uint32_t k : points_[cell])
            sum += fit_.matches.points[k].weight * fit_.matches.points[k].hit.squared;
    }
    return sum > kWorth * mean_ * static_cast<double>(count);
}

/// Of each class, while all others stay.
std::vector<Offer> EdgeSnap::best_places(const std::vector<std::uint32_t>& classes) {
    std::vector<Offer> out(classes.size());
    std::vector<std::uint64_t> looked(pieces_of(classes.size()), 0);
    in_pieces(classes.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
        RingError ring(surroundings_);
        for (std::size_t k = begin; k < end; ++k) out[k] = best_place(classes[k], ring);
        looked[piece] = ring.looked();
    });
    for (const std::uint64_t faces : looked) fit_.matches.count_looks(faces);
    for (const std::uint32_t c : classes) settled_[c] = 1;
    return out;
}

Offer EdgeSnap::best_place(std::uint32_t c, RingError& ring) const {
    RingBounds bounds;
    const RingPlace present = ring.present(c, bounds);
    bounds.upright = std::min(kBounds.upright, bounds.upright - kTilt);
    bounds.thickness = std::min(kBounds.thickness, bounds.thickness * kThinner);
    Offer out{present, 0};
    double limit = kGain * present.error;
    for (const Vec3d& to : edges_->places(c, present.position)) {
        RingPlace place{to, 0, {}};
        if (!ring.measure(c, bounds, limit, place)) continue;
        limit = place.error;
        out = {place, present.error - place.error};
    }
    return out;
}

/// Moves the classes that gain the most, as long as nothing around them has moved in this sweep.
/// @return  how many moved
std::size_t EdgeSnap::take(const std::vector<std::uint32_t>& classes, const std::vector<Offer>& offers) {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < classes.size(); ++k)
        if (offers[k].gain > 0) order.push_back(k);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return offers[a].gain > offers[b].gain; });
    std::vector<char> changed(cells_.size(), 0);
    std::size_t moved = 0;
    for (const std::size_t k : order) {
        const auto around = cells_.around(classes[k]);
        if (std::any_of(around.begin(), around.end(), [&](std::uint32_t cell) { return changed[cell] != 0; })) {
            settled_[classes[k]] = 0;
            continue;
        }
        for (const std::uint32_t cell : around) changed[cell] = 1;
        move(classes[k], offers[k].place);
        ++moved;
    }
    return moved;
}

void EdgeSnap::move(std::uint32_t c, const RingPlace& place) {
    const auto around = cells_.around(c);
    positions_[c] = place.position;
    SurfaceHit& hit = fit_.matches.classes[c].hit;
    hit = walk_to_closest(fit_.source, place.position, hit.face);
    for (std::size_t k = 0; k < around.size(); ++k) {
        if (cells_.is_quad(around[k])) fit_.chart.diagonals[cells_.quad(around[k])] = place.diagonals[k];
        for (unsigned d = 0; d < 2; ++d) {
            const CellFaces of = cells_.faces(around[k], d);
            for (int f = 0; f < of.count; ++f)
                for (const std::uint32_t other : of.faces[f]) settled_[other] = other == c;
        }
    }
    deal_again(around);
}

/// The points over these cells go to the nearest of them.
void EdgeSnap::deal_again(std::span<const std::uint32_t> around) {
    std::vector<std::uint32_t> all;
    std::vector<std::pair<std::uint32_t, std::array<Vec3d, 3>>> faces;
    for (const std::uint32_t cell : around) {
        all.insert(all.end(), points_[cell].begin(), points_[cell].end());
        points_[cell].clear();
        const CellFaces of = cells_.faces(cell, cells_.diagonal(cell));
        for (int f = 0; f < of.count; ++f) faces.emplace_back(cell, corners(of.faces[f]));
    }
    std::array<double, 3> ignored{};
    for (const std::uint32_t k : all) {
        Match& m = fit_.matches.points[k];
        std::uint32_t nearest = around[0];
        m.hit.squared = kInfinity;
        for (const auto& [cell, triangle] : faces)
            if (const double squared = closest_on_triangle(m.position, triangle, ignored); squared < m.hit.squared) {
                m.hit.squared = squared;
                nearest = cell;
            }
        points_[nearest].push_back(k);
        m.hit.face = cells_.first_face(nearest);
    }
}

}  // namespace

bool snap_to_edges(FitState& fit) {
    if (!EdgeSnap(fit).run()) return false;
    fit.relink();
    fit.grid.surface.update_normals();
    fit.matches.update(false);
    return true;
}

}  // namespace dgm::bake
