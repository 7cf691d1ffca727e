// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/union_find.h
// Disjoint sets whose representative is always the lowest member, so that results do not depend on the order of unions.
#pragma once
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace dgm::bake {

class UnionFind {
 public:
    explicit UnionFind(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
    [[nodiscard]] std::uint32_t find(std::uint32_t x) {
        while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
        return x;
    }
    /// Returns false if they were already one set.
    bool unite(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        if (a == b) return false;
        if (b < a) std::swap(a, b);
        parent_[b] = a;
        return true;
    }

 private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace dgm::bake
