// SPDX-License-Identifier: MIT
// libdgm/src/surface/seam_links.cpp
// Weld classes from the table of pairs, and how the grid continues across them.
//
// A cut path stands twice on the border, run through in opposite directions. So a directed border edge (a -> b),
// surface on its left, has its mate in the border edge whose ends are the same classes the other way round. Laid side
// by side the mate's direction t' points along -t: that fixes the turn between the two charts (outward here = inward
// there). The leaf of a cut path has one copy only and no class; by itself it stands for its class, so the edges next
// to it find each other too.
//
// Where a surface without an inside was opened, the mate runs in the same direction. No turn lays it beside the edge,
// so it gets no link: distances go on over the welded triangles (touch/geodesic.h), Footprint::Grid ends.
#include <algorithm>
#include <cmath>

#include "surface/surface.h"

namespace dgm::detail {
namespace {

constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the seams"};

struct Edge {
    std::uint32_t class_a, class_b;  // representatives
    std::uint32_t a, b;
};
bool before(const Edge& l, const Edge& r) noexcept {
    if (l.class_a != r.class_a) return l.class_a < r.class_a;
    if (l.class_b != r.class_b) return l.class_b < r.class_b;
    return l.a != r.a ? l.a < r.a : l.b < r.b;
}
bool same_ends(const Edge& e, std::uint32_t class_a, std::uint32_t class_b) noexcept {
    return e.class_a == class_a && e.class_b == class_b;
}

struct RawLink {
    std::uint32_t place;  // of the from sample in class_members
    SeamLink link;
};
bool before_link(const RawLink& l, const RawLink& r) noexcept {
    if (l.place != r.place) return l.place < r.place;
    if (l.link.to != r.link.to) return l.link.to < r.link.to;
    return l.link.cosine != r.link.cosine ? l.link.cosine < r.link.cosine : l.link.sine < r.link.sine;
}

/// Whether the directed edge (a -> b) of a grid triangle exists, both being grid samples next to each other.
bool quad_has_edge(const ChartTables& t, std::uint32_t a, std::uint32_t b) noexcept {
    const std::uint32_t ia = a / t.cols, ja = a % t.cols, ib = b / t.cols, jb = b % t.cols;
    if (ib == ia + 1 && jb == ja) return ja + 1 < t.cols && t.has_quad(ia, ja);  // along +i: quad on the left, +j
    if (ia == ib + 1 && jb == ja) return ja > 0 && t.has_quad(ib, ja - 1);       // along -i
    if (ia == ib && jb == ja + 1) return ia > 0 && t.has_quad(ia - 1, ja);       // along +j: quad on the left, -i
    if (ia == ib && ja == jb + 1) return ia + 1 < t.rows && t.has_quad(ia, jb);  // along -j
    if (ib == ia + 1 && jb == ja + 1) return t.has_quad(ia, ja) && t.diagonal(ia, ja) == 0;
    if (ia == ib + 1 && ja == jb + 1) return t.has_quad(ib, jb) && t.diagonal(ib, jb) == 0;
    if (ib == ia + 1 && ja == jb + 1) return t.has_quad(ia, jb) && t.diagonal(ia, jb) == 1;
    if (ia == ib + 1 && jb == ja + 1) return t.has_quad(ib, ja) && t.diagonal(ib, ja) == 1;
    return false;
}

std::uint32_t representative(const Surface& s, std::uint32_t sample) noexcept {
    const std::uint32_t id = s.class_id(sample);
    return id == kNone ? sample : s.members(id)[0];
}

/// Border edges of the square, counter-clockwise in (u, v).
template <class Add>
void square_border(const ChartTables& t, Add add) noexcept {
    const std::uint32_t m = t.rows, n = t.cols;
    for (std::uint32_t i = 0; i + 1 < m; ++i) add(i * n, (i + 1) * n);
    for (std::uint32_t j = 0; j + 1 < n; ++j) add((m - 1) * n + j, (m - 1) * n + j + 1);
    for (std::uint32_t i = m - 1; i > 0; --i) add(i * n + n - 1, (i - 1) * n + n - 1);
    for (std::uint32_t j = n - 1; j > 0; --j) add(j, j - 1);
}

/// Border edges of a free domain: directed edges of strip and quads that no other triangle runs the other way.
/// `sorted` holds the strip's directed edges as (a, b) pairs in order.
template <class Add>
void free_border(const ChartTables& t, const Array<std::uint64_t>& sorted, Add add) noexcept {
    const auto strip_has = [&](std::uint32_t a, std::uint32_t b) {
        return std::binary_search(sorted.begin(), sorted.end(), std::uint64_t{a} << 32 | b);
    };
    const auto open = [&](std::uint32_t a, std::uint32_t b) {
        return !strip_has(b, a) && !(a < t.grid && b < t.grid && quad_has_edge(t, b, a));
    };
    for (const std::uint64_t key : sorted) {
        const auto a = static_cast<std::uint32_t>(key >> 32), b = static_cast<std::uint32_t>(key);
        if (open(a, b)) add(a, b);
    }
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < t.cols; ++j) {
            if (!t.has_quad(i, j)) continue;
            const std::uint32_t a = i * t.cols + j, b = a + t.cols, c = b + 1, d = a + 1;
            const std::uint32_t ring[5] = {a, b, c, d, a};
            for (int k = 0; k < 4; ++k)
                if (open(ring[k], ring[k + 1])) add(ring[k], ring[k + 1]);
        }
}

Result<void> collect_edges(const Surface& s, Array<Edge>& edges, std::size_t& count) noexcept {
    const ChartTables& t = s.tables;
    Array<std::uint64_t> sorted;
    if (!sorted.allocate(s.allocator, t.faces.size())) return kNoMemory;
    for (std::size_t k = 0; k < t.faces.size(); ++k)
        sorted[k] = std::uint64_t{t.faces[k]} << 32 | t.faces[k % 3 == 2 ? k - 2 : k + 1];
    std::sort(sorted.begin(), sorted.end());
    const auto visit = [&](auto add) {
        if (t.free_domain)
            free_border(t, sorted, add);
        else
            square_border(t, add);
    };
    // Only edges with a seam sample can have a mate.
    const auto on_seam = [&](std::uint32_t a, std::uint32_t b) {
        return s.class_id(a) != kNone || s.class_id(b) != kNone;
    };
    std::size_t needed = 0;
    visit([&](std::uint32_t a, std::uint32_t b) { needed += on_seam(a, b); });
    if (!edges.allocate(s.allocator, needed)) return kNoMemory;
    count = 0;
    visit([&](std::uint32_t a, std::uint32_t b) {
        if (on_seam(a, b)) edges[count++] = {representative(s, a), representative(s, b), a, b};
    });
    std::sort(edges.begin(), edges.begin() + count, before);
    return {};
}

/// The edge that runs along `edges[k]` on the other side, or null. Where several paths join the same two classes the
/// n-th of one direction goes with the n-th of the other: arbitrary, but the same on every machine.
const Edge* find_mate(const Edge* edges, std::size_t count, std::size_t k) noexcept {
    const Edge& e = edges[k];
    const auto group = [&](std::uint32_t a, std::uint32_t b) {
        return static_cast<std::size_t>(std::lower_bound(edges, edges + count, Edge{a, b, 0, 0}, before) - edges);
    };
    const std::size_t rank = k - group(e.class_a, e.class_b);
    const std::size_t mate = group(e.class_b, e.class_a) + (e.class_a == e.class_b ? rank ^ 1 : rank);
    return mate < count && mate != k && same_ends(edges[mate], e.class_b, e.class_a) ? edges + mate : nullptr;
}

struct Direction {
    float x, y;
};
/// Unit vector from a to b in grid steps; exact along rows and columns. 0 if they coincide.
Direction direction(const Surface& s, std::uint32_t a, std::uint32_t b) noexcept {
    const auto p = s.place(a), q = s.place(b);
    const float x = q.x - p.x, y = q.y - p.y, length = std::sqrt(x * x + y * y);
    return length > 0 ? Direction{x / length, y / length} : Direction{0, 0};
}
}  // namespace

