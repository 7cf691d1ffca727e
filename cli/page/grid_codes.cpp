// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/grid_codes.cpp
#include "page/grid_codes.h"

#include <cstring>
#include <vector>

namespace dgm::page {

void code_grid(std::span<std::byte> bytes, std::uint32_t rows, std::uint32_t cols) {
    const std::size_t n = cols, count = std::size_t{rows} * n * 3;
    if (count == 0) return;
    std::vector<std::uint16_t> q(count);
    std::memcpy(q.data(), bytes.data(), 2 * count);
    for (std::size_t k = 0; k < count; ++k) {
        const bool row = k >= 3 * n, col = k % (3 * n) >= 3;
        const int guess = (col ? q[k - 3] : 0) + (row ? q[k - 3 * n] : 0) - (row && col ? q[k - 3 * n - 3] : 0);
        const std::uint16_t code = sign_last(static_cast<std::uint16_t>(q[k] - guess));
        bytes[k] = static_cast<std::byte>(code & 0xff);
        bytes[count + k] = static_cast<std::byte>(code >> 8);
    }
}

}  // namespace dgm::page
