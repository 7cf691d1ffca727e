// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/dilate.cpp
#include "geometry/layers/dilate.h"

namespace dgm::bake {

std::vector<std::uint32_t> nearest_covered(std::span<const char> covered, std::uint32_t rows, std::uint32_t cols) {
    std::vector<std::uint32_t> from(covered.size(), kNone), front;
    for (std::uint32_t t = 0; t < covered.size(); ++t)
        if (covered[t]) {
            from[t] = t;
            front.push_back(t);
        }
    for (std::size_t at = 0; at < front.size(); ++at) {
        const std::uint32_t t = front[at], i = t / cols, j = t % cols;
        const auto visit = [&](std::uint32_t to) {
            if (from[to] != kNone) return;
            from[to] = from[t];
            front.push_back(to);
        };
        if (i > 0) visit(t - cols);
        if (i + 1 < rows) visit(t + cols);
        if (j > 0) visit(t - 1);
        if (j + 1 < cols) visit(t + 1);
    }
    return from;
}

}  // namespace dgm::bake
