// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/rank_update.cpp
// Tiles of 4 x 4 entries, whose sums stay in registers [Goto, van de Geijn 2008]. A is packed into strips of four rows,
// so that the innermost loop reads memory from front to back.
#include "geometry/solve/rank_update.h"

#include <algorithm>
#include <cstring>

namespace dgm::bake {
namespace {
constexpr std::size_t kTile = 4;
using Two = double __attribute__((vector_size(16)));

Two load(const double* from) {
    Two out;
    std::memcpy(&out, from, sizeof out);
    return out;
}

/// Rows of A by fours, column after column; rows beyond the last are zero.
void pack(const double* a, std::size_t size, std::size_t depth, std::size_t stride, double* out) {
    for (std::size_t i = 0; i < size; i += kTile) {
        const std::size_t rows = std::min(kTile, size - i);
        for (std::size_t p = 0; p < depth; ++p, out += kTile) {
            std::fill(out, out + kTile, 0.0);
            std::copy(a + p * stride + i, a + p * stride + i + rows, out);
        }
    }
}

/// Sums of a tile: column q of `out` is the strip `rows` times entry q of the strip that `twice` holds, each entry two
/// times.
void tile_sums(const double* rows, const double* twice, std::size_t depth, double (&out)[kTile][kTile]) {
    Two a0{}, a1{}, b0{}, b1{}, c0{}, c1{}, d0{}, d1{};
    for (std::size_t p = 0; p < depth; ++p, rows += kTile, twice += 2 * kTile) {
        const Two upper = load(rows), lower = load(rows + 2);
        const Two a = load(twice), b = load(twice + 2), c = load(twice + 4), d = load(twice + 6);
        a0 += upper * a;
        a1 += lower * a;
        b0 += upper * b;
        b1 += lower * b;
        c0 += upper * c;
        c1 += lower * c;
        d0 += upper * d;
        d1 += lower * d;
    }
    const Two all[] = {a0, a1, b0, b1, c0, c1, d0, d1};
    std::memcpy(out, all, sizeof all);
}
}  // namespace

void subtract_square(double* c, const double* a, std::size_t size, std::size_t depth, std::size_t stride,
                     std::vector<double>& work) {
    const std::size_t strips = (size + kTile - 1) / kTile, strip = depth * kTile;
    work.resize(std::max(work.size(), (strips + 2) * strip));
    double* packed = work.data();
    double* twice = packed + strips * strip;
    pack(a, size, depth, stride, packed);
    double sums[kTile][kTile];
    for (std::size_t j = 0; j < strips; ++j) {
        for (std::size_t k = 0; k < strip; ++k) twice[2 * k] = twice[2 * k + 1] = packed[j * strip + k];
        const std::size_t columns = std::min(kTile, size - j * kTile);
        for (std::size_t i = j; i < strips; ++i) {
            tile_sums(packed + i * strip, twice, depth, sums);
            const std::size_t rows = std::min(kTile, size - i * kTile);
            for (std::size_t q = 0; q < columns; ++q) {
                double* to = c + (j * kTile + q) * stride + i * kTile;
                for (std::size_t r = i == j ? q : 0; r < rows; ++r) to[r] -= sums[q][r];
            }
        }
    }
}

}  // namespace dgm::bake
