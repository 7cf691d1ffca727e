// SPDX-License-Identifier: MIT
// libdgm/src/relax.cpp
// The end of elastic touches: at once, or fading.
#include <algorithm>
#include <cstring>

#include "state_impl.h"

namespace dgm::detail {
namespace {

void copy_rect(const StateImpl& s, const Rect& r) noexcept {
    const std::size_t bytes = r.width() * sizeof(float);
    for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
        const std::size_t at = std::size_t{i} * s.tables.cols + r.j0;
        std::memcpy(s.now.x + at, s.base.x + at, bytes);
        std::memcpy(s.now.y + at, s.base.y + at, bytes);
        std::memcpy(s.now.z + at, s.base.z + at, bytes);
    }
}

Planes from(const Planes& p, std::size_t at) noexcept {
    return {p.x + at, p.y + at, p.z + at};
}

bool relax_run(const StateImpl& s, std::size_t first, std::uint32_t count, float factor, float still) noexcept {
    return s.rows_of->relax(from(s.now, first), StateImpl::fixed(from(s.base, first)), count, factor, still);
}
}  // namespace

void release_elastic(StateImpl& s) noexcept {
    if (s.elastic.empty()) return;
    for (std::uint32_t k = 0; k < s.elastic.count; ++k) copy_rect(s, s.elastic.rects[k]);
    if (s.elastic.border_low <= s.elastic.border_high) {
        const std::size_t at = s.elastic.border_low, bytes = (s.elastic.border_high - at + 1) * sizeof(float);
        std::memcpy(s.now.x + at, s.base.x + at, bytes);
        std::memcpy(s.now.y + at, s.base.y + at, bytes);
        std::memcpy(s.now.z + at, s.base.z + at, bytes);
    }
    s.now_boxes.dirty.add(s.elastic);
    s.normal_dirty.add(s.elastic);
    s.elastic.clear();
}

// Rectangles may overlap, and a sample must fade once: so by the tiles they meet. Whether a sample has come to rest is
// decided by its own displacement alone, so copies of a class do so together.
void relax_elastic(StateImpl& s, float factor, float still) noexcept {
    if (s.elastic.empty()) return;
    s.now_boxes.dirty.add(s.elastic);
    s.normal_dirty.add(s.elastic);
    for (std::uint32_t k = 0; k < s.elastic.count; ++k) {
        const Rect& r = s.elastic.rects[k];
        for (std::uint32_t ti = StateImpl::owner(r.i0, s.tile_rows); ti <= StateImpl::owner(r.i1, s.tile_rows); ++ti)
            for (std::uint32_t tj = StateImpl::owner(r.j0, s.tile_cols); tj <= StateImpl::owner(r.j1, s.tile_cols);
                 ++tj)
                s.list_tile(ti * s.tile_cols + tj);
    }
    const std::uint32_t low = s.elastic.border_low, high = s.elastic.border_high;
    s.elastic.clear();
    for (std::uint32_t k = 0; k < s.tile_count_listed; ++k) {
        const Rect r = s.tile_rect(s.tile_list[k]);
        bool moving = false;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            moving = relax_run(s, std::size_t{i} * s.tables.cols + r.j0, r.width(), factor, still) || moving;
        if (moving) s.elastic.add(r);
    }
    s.end_tile_list();
    if (low > high || !relax_run(s, low, high - low + 1, factor, still)) return;
    s.elastic.add_border(low);
    s.elastic.add_border(high);
}

}  // namespace dgm::detail
