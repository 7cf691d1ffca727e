// SPDX-License-Identifier: MIT
// libdgm/src/rows/rect_list.cpp
#include "rows/rect_list.h"

namespace dgm::detail {

void RectList::add(const Rect& r) noexcept {
    if (r.empty()) return;
    std::uint32_t best = 0;
    std::uint64_t growth = ~std::uint64_t{0};
    for (std::uint32_t k = count; k-- > 0;) {  // neighbours come one after the other
        if (rects[k].holds(r)) return;
        // Joined where one rectangle costs no more than two.
        const Rect u = unite(rects[k], r);
        if (area(u) <= area(rects[k]) + area(r)) {
            rects[k] = u;
            return;
        }
        if (area(u) - area(rects[k]) < growth) {
            growth = area(u) - area(rects[k]);
            best = k;
        }
    }
    if (count < kCapacity)
        rects[count++] = r;
    else
        rects[best] = unite(rects[best], r);
}

void RectList::add_near(const Rect& r) noexcept {
    for (std::uint32_t k = count; k-- > 0;)
        if (near(rects[k], r)) {
            rects[k] = unite(rects[k], r);
            return;
        }
    add(r);
}

void RectList::join() noexcept {
    for (std::uint32_t k = 0; k < count;) {
        std::uint32_t e = k + 1;
        while (e < count && !near(rects[k], rects[e])) ++e;
        if (e == count) {
            ++k;
            continue;
        }
        rects[k] = unite(rects[k], rects[e]);
        rects[e] = rects[--count];
        k = 0;  // it may meet those before it now
    }
}

void RectList::add(const RectList& other) noexcept {
    for (std::uint32_t k = 0; k < other.count; ++k) add(other.rects[k]);
    if (other.border_low > other.border_high) return;
    add_border(other.border_low);
    add_border(other.border_high);
}

}  // namespace dgm::detail
