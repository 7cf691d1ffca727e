// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/simplify/vertex_heap.h
// A priority queue of vertices whose keys change.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// Least key first, ties by the lower vertex, so the order of removal does not depend on the order of insertion.
class VertexHeap {
 public:
    explicit VertexHeap(std::size_t vertices) : place_(vertices, kNone) {}

    [[nodiscard]] bool empty() const { return heap_.empty(); }
    [[nodiscard]] std::uint32_t top() const { return heap_.front().vertex; }
    /// Key of a vertex in the heap.
    [[nodiscard]] double key(std::uint32_t vertex) const { return heap_[place_[vertex]].key; }

    /// Inserts the vertex or changes its key.
    void set(std::uint32_t vertex, double key) {
        std::uint32_t at = place_[vertex];
        if (at == kNone) {
            at = static_cast<std::uint32_t>(heap_.size());
            heap_.push_back({key, vertex});
            place_[vertex] = at;
        } else {
            heap_[at].key = key;
        }
        sink(rise(at));
    }

    void erase(std::uint32_t vertex) {
        const std::uint32_t at = place_[vertex];
        if (at == kNone) return;
        place_[vertex] = kNone;
        const Entry last = heap_.back();
        heap_.pop_back();
        if (at == heap_.size()) return;
        heap_[at] = last;
        place_[last.vertex] = at;
        sink(rise(at));
    }

 private:
    struct Entry {
        double key;
        std::uint32_t vertex;
        bool operator<(const Entry& o) const { return key != o.key ? key < o.key : vertex < o.vertex; }
    };
    static constexpr std::uint32_t kArity = 4;

    std::uint32_t rise(std::uint32_t at) {
        const Entry moved = heap_[at];
        while (at > 0) {
            const std::uint32_t parent = (at - 1) / kArity;
            if (!(moved < heap_[parent])) break;
            put(at, heap_[parent]);
            at = parent;
        }
        put(at, moved);
        return at;
    }
    void sink(std::uint32_t at) {
        const Entry moved = heap_[at];
        while (true) {
            const std::size_t first = std::size_t{at} * kArity + 1;
            if (first >= heap_.size()) break;
            const std::size_t end = std::min(first + kArity, heap_.size());
            std::size_t least = first;
            for (std::size_t c = first + 1; c < end; ++c)
                if (heap_[c] < heap_[least]) least = c;
            if (!(heap_[least] < moved)) break;
            put(at, heap_[least]);
            at = static_cast<std::uint32_t>(least);
        }
        put(at, moved);
    }
    void put(std::uint32_t at, const Entry& e) {
        heap_[at] = e;
        place_[e.vertex] = at;
    }

    std::vector<Entry> heap_;
    std::vector<std::uint32_t> place_;
};

}  // namespace dgm::bake
