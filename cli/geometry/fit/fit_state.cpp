// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit_state.cpp
#include "geometry/fit/fit_state.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "geometry/fit/diagonals.h"
#include "geometry/fit/normal_equations.h"

namespace dgm::bake {
namespace {

// Of the last step, in the next one: at most, and how slowly it comes to that [Nesterov 1983].
constexpr double kMomentum = 0.85, kRamp = 3;

// Facets of the source a face of the grid from which on points are what the fit lacks, and how many there may be: 80
// bytes each.
constexpr double kDense = 0.4, kMostPoints = 2e6;

/// Source points a sample of a grid that is not small.
double points_per_sample(const SampledChart& chart, const FitOptions& options) {
    const auto samples = static_cast<double>(chart.grid_count());
    const bool dense = static_cast<double>(chart.disk->mesh.faces.size()) >= kDense * 2 * samples;
    const bool many = dense && chart.grid_count() >= kLargeGrid && options.points_of_dense * samples <= kMostPoints;
    return many ? std::max(options.points_per_sample, options.points_of_dense) : options.points_per_sample;
}

std::size_t point_count(const SampledChart& chart, const FitOptions& options, double per_sample) {
    const double samples = static_cast<double>(chart.grid_count()), wanted = per_sample * samples;
    return static_cast<std::size_t>(
        std::max(wanted, std::min(static_cast<double>(options.points_of_small), 3 * wanted)));
}

}  // namespace

FitState::FitState(SampledChart& fitted, const FitOptions& options)
    : chart(fitted),
      most_looks(options.most_looks != 0 ? options.most_looks : most_looks_of(fitted.grid_count())),
      holds_largest(options.worst_rounds > 0),
      damping(options.hold.damping),
      points_a_sample(points_per_sample(fitted, options)),
      has_dense_points(points_a_sample > options.points_per_sample),
      source(link_source(*fitted.disk)),
      grid(fitted),
      matches(fitted, source, grid, point_count(fitted, options, points_a_sample), options.hold),
      fixed(grid.on_border),
      rails(fitted, source, grid),
      upward(normals_at_scale(source, surface_area(source) / static_cast<double>(fitted.grid_count()))),
      sliding(grid, matches, rails, upward, fixed),
      inverted(source, grid.surface, fitted.disk),
      rows(source, grid, matches, rails, points_a_sample),
      equations(grid) {}

double FitState::largest() const {
    return std::max(matches.largest, rails.largest_gap());
}

void FitState::keep() {
    kept = {matches.rms, largest(), grid.surface.positions, chart.diagonals, rails.places()};
}

void FitState::restore() {
    grid.surface.positions = kept.positions;
    chart.diagonals = kept.diagonals;
    relink();
    rails.set_places(kept.places);
}

void FitState::go_back_to(const Kept& before) {
    kept = before;
    restore();
    matches.update(holds_largest);
}

void FitState::relink() {
    grid.link(chart);
    rows.forget_edges();
}

void FitState::look_up_farthest() {
    matches.update(true);
    matches.settle_farthest(inverted.source_index());
}

void FitState::step(bool worst_only, const Region& region) {
    equations.clear();
    rows.assemble(equations, worst_only, region.faces, true);
    std::vector<Freedom> freedom(rails.freedom().begin(), rails.freedom().end());
    for (std::size_t c = 0; c < region.classes.size(); ++c)
        if (!region.classes[c]) freedom[c] = Freedom::kHeld;
    std::vector<Vec3d> onward;
    steps_ = came_from_.empty() ? 0 : steps_ + 1;
    if (!worst_only && steps_ > 0) {
        const double share = std::min(kMomentum, steps_ / (steps_ + kRamp));
        onward.resize(came_from_.size());
        for (std::size_t c = 0; c < onward.size(); ++c) onward[c] = (grid.surface.positions[c] - came_from_[c]) * share;
    }
    came_from_ = grid.surface.positions;
    const std::vector<Vec3d> step = equations.solve(freedom, rails.directions(), damping, kCgIterations, onward);
    std::vector<double> ways(rails.empty() ? 0 : step.size());
    for (std::size_t c = 0; c < ways.size(); ++c) ways[c] = dot(step[c], rails.directions()[c]);
    sliding.take(step, std::move(ways));
}

void FitState::split_quads() {
    const std::vector<char> changed = fit_diagonals(chart, grid, matches, source);
    relink();
    matches.update(false, changed);
}

bool FitState::flip_quads(std::span<const std::uint32_t> faces, bool measured) {
    if (!flip_diagonals(chart, grid, faces, measured ? &inverted.source_index() : nullptr)) return false;
    relink();
    matches.update(false);
    return true;
}

void FitState::move_back(std::span<const std::uint32_t> faces, const std::vector<Vec3d>& before,
                         std::span<char> went_back) {
    LinkedSurface& surface = grid.surface;
    std::vector<char> back(surface.positions.size(), 0), near(surface.faces.size(), 0);
    for (const std::uint32_t f : faces)
        for (const std::uint32_t c : surface.faces[f]) back[c] = !fixed[c];
    for (std::size_t c = 0; c < back.size(); ++c)
        if (back[c]) surface.positions[c] = before[c];
    for (std::size_t c = 0; c < went_back.size(); ++c) went_back[c] |= back[c];
    for (std::size_t f = 0; f < near.size(); ++f)
        for (const std::uint32_t c : surface.faces[f]) near[f] |= back[c];
    for (std::uint32_t f = 0; f < near.size(); ++f)
        if (near[f]) surface.update_normal(f);
    matches.update(holds_largest, near);
}

std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& all, const std::vector<std::uint32_t>& known) {
    std::vector<std::uint32_t> out;
    std::set_difference(all.begin(), all.end(), known.begin(), known.end(), std::back_inserter(out));
    return out;
}

}  // namespace dgm::bake
