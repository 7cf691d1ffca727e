// SPDX-License-Identifier: MIT
// libdgm/src/collide.cpp
// Nearest sample and hit test, paper section 5.1.
#include <dgm/collide.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <dgm/deform.h>

#include "state_impl.h"

namespace dgm {
namespace detail {
namespace {

bool is_finite(Vec3 v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Squared distances to samples and to boxes, rounded alike: for a point inside a box each |gap| is at most the
/// sample's |difference|, subtraction, squaring and adding round monotonically, so a box never seems farther than a
/// sample in it, and pruning by `box > best` is exact.
float sample_d2(Vec3 p, Vec3 tool) noexcept {
    const float x = p.x - tool.x, y = p.y - tool.y, z = p.z - tool.z;
    return x * x + y * y + z * z;
}
float box_d2(const Box& box, Vec3 tool) noexcept {
    const float x = std::max(std::max(box.low[0] - tool.x, tool.x - box.high[0]), 0.0f);
    const float y = std::max(std::max(box.low[1] - tool.y, tool.y - box.high[1]), 0.0f);
    const float z = std::max(std::max(box.low[2] - tool.z, tool.z - box.high[2]), 0.0f);
    return x * x + y * y + z * z;
}

struct Best {
    float d2 = std::numeric_limits<float>::infinity();
    std::uint32_t sample = kNone;
    void offer(float d, std::uint32_t k) noexcept {
        if (d < d2 || (d == d2 && k < sample)) {
            d2 = d;
            sample = k;
        }
    }
    [[nodiscard]] Result<Nearest> answer() const noexcept {
        if (sample == kNone) return Error{ErrorCode::NotFound, kNoOffset, "the chart has no sample to be near to"};
        return Nearest{sample, std::sqrt(d2)};
    }
};

void search_leaf(const StateImpl& s, std::uint32_t tile, Vec3 tool, Best& best) noexcept {
    const ChartTables& t = s.tables;
    const std::uint32_t ti = tile / s.tile_cols, tj = tile % s.tile_cols;
    // The tile's own samples; the last tile owns the grid's last row and column too.
    const std::uint32_t i1 = ti + 1 == s.tile_rows ? t.rows : (ti + 1) * kTileQuads;
    const std::uint32_t j1 = tj + 1 == s.tile_cols ? t.cols : (tj + 1) * kTileQuads;
    for (std::uint32_t i = ti * kTileQuads; i < i1; ++i)
        for (std::uint32_t j = tj * kTileQuads; j < j1; ++j) {
            const std::uint32_t k = i * t.cols + j;
            if (t.on_surface(k)) best.offer(sample_d2(s.point(k), tool), k);
        }
    for (std::uint32_t b = s.tile_border_start[tile]; b < s.tile_border_start[tile + 1]; ++b)
        best.offer(sample_d2(s.point(s.tile_border[b]), tool), s.tile_border[b]);
}

struct Entry {
    float d2;
    std::uint32_t level, node;
};

/// Depth first, nearest child first.
Best search_pyramid(const StateImpl& s, Vec3 tool) noexcept {
    const Pyramid& p = s.pyramid;
    Entry stack[4 * kMaxLevels];  // a visited node leaves at most three siblings behind on each level
    std::uint32_t depth = 0;
    stack[depth++] = {0, p.levels - 1, 0};
    Best best;
    while (depth != 0) {
        const Entry e = stack[--depth];
        if (e.d2 > best.d2) continue;
        if (e.level == 0) {
            search_leaf(s, e.node, tool, best);
            continue;
        }
        const std::uint32_t level = e.level - 1, r = e.node / p.cols[e.level] * 2, c = e.node % p.cols[e.level] * 2;
        const std::uint32_t first = depth;
        for (std::uint32_t i = r; i < std::min(r + 2, p.rows[level]); ++i)
            for (std::uint32_t j = c; j < std::min(c + 2, p.cols[level]); ++j) {
                const std::uint32_t node = i * p.cols[level] + j;
                const float d2 = box_d2(p.boxes[p.start[level] + node], tool);
                if (d2 > best.d2) continue;
                std::uint32_t at = depth++;
                for (; at > first && stack[at - 1].d2 < d2; --at) stack[at] = stack[at - 1];
                stack[at] = {d2, level, node};
            }
    }
    return best;
}

void search_window(const StateImpl& s, std::uint32_t last, std::uint32_t a, Vec3 tool, Best& best) noexcept {
    const ChartTables& t = s.tables;
    const std::uint32_t ic = last / t.cols, jc = last % t.cols;
    for (std::uint32_t i = ic > a ? ic - a : 0; i <= std::min(ic + a, t.rows - 1); ++i)
        for (std::uint32_t j = jc > a ? jc - a : 0; j <= std::min(jc + a, t.cols - 1); ++j)
            best.offer(sample_d2(s.point(i * t.cols + j), tool), i * t.cols + j);
}
}  // namespace
}  // namespace detail

Result<Nearest> nearest_sample(State& state, Vec3 tool) noexcept {
    if (!detail::is_finite(tool)) return Error{ErrorCode::BadArgument, kNoOffset, "the tool position is not finite"};
    detail::refit(*state.impl());
    return detail::search_pyramid(*state.impl(), tool).answer();
}

Result<Nearest> track_sample(State& state, Vec3 tool, std::uint32_t last, std::uint32_t a) noexcept {
    detail::StateImpl& s = *state.impl();
    if (!detail::is_finite(tool)) return Error{ErrorCode::BadArgument, kNoOffset, "the tool position is not finite"};
    if (!s.usable(last)) return Error{ErrorCode::BadArgument, kNoOffset, "the last sample is not on the surface"};
    if (a >= s.max_reach)
        return Error{ErrorCode::BadArgument, kNoOffset, "the window is larger than the state was made for"};
    detail::Best best;
    if (detail::is_plain_window(s, last, a + 1)) {
        detail::search_window(s, last, a, tool, best);
        return best.answer();
    }
    if (auto r = detail::begin_walk(s, last, a + 1); !r) return r.error();
    for (std::uint32_t k = 0; k < s.walk.visited_count; ++k) {
        const std::uint32_t sample = s.walk.nodes[s.walk.visited[k]].sample;
        best.offer(detail::sample_d2(s.point(sample), tool), sample);
    }
    detail::end_walk(s);
    return best.answer();
}

Result<bool> hit_test(Vec3 tool_vector, Vec3 normal) noexcept {
    if (!detail::is_finite(tool_vector) || !detail::is_finite(normal))
        return Error{ErrorCode::BadArgument, kNoOffset, "a vector of the hit test is not finite"};
    // In double: no product of floats overflows or vanishes there, so the sign is right.
    return double{tool_vector.x} * normal.x + double{tool_vector.y} * normal.y + double{tool_vector.z} * normal.z < 0;
}

}  // namespace dgm
