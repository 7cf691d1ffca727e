// SPDX-License-Identifier: MIT
// libdgm/src/state_impl.h
// What a State holds. Coordinates stand in planes (all x, then all y, then all z): deform and normals stream them.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/grid.h>
#include <dgm/state.h>

#include "chart_tables.h"
#include "memory.h"

namespace dgm::detail {

struct Box {
    float low[3], high[3];  ///< empty: low = +inf, high = -inf
};

/// From one copy of a seam sample to another: a vector v of the target's chart stands in this chart as
/// (cosine * v.x - sine * v.y, sine * v.x + cosine * v.y).
struct SeamLink {
    std::uint32_t to;
    float cosine, sine;
};

/// A sample met by a walk, unfolded into the chart of the walk's start.
struct WalkNode {
    std::uint32_t sample;
    float x, y;          ///< offset from the start in grid steps (rows, columns)
    float cosine, sine;  ///< of this sample's chart in the start's
    float d2;            ///< x^2 + y^2
    std::uint32_t heap;  ///< place in the heap, kNone once visited
};

inline constexpr std::uint8_t kTileSpecial = 1;  ///< holds seam samples, a free border or samples off the surface
inline constexpr std::uint8_t kTileElastic = 2;  ///< touched since the last release
inline constexpr std::uint8_t kTileDirty = 4;    ///< box out of date

inline constexpr std::uint32_t kMaxLevels = 16;  // 8192 leaf tiles a side halve to 1 in 13 steps

struct Pyramid {
    Array<Box> boxes;  ///< leaf level first, row-major, up to the root
    std::uint32_t levels = 0;
    std::uint32_t rows[kMaxLevels] = {}, cols[kMaxLevels] = {};
    std::uint32_t start[kMaxLevels] = {};
};

/// Memory of a walk, emptied after each.
struct WalkScratch {
    Array<std::uint32_t> slot_of;  ///< sample -> node, or kNone
    Array<WalkNode> nodes;
    Array<std::uint32_t> heap, visited;  ///< node numbers
    std::uint32_t node_count = 0, heap_count = 0, visited_count = 0;
    Array<std::uint32_t> class_node;  ///< class -> nearest node, or kNone
    Array<std::uint32_t> classes;     ///< classes met
};

struct StateImpl {
    explicit StateImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    std::uint32_t max_reach = 0;
    ChartTables tables;  ///< mask, diagonals, faces and seams point into the arrays below; layer pointers are null
    Array<float> rest, base, now;  ///< 3 planes of `total`: baked, with plastic touches, with elastic ones
    Array<std::uint8_t> mask, diagonals;
    Array<std::uint32_t> faces;
    Array<float> border_uv;
    Array<std::uint32_t> face_start, face_of;  ///< free domain: border faces of each sample

    Array<std::uint32_t> class_of, class_start, class_members;
    Array<std::uint32_t> link_start;  ///< by place in class_members
    Array<SeamLink> links;
    std::uint32_t class_count = 0;

    std::uint32_t tile_rows = 0, tile_cols = 0;
    Array<std::uint8_t> tile_flags;
    Array<std::uint32_t> elastic_tiles, dirty_tiles, next_tiles;
    std::uint32_t elastic_count = 0, dirty_count = 0;
    Array<std::uint32_t> tile_border_start, tile_border;  ///< border samples of each tile
    Pyramid pyramid;
    WalkScratch walk;

    [[nodiscard]] std::uint32_t total() const noexcept { return tables.total; }
    /// Some window can reach a seam or a free border, so walks are needed.
    [[nodiscard]] bool classes_or_border() const noexcept { return class_count != 0 || tables.free_domain; }
    [[nodiscard]] Vec3 point(std::uint32_t s) const noexcept {
        const std::size_t n = tables.total;
        return {now[s], now[n + s], now[2 * n + s]};
    }
    [[nodiscard]] bool usable(std::uint32_t s) const noexcept { return s < tables.total && tables.on_surface(s); }
    [[nodiscard]] std::uint32_t class_id(std::uint32_t s) const noexcept {
        return class_of.empty() ? kNone : class_of[s];
    }
    [[nodiscard]] std::span<const std::uint32_t> members(std::uint32_t id) const noexcept {
        return {class_members.data() + class_start[id], class_start[id + 1] - class_start[id]};
    }
    /// (row, column) of a sample in grid steps.
    struct Place {
        float x, y;
    };
    [[nodiscard]] Place place(std::uint32_t s) const noexcept {
        if (s < tables.grid) return {static_cast<float>(s / tables.cols), static_cast<float>(s % tables.cols)};
        const std::size_t b = s - tables.grid;
        return {border_uv[2 * b] * static_cast<float>(tables.rows - 1),
                border_uv[2 * b + 1] * static_cast<float>(tables.cols - 1)};
    }
    /// Leaf tile that owns row (or column) `k`: its quads start there; the last row belongs to the last tile.
    [[nodiscard]] static std::uint32_t owner(std::uint32_t k, std::uint32_t tiles) noexcept {
        const std::uint32_t t = k / kTileQuads;
        return t < tiles ? t : tiles - 1;
    }
    [[nodiscard]] std::uint32_t tile_of(std::uint32_t s) const noexcept;
    /// Notes that samples of rows i0..i1, columns j0..j1 moved (boxes reach one quad beyond their own samples).
    void touch_rows(std::uint32_t i0, std::uint32_t i1, std::uint32_t j0, std::uint32_t j1, bool elastic) noexcept;
    void touch_sample(std::uint32_t s, bool elastic) noexcept;
    void touch_tile(std::uint32_t tile, bool elastic) noexcept;
    void touch_all() noexcept;
};

/// Seam classes from the pairs, then links from the border edges that two mates share. @return OutOfMemory.
[[nodiscard]] Result<void> build_classes(StateImpl& state) noexcept;
[[nodiscard]] Result<void> build_links(StateImpl& state) noexcept;
/// Tiles, their border samples and boxes. @return OutOfMemory.
[[nodiscard]] Result<void> build_pyramid(StateImpl& state) noexcept;
/// Brings the boxes of dirty tiles and of the nodes above them up to date.
void refit(StateImpl& state) noexcept;
/// Area-weighted unit normal over the welded ring; 0 without area.
[[nodiscard]] Vec3 ring_normal(const StateImpl& state, std::uint32_t sample) noexcept;

/// True if the window |di| < b, |dj| < b around grid sample (i, j) holds no seam and no free border, so that it is a
/// plain rectangle clipped by the grid.
[[nodiscard]] bool is_plain_window(const StateImpl& state, std::uint32_t sample, std::uint32_t b) noexcept;
/// Visits every sample whose unfolded offset from `start` stays within |x| < b, |y| < b, nearest first; the nodes
/// stay in state.walk (visited order in `visited`) until end_walk(). @return LimitExceeded (then already ended).
[[nodiscard]] Result<void> begin_walk(StateImpl& state, std::uint32_t start, std::uint32_t b) noexcept;
void end_walk(StateImpl& state) noexcept;

}  // namespace dgm::detail
