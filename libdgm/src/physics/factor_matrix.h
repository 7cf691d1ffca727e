// SPDX-License-Identifier: MIT
// libdgm/src/physics/factor_matrix.h
// The second derivatives at rest by tiles, while they are factorised.
#pragma once
#include <algorithm>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {

inline constexpr std::size_t kTileEntries = kTileRows * kTileRows;

/// A 3 x 3 matrix by rows.
struct Block {
    double at[9] = {};
};
/// The matrix while it is factorised: tile e of column j is (row[e], j); diagonal tiles apart.
struct Making {
    const PhysicsImpl& p;
    Factor to;
    Array<std::uint32_t> tile;  ///< by unknown
    Array<float> diagonal, below;

    [[nodiscard]] std::size_t find(std::uint32_t row, std::uint32_t col) const noexcept {
        const std::uint32_t* at =
            std::lower_bound(to.row.begin() + to.start[col], to.row.begin() + to.start[col + 1], row);
        return static_cast<std::size_t>(at - to.row.begin());
    }
    /// Adds a block to rows of unknown a and columns of unknown b, if it is not above the diagonal tiles.
    void add(std::uint32_t a, std::uint32_t b, const Block& block) noexcept {
        const std::uint32_t i = to.slot[a] / kTileRows, j = to.slot[b] / kTileRows;
        if (i < j) return;
        float* m = i == j ? diagonal.data() + j * kTileEntries : below.data() + find(i, j) * kTileEntries;
        m += to.slot[b] % kTileRows * kTileRows + to.slot[a] % kTileRows;
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 3; ++c) m[c * kTileRows + r] += static_cast<float>(block.at[3 * r + c]);
    }
};

/// f(unknowns of a sample's 3 x 3 and its copies', their number), by unknown.
template <class F>
void each_ring(const Level& l, F f) noexcept {
    for (std::uint32_t d = 0; d < l.dofs; ++d)
        f(d, l.matrix.col.data() + l.matrix.start[d], l.matrix.start[d + 1] - l.matrix.start[d]);
}

/// Adds mass, foundation, membrane, bending and what holds samples, and scales the diagonal: to 1, then times `by`.
/// @return false: no memory.
[[nodiscard]] bool add_matrix(Making& m, float by) noexcept;

}  // namespace dgm::detail::physics
