// SPDX-License-Identifier: MIT
// libdgm/src/pyramid.cpp
// Boxes over 8 x 8 quads, then over 2 x 2 boxes up to one root (design section 4, layer `collision`), kept up to date
// for the tiles that were touched.
#include <algorithm>
#include <limits>

#include "state_impl.h"

namespace dgm::detail {
namespace {
constexpr float kInfinity = std::numeric_limits<float>::infinity();

void grow(Box& box, Vec3 p) noexcept {
    const float v[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], v[k]);
        box.high[k] = std::max(box.high[k], v[k]);
    }
}

constexpr Box kEmpty{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

Box leaf_box(const StateImpl& s, std::uint32_t tile) noexcept {
    Box box = kEmpty;
    const ChartTables& t = s.tables;
    const std::uint32_t i0 = tile / s.tile_cols * kTileQuads, j0 = tile % s.tile_cols * kTileQuads;
    const std::uint32_t i1 = std::min(i0 + kTileQuads, t.rows - 1), j1 = std::min(j0 + kTileQuads, t.cols - 1);
    for (std::uint32_t i = i0; i <= i1; ++i)
        for (std::uint32_t j = j0; j <= j1; ++j) {
            const std::uint32_t k = i * t.cols + j;
            if (t.on_surface(k)) grow(box, s.point(k));
        }
    for (std::uint32_t b = s.tile_border_start[tile]; b < s.tile_border_start[tile + 1]; ++b)
        grow(box, s.point(s.tile_border[b]));
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

bool index_border(StateImpl& s, std::uint32_t tiles) noexcept {
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

void mark_special(StateImpl& s) noexcept {
    const auto mark = [&](std::uint32_t sample) { s.tile_flags[s.tile_of(sample)] |= kTileSpecial; };
    for (const std::uint32_t sample : s.class_members) mark(sample);
    if (!s.tables.free_domain) return;
    for (std::uint32_t k = 0; k < s.total(); ++k)
        if (k >= s.tables.grid || !s.tables.on_surface(k)) mark(k);
    for (const std::uint32_t sample : s.tables.faces) mark(sample);
}
}  // namespace

std::uint32_t StateImpl::tile_of(std::uint32_t s) const noexcept {
    std::uint32_t i = 0, j = 0;
    if (s < tables.grid) {
        i = s / tables.cols;
        j = s % tables.cols;
    } else {
        const Place p = place(s);  // 0 .. rows - 1, checked
        i = static_cast<std::uint32_t>(p.x);
        j = static_cast<std::uint32_t>(p.y);
    }
    return owner(i, tile_rows) * tile_cols + owner(j, tile_cols);
}

void StateImpl::touch_tile(std::uint32_t tile, bool elastic) noexcept {
    std::uint8_t& flags = tile_flags[tile];
    if (elastic && (flags & kTileElastic) == 0) elastic_tiles[elastic_count++] = tile;
    if ((flags & kTileDirty) == 0) dirty_tiles[dirty_count++] = tile;
    flags |= static_cast<std::uint8_t>(elastic ? kTileElastic | kTileDirty : kTileDirty);
}

void StateImpl::touch_rows(std::uint32_t i0, std::uint32_t i1, std::uint32_t j0, std::uint32_t j1,
                           bool elastic) noexcept {
    const auto first = [](std::uint32_t k, std::uint32_t tiles) { return owner(k == 0 ? 0 : k - 1, tiles); };
    for (std::uint32_t ti = first(i0, tile_rows); ti <= owner(i1, tile_rows); ++ti)
        for (std::uint32_t tj = first(j0, tile_cols); tj <= owner(j1, tile_cols); ++tj)
            touch_tile(ti * tile_cols + tj, elastic);
}

void StateImpl::touch_sample(std::uint32_t s, bool elastic) noexcept {
    if (s >= tables.grid)
        touch_tile(tile_of(s), elastic);
    else
        touch_rows(s / tables.cols, s / tables.cols, s % tables.cols, s % tables.cols, elastic);
}

void StateImpl::touch_all() noexcept {
    for (std::uint32_t tile = 0; tile < tile_rows * tile_cols; ++tile) touch_tile(tile, false);
}

Result<void> build_pyramid(StateImpl& s) noexcept {
    s.tile_rows = tile_count(s.tables.rows - 1);
    s.tile_cols = tile_count(s.tables.cols - 1);
    const std::uint32_t tiles = s.tile_rows * s.tile_cols;
    Pyramid& p = s.pyramid;
    std::uint32_t r = s.tile_rows, c = s.tile_cols, nodes = 0;
    for (p.levels = 0;; r = (r + 1) / 2, c = (c + 1) / 2) {
        p.rows[p.levels] = r;
        p.cols[p.levels] = c;
        p.start[p.levels++] = nodes;
        nodes += r * c;
        if (r * c == 1) break;
    }
    if (!p.boxes.allocate(s.allocator, nodes, kEmpty) || !s.tile_flags.allocate(s.allocator, tiles) ||
        !s.elastic_tiles.allocate(s.allocator, tiles) || !s.dirty_tiles.allocate(s.allocator, tiles) ||
        !s.next_tiles.allocate(s.allocator, tiles) || !index_border(s, tiles))
        return Error{ErrorCode::OutOfMemory, kNoOffset, "no memory for the search pyramid"};
    mark_special(s);
    s.touch_all();
    refit(s);
    return {};
}

void refit(StateImpl& s) noexcept {
    if (s.dirty_count == 0) return;
    Pyramid& p = s.pyramid;
    for (std::uint32_t k = 0; k < s.dirty_count; ++k) {
        const std::uint32_t tile = s.dirty_tiles[k];
        p.boxes[tile] = leaf_box(s, tile);
        s.tile_flags[tile] &= static_cast<std::uint8_t>(~kTileDirty);
    }
    // Up level by level. The flag of a parent's number keeps it from entering the next list twice; it is free for that
    // use, since dirty leaves have just been cleared and parents are fewer than leaves.
    std::uint32_t* now = s.dirty_tiles.data();
    std::uint32_t* next = s.next_tiles.data();
    std::uint32_t count = s.dirty_count;
    for (std::uint32_t level = 1; level < p.levels; ++level) {
        std::uint32_t parents = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t parent =
                now[k] / p.cols[level - 1] / 2 * p.cols[level] + now[k] % p.cols[level - 1] / 2;
            if ((s.tile_flags[parent] & kTileDirty) != 0) continue;
            s.tile_flags[parent] |= kTileDirty;
            next[parents++] = parent;
        }
        for (std::uint32_t k = 0; k < parents; ++k) {
            p.boxes[p.start[level] + next[k]] = parent_box(p, level, next[k]);
            s.tile_flags[next[k]] &= static_cast<std::uint8_t>(~kTileDirty);
        }
        std::swap(now, next);
        count = parents;
    }
    s.dirty_count = 0;
}

}  // namespace dgm::detail
