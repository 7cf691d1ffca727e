// SPDX-License-Identifier: MIT
// libdgm/src/cloth/smoother.h
// What the smoother's first step, in prepare(), shares with the others.
#pragma once
#include "cloth/cloth_impl.h"

namespace dgm::detail::cloth {

inline constexpr float kBand = 16;  ///< highest eigenvalue over the lowest one that a level is to damp

/// No sample has copies, and nothing bends across seams: rows can be used as they come.
inline bool is_whole(const Level& l) noexcept {
    return l.groups.empty() && l.seams.empty();
}

/// Steps of the smoother, one after the other: way = keep way + step inverse residual.
struct Chebyshev {
    float middle, half, rho, keep = 0, step;
    explicit Chebyshev(const ClothImpl& c) noexcept {
        const float high = c.highest, low = high / kBand;
        middle = 0.5f * (high + low);
        half = 0.5f * (high - low);
        rho = half / middle;
        step = 1 / middle;
    }
    void go_on() noexcept {
        const float next = 1 / (2 * middle / half - rho);
        keep = rho * next;
        step = 2 * next / half;
        rho = next;
    }
};

/// to = transpose of the interpolation.
inline void restrict_to(const ClothImpl& c, std::uint32_t at, const Field& from, const Field& to, const float* free,
                        int planes = 3) noexcept {
    const Level &fine = c.level[at], &coarse = c.level[at + 1];
    c.kernels->restrict_to({&fine.on, &coarse.on, coarse.even, coarse.from_rows.data(), coarse.from_columns.data(),
                            from, to, free, planes});
}

}  // namespace dgm::detail::cloth
