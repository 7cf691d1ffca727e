// SPDX-License-Identifier: MIT
// libdgm/src/state_impl.h
// What a State holds. Coordinates stand in planes (all x, then all y, then all z): deform and normals stream them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/deform.h>
#include <dgm/grid.h>
#include <dgm/limits.h>
#include <dgm/state.h>

#include "changes.h"
#include "chart_tables.h"
#include "geodesic.h"
#include "memory.h"
#include "patch.h"
#include "rect_list.h"
#include "rows.h"
#include "tool_slot.h"

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
inline constexpr std::uint8_t kTileListed = 2;   ///< in StateImpl::tile_list; only while one function runs
inline constexpr std::uint8_t kTileFading = 4;   ///< in Fading::plain or Fading::special
inline constexpr std::uint8_t kTileMoved = 8;    ///< faded or came to rest, and settle() has not told of it

inline constexpr std::uint8_t kRingCorners = 15;    ///< bit k: corner k of rows.h is in the ring
inline constexpr std::uint8_t kRingIrregular = 16;  ///< normal by ring_normal(): border, seam or free border sample

inline constexpr std::uint8_t kRingRim = 128;  ///< on an open border of the welded surface

inline constexpr std::uint32_t kMaxLevels = 16;  // 8192 leaf tiles a side halve to 1 in 13 steps

/// Boxes over 8 x 8 quads up to one root, over one of the state's shapes.
struct Pyramid {
    Array<Box> boxes;  ///< leaf level first, row-major, up to the root
    std::uint32_t levels = 0;
    std::uint32_t rows[kMaxLevels] = {}, cols[kMaxLevels] = {};
    std::uint32_t start[kMaxLevels] = {};
    ConstPlanes at = {};
    RectList dirty;  ///< moved since the last refit
};

/// Memory of a walk, emptied after each.
struct WalkScratch {
    Array<std::uint32_t> slot_of;  ///< sample -> node, or kNone
    Array<WalkNode> nodes;
    Array<std::uint32_t> heap, visited;  ///< node numbers
    std::uint32_t node_count = 0, heap_count = 0, visited_count = 0;
};

/// A copy of the chart placed in the plane of the contact: sample (i, j) lies at offset
/// (c i - s j + x, s i + c j + y) from it, a quarter turn being (0, 1).
struct Frame {
    std::int32_t c, s, x, y;
    Rect rect;  ///< its samples inside the window
};

/// Samples in reach and their weights; keys and weights are back at infinity and 0 when no footprint is built.
struct FootprintScratch {
    Array<float> key, weight;  ///< of every sample: distance^2 of its nearest place, and the kernel there
    Frame frames[kMaxFrames];
    std::uint32_t frame_count = 0;
    Array<std::uint32_t> samples;  ///< besides the frames' rectangles
    std::uint32_t sample_count = 0;
    Array<std::uint32_t> classes;  ///< classes in reach
    std::uint32_t class_count = 0;
    Array<std::uint8_t> class_seen;
    bool truncated = false;
};

struct TileList {
    Array<std::uint32_t> tiles;
    std::uint32_t count = 0;
};

/// Elastic displacement that fades. exp is multiplicative: a tile nobody looks at waits, and fades in one step when
/// somebody does, by exp(-(clock - its own time)). So a tick looks at what its tools reach, and settle() at the rest.
/// Copies of a seam class must fade in the same steps to hold the same bits: special tiles and border samples keep one
/// time for all.
struct Fading {
    double clock = 0;  ///< sum of rate dt
    double special_time = 0;
    Array<double> time;  ///< by plain tile, while it is fading
    Array<float> left;   ///< by plain tile: no component of a displacement was larger then
    TileList plain, special;
    std::uint32_t border_low = kNone, border_high = 0;  ///< border samples that fade
    std::uint32_t sweep = 0;                            ///< place in `plain` where the next look for tiles at rest is
    std::uint32_t tile_moved = 0;                       ///< tiles with kTileMoved
    bool border_moved = false;                          ///< they did since settle()
    bool behind = false;                                ///< some tile's time is before the clock
    bool normals_owed = false;                          ///< normals() is promised for the shape as of the clock
    bool in_tick = false;                               ///< elastic touches are told of by settle()
    [[nodiscard]] bool empty() const noexcept {
        return plain.count + special.count + tile_moved == 0 && border_low > border_high && !border_moved;
    }
};

