// SPDX-License-Identifier: MIT
// libdgm/src/touch/walk.cpp
// The footprint at the border of a free domain: samples around a start, unfolded into its chart (deform.h says how).
//
// Best-first by d2 = x^2 + y^2, ties by sample number, one heap entry a sample.
#include <algorithm>
#include <cmath>

#include "touch/state_impl.h"

namespace dgm::detail {
namespace {

class Walk {
 public:
    Walk(StateImpl& state, std::uint32_t b) noexcept : s_(state), w_(state.walk), b_(static_cast<float>(b)) {}

    [[nodiscard]] bool run(std::uint32_t start) noexcept {
        if (!meet(start, 0, 0, 1, 0)) return false;
        while (w_.heap_count != 0) {
            const std::uint32_t slot = pop();
            w_.visited[w_.visited_count++] = slot;
            if (!expand(w_.nodes[slot])) return false;
        }
        return true;
    }

 private:
    /// One way of placing a sample. @return false if the scratch is full.
    bool meet(std::uint32_t sample, float x, float y, float cosine, float sine) noexcept {
        if (!(std::fabs(x) < b_ && std::fabs(y) < b_)) return true;
        const float d2 = x * x + y * y;
        std::uint32_t slot = w_.slot_of[sample];
        if (slot != kNone) {
            WalkNode& known = w_.nodes[slot];
            if (known.heap == kNone || !(d2 < known.d2)) return true;
            known = {sample, x, y, cosine, sine, d2, known.heap};
            sift_up(known.heap);
            return true;
        }
        if (w_.node_count == w_.nodes.size()) return false;
        slot = w_.node_count++;
        w_.slot_of[sample] = slot;
        w_.nodes[slot] = {sample, x, y, cosine, sine, d2, w_.heap_count};
        w_.heap[w_.heap_count] = slot;
        sift_up(w_.heap_count++);
        return true;
    }

    /// Copy, since meeting others may not move nodes but reads better this way.
    bool expand(const WalkNode node) noexcept {
        const ChartTables& t = s_.tables;
        if (node.sample < t.grid && !expand_grid(node)) return false;
        if (!s_.face_start.empty() && !expand_strip(node)) return false;
        const std::uint32_t id = s_.class_id(node.sample);
        if (id == kNone) return true;
        const auto members = s_.members(id);
        const auto nth = std::lower_bound(members.begin(), members.end(), node.sample) - members.begin();
        const std::size_t place = s_.class_start[id] + static_cast<std::size_t>(nth);
        for (std::uint32_t k = s_.link_start[place]; k < s_.link_start[place + 1]; ++k) {
            const SeamLink& link = s_.links[k];
            if (!meet(link.to, node.x, node.y, node.cosine * link.cosine - node.sine * link.sine,
                      node.sine * link.cosine + node.cosine * link.sine))
                return false;
        }
        return true;
    }

    bool step(const WalkNode& node, std::uint32_t sample, float dx, float dy) noexcept {
        return meet(sample, node.x + (node.cosine * dx - node.sine * dy), node.y + (node.sine * dx + node.cosine * dy),
                    node.cosine, node.sine);
    }

    bool expand_grid(const WalkNode& node) noexcept {
        const ChartTables& t = s_.tables;
        const std::uint32_t i = node.sample / t.cols, j = node.sample % t.cols;
        // A grid edge belongs to the surface if a quad beside it does.
        const auto quad = [&](std::uint32_t qi, std::uint32_t qj) {
            return qi < t.rows - 1 && qj < t.cols - 1 && t.has_quad(qi, qj);  // -1 wraps to a large number
        };
        const bool all = t.mask == nullptr;
        if (i > 0 && (all || quad(i - 1, j - 1) || quad(i - 1, j)) && !step(node, node.sample - t.cols, -1, 0))
            return false;
        if (j > 0 && (all || quad(i - 1, j - 1) || quad(i, j - 1)) && !step(node, node.sample - 1, 0, -1)) return false;
        if (j + 1 < t.cols && (all || quad(i - 1, j) || quad(i, j)) && !step(node, node.sample + 1, 0, 1)) return false;
        return i + 1 >= t.rows || !(all || quad(i, j - 1) || quad(i, j)) || step(node, node.sample + t.cols, 1, 0);
    }

