// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/border_simple.cpp
#include "geometry/cgal/border_simple.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2_algorithms.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dgm::bake {

bool border_is_simple(std::span<const model::Vec2d> border) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    if (border.size() < 3) return false;
    std::vector<Kernel::Point_2> points;
    points.reserve(border.size());
    for (const model::Vec2d& p : border) {
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) return false;
        points.emplace_back(p.x, p.y);
    }
    // The sweep takes equal points for equal vertices: rule them out before.
    std::vector<Kernel::Point_2> sorted = points;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return false;
    return CGAL::is_simple_2(points.begin(), points.end(), Kernel());
}

}  // namespace dgm::bake
