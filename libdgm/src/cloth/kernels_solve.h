// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_solve.h
// Loops of the solver: the matrix, its blocks, and the smoother. Included by kernels_impl.h.

/// Moments of samples side by side.
static DGM_INLINE Bent bend_way(const ProductJob& job, std::uint32_t i, std::ptrdiff_t j) {
    const Sheet& on = job.on;
    const std::ptrdiff_t n = on.pitch, s = i * n + j;
    const BentRows to = bent_rows(on, i);
    const V3 d = load(job.from, s), up = load(job.from, s + n), down = load(job.from, s - n);
    const V3 right = load(job.from, s + 1), left = load(job.from, s - 1);
    const V3 bu =
        (load(on.u_up + s) * (up - d) + load(on.u_down + s) * (down - d)) + load(on.u_side + s) * (right - left);
    const V3 bv =
        (load(on.v_up + s) * (right - d) + load(on.v_down + s) * (left - d)) + load(on.v_side + s) * (up - down);
    const Bent out{bu, bv};
    store(to.u, j, out.u);
    store(to.v, j, out.v);
    return out;
}

static DGM_INLINE Handed resist(const ProductJob& job, std::ptrdiff_t s) {
    const Sheet& on = job.on;
    const Moduli& m = on.moduli;
    const Quad k = known_quad(on, s);
    const V3 a = load(job.from, s), b = load(job.from, s + on.pitch);
    const V3 c = load(job.from, s + 1), d = load(job.from, s + on.pitch + 1);
    const V3 ab = b - a, cd = d - c, du = 0.5f * (ab + cd), dv = 0.5f * ((c - a) + (d - b));
    const V3 dh = (cd - ab) - (k.twist_u * du + k.twist_v * dv);
    const V3 d1 = k.q11 * du, d2 = k.q12 * du + k.q22 * dv;
    const Floats e1 = dot(k.f1, d1), e2 = dot(k.f2, d2), e3 = dot(k.f1, d2) + dot(k.f2, d1);
    const Floats t1 = m.warp * e1 + m.cross * e2, t2 = m.cross * e1 + m.weft * e2, t3 = m.shear * e3;
    const Floats s1 = load(on.s1 + s), s2 = load(on.s2 + s), z1 = k.q11 * k.q11, z2 = k.q22 * k.q22;
    const V3 p1 = k.area * ((t1 * k.f1 + t3 * k.f2) + s1 * d1), p2 = k.area * ((t2 * k.f2 + t3 * k.f1) + s2 * d2);
    const Floats w1 = (m.warp_uneven * z1) * dot(k.f1, dh), w2 = (m.weft_uneven * z2) * dot(k.f2, dh);
    const Floats across = (1.0f / 12) * (s1 * z1 + s2 * z2) + (2 * on.plate) * (z1 * z2);
    const V3 r = (k.uneven * k.area) * ((w1 * k.f1 + w2 * k.f2) + across * dh);
    return hand_out((k.q11 * p1 + k.q12 * p2) - k.twist_u * r, k.q22 * p2 - k.twist_v * r, r);
}

