// SPDX-License-Identifier: MIT
// libdgm/src/touch/relax.cpp
// The end of elastic touches: at once, or fading (see Fading in state_impl.h).
#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/portable_math.h"
#include "touch/state_impl.h"

namespace dgm::detail {
namespace {

/// Tiles looked at by a sweep: more than a tool leaves behind in a tick, on the whole.
constexpr std::uint32_t kSweep = 4;
/// exp(-200) leaves nothing of a float displacement, and the clock keeps the small steps of later ticks.
constexpr double kForgotten = 200;

void copy_rect(const StateImpl& s, const Rect& r) noexcept {
    const std::size_t bytes = r.width() * sizeof(float);
    for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
        const std::size_t at = std::size_t{i} * s.tables.cols + r.j0;
        std::memcpy(s.now.x + at, s.base.x + at, bytes);
        std::memcpy(s.now.y + at, s.base.y + at, bytes);
        std::memcpy(s.now.z + at, s.base.z + at, bytes);
    }
}
/// Border samples are a row of their own.
Rect border_run(std::uint32_t low, std::uint32_t high) noexcept {
    return {0, 0, low, high};
}

/// Less than this is left out.
float still(const StateImpl& s) noexcept {
    return 1e-6f * s.mean_step;
}
float relax_rect(const StateImpl& s, const Rect& r, double passed) noexcept {
    return s.rows_of->relax(
        {r, s.tables.cols, s.now, StateImpl::fixed(s.base), static_cast<float>(portable_exp(-passed)), still(s)});
}

bool is_special(const StateImpl& s, std::uint32_t tile) noexcept {
    return (s.tile_flags[tile] & kTileSpecial) != 0;
}

/// Samples of a tile are not where settle() last marked them.
void mark_moved(StateImpl& s, std::uint32_t tile) noexcept {
    std::uint8_t& flags = s.tile_flags[tile];
    s.fading.tile_moved += (flags & kTileMoved) == 0 ? 1 : 0;
    flags |= kTileMoved;
}

/// A tile that has come to rest; its place in the list goes to the last one.
void drop(StateImpl& s, TileList& list, std::uint32_t place) noexcept {
    mark_moved(s, list.tiles[place]);
    s.tile_flags[list.tiles[place]] &= static_cast<std::uint8_t>(~kTileFading);
    list.tiles[place] = list.tiles[--list.count];
}

void fade_special(StateImpl& s) noexcept {
    Fading& f = s.fading;
    const double passed = f.clock - f.special_time;
    if (!(passed > 0)) return;
    f.special_time = f.clock;
    for (std::uint32_t k = f.special.count; k-- > 0;) {
        const Rect r = s.tile_rect(f.special.tiles[k]);
        s.note(r);
        mark_moved(s, f.special.tiles[k]);
        if (!(relax_rect(s, r, passed) > 0)) drop(s, f.special, k);
    }
    if (f.border_low > f.border_high) return;
    f.border_moved = true;
    s.note_border(f.border_low, f.border_high);
    if (relax_rect(s, border_run(f.border_low, f.border_high), passed) > 0) return;
    f.border_low = kNone;
    f.border_high = 0;
}

void start_tile(StateImpl& s, std::uint32_t tile) noexcept {
    Fading& f = s.fading;
    const bool special = is_special(s, tile);
    if (special)
        fade_special(s);
    else
        f.left[tile] = __builtin_inff();
    if ((s.tile_flags[tile] & kTileFading) != 0) return;
    s.tile_flags[tile] |= kTileFading;
    TileList& list = special ? f.special : f.plain;
    list.tiles[list.count++] = tile;
    if (!special) f.time[tile] = f.clock;
}

struct TileRange {
    std::uint32_t i0, i1, j0, j1;
};
TileRange tiles_of(const StateImpl& s, const Rect& r) noexcept {
    return {StateImpl::owner(r.i0, s.tile_rows), StateImpl::owner(r.i1, s.tile_rows),
            StateImpl::owner(r.j0, s.tile_cols), StateImpl::owner(r.j1, s.tile_cols)};
}

/// Tiles of a row of them, side by side and of one time, in one go.
void fade_run(StateImpl& s, std::uint32_t first, std::uint32_t last) noexcept {
    Fading& f = s.fading;
    Rect r = s.tile_rect(first);
    r.j1 = s.tile_rect(last).j1;
    s.note(r);
    const float left = relax_rect(s, r, f.clock - f.time[first]);
    for (std::uint32_t tile = first; tile <= last; ++tile) {
        f.time[tile] = f.clock;
        f.left[tile] = left;
        mark_moved(s, tile);
    }
}

void release_list(StateImpl& s, TileList& list) noexcept {
    for (std::uint32_t k = list.count; k-- > 0;) {
        const Rect r = s.tile_rect(list.tiles[k]);
        s.note(r);
        copy_rect(s, r);
        drop(s, list, k);
    }
}

/// Marks for the pyramid and the normals all samples that faded or came to rest since the last time.
void tell_moved(StateImpl& s) noexcept {
    Fading& f = s.fading;
    RectList moved;
    if (f.tile_moved != 0) {
        for (std::uint32_t i = 0; i < s.tile_rows; ++i)
            for (std::uint32_t j = 0; j < s.tile_cols; ++j) {
                const std::uint32_t first = i * s.tile_cols + j;
                if ((s.tile_flags[first] & kTileMoved) == 0) continue;
                std::uint32_t last = first;
                for (;; ++last, ++j) {
                    s.tile_flags[last] &= static_cast<std::uint8_t>(~kTileMoved);
                    if (j + 1 == s.tile_cols || (s.tile_flags[last + 1] & kTileMoved) == 0) break;
                }
                Rect r = s.tile_rect(first);
                r.j1 = s.tile_rect(last).j1;
                moved.add(r);
            }
        f.tile_moved = 0;
    }
    if (f.border_moved) {
        moved.add_border(s.tables.grid);
        moved.add_border(s.total() - 1);
        f.border_moved = false;
    }
    s.now_boxes.dirty.add(moved);
    s.normal_dirty.add(moved);
}

/// The displacements in `elastic` fade from now on. Their tiles are up to the clock. `told`: touch() has listed the
/// change already.
void start_fading(StateImpl& s, bool told) noexcept {
    Fading& f = s.fading;
    if (s.elastic.empty()) return;
    for (std::uint32_t k = 0; k < s.elastic.count; ++k) {
        const TileRange t = tiles_of(s, s.elastic.rects[k]);
        for (std::uint32_t i = t.i0; i <= t.i1; ++i)
            for (std::uint32_t j = t.j0; j <= t.j1; ++j) {
                start_tile(s, i * s.tile_cols + j);
                if (!told) mark_moved(s, i * s.tile_cols + j);
            }
    }
    if (s.elastic.border_low <= s.elastic.border_high) {
        fade_special(s);
        f.border_low = std::min(f.border_low, s.elastic.border_low);
        f.border_high = std::max(f.border_high, s.elastic.border_high);
        f.border_moved = f.border_moved || !told;
    }
    s.elastic.clear();
}

/// Tiles that have come to rest without being read.
void sweep(StateImpl& s) noexcept {
    Fading& f = s.fading;
    for (std::uint32_t k = 0; k < kSweep && f.plain.count != 0; ++k) {
        if (f.sweep >= f.plain.count) f.sweep = 0;
        const std::uint32_t tile = f.plain.tiles[f.sweep];
        const double passed = f.clock - f.time[tile];
        const bool known = f.left[tile] < __builtin_inff();
        if (passed > 0 && (!known || passed >= portable_log(double{f.left[tile]} / still(s)))) fade_run(s, tile, tile);
        if (f.left[tile] > 0)
            ++f.sweep;
        else
            drop(s, f.plain, f.sweep);
    }
}
}  // namespace

