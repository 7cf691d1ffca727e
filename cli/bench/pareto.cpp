// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/pareto.cpp
#include "bench/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dgm::bench {

std::vector<std::size_t> pareto_front(std::span<const Cost> points) {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < points.size(); ++k)
        if (std::isfinite(points[k].x) && std::isfinite(points[k].y)) order.push_back(k);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return points[a].x != points[b].x ? points[a].x < points[b].x : points[a].y < points[b].y;
    });
    std::vector<std::size_t> front;
    double lowest = std::numeric_limits<double>::infinity();
    for (const std::size_t k : order) {
        if (points[k].y >= lowest) continue;
        lowest = points[k].y;
        front.push_back(k);
    }
    return front;
}

}  // namespace dgm::bench
