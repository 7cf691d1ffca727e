// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows_impl.h
// Bodies of contact_rows.h, four doubles at a time. Included as rows_impl.h is: inside a namespace and a target region,
// after all other headers, and without std:: for the same reason.
//
// Needs Doubles, Longs, Single4, Int4 (vectors of four), load_four (floats to doubles), store_four (back) and
// four_bytes (bytes to Longs).
//
// A quad (a, b, c, d) split along a-c encloses a . ((b - d) x c) / 6 with the origin, split along b-d the same with the
// corners turned by one: one determinant for two triangles.

template <class T, class From>
static inline __attribute__((always_inline)) T fetch(const From* p) {
    struct __attribute__((packed, may_alias)) Raw {
        T value;
    };
    return reinterpret_cast<const Raw*>(p)->value;
}
template <class T, class To>
static inline __attribute__((always_inline)) void put_raw(To* p, const T& v) {
    struct __attribute__((packed, may_alias)) Raw {
        T value;
    };
    reinterpret_cast<Raw*>(p)->value = v;
}

/// Lanes of four samples, or one.
struct Four {
    typedef Doubles D;
    static constexpr std::uint32_t kLanes = 4;
    static inline __attribute__((always_inline)) D load(const float* p) { return load_four(p); }
    static inline __attribute__((always_inline)) void store(float* p, const D& v) { store_four(p, v); }
    static inline __attribute__((always_inline)) Longs bytes(const std::uint8_t* p) { return four_bytes(p); }
    template <class Mask>
    static inline __attribute__((always_inline)) D choose(const Mask& c, const D& a, const D& b) {
        return c ? a : b;
    }
    static inline __attribute__((always_inline)) double sum(const D& v) { return (v[0] + v[1]) + (v[2] + v[3]); }
};
struct One {
    typedef double D;
    static constexpr std::uint32_t kLanes = 1;
    static inline __attribute__((always_inline)) D load(const float* p) { return static_cast<double>(*p); }
    static inline __attribute__((always_inline)) void store(float* p, D v) { *p = static_cast<float>(v); }
    static inline __attribute__((always_inline)) long long bytes(const std::uint8_t* p) { return *p; }
    static inline __attribute__((always_inline)) D choose(bool c, D a, D b) { return c ? a : b; }
    static inline __attribute__((always_inline)) double sum(D v) { return v; }
};

