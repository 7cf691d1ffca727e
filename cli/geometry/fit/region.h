// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/region.h
// Parts of a grid that a round of the fit works on while the rest is held.
#pragma once
#include <vector>

#include "geometry/fit/matches.h"

namespace dgm::bake {

/// Classes that may move and all faces around them; both empty: the whole grid.
struct Region {
    std::vector<char> classes, faces;

    [[nodiscard]] bool is_whole() const { return faces.empty(); }
};

/// The marked classes with `rings` rings of others around them.
[[nodiscard]] Region grown(const WeldedGrid& grid, std::vector<char> classes, int rings);

/// The faces with a match farther away than that, and some rings around them; the whole grid where they are nearly all
/// of it.
[[nodiscard]] Region around_far(const WeldedGrid& grid, const Matches& matches, double distance);

}  // namespace dgm::bake
