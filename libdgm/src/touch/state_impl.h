// SPDX-License-Identifier: MIT
// libdgm/src/touch/state_impl.h
// A State: a surface and the memory of its touches.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/deform.h>
#include <dgm/grid.h>
#include <dgm/limits.h>
#include <dgm/state.h>

#include "surface/surface.h"
#include "touch/geodesic.h"
#include "touch/patch.h"
#include "touch/tool_slot.h"

namespace dgm::detail {

/// A sample met by a walk, unfolded into the chart of the walk's start.
struct WalkNode {
    std::uint32_t sample;
    float x, y;          ///< offset from the start in grid steps (rows, columns)
    float cosine, sine;  ///< of this sample's chart in the start's
    float d2;            ///< x^2 + y^2
    std::uint32_t heap;  ///< place in the heap, kNone once visited
};

inline constexpr std::uint8_t kTileFading = 4;  ///< in Fading::plain or Fading::special
inline constexpr std::uint8_t kTileMoved = 8;   ///< faded or came to rest, and settle() has not marked it

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

/// Elastic displacement that fades. exp is multiplicative: a tile that nobody reads waits, and fades in one step when
/// it is read, by exp(-(clock - its own time)). So a tick visits the samples in reach of its tools, and settle() the
/// rest. Copies of a weld class must fade in the same steps to keep the same bits: special tiles and border samples
/// keep one time for all.
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
    bool in_tick = false;                               ///< settle() marks elastic touches
    [[nodiscard]] bool empty() const noexcept {
        return plain.count + special.count + tile_moved == 0 && border_low > border_high && !border_moved;
    }
};

struct StateImpl : Surface {
    explicit StateImpl(const Allocator& a) noexcept : Surface(a) {}
    std::uint32_t max_reach = 0;
    RectList elastic;  ///< where now may differ from base, besides `fading`
    Fading fading;
    std::uint32_t base_version = 0;
    std::uint64_t moved = 0;  ///< how often `now` was written
    static constexpr std::uint32_t kMostPatches = 2;
    Patch patches[kMostPatches];
    std::uint32_t patch_count = 0;
    std::uint64_t patch_clock = 0;
    PatchScratch patch_scratch;
    PatchPress press;
    WalkScratch walk;
    FootprintScratch footprint;
    GeodesicScratch geodesic;
    Array<ToolSlot> tools;

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
    /// Notes that all samples were written, as an elastic touch.
    void touch_all() noexcept {
        const Rect all = whole();
        ++moved;
        changes.note(all);
        for (RectList* list : {&elastic, &now_boxes.dirty, &normal_dirty}) {
            list->clear();
            list->rects[0] = all;
            list->count = 1;
        }
    }
};

/// now = base wherever it may differ.
void release_elastic(StateImpl& state) noexcept;
/// Lets elastic displacements fade by exp(-passed); normals() stay as they were.
void relax_elastic(StateImpl& state, double passed) noexcept;
/// The same for a tick, which handles the normals itself.
void advance_fading(StateImpl& state, double passed) noexcept;
/// Adds the tiles and border samples that fade.
void add_fading(const StateImpl& state, RectList& to) noexcept;
/// Brings samples up to the clock: those of a rectangle, one, or all that fade.
void fade(StateImpl& state, const Rect& rect) noexcept;
void fade(StateImpl& state, std::uint32_t sample) noexcept;
/// Ends a tick in which displacements fade: the new ones fade from now on, and a few tiles that have come to rest
/// without being read are released.
void end_fading_tick(StateImpl& state, bool normals) noexcept;
void settle_all(StateImpl& state) noexcept;
/// Memory for displacements that fade. @return false if there is none.
[[nodiscard]] bool make_fading(StateImpl& state) noexcept;
/// Call this before reading all of `now` or `normal`.
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

[[nodiscard]] Result<DeformReport> apply_contact(StateImpl& state, const TableImpl& table,
                                                 const Contact& contact) noexcept;
[[nodiscard]] Result<void> check_contact(const StateImpl& state, const TableImpl& table, Footprint footprint,
                                         DeformMode mode, float d_max, float step) noexcept;
/// A plain window (rectangle r) around a grid sample, in place on `now`.
[[nodiscard]] MoveJob window_job(const StateImpl& state, const TableImpl& table, const Rect& r, std::uint32_t sample,
                                 Vec3 d) noexcept;
[[nodiscard]] Vec3 clamped(Vec3 d, float d_max) noexcept;

}  // namespace dgm::detail