void fade(StateImpl& s, const Rect& rect) noexcept {
    if (!s.fading.behind) return;
    const Fading& f = s.fading;
    const TileRange t = tiles_of(s, rect);
    for (std::uint32_t i = t.i0; i <= t.i1; ++i) {
        const std::uint32_t row = i * s.tile_cols;
        for (std::uint32_t j = t.j0; j <= t.j1; ++j) {
            const std::uint32_t first = row + j;
            if ((s.tile_flags[first] & kTileFading) == 0) continue;
            if (is_special(s, first)) {
                fade_special(s);
                continue;
            }
            if (!(f.time[first] < f.clock)) continue;
            const auto alike = [&](std::uint32_t tile) {
                return (s.tile_flags[tile] & (kTileFading | kTileSpecial)) == kTileFading &&
                       f.time[tile] == f.time[first];
            };
            while (j < t.j1 && alike(row + j + 1)) ++j;
            fade_run(s, first, row + j);
        }
    }
}

void fade(StateImpl& s, std::uint32_t sample) noexcept {
    if (!s.fading.behind) return;
    const std::uint32_t tile = s.tile_of(sample);
    if (is_special(s, tile)) return fade_special(s);
    if ((s.tile_flags[tile] & kTileFading) != 0 && s.fading.time[tile] < s.fading.clock) fade_run(s, tile, tile);
}

