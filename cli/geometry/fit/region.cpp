// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/region.cpp
#include "geometry/fit/region.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace dgm::bake {
namespace {

constexpr int kFarRings = 4;         // around the faces that are far off: samples come to them from there
constexpr double kMostOfGrid = 0.9;  // of all faces, from which on the region is the grid

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

Region around_far(const WeldedGrid& grid, const Matches& matches, double distance) {
    std::vector<char> classes(grid.sample_of.size(), 0);
    for (const std::uint32_t f : matches.faces_beyond(distance))
        for (const std::uint32_t c : grid.surface.faces[f]) classes[c] = 1;
    Region out = grown(grid, std::move(classes), kFarRings);
    const auto inside = static_cast<double>(std::count(out.faces.begin(), out.faces.end(), 1));
    return inside > kMostOfGrid * static_cast<double>(out.faces.size()) ? Region{} : out;
}

}  // namespace dgm::bake