struct StateImpl {
    explicit StateImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    std::uint32_t max_reach = 0;
    const RowKernels* rows_of = nullptr;
    NormalLoops normals_of = nullptr;  ///< one for all normals of a state: incremental is full, to the bit
    ChartTables tables;  ///< mask, diagonals, faces and seams point into the arrays below; layer pointers are null
    /// Sixteen planes `plane` floats apart, no two alike modulo 4096 bytes: loads from one must not wait for stores to
    /// another that only look the same to the processor.
    Array<float> planes;
    std::size_t plane = 0;
    Planes rest = {}, base = {}, now = {};  ///< baked, with plastic touches, with elastic ones
    Planes normal = {};                     ///< of `now` but for `normal_dirty`
    Planes rest_normal = {};
    float* rough = nullptr;  ///< mean square of the distances of a sample's rest normal from those of its faces
    float normal_scale = 1;
    float mean_step = 1;
    Array<std::uint8_t> mask, diagonals;
    Array<std::uint8_t> ring;  ///< per grid sample, see kRing*
    bool uniform = false;      ///< every diagonal is 0
    Array<std::uint32_t> faces;
    Array<float> border_uv;
    Array<std::uint32_t> face_start, face_of;  ///< free domain: border faces of each sample
    Array<float> stiffness, mobility;          ///< per grid sample; empty if all are 1

    Array<std::uint32_t> class_of, class_start, class_members;
    Array<std::uint32_t> link_start;  ///< by place in class_members
    Array<SeamLink> links;
    std::uint32_t class_count = 0;

    std::uint32_t tile_rows = 0, tile_cols = 0;
    Array<std::uint8_t> tile_flags;
    Array<std::uint32_t> tile_list, next_tiles;
    std::uint32_t tile_count_listed = 0;
    Array<std::uint32_t> tile_border_start, tile_border;  ///< border samples of each tile
    /// Border faces by the tile whose leaf holds them, and tiles that hold faces with a corner in this one.
    Array<std::uint32_t> tile_face_start, tile_faces, tile_link_start, tile_links;
    Pyramid now_boxes, base_boxes;
    RectList elastic;  ///< where now may differ from base, besides `fading`
    Fading fading;
    RectList normal_dirty;  ///< moved since update_normals()
    std::uint32_t base_version = 0;
    std::uint64_t moved = 0;  ///< how often `now` was written
    static constexpr std::uint32_t kMostPatches = 2;
    Patch patches[kMostPatches];
    std::uint32_t patch_count = 0;
    std::uint64_t patch_clock = 0;
    PatchScratch patch_scratch;
    PatchPress press;
    mutable Changes changes;  ///< of `now` and `normal`, for readers: asking changes nothing else
    WalkScratch walk;
    FootprintScratch footprint;
    GeodesicScratch geodesic;
    Array<ToolSlot> tools;
    std::uint32_t any_sample = kNone;  ///< the first on the surface
    bool any_face = false;             ///< it has a triangle at all
    bool open_surface = true;          ///< some edge of the welded surface has one face