static DGM_INLINE V3 times(const Blocks& of, std::ptrdiff_t s, const V3& r) {
    Floats v[6];
    for (int c = 0; c < 6; ++c) v[c] = load(of.p[c] + s);
    return {(v[0] * r.x + v[3] * r.y) + v[4] * r.z, (v[3] * r.x + v[1] * r.y) + v[5] * r.z,
            (v[4] * r.x + v[5] * r.y) + v[2] * r.z};
}
static DGM_INLINE void store_if(const Field& f, std::ptrdiff_t s, const V3& v) {
    if (f.p[0] != nullptr) store(f, s, v);
}
/// What becomes of a part of the product. Nothing reads this part of `from` any more, so it may be written.
static DGM_INLINE void use_product(const ProductJob& job, std::ptrdiff_t s, std::ptrdiff_t j, const V3& from,
                                   const V3& product) {
    V3 r, way;
    switch (job.kind) {
        case Product::Whole:
            return store(job.to, s, product);
        case Product::Curve:
            return store(line_row(job.on), j, product);
        case Product::Residual:
            r = load(job.right, s);
            if (job.own != nullptr) r = load(job.own + s) * r;
            return store(job.to, s, load(job.free + s) * (r - product));
        case Product::Polish:
            r = load(job.right, s) - product;
            if (job.way.p[0] != nullptr) r = load(job.free + s) * r;  // the inverse is 0 where samples are held
            way = job.step * times(job.inverse, s, r);
            store(job.sum, s, from + way);
            break;
        case Product::Smooth:
            r = load(job.residual, s) - product;
            way = job.step * times(job.inverse, s, r) + job.keep * from;
            store(job.sum, s, load(job.sum, s) + way);
            break;
    }
    store_if(job.way, s, way);
    if (job.way.p[0] != nullptr) store(job.residual, s, r);
}
struct Dots {
    Doubles sum[4];
};
/// Of a row, by what Product::Curve has put into the scratch.
static DGM_INLINE void add_dots(const ProductJob& job, std::ptrdiff_t row, Dots& dots) {
    const Row product = line_row(job.on);
    for (std::ptrdiff_t j = 0; j < job.on.pitch; j += 8)
        for (int c = 0; c < 3; ++c) {
            const Doubles p = eight_at(product.p[c] + j), d = eight_at(job.from.p[c] + row + j);
            const Doubles r = eight_at(job.right.p[c] + row + j);
            dots.sum[0] += d * p;
            dots.sum[1] += d * r;
            dots.sum[2] += r * p;
            dots.sum[3] += p * p;
        }
}

static __attribute__((noinline)) void product_row(const ProductJob& job, std::uint32_t i, Dots& dots) noexcept {
    const Sheet& on = job.on;
    if (i == 0) {
        clear_first(on);
        for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) bend_way(job, 0, j);
    }
    const BentRows row = bent_rows(on, i), other = bent_rows(on, i + 1);
    const bool touched = on.touched[i] != 0, quads = i + 1 < on.rows;
    Handed before{};
    for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
        const std::ptrdiff_t s = i * on.pitch + j;
        const Bent above{load(other.u, j), load(other.v, j)};
        Bent below{};
        Handed handed{};
        if (quads) {
            below = bend_way(job, i + 1, j);
            handed = resist(job, s);
        }
        const V3 d = load(job.from, s);
        V3 sum = take_in(on, j, handed, before) + unbend(on, s, j, above, row, below);
        sum = sum + (job.by_dt2 * load(on.mass + s)) * d;
        if (touched) {
            const V3 n = load(on.normal, s);
            const Floats drag = load(on.drag + s);
            sum = sum + drag * d + ((load(on.press + s) - drag) * dot(n, d)) * n;
        }
        use_product(job, s, j, d, sum);
    }
    if (job.kind == Product::Curve) add_dots(job, i * on.pitch, dots);
}

/// A product reads `from` down to so many rows below the one that it writes. The next one follows it at that distance,
/// while what both need is near.
constexpr std::uint32_t kBehind = 2;
static void products(const ProductJob* jobs, std::uint32_t count) noexcept {
    const std::uint32_t rows = jobs[0].on.rows;
    Dots dots{};
    for (std::uint32_t i = 0; i < rows + kBehind * (count - 1); ++i)
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::uint32_t at = i - kBehind * k;
            if (at < rows) product_row(jobs[k], at, dots);
        }
    double* to = jobs[count - 1].dots;
    for (int k = 0; to != nullptr && k < 4; ++k) to[k] = sum_of(dots.sum[k]);
}

