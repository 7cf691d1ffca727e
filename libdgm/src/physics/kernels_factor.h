// SPDX-License-Identifier: MIT
// libdgm/src/physics/kernels_factor.h
// Bodies of the loops of block factors for one number of lanes. Included after kernels_impl.h.

constexpr std::size_t kWide = kLanes, kParts = kTileRows / kWide;
typedef std::int16_t Shorts __attribute__((vector_size(2 * kLanes)));

static DGM_INLINE Floats widen(const std::int16_t* from) {
#ifdef DGM_WIDEN
    return widened(from);
#else
    Shorts s;
    __builtin_memcpy(&s, from, sizeof s);
    return __builtin_convertvector(__builtin_convertvector(s, Ints), Floats);
#endif
}
#include "rows/pairs.h"

constexpr std::size_t kPieces = kSquare / kWide, kEntries = kSquare * kSquare;
/// Sums of a product by columns; even and odd ones have sums of their own, that additions wait less.
typedef Floats Pushed[2][kPieces];
/// sum += unit m x of a square.
static DGM_INLINE void push(Pushed& sum, const std::int16_t* m, float unit, const float* x) {
    float scaled[kSquare];
    for (std::size_t k = 0; k < kSquare; k += kWide) store(scaled + k, unit * load(x + k));
    for (std::size_t k = 0; k < kSquare; k += 2, m += 2 * kSquare)
#pragma GCC unroll 8
        for (std::size_t c = 0; c < 2 * kPieces; ++c) {
            const std::size_t odd = c / kPieces, piece = c % kPieces;
            sum[odd][piece] = sum[odd][piece] + scaled[k + odd] * widen(m + odd * kSquare + piece * kWide);
        }
}
/// x_I -= M_IJ x_J for a column of squares.
static DGM_INLINE void push_down(const FactorJob& job, std::size_t column) {
    const float* x = job.x + column * kSquare;
    for (std::size_t e = job.start[column]; e < job.start[column + 1]; ++e) {
        Pushed sum = {};
        push(sum, job.value + e * kEntries, job.unit[e], x);
        float* to = job.x + job.row[e] * kSquare;
#pragma GCC unroll 4
        for (std::size_t c = 0; c < kPieces; ++c) store(to + c * kWide, load(to + c * kWide) - (sum[0][c] + sum[1][c]));
    }
}
/// Sums of products with some columns of squares, which have sixteen parts each whatever the number of lanes.
constexpr std::size_t kPulled = kLanes == 16 ? 16 : kWide / 2;
typedef Floats Pulled[kPulled * kPieces];
/// sum += unit m^T x; m: from a column of a square on.
static DGM_INLINE void pull(Pulled& sum, const std::int16_t* m, float unit, const float* x) {
#pragma GCC unroll 4
    for (std::size_t c = 0; c < kPieces; ++c) {
        const Floats by = unit * load(x + c * kWide);
#pragma GCC unroll 16
        for (std::size_t t = 0; t < kPulled; ++t)
            sum[t * kPieces + c] = sum[t * kPieces + c] + by * widen(m + t * kSquare + c * kWide);
    }
}
/// Adds up the parts: neighbours, their sums, and so on.
template <std::size_t n>
static DGM_INLINE void fold(Floats* sum, float* to) {
    if constexpr (n > 1) {
#pragma GCC unroll 8
        for (std::size_t k = 0; k < n / 2; ++k)
            sum[k] = Pairs::evens(sum[2 * k], sum[2 * k + 1]) + Pairs::odds(sum[2 * k], sum[2 * k + 1]);
        fold<n / 2>(sum, to);
    } else if constexpr (kPulled < kWide) {  // one vector is left, of pairs
        const Floats all = Pairs::evens(sum[0], sum[0]) + Pairs::odds(sum[0], sum[0]);
        __builtin_memcpy(to, &all, kPulled * sizeof(float));
    } else {
        store(to, sum[0]);
    }
}
/// x_J -= sum M_IJ^T x_I.
static DGM_INLINE void pull_up(const FactorJob& job, std::size_t column) {
    float* x = job.x + column * kSquare;
    for (std::size_t k = 0; k < kSquare; k += kPulled) {
        Pulled sum = {};
        for (std::size_t e = job.start[column]; e < job.start[column + 1]; ++e)
            pull(sum, job.value + e * kEntries + k * kSquare, job.unit[e], job.x + job.row[e] * kSquare);
        float all[kPulled];
        fold<kPulled * kPieces>(sum, all);
        for (std::size_t t = 0; t < kPulled; ++t) x[k + t] -= all[t];
    }
}
/// The square in a row and column of squares of a lower triangle.
static DGM_INLINE std::size_t own_square(std::size_t tile, std::size_t r, std::size_t c) {
    return kOwnSquares * tile + r * (r + 1) / 2 + c;
}
/// x_j = m x_j
static DGM_INLINE void push_own(const FactorJob& job, std::size_t tile) {
    float* x = job.x + tile * kTileRows;
    for (std::size_t r = kTileRows / kSquare; r-- > 0;) {
        Pushed sum = {};
        for (std::size_t c = 0; c <= r; ++c) {
            const std::size_t e = own_square(tile, r, c);
            push(sum, job.own + e * kEntries, job.own_unit[e], x + c * kSquare);
        }
#pragma GCC unroll 4
        for (std::size_t p = 0; p < kPieces; ++p) store(x + r * kSquare + p * kWide, sum[0][p] + sum[1][p]);
    }
}
/// x_j = m^T x_j
static DGM_INLINE void pull_own(const FactorJob& job, std::size_t tile) {
    float* x = job.x + tile * kTileRows;
    for (std::size_t c = 0; c < kTileRows / kSquare; ++c) {
        float all[kSquare];
        for (std::size_t k = 0; k < kSquare; k += kPulled) {
            Pulled sum = {};
            for (std::size_t r = c; r < kTileRows / kSquare; ++r) {
                const std::size_t e = own_square(tile, r, c);
                pull(sum, job.own + e * kEntries + k * kSquare, job.own_unit[e], x + r * kSquare);
            }
            fold<kPulled * kPieces>(sum, all + k);
        }
        __builtin_memcpy(x + c * kSquare, all, sizeof all);
    }
}
static void solve(const FactorJob& job) noexcept {
    constexpr std::size_t kColumns = kTileRows / kSquare;
    for (std::size_t j = 0; j < job.tiles; ++j) {
        push_own(job, j);
        for (std::size_t c = 0; c < kColumns; ++c) push_down(job, j * kColumns + c);
    }
    for (std::size_t j = job.tiles; j-- > 0;) {
        for (std::size_t c = 0; c < kColumns; ++c) pull_up(job, j * kColumns + c);
        pull_own(job, j);
    }
}

static void subtract_product(float* to, const float* a, const float* b) noexcept {
    constexpr std::size_t kTogether = kLanes / 4;
    for (std::size_t c = 0; c < kTileRows; c += kTogether) {
        Floats sum[kTogether][kParts] = {};
        for (std::size_t k = 0; k < kTileRows; ++k)
#pragma GCC unroll 12
            for (std::size_t p = 0; p < kParts; ++p) {
                const Floats v = load(a + k * kTileRows + p * kWide);
#pragma GCC unroll 4
                for (std::size_t t = 0; t < kTogether; ++t) sum[t][p] = sum[t][p] + b[k * kTileRows + c + t] * v;
            }
        for (std::size_t t = 0; t < kTogether; ++t)
            for (std::size_t p = 0; p < kParts; ++p) {
                float* at = to + (c + t) * kTileRows + p * kWide;
                store(at, load(at) - sum[t][p]);
            }
    }
}
