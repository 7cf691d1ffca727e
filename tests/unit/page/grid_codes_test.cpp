// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/page/grid_codes_test.cpp
#include "page/grid_codes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

namespace dgm::page {
namespace {
using Codes = std::vector<std::uint16_t>;

Codes coded(const Codes& q, std::uint32_t rows, std::uint32_t cols) {
    std::vector<std::byte> bytes(2 * q.size());
    std::memcpy(bytes.data(), q.data(), bytes.size());
    code_grid(bytes, rows, cols);
    Codes out;
    for (std::size_t k = 0; k < q.size(); ++k)
        out.push_back(static_cast<std::uint16_t>(std::to_integer<unsigned>(bytes[k]) |
                                                 std::to_integer<unsigned>(bytes[q.size() + k]) << 8));
    return out;
}

/// As web/module.js does it.
Codes decoded(const Codes& codes, std::uint32_t cols) {
    const std::size_t row = std::size_t{3} * cols;
    Codes q(codes.size());
    for (std::size_t k = 0; k < q.size(); ++k) {
        const int rest = codes[k] >> 1 ^ -(codes[k] & 1);
        const bool left = k % row >= 3, above = k >= row;
        q[k] = static_cast<std::uint16_t>(rest + (left ? q[k - 3] : 0) + (above ? q[k - row] : 0) -
                                          (left && above ? q[k - row - 3] : 0));
    }
    return q;
}

TEST(GridCodes, PlaneLeavesItsFirstRowAndColumn) {
    Codes q;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int c = 0; c < 3; ++c) q.push_back(static_cast<std::uint16_t>(100 + 7 * i - 3 * j + c));
    // 100 is 200 after its sign moved; a step of -3 is 5, one of 7 is 14; what lies inside is guessed.
    EXPECT_EQ(coded(q, 3, 3), (Codes{200, 202, 204, 5, 5, 5, 5, 5, 5, 14, 14, 14, 0, 0, 0, 0, 0, 0,  //
                                     14,  14,  14,  0, 0, 0, 0, 0, 0}));
}

TEST(GridCodes, AnyCodesComeBack) {
    std::mt19937 draw(3);
    for (const auto& [rows, cols] : {std::pair{2U, 2U}, {5U, 3U}, {17U, 9U}}) {
        Codes q(std::size_t{3} * rows * cols);
        for (std::uint16_t& code : q) code = static_cast<std::uint16_t>(draw());
        EXPECT_EQ(decoded(coded(q, rows, cols), cols), q);
    }
}

}  // namespace
}  // namespace dgm::page
