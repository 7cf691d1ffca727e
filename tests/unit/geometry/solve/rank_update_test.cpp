// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/solve/rank_update_test.cpp
#include "geometry/solve/rank_update.h"

#include <gtest/gtest.h>

#include <random>

namespace dgm::bake {
namespace {

/// A matrix of `stride` rows, of which the lower right block of size x size is C and the columns before it are A.
struct Problem {
    std::size_t size, depth, stride;
    std::vector<double> values;

    Problem(std::size_t rows, std::size_t columns, std::size_t gap)
        : size(rows), depth(columns), stride(rows + columns + gap) {
        std::mt19937_64 random(size * 100 + depth);
        values.resize(stride * (size + depth));
        for (double& v : values) v = static_cast<double>(random() >> 11) * 0x1p-53 - 0.5;
    }
    double* a() { return values.data() + depth; }
    double* c() { return values.data() + depth * stride + depth; }
};

/// As the header defines it: the sum over the columns of A in their order, subtracted once.
void subtract_plainly(Problem& p) {
    for (std::size_t j = 0; j < p.size; ++j)
        for (std::size_t i = j; i < p.size; ++i) {
            double sum = 0;
            for (std::size_t k = 0; k < p.depth; ++k) sum += p.a()[k * p.stride + i] * p.a()[k * p.stride + j];
            p.c()[j * p.stride + i] -= sum;
        }
}

TEST(RankUpdate, HasTheBitsOfPlainSums) {
    std::vector<double> work;  // shared, as the factorization shares it: from large to small and back
    for (const std::size_t size : {131u, 1u, 2u, 3u, 4u, 5u, 7u, 8u, 48u, 130u})
        for (const std::size_t depth : {1u, 2u, 16u, 48u}) {
            Problem got(size, depth, 3), wanted(size, depth, 3);
            subtract_square(got.c(), got.a(), size, depth, got.stride, work);
            subtract_plainly(wanted);
            EXPECT_EQ(got.values, wanted.values) << size << " x " << depth << ", what lies around included";
        }
}

}  // namespace
}  // namespace dgm::bake
