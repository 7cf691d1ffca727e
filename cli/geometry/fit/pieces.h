// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/pieces.h
// Loops cut into pieces that do not depend on the number of threads, so that sums over them do not either.
#pragma once
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dgm::bake {

inline constexpr std::size_t kPiece = 1024;

/// Number of pieces of a list.
[[nodiscard]] constexpr std::size_t pieces_of(std::size_t count) {
    return (count + kPiece - 1) / kPiece;
}

/// Calls body(piece, begin, end) for every piece of 0 .. count, in parallel.
template <class Body>
void in_pieces(std::size_t count, const Body& body) {
    if (count <= kPiece) {
        if (count > 0) body(std::size_t{0}, std::size_t{0}, count);
        return;
    }
    tbb::parallel_for(std::size_t{0}, pieces_of(count),
                      [&](std::size_t piece) { body(piece, piece * kPiece, std::min(count, (piece + 1) * kPiece)); });
}

/// Calls body(k) for every k in 0 .. count, in parallel.
template <class Body>
void each_in_pieces(std::size_t count, const Body& body) {
    in_pieces(count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) body(k);
    });
}

/// Sum of term(k) for k in 0 .. count, in parallel: over each piece, then over the pieces.
template <class Term>
[[nodiscard]] double sum_in_pieces(std::size_t count, const Term& term) {
    std::vector<double> sums(pieces_of(count), 0.0);
    in_pieces(count, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t k = begin; k < end; ++k) sum += term(k);
        sums[piece] = sum;
    });
    double all = 0;
    for (const double s : sums) all += s;
    return all;
}

}  // namespace dgm::bake
