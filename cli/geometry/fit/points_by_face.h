// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/points_by_face.h
// The matches of a fit by the faces that they lie over.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/fit/matches.h"

namespace dgm::bake {

/// Points over face f when it was made, ascending: of[first[f]] .. of[first[f + 1] - 1].
struct PointsByFace {
    std::vector<std::uint32_t> first, of;

    PointsByFace(std::span<const Match> points, std::size_t faces) : first(faces + 1, 0), of(points.size()) {
        for (const Match& m : points) ++first[m.hit.face + 1];
        for (std::size_t f = 0; f < faces; ++f) first[f + 1] += first[f];
        std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
        for (std::uint32_t k = 0; k < points.size(); ++k) of[next[points[k].hit.face]++] = k;
    }
};

}  // namespace dgm::bake
