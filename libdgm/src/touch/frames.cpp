// SPDX-License-Identifier: MIT
// libdgm/src/touch/frames.cpp
// The footprint at a seam of a square domain: copies of the whole grid laid around the contact.
//
// Across a seam the grid goes on turned by quarter turns. So the window consists of rectangles of a few placed copies
// ("frames") of the grid, and each is done row by row. A sample with several places takes the nearest; a copy is looked
// at only if it was reached over a seam sample that lay nearest in the copy before.
#include <algorithm>
#include <cmath>

#include "touch/state_impl.h"
#include "touch/table_impl.h"

namespace dgm::detail {
namespace {

class Placer {
 public:
    Placer(StateImpl& s, const TableImpl* table, std::uint32_t b) noexcept
        : s_(s), f_(s.footprint), table_(table), r_(static_cast<std::int32_t>(b) - 1) {}

    void run(std::uint32_t start) noexcept {
        begin(start);
        for (std::uint32_t k = 0; k < f_.frame_count; ++k) {
            place(f_.frames[k]);
            if (s_.class_count != 0) follow_seams(f_.frames[k]);
        }
    }

    /// Frames only; keys stay at infinity. @return false if two meet, or rows run through the kernel's columns.
    bool run_apart(std::uint32_t start) noexcept {
        begin(start);
        for (std::uint32_t k = 0; k < f_.frame_count; ++k) {
            const Frame& f = f_.frames[k];
            if (f.c == 0 && !table_->mirrored) return false;
            for (std::uint32_t e = 0; e < k; ++e)
                if (f_.frames[e].rect.meets(f.rect)) return false;
            follow_seams(f);
        }
        return !f_.truncated;
    }

 private:
    void begin(std::uint32_t start) noexcept {
        const auto i = static_cast<std::int32_t>(start / s_.tables.cols);
        const auto j = static_cast<std::int32_t>(start % s_.tables.cols);
        f_.frame_count = 0;
        add(1, 0, -i, -j);
    }

    void add(std::int32_t c, std::int32_t s, std::int32_t x, std::int32_t y) noexcept {
        for (std::uint32_t k = f_.frame_count; k-- > 0;) {
            const Frame& known = f_.frames[k];
            if (known.c == c && known.s == s && known.x == x && known.y == y) return;
        }
        // The window seen from the frame: (i, j) = turn back (X - x, Y - y) for |X|, |Y| <= r.
        const std::int32_t i = c * -x + s * -y, j = -s * -x + c * -y;
        const std::int32_t i0 = std::max(i - r_, 0),
                           i1 = std::min(i + r_, static_cast<std::int32_t>(s_.tables.rows) - 1);
        const std::int32_t j0 = std::max(j - r_, 0),
                           j1 = std::min(j + r_, static_cast<std::int32_t>(s_.tables.cols) - 1);
        if (i0 > i1 || j0 > j1) return;
        if (f_.frame_count == kMaxFrames) {
            f_.truncated = true;
            return;
        }
        f_.frames[f_.frame_count++] = {c,
                                       s,
                                       x,
                                       y,
                                       {static_cast<std::uint32_t>(i0), static_cast<std::uint32_t>(i1),
                                        static_cast<std::uint32_t>(j0), static_cast<std::uint32_t>(j1)}};
    }

    [[nodiscard]] float key(std::int32_t x, std::int32_t y) const noexcept {
        const auto X = static_cast<float>(x), Y = static_cast<float>(y);
        return a() * X * X + b() * X * Y + c() * Y * Y;
    }
    [[nodiscard]] float a() const noexcept { return table_ == nullptr ? 1 : static_cast<float>(table_->a); }
    [[nodiscard]] float b() const noexcept { return table_ == nullptr ? 0 : static_cast<float>(table_->b); }
    [[nodiscard]] float c() const noexcept { return table_ == nullptr ? 1 : static_cast<float>(table_->c); }