/// Six numbers of symmetric blocks of quads.
struct Sym {
    Floats v[6];
};
static DGM_INLINE Sym outer(const V3& a) {
    return {{a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z}};
}
static DGM_INLINE void add_to(Sym& to, const Floats& by, const Sym& from) {
    for (int k = 0; k < 6; ++k) to.v[k] += by * from.v[k];
}
/// Products of the columns of a quad's deformation gradient, and what both pairs of its corners have in common.
struct Strained {
    Sym first, second, both;  ///< f1 f1^T, f2 f2^T, f1 f2^T + f2 f1^T
    Floats z1, z2, s1, s2, plate;
};
static DGM_INLINE Strained strain_of(const Sheet& on, const Quad& k, std::ptrdiff_t s) {
    const V3 &a = k.f1, &b = k.f2;
    const Floats xy = a.x * b.y + a.y * b.x, xz = a.x * b.z + a.z * b.x, yz = a.y * b.z + a.z * b.y;
    const Floats z1 = k.q11 * k.q11, z2 = k.q22 * k.q22;
    const Floats s1 = load(on.s1 + s), s2 = load(on.s2 + s);
    return {outer(a), outer(b), {{2.0f * a.x * b.x, 2.0f * a.y * b.y, 2.0f * a.z * b.z, xy, xz, yz}}, z1, z2,
            s1,       s2,       (1.0f / 12) * (z1 * s1 + z2 * s2) + (2 * on.plate) * (z1 * z2)};
}
/// Block of the two opposite corners whose displacement changes the columns of the gradient by c1 and c2 times itself,
/// up to sign. Their shares of the twist are 1 + t/2 and 1 - t/2: the larger one counts for both. In a quad of
/// thin triangles it may be 20; blocks without it would let the smoother grow what it should damp.
static DGM_INLINE Sym corner_block(const Moduli& m, const Quad& k, const Strained& of, const Floats& c1,
                                   const Floats& c2, const Floats& t) {
    const Floats turn = t > 0 ? t : -t;
    const Floats share = turn > 1e-4f ? 1 + 0.5f * turn : all(1), weight = k.uneven * (share * share);
    const Floats one = c1 * c1, two = c2 * c2;
    const Floats first = k.area * ((m.warp * one + weight * (m.warp_uneven * of.z1)) + m.shear * two);
    const Floats second = k.area * ((m.weft * two + weight * (m.weft_uneven * of.z2)) + m.shear * one);
    const Floats both = k.area * ((m.cross + m.shear) * (c1 * c2));
    const Floats same = k.area * ((one * of.s1 + two * of.s2) + weight * of.plate);
    Sym sum;
    for (int c = 0; c < 6; ++c) {
        sum.v[c] = (first * of.first.v[c] + second * of.second.v[c]) + both * of.both.v[c];
        if (c < 3) sum.v[c] += same;
    }
    return sum;
}

/// Of `count` samples from `start` on. `whole` += right . right
static DGM_INLINE void invert_some(const InvertJob& job, std::size_t start, std::size_t count, Doubles& whole) {
    // In doubles: what is stiff along the cloth may be 1e6 times as stiff as across it.
    for (std::size_t s = start; s < start + count; s += 8) {
        Doubles v[6];
        for (int c = 0; c < 6; ++c) v[c] = eight_at(job.of.p[c] + s);
        Doubles trace = (v[0] + v[1]) + v[2];
        const Doubles none{};
        trace = trace > 1e-30 ? trace : none + 1;
        for (int c = 0; c < 3; ++c) v[c] += 2e-7 * trace;  // the rounding of their sums in floats
        const Doubles xx = v[1] * v[2] - v[5] * v[5], yy = v[0] * v[2] - v[4] * v[4], zz = v[0] * v[1] - v[3] * v[3];
        const Doubles xy = v[4] * v[5] - v[3] * v[2], xz = v[3] * v[5] - v[4] * v[1], yz = v[3] * v[4] - v[0] * v[5];
        const Doubles det = (v[0] * xx + v[3] * xy) + v[4] * xz;
        const auto sound = det > 1e-18 * ((trace * trace) * trace);
        const Doubles free = eight_at(job.free + s);
        const Doubles part = free / (sound ? det : trace), by = sound ? part : none, same = sound ? none : part;
        const Doubles to[6] = {by * xx + same, by * yy + same, by * zz + same, by * xy, by * xz, by * yz};
        for (int c = 0; c < 6; ++c) put_eight(job.of.p[c] + s, to[c]);
    }
    for (std::size_t k = start; k < start + count && job.gradient.p[0] != nullptr; k += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(k);
        const V3 r = V3{} - load(job.free + s) * load(job.gradient, s);
        store(job.right, s, r);
        store(job.sum, s, job.step * times(job.of, s, r));
    }
    for (std::size_t s = start; s < start + count && job.gradient.p[0] != nullptr; s += 8) {
        Doubles square{};
        for (int c = 0; c < 3; ++c) {
            const Doubles r = eight_at(job.right.p[c] + s);
            square += r * r;
        }
        whole += job.own != nullptr ? square * eight_at(job.own + s) : square;
    }
}
static double invert(const InvertJob& job) noexcept {
    Doubles whole{};
    invert_some(job, 0, job.count, whole);
    return sum_of(whole);
}

