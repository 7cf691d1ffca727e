// SPDX-License-Identifier: MIT
// libdgm/src/surface/changes.cpp
#include "surface/changes.h"

namespace dgm {
namespace detail {
namespace {

Rect rect_of(const CellGrid& grid, const ChangedRange& r) noexcept {
    const std::uint32_t i = r.first / grid.cols, j = r.first % grid.cols;
    return {i, i + r.rows - 1, j, j + r.columns - 1};
}
std::uint64_t overlap(const Rect& a, const Rect& b) noexcept {
    if (!a.meets(b)) return 0;
    return RectList::area({std::max(a.i0, b.i0), std::min(a.i1, b.i1), std::max(a.j0, b.j0), std::min(a.j1, b.j1)});
}
}  // namespace

bool Changes::allocate(const Allocator& allocator, const CellGrid& size) noexcept {
    grid = size;
    return cells.allocate(allocator, size.cells(), epoch) &&
           blocks.allocate(allocator, std::uint64_t{size.bands()} * size.across(), epoch) &&
           bands.allocate(allocator, size.bands(), epoch);
}

void Changes::stamp(const Rect& r) noexcept {
    const std::uint32_t across = grid.across(), c0 = r.j0 / kRunSamples, width = r.j1 / kRunSamples - c0 + 1;
    for (std::uint32_t i = r.i0; i <= r.i1; ++i)
        std::fill_n(cells.data() + std::size_t{i} * across + c0, width, epoch + 1);
    for (std::uint32_t b = r.i0 / kBandRows; b <= r.i1 / kBandRows; ++b) {
        std::fill_n(blocks.data() + std::size_t{b} * across + c0, width, epoch + 1);
        bands[b] = epoch + 1;
    }
    stamped = true;
}

void Changes::note(const RectList& list) noexcept {
    for (std::uint32_t k = 0; k < list.count; ++k) note(list.rects[k]);
    note_border(list.border_low, list.border_high);
}

void Changes::note_border(std::uint32_t low, std::uint32_t high) noexcept {
    if (low > high) return;
    const std::size_t from = std::size_t{grid.rows} * grid.across();
    for (std::uint32_t c = (low - grid.grid()) / kRunSamples; c <= (high - grid.grid()) / kRunSamples; ++c)
        cells[from + c] = epoch + 1;
    border_latest = epoch + 1;
    stamped = true;
}

void Changes::note_sample(std::uint32_t sample) noexcept {
    if (sample >= grid.grid()) return note_border(sample, sample);
    const std::uint32_t i = sample / grid.cols, j = sample % grid.cols;
    stamp({i, i, j, j});
}

/// Joined where at most a fifth of the joint rectangle was not noted.
void Changes::note_other(const Rect& r) noexcept {
    if (r.empty()) return;
    for (std::uint32_t k = count; k-- > 0;)
        if (waiting[k].rect.holds(r)) return;
    for (std::uint32_t k = count; k-- > 0;) {
        Waiting& w = waiting[k];
        const Rect joint = RectList::unite(w.rect, r);
        const std::uint64_t sure = w.sure + RectList::area(r) - overlap(w.rect, r);
        if (4 * RectList::area(joint) > 5 * sure) continue;
        w = {joint, sure};
        return;
    }
    if (count == kWaiting) {
        for (const Waiting& w : waiting) stamp(w.rect);
        count = 0;
    }
    waiting[count++] = {r, RectList::area(r)};
}

void Changes::bring_up() noexcept {
    for (std::uint32_t k = 0; k < count; ++k) stamp(waiting[k].rect);
    count = 0;
    epoch += stamped ? 1 : 0;
    stamped = false;
}

void RangeWriter::add_row(std::uint32_t row, std::uint32_t first, std::uint32_t last) noexcept {
    const std::uint32_t j0 = first * kRunSamples, j1 = std::min(last * kRunSamples + kRunSamples, grid_.cols) - 1;
    const std::uint32_t at = row * grid_.cols + j0;
    // The run below one of the row before, mostly the last ones.
    for (std::size_t k = count_; k-- > (count_ > 16 ? count_ - 16 : 0);) {
        ChangedRange& r = out_[k];
        if (r.columns != j1 - j0 + 1 || r.first + r.rows * grid_.cols != at) continue;
        ++r.rows;
        return;
    }
    if (count_ + reserved_ < out_.size())
        out_[count_++] = {at, j1 - j0 + 1, 1};
    else
        join({row, row, j0, j1});
}

void RangeWriter::join(const Rect& r) noexcept {
    std::size_t best = 0;
    std::uint64_t growth = ~std::uint64_t{0};
    for (std::size_t k = 0; k < count_; ++k) {
        const Rect is = rect_of(grid_, out_[k]);
        const std::uint64_t grown = RectList::area(RectList::unite(is, r)) - RectList::area(is);
        if (grown >= growth) continue;
        growth = grown;
        best = k;
    }
    const Rect joint = RectList::unite(rect_of(grid_, out_[best]), r);
    out_[best] = {joint.i0 * grid_.cols + joint.j0, joint.width(), joint.height()};
}

void RangeWriter::add_border(std::uint32_t first, std::uint32_t last) noexcept {
    const std::uint32_t low = first * kRunSamples, high = std::min((last + 1) * kRunSamples, grid_.border);
    if (count_ < out_.size()) {
        out_[count_++] = {grid_.grid() + low, high - low, 1};
        return;
    }
    ChangedRange& r = out_[count_ - 1];  // intervals come in ascending order
    r.columns = grid_.grid() + high - r.first;
}
}  // namespace detail

}  // namespace dgm
