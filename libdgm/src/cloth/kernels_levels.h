// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_levels.h
// Loops that hand values from one stride to the next. Included by kernels_impl.h.

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ < 12
#error "needs __builtin_shufflevector"
#endif
template <int... k>
struct Places {
    /// Values 0, 2, 4, ... and 1, 3, 5, ... of a row of two vectors.
    static DGM_INLINE Floats evens(const Floats& a, const Floats& b) { return __builtin_shufflevector(a, b, 2 * k...); }
    static DGM_INLINE Floats odds(const Floats& a, const Floats& b) {
        return __builtin_shufflevector(a, b, 2 * k + 1 ...);
    }
    /// The row of two vectors whose even and odd values are given.
    static DGM_INLINE Floats first(const Floats& e, const Floats& o) {
        return __builtin_shufflevector(e, o, (k / 2 + k % 2 * kLanes)...);
    }
    static DGM_INLINE Floats second(const Floats& e, const Floats& o) {
        return __builtin_shufflevector(e, o, (kLanes / 2 + k / 2 + k % 2 * kLanes)...);
    }
};
template <int n, int... k>
struct Count : Count<n - 1, n - 1, k...> {};
template <int... k>
struct Count<0, k...> {
    typedef Places<k...> Of;
};
typedef Count<kLanes>::Of Pairs;

static DGM_INLINE Floats even_at(const float* row, std::ptrdiff_t j) {
    return Pairs::evens(load(row + 2 * j), load(row + 2 * j + kLanes));
}
static DGM_INLINE Floats odd_at(const float* row, std::ptrdiff_t j) {
    return Pairs::odds(load(row + 2 * j), load(row + 2 * j + kLanes));
}

/// line = weighted sum of rows.
static DGM_INLINE void sum_rows(const Taps& t, const float* from, std::ptrdiff_t pitch, float* line) {
    for (std::ptrdiff_t j = 0; j < pitch; j += kLanes) {
        Floats sum = t.weight[0] * load(from + t.at[0] * pitch + j);
        for (std::uint32_t k = 1; k < t.count; ++k) sum = sum + t.weight[k] * load(from + t.at[k] * pitch + j);
        store(line + j, sum);
    }
}
static DGM_INLINE float sum_taps(const Taps& t, const float* line) {
    float sum = 0;
    for (std::uint32_t k = 0; k < t.count; ++k) sum += t.weight[k] * line[t.at[k]];
    return sum;
}
static DGM_INLINE void clear_from(float* row, std::ptrdiff_t from, std::ptrdiff_t to) {
    for (std::ptrdiff_t j = from; j < to; ++j) row[j] = 0;
}

static void restrict_to(const TransferJob& job) noexcept {
    const std::ptrdiff_t wide = job.fine->pitch, narrow = job.coarse->pitch, cols = job.coarse->cols;
    clear_scratch(*job.fine);
    float *line = scratch_row(*job.fine, 0).p[0], *even = scratch_row(*job.fine, 1).p[0],
          *odd = scratch_row(*job.fine, 2).p[0];
    const std::ptrdiff_t last = job.even < 3 ? 0 : static_cast<std::ptrdiff_t>(job.even) - 3;
    for (int c = 0; c < job.planes; ++c)
        for (std::uint32_t i = 0; i < job.coarse->rows; ++i) {
            sum_rows(job.rows[i], job.from.p[c], wide, line);
            for (std::ptrdiff_t j = 0; j < narrow; j += kLanes) {
                store(even + j, even_at(line, j));
                store(odd + j, odd_at(line, j));
            }
            float* to = job.to.p[c] + i * narrow;
            const float* free = job.free == nullptr ? nullptr : job.free + i * narrow;
            for (std::ptrdiff_t j = 0; j < narrow; j += kLanes) {
                const Floats near = 0.5625f * (load(odd + j - 1) + load(odd + j));
                const Floats sum = (load(even + j) + near) - 0.0625f * (load(odd + j - 2) + load(odd + j + 1));
                store(to + j, free == nullptr ? sum : load(free + j) * sum);
            }
            // Near borders there are other weights.
            for (std::ptrdiff_t j = 0; j < cols; ++j) {
                if (j == 3 && last > j) j = last;
                const float sum = sum_taps(job.columns[j], line);
                to[j] = free == nullptr ? sum : free[j] * sum;
            }
            clear_from(to, cols, narrow);
        }
}