template <class D>
struct Triple {
    D x, y, z;
};
template <class D>
static inline __attribute__((always_inline)) Triple<D> minus(const Triple<D>& a, const Triple<D>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class D>
static inline __attribute__((always_inline)) Triple<D> times(const Triple<D>& a, const Triple<D>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class D>
static inline __attribute__((always_inline)) D inner(const Triple<D>& a, const Triple<D>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class L>
static inline __attribute__((always_inline)) Triple<typename L::D> place(const ConstPlanes& p, std::size_t k) {
    return {L::load(p.x + k), L::load(p.y + k), L::load(p.z + k)};
}
template <class L, class C>
static inline __attribute__((always_inline)) Triple<typename L::D> either(const C& c, const Triple<typename L::D>& a,
                                                                          const Triple<typename L::D>& b) {
    return {L::choose(c, a.x, b.x), L::choose(c, a.y, b.y), L::choose(c, a.z, b.z)};
}

/// Corners p q r s of a quad, turned so that it is split along p-r.
template <class D>
struct Corners {
    Triple<D> p, q, r, s;
};
template <class L, class C>
static inline __attribute__((always_inline)) Corners<typename L::D> turned(const C& second,
                                                                           const Triple<typename L::D>& a,
                                                                           const Triple<typename L::D>& b,
                                                                           const Triple<typename L::D>& c,
                                                                           const Triple<typename L::D>& d) {
    return {either<L>(second, b, a), either<L>(second, c, b), either<L>(second, d, c), either<L>(second, a, d)};
}
template <class L>
static inline __attribute__((always_inline)) Corners<typename L::D> corners(const QuadJob& j, std::size_t k) {
    const Triple<typename L::D> o{typename L::D{} + j.origin[0], typename L::D{} + j.origin[1],
                                  typename L::D{} + j.origin[2]};
    const std::size_t n = j.cols;
    return turned<L>(L::bytes(j.kind + k) == 1, minus(place<L>(j.at, k), o), minus(place<L>(j.at, k + n), o),
                     minus(place<L>(j.at, k + n + 1), o), minus(place<L>(j.at, k + 1), o));
}

template <class Block>
static inline __attribute__((always_inline)) void each_row(const Rect& rect, std::uint32_t cols, Block block) {
    for (std::uint32_t i = rect.i0; i <= rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * cols + rect.j0;
        const std::size_t end = k + rect.j1 - rect.j0 + 1;
        for (; k + 4 <= end; k += 4) block(Four{}, k);
        for (; k < end; ++k) block(One{}, k);
    }
}

/// One row of samples in doubles, over the origin.
struct WideRow {
    static constexpr std::uint32_t kRoom = 68;
    double x[kRoom], y[kRoom], z[kRoom];
};
static inline __attribute__((always_inline)) void widen_plane(const float* p, double o, std::size_t count,
                                                              double* out) {
    std::size_t k = 0;
    for (; k + 4 <= count; k += 4) put_raw(out + k, load_four(p + k) - o);
    for (; k < count; ++k) out[k] = static_cast<double>(p[k]) - o;
}
static inline __attribute__((always_inline)) void widen_row(const QuadJob& j, std::size_t k, std::size_t count,
                                                            WideRow& out) {
    widen_plane(j.at.x + k, j.origin[0], count, out.x);
    widen_plane(j.at.y + k, j.origin[1], count, out.y);
    widen_plane(j.at.z + k, j.origin[2], count, out.z);
}
template <class L>
static inline __attribute__((always_inline)) Triple<typename L::D> wide_place(const WideRow& r, std::size_t k) {
    typedef typename L::D D;
    return {fetch<D>(r.x + k), fetch<D>(r.y + k), fetch<D>(r.z + k)};
}
template <class L>
static inline __attribute__((always_inline)) typename L::D wide_volume(const WideRow& up, const WideRow& down,
                                                                       const std::uint8_t* kind, std::size_t k) {
    typedef typename L::D D;
    const auto kinds = L::bytes(kind + k);
    const Corners<D> c = turned<L>(kinds == 1, wide_place<L>(up, k), wide_place<L>(down, k), wide_place<L>(down, k + 1),
                                   wide_place<L>(up, k + 1));
    return L::choose(kinds != kQuadNone, inner(c.p, times(minus(c.q, c.s), c.r)), D{});
}

double volume(const QuadJob& job) noexcept {
    const QuadJob j = job;
    WideRow rows[2];
    double sum = 0;
    Doubles four = {};
    // Strips as wide as a row's room; each row is converted once.
    for (std::uint32_t first = j.rect.j0; first <= j.rect.j1; first += 64) {
        const std::size_t count = (j.rect.j1 - first < 63 ? j.rect.j1 - first : 63) + 1;
        std::size_t k = static_cast<std::size_t>(j.rect.i0) * j.cols + first;
        widen_row(j, k, count + 1, rows[j.rect.i0 & 1]);
        for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i, k += j.cols) {
            const WideRow& up = rows[i & 1];
            WideRow& down = rows[(i + 1) & 1];
            widen_row(j, k + j.cols, count + 1, down);
            std::size_t q = 0;
            for (; q + 4 <= count; q += 4) four += wide_volume<Four>(up, down, j.kind + k, q);
            for (; q < count; ++q) sum += wide_volume<One>(up, down, j.kind + k, q);
        }
    }
    return sum + Four::sum(four);
}

template <class L>
static inline __attribute__((always_inline)) void cubic_block(const QuadJob& j, const ConstPlanes& normal,
                                                              const float* weight, std::size_t k, typename L::D* out) {
    typedef typename L::D D;
    const std::size_t n = j.cols;
    const auto arrow = [&](std::size_t at) __attribute__((always_inline)) {
        const D w = L::load(weight + at);
        const Triple<D> v = place<L>(normal, at);
        return Triple<D>{w * v.x, w * v.y, w * v.z};
    };
    const Corners<D> x = corners<L>(j, k);
    const Corners<D> b = turned<L>(L::bytes(j.kind + k) == 1, arrow(k), arrow(k + n), arrow(k + n + 1), arrow(k + 1));
    const Triple<D> e = minus(x.q, x.s), f = minus(b.q, b.s);
    const Triple<D> ex = times(e, x.r), fb = times(f, b.r);
    const Triple<D> eb = times(e, b.r), fx = times(f, x.r);
    const Triple<D> mixed{eb.x + fx.x, eb.y + fx.y, eb.z + fx.z};
    const auto there = L::bytes(j.kind + k) != kQuadNone;
    out[0] += L::choose(there, inner(b.p, ex) + inner(x.p, mixed), D{});
    out[1] += L::choose(there, inner(b.p, mixed) + inner(x.p, fb), D{});
    out[2] += L::choose(there, inner(b.p, fb), D{});
}

void cubic(const QuadJob& j, ConstPlanes normal, const float* weight, double* out) noexcept {
    Doubles four[3] = {};
    double sum[3] = {0, 0, 0};
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        for (; k + 4 <= end; k += 4) cubic_block<Four>(j, normal, weight, k, four);
        for (; k < end; ++k) cubic_block<One>(j, normal, weight, k, sum);
    }
    for (int a = 0; a < 3; ++a) out[a] += sum[a] + Four::sum(four[a]);
}

template <class L>
static inline __attribute__((always_inline)) typename L::D root(const typename L::D& v) {
    if constexpr (L::kLanes == 1)
        return __builtin_sqrt(v);
    else
        return four_roots(v);
}
template <class L>
static inline __attribute__((always_inline)) typename L::D area_block(const QuadJob& j, const std::uint8_t* marks,
                                                                      std::size_t k) {
    typedef typename L::D D;
    const Corners<D> c = corners<L>(j, k);
    const Triple<D> v = times(minus(c.r, c.p), minus(c.s, c.q));
    const auto counts = (L::bytes(marks + k) & 1) > (L::bytes(j.kind + k) >> 1);
    return L::choose(counts, 0.5 * root<L>(inner(v, v)), D{});
}

double area(const QuadJob& j, const std::uint8_t* marks) noexcept {
    double sum = 0;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        Doubles four = {};
        for (; k + 4 <= end; k += 4) four += area_block<Four>(j, marks, k);
        sum += Four::sum(four);
        for (; k < end; ++k) sum += area_block<One>(j, marks, k);
    }
    return sum;
}