static double diagonal(const DiagonalJob& job) noexcept {
    const Sheet& on = job.on;
    const Moduli& m = on.moduli;
    const std::ptrdiff_t n = on.pitch;
    Doubles whole{};
    // Of quads for the next row.
    const Row waiting[2] = {spare_row(on, 0), spare_row(on, 1)};
    for (const Row& r : waiting) clear(r, n);
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        const bool touched = on.touched[i] != 0;
        Sym plus_before{}, minus_before{};
        for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
            const std::ptrdiff_t s = i * n + j;
            Sym plus{}, minus{}, sum;  // of corners (0, 0) and (1, 1), and of the others
            if (i + 1 < on.rows) {
                const Quad k = known_quad(on, s);
                const Strained of = strain_of(on, k, s);
                plus = corner_block(m, k, of, 0.5f * k.q11, 0.5f * (k.q12 + k.q22), k.twist_u + k.twist_v);
                minus = corner_block(m, k, of, 0.5f * k.q11, 0.5f * (k.q12 - k.q22), k.twist_u - k.twist_v);
            }
            for (int c = 0; c < 6; ++c) {
                float* wait = waiting[c / 3].p[c % 3] + j;
                sum.v[c] = (plus.v[c] + Pairs::left(minus_before.v[c], minus.v[c])) + load(wait);
                store(wait, minus.v[c] + Pairs::left(plus_before.v[c], plus.v[c]));
            }
            plus_before = plus;
            minus_before = minus;
            const auto square = [&](const float* coefficient, std::ptrdiff_t at) DGM_INLINED {
                const Floats v = load(coefficient + at);
                return v * v;
            };
            const Floats mu = load(on.u_up + s) + load(on.u_down + s), mv = load(on.v_up + s) + load(on.v_down + s);
            Floats same = job.by_dt2 * load(on.mass + s) + (mu * mu + mv * mv);
            same = same + ((square(on.u_up, s - n) + square(on.u_down, s + n)) +
                           (square(on.v_up, s - 1) + square(on.v_down, s + 1)));
            same = same + ((square(on.u_side, s - 1) + square(on.u_side, s + 1)) +
                           (square(on.v_side, s - n) + square(on.v_side, s + n)));
            if (touched) {
                const Floats drag = load(on.drag + s);
                same = same + drag;
                add_to(sum, load(on.press + s) - drag, outer(load(on.normal, s)));
            }
            for (int c = 0; c < 3; ++c) sum.v[c] += same;
            for (int c = 0; c < 6; ++c) store(job.invert.of.p[c] + s, sum.v[c]);
        }
        if (job.at_once) invert_some(job.invert, static_cast<std::size_t>(i * n), static_cast<std::size_t>(n), whole);
    }
    return sum_of(whole);
}

static void sweep(const SweepJob& job) noexcept {
    for (std::size_t k = 0; k < job.count; k += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(k);
        V3 r = load(job.kind == Sweep::Begin ? job.right : job.residual, s);
        if (job.kind == Sweep::Next) r = r - load(job.product, s);
        V3 way = job.step * times(job.inverse, s, r);
        if (job.kind == Sweep::Next) way = way + job.keep * load(job.way, s);
        if (job.keeps) {
            store(job.residual, s, r);
            store(job.way, s, way);
        }
        store(job.sum, s, job.kind == Sweep::Begin ? way : load(job.sum, s) + way);
    }
}

static void add(const AddJob& job) noexcept {
    for (std::size_t k = 0; k < job.count; k += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(k);
        const V3 sum = job.a * load(job.x, s) + job.b * load(job.y, s);
        store(job.to, s, load(job.free + s) * sum);
    }
}

static double inner(std::size_t count, const float* own, const Field& a, const Field& b) noexcept {
    Doubles sum{};
    for (std::size_t s = 0; s < count; s += 8) {
        Doubles part{};
        for (int c = 0; c < 3; ++c) part += eight_at(a.p[c] + s) * eight_at(b.p[c] + s);
        sum += part * eight_at(own + s);
    }
    return sum_of(sum);
}
