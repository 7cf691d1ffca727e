// SPDX-License-Identifier: MIT
// libdgm/src/rows/rows_impl.h
// Bodies of rows.h for one number of lanes. Included inside a namespace (and a target region) of the including file,
// after all other headers: nothing from a header may be compiled for the wider instruction set, or the linker could use
// that copy everywhere. Hence no std:: below.
//
// Needs DGM_LANES, Floats (vector of DGM_LANES floats), Ints (of as many ints), Floats4, inverse_root, any and
// sign_bits (a bit for each true lane); for F in Floats, float: multiply_add (a b + c), multiply_subtract (a b - c),
// subtract_product (c - a b), fused or not; widen (bytes to ints) and choose_bit<k>(ring, a, b): a where bit k is set,
// else b.

template <class T>
struct __attribute__((packed, may_alias)) Unaligned {
    T value;
};
template <class T>
static DGM_INLINE T load(const float* p) {
    return reinterpret_cast<const Unaligned<T>*>(p)->value;
}
template <class T>
static DGM_INLINE void store(float* p, const T& v) {
    reinterpret_cast<Unaligned<T>*>(p)->value = v;
}
template <class F>
static DGM_INLINE void move_block(const MoveJob& j, const float* w, std::uint32_t at, float dx, float dy, float dz) {
    F weight = load<F>(w);
    if (j.mobility != nullptr) weight = weight * load<F>(j.mobility + at);
    store<F>(j.to.x + at, load<F>(j.from.x + at) + weight * dx);
    store<F>(j.to.y + at, load<F>(j.from.y + at) + weight * dy);
    store<F>(j.to.z + at, load<F>(j.from.z + at) + weight * dz);
}

// Jobs are copied to locals: a store through a float* could otherwise change their fields for all the compiler knows.
void move(const MoveJob& job) noexcept {
    const MoveJob j = job;
    const std::uint32_t count = j.rect.j1 - j.rect.j0 + 1;
    const bool in_place = j.from.x == j.to.x;
    const float dx = j.d[0], dy = j.d[1], dz = j.d[2];
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        const std::uint32_t row = !j.mirrored ? i - j.rect.i0 : i < j.centre ? j.centre - i : i - j.centre;
        const float* w = j.weights + static_cast<std::size_t>(row) * j.weight_step;
        const std::uint32_t first = i * j.cols + j.rect.j0;
        std::uint32_t k = 0;
        for (; k + DGM_LANES <= count; k += DGM_LANES) move_block<Floats>(j, w + k, first + k, dx, dy, dz);
        if (k < count && k != 0 && !in_place) {
            k = count - DGM_LANES;
            move_block<Floats>(j, w + k, first + k, dx, dy, dz);
            continue;
        }
        for (; k + 4 <= count; k += 4) move_block<Floats4>(j, w + k, first + k, dx, dy, dz);
        for (; k < count; ++k) move_block<float>(j, w + k, first + k, dx, dy, dz);
    }
}

template <class F>
static DGM_INLINE F magnitude(F v) {
    return v < 0 ? -v : v;
}