    [[nodiscard]] std::uint32_t total() const noexcept { return tables.total; }
    /// Some window can reach a seam or a free border, so unfolding is needed.
    [[nodiscard]] bool classes_or_border() const noexcept { return class_count != 0 || tables.free_domain; }
    // Always inline: files built for size ask for them in inner loops too.
    [[nodiscard, gnu::always_inline]] static Vec3 at(const Planes& p, std::uint32_t s) noexcept {
        return {p.x[s], p.y[s], p.z[s]};
    }
    [[nodiscard, gnu::always_inline]] static Vec3 at(const ConstPlanes& p, std::uint32_t s) noexcept {
        return {p.x[s], p.y[s], p.z[s]};
    }
    [[nodiscard]] static ConstPlanes fixed(const Planes& p) noexcept { return {p.x, p.y, p.z}; }
    [[nodiscard, gnu::always_inline]] Vec3 point(std::uint32_t s) const noexcept { return at(now, s); }
    [[nodiscard]] bool usable(std::uint32_t s) const noexcept { return s < tables.total && tables.on_surface(s); }
    [[nodiscard]] std::uint32_t class_id(std::uint32_t s) const noexcept {
        return class_of.empty() ? kNone : class_of[s];
    }
    [[nodiscard]] std::span<const std::uint32_t> members(std::uint32_t id) const noexcept {
        return {class_members.data() + class_start[id], class_start[id + 1] - class_start[id]};
    }
    [[nodiscard]] std::uint32_t representative(std::uint32_t s) const noexcept {
        const std::uint32_t id = class_id(s);
        return id == kNone ? s : class_members[class_start[id]];
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
    /// Samples a tile owns: 8 x 8, the last row and column with the last tiles.
    [[nodiscard]] Rect tile_rect(std::uint32_t tile) const noexcept;
    /// Window of half size b - 1 around a grid sample, clipped by the grid.
    [[nodiscard]] Rect window(std::uint32_t sample, std::uint32_t b) const noexcept;
    [[nodiscard]] Rect whole() const noexcept { return {0, tables.rows - 1, 0, tables.cols - 1}; }
    /// Notes that samples moved, those of a Rect or a RectList; `plastic`: in the base shape too.
    template <class Moved>
    void touch(const Moved& where, bool plastic) noexcept {
        ++moved;
        changes.note(where);
        if (!plastic) elastic.add(where);
        if (!plastic && fading.in_tick) return;
        now_boxes.dirty.add(where);
        normal_dirty.add(where);
        if (!plastic) return;
        base_boxes.dirty.add(where);
        ++base_version;
    }
    void touch_all() noexcept;
    /// Whoever writes to `now` or `normal` past touch() and update_normals() says where, for changed_rows().
    void note_moved(const Rect& r) noexcept { changes.note(r); }
    void note_normals(const Rect& r) noexcept { changes.note(r); }
    /// Positions or normals of border samples low .. high.
    void note_border(std::uint32_t low, std::uint32_t high) noexcept { changes.note_border(low, high); }
    /// Appends a tile to tile_list once.
    void list_tile(std::uint32_t tile) noexcept {
        if ((tile_flags[tile] & kTileListed) != 0) return;
        tile_flags[tile] |= kTileListed;
        tile_list[tile_count_listed++] = tile;
    }
    void end_tile_list() noexcept {
        for (std::uint32_t k = 0; k < tile_count_listed; ++k)
            tile_flags[tile_list[k]] &= static_cast<std::uint8_t>(~kTileListed);
        tile_count_listed = 0;
    }
};

/// Seam classes from the pairs, then links from the border edges that two mates share. @return OutOfMemory.
[[nodiscard]] Result<void> build_classes(StateImpl& state) noexcept;
[[nodiscard]] Result<void> build_links(StateImpl& state) noexcept;
/// Tiles, their border samples and boxes. @return OutOfMemory.
[[nodiscard, gnu::cold]] Result<void> build_pyramid(StateImpl& state) noexcept;  // cold: built small
/// Brings the boxes of moved samples and of the nodes above them up to date.
void refit(StateImpl& state, Pyramid& pyramid) noexcept;

/// Which corners are in the ring of each sample, and which samples need ring_normal(). @return OutOfMemory.
[[nodiscard, gnu::cold]] Result<void> build_rings(StateImpl& state) noexcept;
/// How far normals lie from those of the faces around them, at rest.
void measure_roughness(StateImpl& state) noexcept;
/// Twice the area vector of the welded ring of a sample, and its slope as in RingJob.
struct RingForm {
    double sum[6] = {};  ///< area, slope
};
[[nodiscard]] RingForm ring_form(const StateImpl& state, const ConstPlanes& shape, const float* weight,
                                 std::uint32_t sample) noexcept;
/// Area-weighted unit normal of a shape over the welded ring; 0 without area.
[[nodiscard]] Vec3 ring_normal(const StateImpl& state, const ConstPlanes& shape, std::uint32_t sample) noexcept;
/// Of `count` regular samples side by side. @return false if one was left at 0: float would not do.
[[nodiscard]] bool normals_inside(const StateImpl& state, const ConstPlanes& shape, std::uint32_t first,
                                  std::uint32_t count, const Planes& to) noexcept;
/// The normal that update_normals() stores for `now`.
[[nodiscard]] Vec3 sample_normal(const StateImpl& state, const ConstPlanes& shape, std::uint32_t sample) noexcept;
/// Brings `normal` up to date around what moved.
void update_normals(StateImpl& state) noexcept;

/// now = base wherever it may differ.
void release_elastic(StateImpl& state) noexcept;
/// Lets elastic displacements fade by exp(-passed); normals() stay as they were.
void relax_elastic(StateImpl& state, double passed) noexcept;
/// The same for a tick, which says itself what becomes of the normals.
void advance_fading(StateImpl& state, double passed) noexcept;
/// Adds the tiles and border samples that fade.
void add_fading(const StateImpl& state, RectList& to) noexcept;
/// Brings samples up to the clock: those of a rectangle, one, or all that fade.
void fade(StateImpl& state, const Rect& rect) noexcept;
void fade(StateImpl& state, std::uint32_t sample) noexcept;
/// Ends a tick in which displacements fade: what it moved fades from now on, and a few tiles that have come to rest
/// while nobody looked are let go.
void end_fading_tick(StateImpl& state, bool normals) noexcept;
void settle_all(StateImpl& state) noexcept;
/// Whoever reads all of `now` or `normal` calls this before.
inline void settle(StateImpl& state) noexcept {
    if (state.fading.behind) settle_all(state);
}

/// True if the window |di| < b, |dj| < b around grid sample (i, j) holds no seam and no free border, so that it is a
/// plain rectangle clipped by the grid.
[[nodiscard]] bool is_plain_window(const StateImpl& state, std::uint32_t sample, std::uint32_t b) noexcept;
/// Visits every sample whose unfolded offset from `start` stays within |x| < b, |y| < b, nearest first; the nodes
/// stay in state.walk (visited order in `visited`) until end_walk(). @return LimitExceeded (then already ended).
[[nodiscard]] Result<void> begin_walk(StateImpl& state, std::uint32_t start, std::uint32_t b) noexcept;
void end_walk(StateImpl& state) noexcept;

/// One contact of deform(): arguments checked, d clamped.
struct Contact {
    std::uint32_t sample;
    Vec3 d;
    Footprint footprint;
    bool plastic;
    float step;
};
struct TableImpl;

/// Writes key and weight of every sample in reach into state.footprint, its frames, samples and classes; classes all
/// have the values of their nearest copy. @return LimitExceeded; footprint.truncated as DeformReport says.
[[nodiscard]] Result<void> begin_footprint(StateImpl& state, const TableImpl& table, const Contact& contact) noexcept;
void end_footprint(StateImpl& state) noexcept;
/// Square domain: copies of the chart placed over the window |x| < b, |y| < b around `start`, into footprint.frames,
/// with kernel distances of `table` as keys (x^2 + y^2 if null); across seams as far as a copy lies nearest somewhere.
void place_frames(StateImpl& state, const TableImpl* table, std::uint32_t start, std::uint32_t b) noexcept;
/// The same where no two frames share a sample, as at most seams: frames and classes only, all keys stay at infinity.
/// @return false, and nothing placed, where it is not so or a frame's rows are none of the table's.
[[nodiscard]] bool place_frames_apart(StateImpl& state, const TableImpl& table, std::uint32_t start,
                                      std::uint32_t b) noexcept;

/// Exact nearest sample of a shape by its pyramid (which must be refitted).
struct Best {
    float d2 = __builtin_inff();
    std::uint32_t sample = kNone;
    void offer(float d, std::uint32_t k) noexcept {
        if (d < d2 || (d == d2 && k < sample)) {
            d2 = d;
            sample = k;
        }
    }
};
/// Improves `best`; samples of `except` are left out.
void search_pyramid(const StateImpl& state, const Pyramid& pyramid, Vec3 tool, Best& best,
                    const Rect* except = nullptr) noexcept;
[[nodiscard]] bool is_finite(Vec3 v) noexcept;
/// No coordinate beyond kMaxCoordinate, none a NaN.
[[nodiscard]] bool is_place(Vec3 v) noexcept;

[[nodiscard]] Result<DeformReport> apply_contact(StateImpl& state, const TableImpl& table,
                                                 const Contact& contact) noexcept;
[[nodiscard]] Result<void> check_contact(const StateImpl& state, const TableImpl& table, Footprint footprint,
                                         DeformMode mode, float d_max, float step) noexcept;
/// A plain window (rectangle r) around a grid sample, in place on `now`.
[[nodiscard]] MoveJob window_job(const StateImpl& state, const TableImpl& table, const Rect& r, std::uint32_t sample,
                                 Vec3 d) noexcept;
[[nodiscard]] Vec3 clamped(Vec3 d, float d_max) noexcept;

}  // namespace dgm::detail