void advance_fading(StateImpl& s, double passed) noexcept {
    Fading& f = s.fading;
    ++s.moved;
    start_fading(s, true);
    if (f.plain.count == 0 && f.special.count == 0 && f.border_low > f.border_high) {
        f.clock = f.special_time = 0;  // nothing keeps a time
        return;
    }
    if (!(passed > 0)) return;
    f.clock += std::min(passed, kForgotten);
    f.behind = true;
}

void settle_all(StateImpl& s) noexcept {
    Fading& f = s.fading;
    fade(s, s.whole());
    fade_special(s);
    for (std::uint32_t k = f.plain.count; k-- > 0;)
        if (!(f.left[f.plain.tiles[k]] > 0)) drop(s, f.plain, k);
    tell_moved(s);
    f.behind = false;
    if (f.normals_owed) update_normals(s);
    f.normals_owed = false;
}

void release_elastic(StateImpl& s) noexcept {
    Fading& f = s.fading;
    ++s.moved;
    if (!f.empty()) {
        release_list(s, f.plain);
        release_list(s, f.special);
        if (f.border_low <= f.border_high) {
            copy_rect(s, border_run(f.border_low, f.border_high));
            f.border_moved = true;
            s.note_border(f.border_low, f.border_high);
        }
        f.border_low = kNone;
        f.border_high = 0;
        f.behind = false;
        tell_moved(s);
    }
    if (s.elastic.empty()) return;
    for (std::uint32_t k = 0; k < s.elastic.count; ++k) copy_rect(s, s.elastic.rects[k]);
    if (s.elastic.border_low <= s.elastic.border_high)
        copy_rect(s, border_run(s.elastic.border_low, s.elastic.border_high));
    s.changes.note(s.elastic);
    s.now_boxes.dirty.add(s.elastic);
    s.normal_dirty.add(s.elastic);
    s.elastic.clear();
}

void relax_elastic(StateImpl& s, double passed) noexcept {
    if (s.fading.normals_owed) settle(s);
    advance_fading(s, passed);
}

void end_fading_tick(StateImpl& s, bool normals) noexcept {
    s.fading.in_tick = false;
    start_fading(s, false);
    s.fading.behind = true;  // the clock may stand, but touched samples are still to be marked
    s.fading.normals_owed = normals;
    sweep(s);
}

void add_fading(const StateImpl& s, RectList& to) noexcept {
    for (const TileList* list : {&s.fading.plain, &s.fading.special})
        for (std::uint32_t k = 0; k < list->count; ++k) to.add(s.tile_rect(list->tiles[k]));
    if (s.fading.border_low > s.fading.border_high) return;
    to.add_border(s.fading.border_low);
    to.add_border(s.fading.border_high);
}

bool make_fading(StateImpl& s) noexcept {
    const std::uint64_t tiles = std::uint64_t{s.tile_rows} * s.tile_cols;
    const Allocator& a = s.allocator;
    return s.fading.time.allocate(a, tiles) && s.fading.left.allocate(a, tiles) &&
           s.fading.plain.tiles.allocate(a, tiles) && s.fading.special.tiles.allocate(a, tiles);
}

}  // namespace dgm::detail