    /// Keys and weights of the frame's rectangle where it is nearer than the frames so far. Kernels are even, so a row
    /// that runs backwards through the kernel is the row of the opposite offset forwards.
    void place(const Frame& f) noexcept {
        const std::uint32_t cols = s_.tables.cols;
        const auto j0 = static_cast<std::int32_t>(f.rect.j0);
        for (std::uint32_t i = f.rect.i0; i <= f.rect.i1; ++i) {
            const auto row = static_cast<std::int32_t>(i);
            const std::int32_t x = f.c * row - f.s * j0 + f.x, y = f.s * row + f.c * j0 + f.y;
            const std::size_t at = std::size_t{i} * cols + f.rect.j0;
            const float* w = f_.weight.data() + at;  // no table: weights stay
            if (table_ != nullptr) {
                const std::int32_t sign = f.c + -f.s > 0 ? 1 : -1;  // direction in which the running offset grows
                w = f.c != 0 ? table_->row(sign * x) + sign * y : table_->row(sign * y, true) + sign * x;
            }
            s_.rows_of->merge({f_.key.data() + at, f_.weight.data() + at, w, f.rect.width(), a(), b(), c(),
                               static_cast<float>(x), static_cast<float>(y), static_cast<float>(-f.s),
                               static_cast<float>(f.c)});
        }
    }

    void follow_seams(const Frame& f) noexcept {
        const Rect r = f.rect;
        const std::uint32_t m = s_.tables.rows, n = s_.tables.cols;
        if (r.i0 == 0)
            for (std::uint32_t j = r.j0; j <= r.j1; ++j) follow(f, 0, j);
        if (r.i1 == m - 1)
            for (std::uint32_t j = r.j0; j <= r.j1; ++j) follow(f, m - 1, j);
        if (r.j0 == 0)
            for (std::uint32_t i = r.i0; i <= r.i1; ++i) follow(f, i, 0);
        if (r.j1 == n - 1)
            for (std::uint32_t i = r.i0; i <= r.i1; ++i) follow(f, i, n - 1);
    }

    void follow(const Frame from, std::uint32_t i, std::uint32_t j) noexcept {
        const std::uint32_t sample = i * s_.tables.cols + j, id = s_.class_of[sample];
        if (id == kNone) return;
        if (f_.class_seen[id] == 0) {
            f_.class_seen[id] = 1;
            f_.classes[f_.class_count++] = id;
        }
        const auto row = static_cast<std::int32_t>(i), column = static_cast<std::int32_t>(j);
        const std::int32_t x = from.c * row - from.s * column + from.x, y = from.s * row + from.c * column + from.y;
        if (f_.key[sample] < key(x, y)) return;  // nearer in another frame
        const auto members = s_.members(id);
        std::size_t nth = 0;
        while (members[nth] != sample) ++nth;
        const std::size_t place = s_.class_start[id] + nth;
        for (std::uint32_t k = s_.link_start[place]; k < s_.link_start[place + 1]; ++k) {
            const SeamLink& link = s_.links[k];
            const auto lc = static_cast<std::int32_t>(link.cosine), ls = static_cast<std::int32_t>(link.sine);
            const std::int32_t c = from.c * lc - from.s * ls, s = from.s * lc + from.c * ls;
            const auto ti = static_cast<std::int32_t>(link.to / s_.tables.cols);
            const auto tj = static_cast<std::int32_t>(link.to % s_.tables.cols);
            add(c, s, x - (c * ti - s * tj), y - (s * ti + c * tj));
        }
    }

    StateImpl& s_;
    FootprintScratch& f_;
    const TableImpl* table_;
    std::int32_t r_;
};
}  // namespace

void place_frames(StateImpl& s, const TableImpl* table, std::uint32_t start, std::uint32_t b) noexcept {
    Placer(s, table, b).run(start);
}

bool place_frames_apart(StateImpl& s, const TableImpl& table, std::uint32_t start, std::uint32_t b) noexcept {
    s.footprint.truncated = false;
    if (Placer(s, &table, b).run_apart(start)) return true;
    s.footprint.frame_count = 0;
    end_footprint(s);
    return false;
}

}  // namespace dgm::detail
