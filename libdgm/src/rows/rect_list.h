// SPDX-License-Identifier: MIT
// libdgm/src/rows/rect_list.h
// Touched samples: a bounded list of rectangles of grid samples and one interval of border samples. When it is full it
// covers more than was added, never less.
#pragma once
#include <algorithm>
#include <cstdint>

#include "rows/rows.h"

namespace dgm::detail {

struct RectList {
    static constexpr std::uint32_t kCapacity = 192;
    Rect rects[kCapacity];
    std::uint32_t count = 0;
    std::uint32_t border_low = 0xFFFFFFFFu, border_high = 0;  ///< sample indices, ends included; empty if low > high

    void clear() noexcept {
        count = 0;
        border_low = 0xFFFFFFFFu;
        border_high = 0;
    }
    [[nodiscard]] bool empty() const noexcept { return count == 0 && border_low > border_high; }
    void add_border(std::uint32_t sample) noexcept {
        border_low = std::min(border_low, sample);
        border_high = std::max(border_high, sample);
    }
    void add(const Rect& r) noexcept;
    void add(const RectList& other) noexcept;
    /// The same, but joined with a rectangle that it meets or lies beside.
    void add_near(const Rect& r) noexcept;
    /// Joins rectangles that meet or lie side by side until there are none.
    void join() noexcept;
    [[nodiscard]] static Rect unite(const Rect& a, const Rect& b) noexcept {
        return {std::min(a.i0, b.i0), std::max(a.i1, b.i1), std::min(a.j0, b.j0), std::max(a.j1, b.j1)};
    }
    [[nodiscard]] static bool near(const Rect& a, const Rect& b) noexcept {
        return a.i0 <= b.i1 + 1 && b.i0 <= a.i1 + 1 && a.j0 <= b.j1 + 1 && b.j0 <= a.j1 + 1;
    }
    [[nodiscard]] static std::uint64_t area(const Rect& r) noexcept { return std::uint64_t{r.height()} * r.width(); }
};

}  // namespace dgm::detail
