// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/region.cpp
#include "geometry/fit/region.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace dgm::bake {
namespace {

// Of the squared error, what is left alone in a round: more costs more than it saves, and less leaves nearly all faces.
constexpr double kConverged = 0.05;
constexpr int kRings = 2;            // around the faces that have not: samples come to them from there
constexpr int kFarRings = 4;         // around those that are far off
constexpr double kMostOfGrid = 0.9;  // of all faces, from which on the region is the grid

/// Squared error per face of the grid, as the matches weigh it.
std::vector<double> squared_errors(const WeldedGrid& grid, const Matches& matches) {
    std::vector<double> out(grid.surface.faces.size(), 0.0);
    for (const Match& m : matches.points) out[m.hit.face] += m.weight * m.hit.squared;
    for (std::size_t f = 0; f < out.size(); ++f) {
        out[f] += matches.middles[f].weight * matches.middles[f].hit.squared;
        for (const std::uint32_t c : grid.surface.faces[f])
            out[f] += matches.classes[c].weight * matches.classes[c].hit.squared / 6;  // six faces around most
    }
    return out;
}

/// A value below which all others together are at most `share` of the sum: the mean, halved until that holds.
double value_that_counts(const std::vector<double>& values, double share) {
    constexpr int kHalvings = 60;
    double sum = 0;
    for (const double v : values) sum += v;
    double least = sum / static_cast<double>(values.size());
    for (int k = 0; k < kHalvings; ++k, least *= 0.5) {
        double below = 0;
        for (const double v : values) below += v < least ? v : 0;
        if (below <= share * sum) break;
    }
    return least;
}

/// The corners of a face.
void mark(const WeldedGrid& grid, std::size_t face, std::vector<char>& classes) {
    for (const std::uint32_t c : grid.surface.faces[face]) classes[c] = 1;
}

Region unless_nearly_all(Region region) {
    const auto inside = static_cast<double>(std::count(region.faces.begin(), region.faces.end(), 1));
    return inside > kMostOfGrid * static_cast<double>(region.faces.size()) ? Region{} : std::move(region);
}

}  // namespace

Region grown(const WeldedGrid& grid, std::vector<char> classes, int rings) {
    const LinkedSurface& surface = grid.surface;
    Region out{std::move(classes), std::vector<char>(surface.faces.size(), 0)};
    for (int ring = 0; ring < rings; ++ring) {
        std::vector<char> next = out.classes;
        for (const auto& [a, b] : grid.edges) {
            next[a] |= out.classes[b];
            next[b] |= out.classes[a];
        }
        out.classes.swap(next);
    }
    for (std::size_t f = 0; f < out.faces.size(); ++f)
        for (const std::uint32_t c : surface.faces[f]) out.faces[f] |= out.classes[c];
    return out;
}

Region unconverged(const WeldedGrid& grid, const Matches& matches) {
    const std::vector<double> errors = squared_errors(grid, matches);
    const double least = value_that_counts(errors, kConverged);
    std::vector<char> classes(grid.sample_of.size(), 0);
    for (std::size_t f = 0; f < errors.size(); ++f)
        if (errors[f] >= least) mark(grid, f, classes);
    return unless_nearly_all(grown(grid, std::move(classes), kRings));
}

Region around_far(const WeldedGrid& grid, const Matches& matches, double distance) {
    std::vector<char> classes(grid.sample_of.size(), 0);
    for (const std::uint32_t f : matches.faces_beyond(distance)) mark(grid, f, classes);
    return unless_nearly_all(grown(grid, std::move(classes), kFarRings));
}

}  // namespace dgm::bake