Result<void> build_classes(Surface& s) noexcept {
    const auto pairs = s.tables.seams;
    if (pairs.empty()) return {};
    if (!s.class_of.allocate(s.allocator, s.total(), kNone)) return kNoMemory;
    // Classes are numbered by their representative, so that the numbers do not depend on the order of the pairs.
    for (std::size_t k = 0; k < pairs.size(); k += 2) s.class_of[pairs[k]] = 0;
    for (std::uint32_t& id : s.class_of)
        if (id != kNone) id = s.class_count++;
    for (std::size_t k = 0; k < pairs.size(); k += 2) s.class_of[pairs[k + 1]] = s.class_of[pairs[k]];
    if (!s.class_start.allocate(s.allocator, std::uint64_t{s.class_count} + 2) ||
        !s.class_members.allocate(s.allocator, std::uint64_t{s.class_count} + pairs.size() / 2))
        return kNoMemory;
    for (const std::uint32_t id : s.class_of)
        if (id != kNone) ++s.class_start[id + 2];
    for (std::size_t k = 2; k < s.class_start.size(); ++k) s.class_start[k] += s.class_start[k - 1];
    for (std::uint32_t sample = 0; sample < s.total(); ++sample)
        if (s.class_of[sample] != kNone) s.class_members[s.class_start[s.class_of[sample] + 1]++] = sample;
    if (s.tables.reversed == nullptr) return {};
    if (!s.reversed.allocate(s.allocator, s.total())) return kNoMemory;
    for (std::size_t k = 0; k < pairs.size() / 2; ++k)
        s.reversed[pairs[2 * k + 1]] = load_once(s.tables.reversed + k) & 1;
    return {};
}

