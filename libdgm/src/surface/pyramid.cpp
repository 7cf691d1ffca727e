// SPDX-License-Identifier: MIT
// libdgm/src/surface/pyramid.cpp
// Boxes over 8 x 8 quads, then over 2 x 2 boxes up to one root (docs/design.md section 4, layer `collision`), kept up
// to date for the tiles that were touched.
#include <algorithm>
#include <limits>

#include "surface/surface.h"

namespace dgm::detail {
namespace {
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the search pyramid"};

constexpr Box kEmpty{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

void grow(Box& box, Vec3 p) noexcept {
    const float v[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], v[k]);
        box.high[k] = std::max(box.high[k], v[k]);
    }
}

Box leaf_box(const Surface& s, const Pyramid& p, std::uint32_t tile) noexcept {
    Box box = kEmpty;
    const ChartTables& t = s.tables;
    const std::uint32_t i0 = tile / s.tile_cols * kTileQuads, j0 = tile % s.tile_cols * kTileQuads;
    const Rect quads{i0, std::min(i0 + kTileQuads, t.rows - 1), j0, std::min(j0 + kTileQuads, t.cols - 1)};
    if (t.mask == nullptr) {
        s.rows_of->bounds(p.at, quads, t.cols, box.low, box.high);
    } else {
        for (std::uint32_t i = quads.i0; i <= quads.i1; ++i)
            for (std::uint32_t j = quads.j0; j <= quads.j1; ++j) {
                const std::uint32_t k = i * t.cols + j;
                if (t.on_surface(k)) grow(box, Surface::at(p.at, k));
            }
    }
    for (std::uint32_t b = s.tile_border_start[tile]; b < s.tile_border_start[tile + 1]; ++b)
        grow(box, Surface::at(p.at, s.tile_border[b]));
    if (s.tile_face_start.empty()) return box;
    for (std::uint32_t k = s.tile_face_start[tile]; k < s.tile_face_start[tile + 1]; ++k)
        for (std::size_t c = 0; c < 3; ++c) grow(box, Surface::at(p.at, s.faces[3 * std::size_t{s.tile_faces[k]} + c]));
    return box;
}

Box parent_box(const Pyramid& p, std::uint32_t level, std::uint32_t node) noexcept {
    Box box = kEmpty;
    const std::uint32_t r = node / p.cols[level] * 2, c = node % p.cols[level] * 2;
    for (std::uint32_t i = r; i < std::min(r + 2, p.rows[level - 1]); ++i)
        for (std::uint32_t j = c; j < std::min(c + 2, p.cols[level - 1]); ++j) {
            const Box& child = p.boxes[p.start[level - 1] + i * p.cols[level - 1] + j];
            for (int k = 0; k < 3; ++k) {
                box.low[k] = std::min(box.low[k], child.low[k]);
                box.high[k] = std::max(box.high[k], child.high[k]);
            }
        }
    return box;
}

bool index_border(Surface& s, std::uint32_t tiles) noexcept {
    const std::uint32_t border = s.total() - s.tables.grid;
    if (!s.tile_border_start.allocate(s.allocator, std::uint64_t{tiles} + 2) ||
        !s.tile_border.allocate(s.allocator, border))
        return false;
    for (std::uint32_t b = 0; b < border; ++b) ++s.tile_border_start[s.tile_of(s.tables.grid + b) + 2];
    for (std::size_t k = 2; k < s.tile_border_start.size(); ++k) s.tile_border_start[k] += s.tile_border_start[k - 1];
    for (std::uint32_t b = 0; b < border; ++b) {
        const std::uint32_t sample = s.tables.grid + b;
        s.tile_border[s.tile_border_start[s.tile_of(sample) + 1]++] = sample;
    }
    return true;
}

/// Each border face is held by the leaf of its first corner, whose box grows around all three: rays look for it there.
/// A tile that owns another corner links to that leaf, so that its box follows.
bool index_faces(Surface& s, std::uint32_t tiles) noexcept {
    const std::size_t count = s.faces.size() / 3;
    if (count == 0) return true;
    if (!s.tile_face_start.allocate(s.allocator, std::uint64_t{tiles} + 2) ||
        !s.tile_faces.allocate(s.allocator, count) ||
        !s.tile_link_start.allocate(s.allocator, std::uint64_t{tiles} + 2) ||
        !s.tile_links.allocate(s.allocator, 2 * std::uint64_t{count}))
        return false;
    for (std::size_t f = 0; f < count; ++f) {
        ++s.tile_face_start[s.tile_of(s.faces[3 * f]) + 2];
        for (std::size_t c = 1; c < 3; ++c) ++s.tile_link_start[s.tile_of(s.faces[3 * f + c]) + 2];
    }
    for (std::size_t k = 2; k < s.tile_face_start.size(); ++k) {
        s.tile_face_start[k] += s.tile_face_start[k - 1];
        s.tile_link_start[k] += s.tile_link_start[k - 1];
    }
    for (std::size_t f = 0; f < count; ++f) {
        const std::uint32_t home = s.tile_of(s.faces[3 * f]);
        s.tile_faces[s.tile_face_start[home + 1]++] = static_cast<std::uint32_t>(f);
        for (std::size_t c = 1; c < 3; ++c) s.tile_links[s.tile_link_start[s.tile_of(s.faces[3 * f + c]) + 1]++] = home;
    }
    return true;
}

void mark_special(Surface& s) noexcept {
    const auto mark = [&](std::uint32_t sample) { s.tile_flags[s.tile_of(sample)] |= kTileSpecial; };
    for (const std::uint32_t sample : s.class_members) mark(sample);
    if (!s.tables.free_domain) return;
    for (std::uint32_t k = 0; k < s.total(); ++k)
        if (k >= s.tables.grid || !s.tables.on_surface(k)) mark(k);
    for (const std::uint32_t sample : s.tables.faces) mark(sample);
}
}  // namespace

