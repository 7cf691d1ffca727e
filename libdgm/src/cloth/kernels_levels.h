// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_levels.h
// Loops that hand values from one stride to the next. Included by kernels_impl.h.

static DGM_INLINE Floats even_at(const float* row, std::ptrdiff_t j) {
    return Pairs::evens(load(row + 2 * j), load(row + 2 * j + kLanes));
}
static DGM_INLINE Floats odd_at(const float* row, std::ptrdiff_t j) {
    return Pairs::odds(load(row + 2 * j), load(row + 2 * j + kLanes));
}

/// line = weighted sum of rows.
static DGM_INLINE void sum_rows(const Taps& t, const float* from, std::ptrdiff_t pitch, float* line) {
    const float* row[Taps::kMost];
    for (std::uint32_t k = 0; k < Taps::kMost; ++k) row[k] = from + t.at[k < t.count ? k : 0] * pitch;
    if (t.count == 5) {
        const float w[5] = {t.weight[0], t.weight[1], t.weight[2], t.weight[3], t.weight[4]};
        for (std::ptrdiff_t j = 0; j < pitch; j += kLanes) {
            const Floats near = (w[0] * load(row[0] + j) + w[1] * load(row[1] + j)) + w[2] * load(row[2] + j);
            store(line + j, (near + w[3] * load(row[3] + j)) + w[4] * load(row[4] + j));
        }
        return;
    }
    for (std::ptrdiff_t j = 0; j < pitch; j += kLanes) {
        Floats sum = t.weight[0] * load(row[0] + j);
        for (std::uint32_t k = 1; k < t.count; ++k) sum = sum + t.weight[k] * load(row[k] + j);
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
    clear(spare_row(*job.fine, 0), wide);
    float *line = spare_row(*job.fine, 0).p[0], *even = spare_row(*job.fine, 1).p[0],
          *odd = spare_row(*job.fine, 2).p[0];
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
    clear(spare_row(*job.fine, 0), wide);
    float *line = spare_row(*job.fine, 0).p[0], *out = spare_row(*job.fine, 1).p[0];
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

static DGM_INLINE Doubles evens_of(const double* row, std::ptrdiff_t j) {
    Doubles a, b;
    __builtin_memcpy(&a, row + 2 * j, sizeof a);
    __builtin_memcpy(&b, row + 2 * j + 8, sizeof b);
    return __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14);
}
/// Edges of a row of a coarse level, of one coordinate, by where samples of the finer one are.
static DGM_INLINE void thin_places(const ThinJob& job, std::uint32_t i, const double* at, float* u, float* v) {
    const std::ptrdiff_t n = job.coarse->pitch, cols = job.coarse->cols, even = job.even;
    const bool quads = i + 1 < job.coarse->rows;
    const double *row = at + job.rows[i] * job.fine->pitch, *next = row;
    if (quads) next = at + job.rows[i + 1] * job.fine->pitch;
    for (std::ptrdiff_t j = 0; j < n; j += 8) {
        const Doubles here = evens_of(row, j);
        put_eight(v + j, evens_of(row + 2, j) - here);
        if (quads) put_eight(u + j, evens_of(next, j) - here);
    }
    for (std::ptrdiff_t j = even < cols ? even - 1 : cols - 1; j < cols; ++j) {
        const std::ptrdiff_t k = job.columns[j];
        v[j] = j + 1 < cols ? static_cast<float>(row[job.columns[j + 1]] - row[k]) : 0;
        if (quads) u[j] = static_cast<float>(next[k] - row[k]);
    }
    if (quads) clear_from(u, cols, n);
    clear_from(v, cols, n);
}
/// The same by edges of the finer one.
static DGM_INLINE void thin_edges(const ThinJob& job, std::uint32_t i, int c, float* to_u, float* to_v) {
    const std::ptrdiff_t n = job.coarse->pitch, wide = job.fine->pitch, cols = job.coarse->cols, even = job.even;
    const bool quads = i + 1 < job.coarse->rows, two = quads && job.rows[i + 1] - job.rows[i] == 2;
    const float *u = job.fine->f1.p[c] + job.rows[i] * wide, *v = job.fine->f2.p[c] + job.rows[i] * wide;
    const float* next = u + wide;
    for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
        if (quads) store(to_u + j, two ? even_at(u, j) + even_at(next, j) : even_at(u, j));
        store(to_v + j, even_at(v, j) + odd_at(v, j));
    }
    for (std::ptrdiff_t j = even < cols ? even - 1 : cols - 1; j < cols; ++j) {
        const std::ptrdiff_t k = job.columns[j];
        to_v[j] = j + 1 < cols ? v[k] : 0;
        if (quads) to_u[j] = two ? u[k] + next[k] : u[k];
    }
    if (quads) clear_from(to_u, cols, n);
    clear_from(to_v, cols, n);
}
static void thin(const ThinJob& job) noexcept {
    const Sheet &fine = *job.fine, &on = *job.coarse;
    const std::ptrdiff_t n = on.pitch, cols = on.cols, even = job.even;
    const float* four[] = {job.tension1, job.tension2, fine.square1, fine.square2};
    float* to[] = {on.tension1, on.tension2, on.square1, on.square2};
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        const std::ptrdiff_t a = job.rows[i] * fine.pitch, s = i * n;
        for (int c = 0; c < 3; ++c) {
            if (job.at[0] != nullptr)
                thin_places(job, i, job.at[c], on.f1.p[c] + s, on.f2.p[c] + s);
            else
                thin_edges(job, i, c, on.f1.p[c] + s, on.f2.p[c] + s);
        }
        for (int q = 0; i + 1 < on.rows && q < 4; ++q) {
            const float *above = four[q] + a, *below = job.rows[i + 1] - job.rows[i] == 2 ? above + fine.pitch : above;
            float* out = to[q] + s;
            for (std::ptrdiff_t j = 0; j < n; j += kLanes)
                store(out + j,
                      0.25f * ((even_at(above, j) + odd_at(above, j)) + (even_at(below, j) + odd_at(below, j))));
            for (std::ptrdiff_t j = even < cols ? even - 1 : cols; j + 1 < cols; ++j) {
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
            const V3 u = 0.5f * (load(on.f1, s) + load(on.f1, s + 1));
            const V3 v = 0.5f * (load(on.f2, s) + load(on.f2, s + on.pitch));
            const V3 f1 = load(on.q11 + s) * u, f2 = load(on.q12 + s) * u + load(on.q22 + s) * v;
            store(on.f1, s, f1);
            store(on.f2, s, f2);
            const Floats lost1 = larger(load(on.square1 + s) - dot(f1, f1), Floats{});
            const Floats lost2 = larger(load(on.square2 + s) - dot(f2, f2), Floats{});
            store(on.s1 + s, load(on.tension1 + s) + (m.warp * lost1 + m.shear * lost2));
            store(on.s2 + s, load(on.tension2 + s) + (m.weft * lost2 + m.shear * lost1));
        }
}