static void interpolate_to(const TransferJob& job) noexcept {
    const std::ptrdiff_t wide = job.fine->pitch, narrow = job.coarse->pitch, cols = job.fine->cols;
    clear_scratch(*job.fine);
    float *line = scratch_row(*job.fine, 0).p[0], *out = scratch_row(*job.fine, 1).p[0];
    const std::ptrdiff_t last = job.even < 2 ? 0 : 2 * static_cast<std::ptrdiff_t>(job.even) - 3;
    for (int c = 0; c < job.planes; ++c)
        for (std::uint32_t i = 0; i < job.fine->rows; ++i) {
            sum_rows(job.rows[i], job.from.p[c], narrow, line);
            for (std::ptrdiff_t j = 0; 2 * j < wide; j += kLanes) {
                const Floats here = load(line + j), near = 0.5625f * (here + load(line + j + 1));
                const Floats between = near - 0.0625f * (load(line + j - 1) + load(line + j + 2));
                store(out + 2 * j, Pairs::first(here, between));
                store(out + 2 * j + kLanes, Pairs::second(here, between));
            }
            if (cols > 1) out[1] = sum_taps(job.columns[1], line);
            for (std::ptrdiff_t j = last; j < cols; ++j) out[j] = sum_taps(job.columns[j], line);
            float* to = job.to.p[c] + i * wide;
            const float* free = job.free + i * wide;
            for (std::ptrdiff_t j = 0; j < wide; j += kLanes)
                store(to + j, load(to + j) + load(free + j) * load(out + j));
        }
}

/// Sums of two edges, and means over four quads.
static void thin(const ThinJob& job) noexcept {
    const Sheet &fine = *job.fine, &on = *job.coarse;
    const std::ptrdiff_t wide = fine.pitch, n = on.pitch, cols = on.cols, even = job.even;
    const std::ptrdiff_t whole = even < cols ? even - 1 : cols;  // columns that are two apart from the next one
    const float* four[] = {job.tension1, job.tension2, fine.square1, fine.square2};
    float* to[] = {on.tension1, on.tension2, on.square1, on.square2};
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        const std::ptrdiff_t a = job.rows[i] * wide, s = i * n;
        const bool quads = i + 1 < on.rows, two = quads && job.rows[i + 1] - job.rows[i] == 2;
        for (int c = 0; c < 3; ++c) {
            const float *u = fine.u.p[c] + a, *v = fine.v.p[c] + a, *next = u + wide;
            for (std::ptrdiff_t j = 0; quads && j < n; j += kLanes)
                store(on.u.p[c] + s + j, two ? even_at(u, j) + even_at(next, j) : even_at(u, j));
            for (std::ptrdiff_t j = 0; j < n; j += kLanes) store(on.v.p[c] + s + j, even_at(v, j) + odd_at(v, j));
            for (std::ptrdiff_t j = whole; j < cols; ++j) {
                const std::ptrdiff_t k = job.columns[j];
                if (quads) on.u.p[c][s + j] = two ? u[k] + next[k] : u[k];
                on.v.p[c][s + j] = j + 1 < cols ? v[k] : 0;
            }
            if (quads) clear_from(on.u.p[c] + s, cols, n);
            clear_from(on.v.p[c] + s, cols, n);
        }
        for (int q = 0; quads && q < 4; ++q) {
            const float *above = four[q] + a, *below = two ? above + wide : above;
            float* out = to[q] + s;
            for (std::ptrdiff_t j = 0; j < n; j += kLanes)
                store(out + j,
                      0.25f * ((even_at(above, j) + odd_at(above, j)) + (even_at(below, j) + odd_at(below, j))));
            for (std::ptrdiff_t j = whole; j + 1 < cols; ++j) {
                const std::ptrdiff_t k = job.columns[j];
                out[j] = 0.5f * (above[k] + below[k]);
            }
            clear_from(out, cols - 1, n);
        }
    }
}

static void stiffen(const Sheet& on) noexcept {
    const Moduli& m = on.moduli;
    for (std::uint32_t i = 0; i + 1 < on.rows; ++i)
        for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
            const std::ptrdiff_t s = i * on.pitch + j;
            V3 u, v;
            const Quad k = load_quad(on, s, u, v);
            const Floats lost1 = larger(load(on.square1 + s) - dot(k.f1, k.f1), Floats{});
            const Floats lost2 = larger(load(on.square2 + s) - dot(k.f2, k.f2), Floats{});
            store(on.s1 + s, load(on.tension1 + s) + (m.warp * lost1 + m.shear * lost2));
            store(on.s2 + s, load(on.tension2 + s) + (m.weft * lost2 + m.shear * lost1));
        }
}