Result<void> build_pyramid(Surface& s) noexcept {
    s.tile_rows = tile_count(s.tables.rows - 1);
    s.tile_cols = tile_count(s.tables.cols - 1);
    const std::uint32_t tiles = s.tile_rows * s.tile_cols;
    if (!s.changes.allocate(s.allocator, {s.tables.rows, s.tables.cols, s.total() - s.tables.grid})) return kNoMemory;
    if (!s.tile_flags.allocate(s.allocator, tiles) || !s.tile_list.allocate(s.allocator, tiles) ||
        !s.next_tiles.allocate(s.allocator, tiles) || !index_border(s, tiles) || !index_faces(s, tiles))
        return kNoMemory;
    for (Pyramid* p : {&s.now_boxes, &s.base_boxes}) {
        std::uint32_t r = s.tile_rows, c = s.tile_cols, nodes = 0;
        for (p->levels = 0;; r = (r + 1) / 2, c = (c + 1) / 2) {
            p->rows[p->levels] = r;
            p->cols[p->levels] = c;
            p->start[p->levels++] = nodes;
            nodes += r * c;
            if (r * c == 1) break;
        }
        if (!p->boxes.allocate(s.allocator, nodes, kEmpty)) return kNoMemory;
    }
    s.now_boxes.at = Surface::fixed(s.now);
    s.base_boxes.at = Surface::fixed(s.base);
    mark_special(s);
    s.all_moved();
    refit(s, s.base_boxes);
    refit(s, s.now_boxes);
    return {};
}

void refit(Surface& s, Pyramid& p) noexcept {
    if (p.dirty.empty()) return;
    // A box reaches one quad beyond the samples its tile owns.
    const auto first = [](std::uint32_t k, std::uint32_t tiles) { return Surface::owner(k == 0 ? 0 : k - 1, tiles); };
    for (std::uint32_t k = 0; k < p.dirty.count; ++k) {
        const Rect& r = p.dirty.rects[k];
        for (std::uint32_t ti = first(r.i0, s.tile_rows); ti <= Surface::owner(r.i1, s.tile_rows); ++ti)
            for (std::uint32_t tj = first(r.j0, s.tile_cols); tj <= Surface::owner(r.j1, s.tile_cols); ++tj)
                s.list_tile(ti * s.tile_cols + tj);
    }
    if (p.dirty.border_low <= p.dirty.border_high)
        for (std::uint32_t b = p.dirty.border_low; b <= p.dirty.border_high; ++b) s.list_tile(s.tile_of(b));
    p.dirty.clear();
    if (!s.tile_link_start.empty())
        for (std::uint32_t k = 0, moved = s.tile_count_listed; k < moved; ++k)
            for (std::uint32_t e = s.tile_link_start[s.tile_list[k]]; e < s.tile_link_start[s.tile_list[k] + 1]; ++e)
                s.list_tile(s.tile_links[e]);
    std::uint32_t count = s.tile_count_listed;
    for (std::uint32_t k = 0; k < count; ++k) p.boxes[s.tile_list[k]] = leaf_box(s, p, s.tile_list[k]);
    s.end_tile_list();
    // Up level by level. The flag of a parent's number keeps it from entering the next list twice; it is free for that
    // use, since the leaves' have just been cleared and parents are fewer than leaves.
    std::uint32_t* now = s.tile_list.data();
    std::uint32_t* next = s.next_tiles.data();
    for (std::uint32_t level = 1; level < p.levels; ++level) {
        std::uint32_t parents = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t parent =
                now[k] / p.cols[level - 1] / 2 * p.cols[level] + now[k] % p.cols[level - 1] / 2;
            if ((s.tile_flags[parent] & kTileListed) != 0) continue;
            s.tile_flags[parent] |= kTileListed;
            next[parents++] = parent;
        }
        for (std::uint32_t k = 0; k < parents; ++k) {
            p.boxes[p.start[level] + next[k]] = parent_box(p, level, next[k]);
            s.tile_flags[next[k]] &= static_cast<std::uint8_t>(~kTileListed);
        }
        std::swap(now, next);
        count = parents;
    }
}

}  // namespace dgm::detail