    bool expand_strip(const WalkNode& node) noexcept {
        const auto here = s_.place(node.sample);
        for (std::uint32_t k = s_.face_start[node.sample]; k < s_.face_start[node.sample + 1]; ++k)
            for (std::uint32_t c = 0; c < 3; ++c) {
                const std::uint32_t other = s_.faces[3 * std::size_t{s_.face_of[k]} + c];
                if (other == node.sample) continue;
                const auto there = s_.place(other);
                if (!step(node, other, there.x - here.x, there.y - here.y)) return false;
            }
        return true;
    }

    [[nodiscard]] bool less(std::uint32_t a, std::uint32_t b) const noexcept {
        const WalkNode &l = w_.nodes[a], &r = w_.nodes[b];
        return l.d2 != r.d2 ? l.d2 < r.d2 : l.sample < r.sample;
    }
    void put(std::uint32_t at, std::uint32_t slot) noexcept {
        w_.heap[at] = slot;
        w_.nodes[slot].heap = at;
    }
    void sift_up(std::uint32_t at) noexcept {
        const std::uint32_t slot = w_.heap[at];
        for (; at > 0 && less(slot, w_.heap[(at - 1) / 2]); at = (at - 1) / 2) put(at, w_.heap[(at - 1) / 2]);
        put(at, slot);
    }
    std::uint32_t pop() noexcept {
        const std::uint32_t top = w_.heap[0], last = w_.heap[--w_.heap_count];
        w_.nodes[top].heap = kNone;
        if (w_.heap_count == 0) return top;
        std::uint32_t at = 0;
        for (;;) {
            std::uint32_t child = 2 * at + 1;
            if (child >= w_.heap_count) break;
            if (child + 1 < w_.heap_count && less(w_.heap[child + 1], w_.heap[child])) ++child;
            if (!less(w_.heap[child], last)) break;
            put(at, w_.heap[child]);
            at = child;
        }
        put(at, last);
        return top;
    }

    StateImpl& s_;
    WalkScratch& w_;
    float b_;
};
}  // namespace

bool is_plain_window(const StateImpl& s, std::uint32_t sample, std::uint32_t b) noexcept {
    if (!s.classes_or_border()) return true;
    if (sample >= s.tables.grid) return false;
    const std::uint32_t i = sample / s.tables.cols, j = sample % s.tables.cols, r = b - 1;
    // In a square domain everything special lies on the border of the grid.
    if (!s.tables.free_domain && i > r && j > r && i + b < s.tables.rows && j + b < s.tables.cols) return true;
    const auto low = [r](std::uint32_t k, std::uint32_t tiles) { return StateImpl::owner(k > r ? k - r : 0, tiles); };
    const std::uint32_t i1 = StateImpl::owner(i + r, s.tile_rows), j1 = StateImpl::owner(j + r, s.tile_cols);
    for (std::uint32_t ti = low(i, s.tile_rows); ti <= i1; ++ti)
        for (std::uint32_t tj = low(j, s.tile_cols); tj <= j1; ++tj)
            if ((s.tile_flags[ti * s.tile_cols + tj] & kTileSpecial) != 0) return false;
    return true;
}

Result<void> begin_walk(StateImpl& s, std::uint32_t start, std::uint32_t b) noexcept {
    if (Walk(s, b).run(start)) return {};
    end_walk(s);
    return Error{ErrorCode::LimitExceeded, kNoOffset, "more samples in reach than the state has scratch for"};
}

void end_walk(StateImpl& s) noexcept {
    for (std::uint32_t k = 0; k < s.walk.node_count; ++k) s.walk.slot_of[s.walk.nodes[k].sample] = kNone;
    s.walk.node_count = s.walk.heap_count = s.walk.visited_count = 0;
}

}  // namespace dgm::detail