template <class L>
static inline __attribute__((always_inline)) typename L::D beyond(const PlaneJob& j, std::size_t k) {
    const ConstPlanes p{j.at.x, j.at.y, j.at.z};
    const Triple<typename L::D> v = place<L>(p, k);
    return j.n[0] * v.x + j.n[1] * v.y + j.n[2] * v.z - j.d;
}

void mark(const PlaneJob& j, PlaneSums& sums) noexcept {
    double deepest = sums.deepest, total = 0;
    std::uint32_t count = 0;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        for (; k + 4 <= end; k += 4) {
            const Doubles d = beyond<Four>(j, k);
            const Longs in = d < -j.tolerance;
            const Doubles depth = in ? -d : Doubles{};
            for (int lane = 0; lane < 4; ++lane) {
                j.marks[k + static_cast<std::size_t>(lane)] = static_cast<std::uint8_t>(in[lane] & 1);
                deepest = depth[lane] > deepest ? depth[lane] : deepest;
            }
            total += Four::sum(depth);
            count -= static_cast<std::uint32_t>(in[0] + in[1] + in[2] + in[3]);
        }
        for (; k < end; ++k) {
            const double d = beyond<One>(j, k);
            const bool in = d < -j.tolerance;
            j.marks[k] = in ? 1 : 0;
            if (!in) continue;
            deepest = -d > deepest ? -d : deepest;
            total -= d;
            ++count;
        }
    }
    sums.deepest = deepest;
    sums.total += total;
    sums.count += count;
}

