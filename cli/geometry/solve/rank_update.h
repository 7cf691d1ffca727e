// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/rank_update.h
// The dense product inside the sparse factorization, with one order of its sums on every processor.
#pragma once
#include <cstddef>
#include <vector>

namespace dgm::bake {

/// C -= A A^T, on and below the diagonal of C; the rest of C is left alone.
///
/// Each entry is the sum over the columns of A from the first to the last, subtracted once, whatever the processor, its
/// caches and its vector registers: libraries of dense products block and sum by those.
///
/// @param c      size x size, column by column, `stride` doubles from one column to the next
/// @param a      size x depth, laid out alike; does not overlap c
/// @param work   memory that calls share, grown as needed
void subtract_square(double* c, const double* a, std::size_t size, std::size_t depth, std::size_t stride,
                     std::vector<double>& work);

}  // namespace dgm::bake
