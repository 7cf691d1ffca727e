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
/// to = m x, by columns.
static DGM_INLINE void multiply_tile(Floats (&to)[kParts], const float* m, const float* x) {
#pragma GCC unroll 12
    for (Floats& t : to) t = Floats{};
    for (std::size_t k = 0; k < kTileRows; ++k, m += kTileRows)
#pragma GCC unroll 12
        for (std::size_t c = 0; c < kParts; ++c) to[c] = to[c] + x[k] * load(m + c * kWide);
}
/// x_I -= M_IJ x_J for a column of squares. Even and odd columns have sums of their own, that additions wait less.
static DGM_INLINE void push_down(const FactorJob& job, std::size_t column) {
    constexpr std::size_t kPieces = kSquare / kWide;
    const float* x = job.x + column * kSquare;
    float scaled[kSquare];
    for (std::size_t e = job.start[column]; e < job.start[column + 1]; ++e) {
        for (std::size_t k = 0; k < kSquare; k += kWide) store(scaled + k, job.unit[e] * load(x + k));
        const std::int16_t* m = job.value + e * kSquare * kSquare;
        Floats sum[2][kPieces] = {};
        for (std::size_t k = 0; k < kSquare; k += 2, m += 2 * kSquare)
#pragma GCC unroll 8
            for (std::size_t c = 0; c < 2 * kPieces; ++c) {
                const std::size_t odd = c / kPieces, piece = c % kPieces;
                sum[odd][piece] = sum[odd][piece] + scaled[k + odd] * widen(m + odd * kSquare + piece * kWide);
            }
        float* to = job.x + job.row[e] * kSquare;
#pragma GCC unroll 4
        for (std::size_t c = 0; c < kPieces; ++c) store(to + c * kWide, load(to + c * kWide) - (sum[0][c] + sum[1][c]));
    }
}
/// x_J -= sum M_IJ^T x_I. Sums have sixteen parts whatever the number of lanes.
static DGM_INLINE void pull_up(const FactorJob& job, std::size_t column) {
    constexpr std::size_t kPieces = kSquare / kWide, kTogether = kLanes == 16 ? 16 : kWide / 2;
    float* x = job.x + column * kSquare;
    for (std::size_t k = 0; k < kSquare; k += kTogether) {
        Floats sum[kTogether][kPieces] = {};
        for (std::size_t e = job.start[column]; e < job.start[column + 1]; ++e) {
            const std::int16_t* m = job.value + (e * kSquare + k) * kSquare;
            const float* from = job.x + job.row[e] * kSquare;
#pragma GCC unroll 4
            for (std::size_t c = 0; c < kPieces; ++c) {
                const Floats by = job.unit[e] * load(from + c * kWide);
#pragma GCC unroll 16
                for (std::size_t t = 0; t < kTogether; ++t)
                    sum[t][c] = sum[t][c] + by * widen(m + t * kSquare + c * kWide);
            }
        }
#pragma GCC unroll 16
        for (std::size_t t = 0; t < kTogether; ++t) {
            float a[kSquare] = {};
#pragma GCC unroll 4
            for (std::size_t c = 0; c < kPieces; ++c) store(a + c * kWide, sum[t][c]);
            x[k + t] = x[k + t] - ((((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]))) +
                                   (((a[8] + a[9]) + (a[10] + a[11])) + ((a[12] + a[13]) + (a[14] + a[15]))));
        }
    }
}
/// x_j = m x_j
static DGM_INLINE void multiply_own(const FactorJob& job, std::size_t tile, const float* m) {
    Floats own[kParts];
    multiply_tile(own, m, job.x + tile * kTileRows);
#pragma GCC unroll 12
    for (std::size_t c = 0; c < kParts; ++c) store(job.x + tile * kTileRows + c * kWide, own[c]);
}
static void solve(const FactorJob& job) noexcept {
    constexpr std::size_t kColumns = kTileRows / kSquare, kEntries = kTileRows * kTileRows;
    for (std::size_t j = 0; j < job.tiles; ++j) {
        multiply_own(job, j, job.inverse + 2 * j * kEntries);
        for (std::size_t c = 0; c < kColumns; ++c) push_down(job, j * kColumns + c);
    }
    for (std::size_t j = job.tiles; j-- > 0;) {
        for (std::size_t c = 0; c < kColumns; ++c) pull_up(job, j * kColumns + c);
        multiply_own(job, j, job.inverse + (2 * j + 1) * kEntries);
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