template <class F>
static DGM_INLINE F lower(F a, F b) {
    return b < a ? b : a;
}
template <class F>
static DGM_INLINE F upper(F a, F b) {
    return a < b ? b : a;
}
template <bool kLargest>
static DGM_INLINE Floats pick(const Floats& a, const Floats& b) {
    return kLargest ? upper(a, b) : lower(a, b);
}
/// The largest or smallest of all lanes, half of them at a time.
template <bool kLargest>
static DGM_INLINE float extreme_lane(Floats v) {
#if DGM_LANES == 8
    v = pick<kLargest>(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
    v = pick<kLargest>(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
    v = pick<kLargest>(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
#else
    v = pick<kLargest>(v, __builtin_shufflevector(v, v, 2, 3, 0, 1));
    v = pick<kLargest>(v, __builtin_shufflevector(v, v, 1, 0, 3, 2));
#endif
    return v[0];
}

/// One float on towards `base`, which is so near that it has the same sign.
template <class F, class I>
static DGM_INLINE F next_towards(const F& v, const F& base) {
    const I bits = __builtin_bit_cast(I, v);
    const I outwards = static_cast<I>((base > v) != (bits < 0));  // of zero
    if constexpr (sizeof(F) == sizeof(float))
        return __builtin_bit_cast(F, outwards != 0 ? bits + 1 : bits - 1);
    else
        return __builtin_bit_cast(F, bits - 1 - 2 * outwards);
}
template <class F, class I>
static DGM_INLINE void relax_plane(float* now, const float* base, const F& left, const I& moving) {
    const F before = load<F>(now), rest = load<F>(base), after = moving ? rest + left : rest;
    const I held = static_cast<I>(after == before) & static_cast<I>(before != rest) &
                   static_cast<I>(magnitude(before - rest) <= kStuck * magnitude(rest));
    store<F>(now, after);
    if (any(held)) store<F>(now, held ? next_towards<F, I>(before, rest) : after);
}

template <class F, class I>
static DGM_INLINE void relax_block(const RelaxJob& j, std::size_t k, F& most) {
    const F x = (load<F>(j.now.x + k) - load<F>(j.base.x + k)) * j.factor,
            y = (load<F>(j.now.y + k) - load<F>(j.base.y + k)) * j.factor,
            z = (load<F>(j.now.z + k) - load<F>(j.base.z + k)) * j.factor;
    const F largest = upper(upper(magnitude(x), magnitude(y)), magnitude(z));
    const I moving = static_cast<I>(largest > j.still);
    most = upper(most, largest);
    relax_plane<F, I>(j.now.x + k, j.base.x + k, x, moving);
    relax_plane<F, I>(j.now.y + k, j.base.y + k, y, moving);
    relax_plane<F, I>(j.now.z + k, j.base.z + k, z, moving);
}

float relax(const RelaxJob& job) noexcept {
    const RelaxJob j = job;
    const std::uint32_t count = j.rect.j1 - j.rect.j0 + 1;
    Floats most = {};
    float most_one = 0;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        const std::size_t first = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        std::uint32_t k = 0;
        for (; k + DGM_LANES <= count; k += DGM_LANES) relax_block<Floats, Ints>(j, first + k, most);
        for (; k < count; ++k) relax_block<float, int>(j, first + k, most_one);
    }
    most_one = upper(most_one, extreme_lane<true>(most));
    return most_one > j.still ? most_one : 0;
}

template <class F>
struct Vector {
    F x, y, z;
};
template <class F>
static DGM_INLINE Vector<F> operator-(const Vector<F>& a, const Vector<F>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class F>
static DGM_INLINE Vector<F> cross(const Vector<F>& a, const Vector<F>& b) {
    return {multiply_subtract(a.y, b.z, a.z * b.y), multiply_subtract(a.z, b.x, a.x * b.z),
            multiply_subtract(a.x, b.y, a.y * b.x)};
}
/// sum += a x b.
template <class F>
static DGM_INLINE void add_cross(Vector<F>& sum, const Vector<F>& a, const Vector<F>& b) {
    sum.x = subtract_product(multiply_add(a.y, b.z, sum.x), a.z, b.y);
    sum.y = subtract_product(multiply_add(a.z, b.x, sum.y), a.x, b.z);
    sum.z = subtract_product(multiply_add(a.x, b.y, sum.z), a.y, b.x);
}

/// Three rows of samples: edge neighbours n0 (+i), n1 (+j), n2 (-i), n3 (-j); corners c0 (+i +j), c1 (-i +j),
/// c2 (-i -j), c3 (+i -j).
struct Row {
    const float *x, *y, *z;
};
static DGM_INLINE Row row_at(const ConstPlanes& p, std::ptrdiff_t k) {
    return {p.x + k, p.y + k, p.z + k};
}
template <class F>
static DGM_INLINE Vector<F> point(const Row& row, std::ptrdiff_t k) {
    return {load<F>(row.x + k), load<F>(row.y + k), load<F>(row.z + k)};
}

template <class F, class I, int kBit>
static DGM_INLINE Vector<F> corner(const I& ring, const Vector<F>& in, const Vector<F>& edge) {
    return {choose_bit<kBit>(ring, in.x, edge.x), choose_bit<kBit>(ring, in.y, edge.y),
            choose_bit<kBit>(ring, in.z, edge.z)};
}

struct NormalRow {
    Row after, here, before;  ///< rows i + 1, i, i - 1
    float *x, *y, *z;
    const std::uint8_t* ring;
    float scale;
};

/// @return which normals are good.
///
/// A corner that is not in the ring is replaced by a neighbour of its own in the ring: the polygon gets an edge without
/// length. The octagon is cut into n0 c0 n1 c1, c1 n2 c2 n3 and n0 c1 n3 c3.
template <class F, class I, bool kUniform, bool kScaled>
static DGM_INLINE I normal_block(const NormalRow& r, std::ptrdiff_t k) {
    const Vector<F> n0 = point<F>(r.after, k), n1 = point<F>(r.here, k + 1);
    Vector<F> sum;
    if constexpr (kUniform) {
        const Vector<F> n2 = point<F>(r.before, k);
        sum = cross(n1 - n0, n2 - point<F>(r.after, k + 1));
        add_cross(sum, point<F>(r.before, k - 1) - n0, point<F>(r.here, k - 1) - n2);
    } else {
        const I ring = widen(r.ring + k, I{});
        const Vector<F> c1 = corner<F, I, 1>(ring, point<F>(r.before, k + 1), n1);
        sum = cross(n1 - n0, c1 - corner<F, I, 0>(ring, point<F>(r.after, k + 1), n0));
        const Vector<F> n2 = point<F>(r.before, k), n3 = point<F>(r.here, k - 1);
        add_cross(sum, corner<F, I, 2>(ring, point<F>(r.before, k - 1), n2) - c1, n3 - n2);
        add_cross(sum, n3 - n0, corner<F, I, 3>(ring, point<F>(r.after, k - 1), n3) - c1);
    }
    if constexpr (kScaled) sum = {sum.x * r.scale, sum.y * r.scale, sum.z * r.scale};
    const F square = multiply_add(sum.z, sum.z, multiply_add(sum.y, sum.y, sum.x * sum.x));
    const I good = static_cast<I>(square > 1e-24f) & static_cast<I>(square < 1e24f);  // false for NaN
    const F inverse = inverse_root(square);
    store<F>(r.x + k, good ? sum.x * inverse : F{});
    store<F>(r.y + k, good ? sum.y * inverse : F{});
    store<F>(r.z + k, good ? sum.z * inverse : F{});
    return good;
}

template <bool kUniform, bool kScaled>
static DGM_INLINE bool normal_rows(const NormalJob& job) {
    const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(job.rect.j1 - job.rect.j0) + 1, n = job.cols;
    Ints good = ~Ints{};
    int good_one = 1;
    for (std::uint32_t i = job.rect.i0; i <= job.rect.i1; ++i) {
        const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(i) * n + job.rect.j0;
        const NormalRow r{row_at(job.at, first + n),
                          row_at(job.at, first),
                          row_at(job.at, first - n),
                          job.out.x + first,
                          job.out.y + first,
                          job.out.z + first,
                          kUniform ? nullptr : job.ring + first,
                          job.scale};
        std::ptrdiff_t k = 0;
        for (; k + DGM_LANES <= count; k += DGM_LANES) good &= normal_block<Floats, Ints, kUniform, kScaled>(r, k);
        if (k < count && k != 0) {
            good &= normal_block<Floats, Ints, kUniform, kScaled>(r, count - DGM_LANES);
            continue;
        }
        for (; k < count; ++k) good_one &= normal_block<float, int, kUniform, kScaled>(r, k);
    }
    return good_one != 0 && !any(~good);
}

bool normals(const NormalJob& job) noexcept {
    if (job.ring == nullptr) return job.scale == 1 ? normal_rows<true, false>(job) : normal_rows<true, true>(job);
    return job.scale == 1 ? normal_rows<false, false>(job) : normal_rows<false, true>(job);
}

template <class F>
static DGM_INLINE F distance(const NearestJob& j, std::uint32_t k) {
    const F x = load<F>(j.at.x + k) - j.tool[0], y = load<F>(j.at.y + k) - j.tool[1],
            z = load<F>(j.at.z + k) - j.tool[2];
    return x * x + y * y + z * z;
}

void nearest(const NearestJob& j, float& d2, std::uint32_t& sample) noexcept {
    const std::uint32_t count = j.rect.j1 - j.rect.j0 + 1;
    Floats best = Floats{} + __builtin_inff();  // of each lane its first one: the lowest index
    Ints index = ~Ints{};
    Ints lane = {};
    for (int k = 0; k < DGM_LANES; ++k) lane[k] = k;
    const auto offer = [&](float d, std::uint32_t k) {
        if (d < d2 || (d == d2 && k < sample)) {
            d2 = d;
            sample = k;
        }
    };
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        const std::uint32_t first = i * j.cols + j.rect.j0;
        std::uint32_t k = 0;
        for (; k + DGM_LANES <= count; k += DGM_LANES) {
            const Floats d = distance<Floats>(j, first + k);
            const Ints nearer = d < best;
            best = nearer ? d : best;
            index = nearer ? lane + static_cast<int>(first + k) : index;
        }
        for (; k < count; ++k) offer(distance<float>(j, first + k), first + k);
    }
    if (!any(best <= d2)) return;
    for (int k = 0; k < DGM_LANES; ++k) offer(best[k], static_cast<std::uint32_t>(index[k]));
}

static DGM_INLINE void plane_bounds(const float* p, const Rect& rect, std::uint32_t cols, float& low, float& high) {
    const std::uint32_t count = rect.j1 - rect.j0 + 1;
    Floats l = Floats{} + low, h = Floats{} + high;
    for (std::uint32_t i = rect.i0; i <= rect.i1; ++i) {
        const float* row = p + static_cast<std::size_t>(i) * cols + rect.j0;
        std::uint32_t k = 0;
        for (; k + DGM_LANES <= count; k += DGM_LANES) {
            const Floats v = load<Floats>(row + k);
            l = lower(l, v);
            h = upper(h, v);
        }
        if (k < count && k != 0) {  // some once more: it does not show in extremes
            const Floats v = load<Floats>(row + count - DGM_LANES);
            l = lower(l, v);
            h = upper(h, v);
            continue;
        }
        for (; k < count; ++k) {
            low = lower(low, row[k]);
            high = upper(high, row[k]);
        }
    }
    low = lower(low, extreme_lane<false>(l));
    high = upper(high, extreme_lane<true>(h));
}

void bounds(ConstPlanes at, const Rect& rect, std::uint32_t cols, float* low, float* high) noexcept {
    const std::uint32_t count = rect.j1 - rect.j0 + 1;
    if (count > DGM_LANES && count <= 2 * DGM_LANES) {  // a tile and a column: two loads a row, which overlap
        Floats l[3] = {Floats{} + low[0], Floats{} + low[1], Floats{} + low[2]};
        Floats h[3] = {Floats{} + high[0], Floats{} + high[1], Floats{} + high[2]};
        for (std::uint32_t i = rect.i0; i <= rect.i1; ++i) {
            const std::size_t k = static_cast<std::size_t>(i) * cols + rect.j0;
            const float* const rows[3] = {at.x + k, at.y + k, at.z + k};
            for (int d = 0; d < 3; ++d) {
                const Floats v = load<Floats>(rows[d]), w = load<Floats>(rows[d] + count - DGM_LANES);
                l[d] = lower(lower(l[d], v), w);
                h[d] = upper(upper(h[d], v), w);
            }
        }
        for (int d = 0; d < 3; ++d) {
            low[d] = lower(low[d], extreme_lane<false>(l[d]));
            high[d] = upper(high[d], extreme_lane<true>(h[d]));
        }
        return;
    }
    plane_bounds(at.x, rect, cols, low[0], high[0]);
    plane_bounds(at.y, rect, cols, low[1], high[1]);
    plane_bounds(at.z, rect, cols, low[2], high[2]);
}

template <class F, class I>
static DGM_INLINE void merge_block(const MergeJob& j, std::uint32_t k, const F& steps) {
    const F x = j.x + steps * j.dx, y = j.y + steps * j.dy;
    const F key = j.a * x * x + j.b * x * y + j.c * y * y;
    const F old = load<F>(j.key + k);
    const I nearer = key < old;
    store<F>(j.key + k, nearer ? key : old);
    store<F>(j.weight + k, nearer ? load<F>(j.weights + k) : load<F>(j.weight + k));
}

void merge(const MergeJob& job) noexcept {
    const MergeJob j = job;
    Floats lane = {};
    for (int k = 0; k < DGM_LANES; ++k) lane[k] = static_cast<float>(k);
    std::uint32_t k = 0;
    for (; k + DGM_LANES <= j.count; k += DGM_LANES) merge_block<Floats, Ints>(j, k, lane + static_cast<float>(k));
    for (; k < j.count; ++k) merge_block<float, int>(j, k, static_cast<float>(k));
}

/// One coordinate: extremes of pairs of samples side by side.
template <class F>
struct Span {
    F low, high;
};
/// All three coordinates, along the axes.
template <class F>
struct Spans {
    Span<F> of[3];
};
template <class F>
static DGM_INLINE Spans<F> side_by_side(const QuadBoxesJob& j, std::size_t k) {
    const float* o = j.frame.centre;
    const F px = F{} + o[0], py = F{} + o[1], pz = F{} + o[2];
    const F ax = load<F>(j.at.x + k) - px, ay = load<F>(j.at.y + k) - py, az = load<F>(j.at.z + k) - pz;
    const F bx = load<F>(j.at.x + k + 1) - px, by = load<F>(j.at.y + k + 1) - py, bz = load<F>(j.at.z + k + 1) - pz;
    Spans<F> spans;
    for (int d = 0; d < 3; ++d) {
        const float* axis = j.frame.axis[d];
        const F x = F{} + axis[0], y = F{} + axis[1], z = F{} + axis[2];
        const F a = multiply_add(z, az, multiply_add(y, ay, x * ax)),
                b = multiply_add(z, bz, multiply_add(y, by, x * bx));
        spans.of[d] = {lower(a, b), upper(a, b)};
    }
    return spans;
}
void quad_boxes(const QuadBoxesJob& job, float* boxes, float* whole) noexcept {
    const QuadBoxesJob j = job;
    const std::uint32_t count = j.rect.j1 - j.rect.j0 + 1;
    if (count < 8 || j.rect.i1 - j.rect.i0 < 7)
        for (int k = 0; k < 6 * 64; ++k) boxes[k] = __builtin_inff();
    const Floats far = Floats{} + __builtin_inff();
    Floats all[6] = {far, -far, far, -far, far, -far};
    Ints lane = {};
    for (int k = 0; k < DGM_LANES; ++k) lane[k] = k;
    for (std::uint32_t first = 0; first < count; first += DGM_LANES) {
        // Planes are padded for the lanes beyond, which stay empty.
        const Ints in = lane < static_cast<int>(count - first);
        std::size_t k = static_cast<std::size_t>(j.rect.i0) * j.cols + j.rect.j0 + first;
        float* to = boxes + first;
        Spans<Floats> up = side_by_side<Floats>(j, k);
        for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i, to += 8) {
            k += j.cols;
            const Spans<Floats> down = side_by_side<Floats>(j, k);
            for (int d = 0; d < 3; ++d) {
                const Floats low = in ? lower(up.of[d].low, down.of[d].low) : far,
                             high = in ? upper(up.of[d].high, down.of[d].high) : -far;
                store<Floats>(to + 128 * d, low);
                store<Floats>(to + 128 * d + 64, high);
                all[2 * d] = lower(low, all[2 * d]);
                all[2 * d + 1] = upper(high, all[2 * d + 1]);
            }
            up = down;
        }
    }
    for (int side = 0; side < 6; ++side)
        whole[side] = side % 2 == 0 ? extreme_lane<false>(all[side]) : extreme_lane<true>(all[side]);
}

std::uint64_t boxes_near(const BoxesNearJob& job) noexcept {
    const BoxesNearJob j = job;
    std::uint64_t near = 0;
    for (std::uint32_t k = 0; k < j.count; k += DGM_LANES) {
        Floats square = {};
        for (int d = 0; d < 3; ++d) {
            const float* low = j.boxes + 2 * static_cast<std::size_t>(d) * j.stride + k;
            const Floats gap =
                upper(upper(load<Floats>(low) - j.high[d], j.low[d] - load<Floats>(low + j.stride)), Floats{});
            square = multiply_add(gap, gap, square);
        }
        near |= static_cast<std::uint64_t>(sign_bits(square <= j.square)) << k;
    }
    return near;
}
