// SPDX-License-Identifier: MIT
// libdgm/src/surface/changes.h
// Remembers when samples changed, for any number of readers: a number that grows (the epoch) is stamped on cells of
// eight samples side by side, and a reader asks for cells stamped after its own number. Rectangles wait in a short list
// before they are stamped: a tool presses on nearly the same samples for many ticks between two calls of a reader.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>

#include <dgm/changed.h>

#include "base/memory.h"
#include "rows/rect_list.h"

namespace dgm::detail {

inline constexpr std::uint32_t kRunSamples = 8;  ///< side by side
inline constexpr std::uint32_t kBandRows = 8;    ///< rows that share a block of stamps

/// Cells of a grid and of its border samples: row-major, then the border's.
struct CellGrid {
    std::uint32_t rows = 0, cols = 0, border = 0;
    [[nodiscard]] std::uint32_t across() const noexcept { return (cols + kRunSamples - 1) / kRunSamples; }
    [[nodiscard]] std::uint32_t border_cells() const noexcept { return (border + kRunSamples - 1) / kRunSamples; }
    [[nodiscard]] std::uint32_t bands() const noexcept { return (rows + kBandRows - 1) / kBandRows; }
    [[nodiscard]] std::uint32_t grid() const noexcept { return rows * cols; }
    [[nodiscard]] bool operator==(const CellGrid&) const noexcept = default;
    [[nodiscard]] std::size_t cells() const noexcept { return std::size_t{rows} * across() + border_cells(); }
};

/// Gathers cells into the caller's ranges. Runs come row by row; a rectangle that does not fit is joined to another
/// one.
class RangeWriter {
 public:
    RangeWriter(const CellGrid& grid, std::span<ChangedRange> out) noexcept : grid_(grid), out_(out) {}
    /// Cells first .. last of a row; rows in ascending order.
    void add_row(std::uint32_t row, std::uint32_t first, std::uint32_t last) noexcept;
    /// Cells of the border samples; after all rows. Needs one free range, or one of the border's.
    void add_border(std::uint32_t first, std::uint32_t last) noexcept;
    /// Leaves a range for the border.
    void reserve(std::uint32_t ranges) noexcept { reserved_ = ranges; }
    [[nodiscard]] std::size_t count() const noexcept { return count_; }

 private:
    void join(const Rect& r) noexcept;
    CellGrid grid_;
    std::span<ChangedRange> out_;
    std::size_t count_ = 0, reserved_ = 0;
};

struct Changes {
    /// A rectangle not stamped yet. `sure`: at least so many of its samples were noted.
    struct Waiting {
        Rect rect;
        std::uint64_t sure = 0;
    };
    static constexpr std::uint32_t kWaiting = 8;

    CellGrid grid;
    Waiting waiting[kWaiting];
    std::uint32_t count = 0;
    bool stamped = false;                ///< some stamps are epoch + 1
    std::uint64_t epoch = 1;             ///< value that readers' cursors are set to
    Array<std::uint64_t> cells;          ///< [rows][across], then the border's
    Array<std::uint64_t> blocks, bands;  ///< latest of eight rows of a column of cells; of eight rows
    std::uint64_t border_latest = 1;
    /// Publisher of this state: pairs with SnapshotImpl::source, so that neither is mistaken for another that has taken
    /// its place in memory.
    static constexpr std::uint32_t kPublishers = 4;
    const void* publishers[kPublishers] = {};
    std::uint32_t next_publisher = 0;

    [[nodiscard]] bool allocate(const Allocator& allocator, const CellGrid& size) noexcept;
    void note(const Rect& r) noexcept {
        if (count != 0 && waiting[count - 1].rect.holds(r)) return;
        note_other(r);
    }
    void note(const RectList& list) noexcept;
    /// Border samples low .. high (sample indices).
    void note_border(std::uint32_t low, std::uint32_t high) noexcept;
    void note_sample(std::uint32_t sample) noexcept;
    /// Stamps the waiting rectangles. The epoch is then that of the latest change.
    void bring_up() noexcept;
    /// f(row, first cell, last cell) of every run stamped after `cursor`, then border(first cell, last cell).
    template <class Row, class Border>
    void each_run(std::uint64_t cursor, Row row, Border border) const noexcept;

 private:
    DGM_API void note_other(const Rect& r) noexcept;
    void stamp(const Rect& r) noexcept;
};

/// f(first, last) of every run of numbers k in from .. end - 1 with is(k).
template <class Is, class F>
void each_run_of(std::uint32_t from, std::uint32_t end, Is is, F f) noexcept {
    for (std::uint32_t k = from; k < end; ++k) {
        if (!is(k)) continue;
        const std::uint32_t first = k;
        while (k + 1 < end && is(k + 1)) ++k;
        f(first, k);
    }
}

template <class Row, class Border>
void Changes::each_run(std::uint64_t cursor, Row row, Border border) const noexcept {
    const std::uint32_t across = grid.across();
    for (std::uint32_t b = 0; b < bands.size(); ++b) {
        if (bands[b] <= cursor) continue;
        const std::uint64_t* block = blocks.data() + std::size_t{b} * across;
        std::uint32_t low = 0, high = across;  // most bands changed in a few columns
        while (low < across && block[low] <= cursor) ++low;
        while (high > low && block[high - 1] <= cursor) --high;
        for (std::uint32_t i = b * kBandRows; i < std::min((b + 1) * kBandRows, grid.rows); ++i) {
            const std::uint64_t* cell = cells.data() + std::size_t{i} * across;
            each_run_of(
                low, high, [&](std::uint32_t c) { return cell[c] > cursor; },
                [&](std::uint32_t first, std::uint32_t last) { row(i, first, last); });
        }
    }
    if (border_latest <= cursor) return;
    const std::uint64_t* cell = cells.data() + std::size_t{grid.rows} * across;
    each_run_of(
        0, grid.border_cells(), [&](std::uint32_t c) { return cell[c] > cursor; }, border);
}

}  // namespace dgm::detail
