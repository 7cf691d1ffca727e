// SPDX-License-Identifier: MIT
// libdgm/src/surface/rim.cpp
// Open borders of the welded surface: edges that have one face.
#include <algorithm>

#include "surface/surface.h"

namespace dgm::detail {
namespace {

/// An edge between two points of the welded surface, lower one first; `way` +1 or -1 by the direction it was met in.
struct Edge {
    std::uint32_t a, b;
    std::int32_t way;
};

/// Directed edges of faces whose other side the grid alone does not show.
template <class F>
void each_rim_edge(const Surface& s, F f) noexcept {
    const ChartTables& t = s.tables;
    const auto quad = [&](std::int64_t i, std::int64_t j) {
        return i >= 0 && j >= 0 && i + 1 < t.rows && j + 1 < t.cols &&
               t.has_quad(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
    };
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i) {
        // Whole rows inside a square domain have nothing to show but at their ends.
        const bool inner = t.mask == nullptr && i > 0 && i + 2 < t.rows;
        const std::uint32_t step = inner && t.cols > 2 ? t.cols - 2 : 1;
        for (std::uint32_t j = 0; j + 1 < t.cols; j += step) {
            if (!quad(i, j)) continue;
            const std::uint32_t a = i * t.cols + j, b = a + t.cols, c = b + 1, d = a + 1;
            if (!quad(i, std::int64_t{j} - 1)) f(a, b);
            if (!quad(std::int64_t{i} + 1, j)) f(b, c);
            if (!quad(i, std::int64_t{j} + 1)) f(c, d);
            if (!quad(std::int64_t{i} - 1, j)) f(d, a);
        }
    }
    for (std::size_t k = 0; k + 2 < s.faces.size(); k += 3) {
        f(s.faces[k], s.faces[k + 1]);
        f(s.faces[k + 1], s.faces[k + 2]);
        f(s.faces[k + 2], s.faces[k]);
    }
}

}  // namespace

Result<bool> find_rim(Surface& s) noexcept {
    const auto mark = [&](std::uint32_t first) {
        const std::uint32_t id = s.class_id(first);
        if (id == kNone) {
            if (first < s.tables.grid) s.ring[first] |= kRingRim;
            return;
        }
        for (const std::uint32_t copy : s.members(id))
            if (copy < s.tables.grid) s.ring[copy] |= kRingRim;
    };
    bool closed = s.any_sample != kNone;
    std::uint64_t count = 0;
    each_rim_edge(s, [&](std::uint32_t, std::uint32_t) { ++count; });
    Array<Edge> edges;
    if (!edges.allocate(s.allocator, count)) return kNoStateMemory;
    std::size_t at = 0;
    each_rim_edge(s, [&](std::uint32_t from, std::uint32_t to) {
        const std::uint32_t a = s.representative(from), b = s.representative(to);
        if (a != b) edges[at++] = a < b ? Edge{a, b, 1} : Edge{b, a, -1};
    });
    std::sort(edges.begin(), edges.begin() + at,
              [](const Edge& e, const Edge& f) { return e.a != f.a ? e.a < f.a : e.b < f.b; });
    for (std::size_t k = 0; k < at;) {
        std::int32_t balance = 0;
        const Edge first = edges[k];
        for (; k < at && edges[k].a == first.a && edges[k].b == first.b; ++k) balance += edges[k].way;
        if (balance == 0) continue;
        closed = false;
        if (balance % 2 == 0) continue;  // two faces that wind alike: no border, but no inside either
        mark(first.a);
        mark(first.b);
    }
    return closed;
}

}  // namespace dgm::detail