template <class L>
static inline __attribute__((always_inline)) void project_block(const PlaneJob& j, const float* mobility,
                                                                std::size_t k) {
    typedef typename L::D D;
    const D distance = beyond<L>(j, k);
    D step = L::choose((L::bytes(j.marks + k) & 1) != 0, distance, D{});
    if (mobility != nullptr) step = step * L::load(mobility + k);
    // What does not move keeps its bits, the sign of a zero too.
    const auto moving = step != 0.0;
    const Triple<D> p = place<L>({j.at.x, j.at.y, j.at.z}, k);
    L::store(j.at.x + k, L::choose(moving, p.x - step * j.n[0], p.x));
    L::store(j.at.y + k, L::choose(moving, p.y - step * j.n[1], p.y));
    L::store(j.at.z + k, L::choose(moving, p.z - step * j.n[2], p.z));
}

void project(const PlaneJob& j, const float* mobility) noexcept {
    each_row(
        j.rect, j.cols, [&](auto lanes, std::size_t k) __attribute__((always_inline)) {
            project_block<decltype(lanes)>(j, mobility, k);
        });
}

/// exp(-x) for 0 <= x <= 64 within 2e-7: a Taylor polynomial of exp(-x / 64), squared six times.
template <class F>
static inline __attribute__((always_inline)) F decay(F x) {
    const F y = x * (1.0f / 64);
    F e = 1.0f - y * (1.0f - y * (0.5f - y * (1.0f / 6 - y * (1.0f / 24 - y * (1.0f / 120 - y * (1.0f / 720))))));
    e = e * e;
    e = e * e;
    e = e * e;
    e = e * e;
    e = e * e;
    return e * e;
}

template <class F, class I>
static inline __attribute__((always_inline)) F weight_of(const WeightJob& j, const F& square, const I& in) {
    const F zero = F{};
    const F x = (in ? square : zero) * j.factor;
    const F v = (decay(x) - j.end * (1.0f + (j.slope - x))) / (1.0f - j.end * (1.0f + j.slope));
    return in ? v : zero;
}

std::uint32_t weights(const WeightJob& j) noexcept {
    std::uint32_t count = 0;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        for (; k + 4 <= end; k += 4) {
            const Single4 square = fetch<Single4>(j.square + k);
            Single4 w = weight_of<Single4, Int4>(j, square, square < j.limit);
            if (j.mobility != nullptr) w = w * fetch<Single4>(j.mobility + k);
            const Int4 positive = w > 0.0f;
            put_raw(j.weight + k, positive ? w : Single4{});
            count -= static_cast<std::uint32_t>(positive[0] + positive[1] + positive[2] + positive[3]);
        }
        for (; k < end; ++k) {
            float w = weight_of<float, bool>(j, j.square[k], j.square[k] < j.limit);
            if (j.mobility != nullptr) w = w * j.mobility[k];
            j.weight[k] = w > 0 ? w : 0;
            count += w > 0 ? 1 : 0;
        }
    }
    return count;
}

// In float: it is the result's own precision, and the volume is measured afterwards.
template <class F>
static inline __attribute__((always_inline)) void bulge_block(const BulgeJob& j, std::size_t k) {
    const F w = fetch<F>(j.weight + k);
    const auto moving = w > 0.0f;
    const F step = w * j.beta;
    const F ox = fetch<F>(j.to.x + k), oy = fetch<F>(j.to.y + k), oz = fetch<F>(j.to.z + k);
    F x = fetch<F>(j.from.x + k) + step * fetch<F>(j.normal.x + k);
    F y = fetch<F>(j.from.y + k) + step * fetch<F>(j.normal.y + k);
    F z = fetch<F>(j.from.z + k) + step * fetch<F>(j.normal.z + k);
    if (j.clamp) {
        const F distance = j.n[0] * x + j.n[1] * y + j.n[2] * z - j.d;
        const F back = distance < 0.0f ? distance : F{};
        x = x - back * j.n[0];
        y = y - back * j.n[1];
        z = z - back * j.n[2];
    }
    put_raw(j.to.x + k, F(moving ? x : ox));
    put_raw(j.to.y + k, F(moving ? y : oy));
    put_raw(j.to.z + k, F(moving ? z : oz));
}

void bulge(const BulgeJob& job) noexcept {
    const BulgeJob j = job;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        for (; k + sizeof(Wide) / 4 <= end; k += sizeof(Wide) / 4) bulge_block<Wide>(j, k);
        for (; k < end; ++k) bulge_block<float>(j, k);
    }
}