Result<void> build_links(Surface& s) noexcept {
    if (s.class_count == 0) return {};
    Array<Edge> edges;
    std::size_t count = 0;
    if (auto r = collect_edges(s, edges, count); !r) return r;
    Array<RawLink> raw;
    if (!raw.allocate(s.allocator, 2 * std::uint64_t{count})) return kNoMemory;
    std::size_t links = 0;
    const auto add = [&](std::uint32_t from, std::uint32_t to, float cosine, float sine) {
        if (from == to) return;
        const std::uint32_t id = s.class_of[from];
        const auto members = s.members(id);
        const auto nth = std::lower_bound(members.begin(), members.end(), from) - members.begin();
        raw[links++] = {s.class_start[id] + static_cast<std::uint32_t>(nth), {to, cosine, sine}};
    };
    for (std::size_t k = 0; k < count; ++k) {
        const Edge& e = edges[k];
        const Edge* mate = find_mate(edges.data(), count, k);
        if (mate == nullptr) continue;
        const Direction t = direction(s, e.a, e.b), u = direction(s, mate->a, mate->b);
        const float cosine = -(u.x * t.x + u.y * t.y), sine = u.y * t.x - u.x * t.y;
        if (cosine == 0 && sine == 0) continue;  // an edge without length has no direction
        add(e.a, mate->b, cosine, sine);
        add(e.b, mate->a, cosine, sine);
    }
    std::sort(raw.begin(), raw.begin() + links, before_link);
    const auto equal = [](const RawLink& l, const RawLink& r) { return !before_link(l, r) && !before_link(r, l); };
    links = static_cast<std::size_t>(std::unique(raw.begin(), raw.begin() + links, equal) - raw.begin());
    if (!s.links.allocate(s.allocator, links) || !s.link_start.allocate(s.allocator, s.class_members.size() + 1))
        return kNoMemory;
    for (std::size_t k = 0; k < links; ++k) {
        s.links[k] = raw[k].link;
        ++s.link_start[raw[k].place + 1];
    }
    for (std::size_t k = 1; k < s.link_start.size(); ++k) s.link_start[k] += s.link_start[k - 1];
    return {};
}

}  // namespace dgm::detail
