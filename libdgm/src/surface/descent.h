// SPDX-License-Identifier: MIT
// libdgm/src/surface/descent.h
// The way down a pyramid, nearest box first.
#pragma once
#include <algorithm>
#include <cstdint>

#include "surface/surface.h"

namespace dgm::detail {

/// Calls leaf(tile) for the tiles of the boxes that are not too far, nearer ones of a node first. `distance(box)` is a
/// lower bound, of any unit; `too_far(distance)` may become true for more of them as leaves are searched.
template <class Distance, class TooFar, class Leaf>
void descend(const Pyramid& p, Distance distance, TooFar too_far, Leaf leaf) noexcept {
    struct Entry {
        decltype(distance(p.boxes[0])) at;
        std::uint32_t level, node;
    };
    Entry stack[4 * kMaxLevels];  // a visited node leaves at most three siblings behind on each level
    std::uint32_t depth = 0;
    stack[depth++] = {0, p.levels - 1, 0};
    while (depth != 0) {
        const Entry e = stack[--depth];
        if (too_far(e.at)) continue;
        if (e.level == 0) {
            leaf(e.node);
            continue;
        }
        const std::uint32_t level = e.level - 1, r = e.node / p.cols[e.level] * 2, c = e.node % p.cols[e.level] * 2;
        const std::uint32_t first = depth;
        for (std::uint32_t i = r; i < std::min(r + 2, p.rows[level]); ++i)
            for (std::uint32_t j = c; j < std::min(c + 2, p.cols[level]); ++j) {
                const std::uint32_t node = i * p.cols[level] + j;
                const auto at = distance(p.boxes[p.start[level] + node]);
                if (too_far(at)) continue;
                std::uint32_t place = depth++;
                for (; place > first && stack[place - 1].at < at; --place) stack[place] = stack[place - 1];
                stack[place] = {at, level, node};
            }
    }
}

}  // namespace dgm::detail
