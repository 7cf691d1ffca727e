// SPDX-License-Identifier: MIT
// libdgm/src/rows/contact_rows_impl.h
// Bodies of contact_rows.h, four doubles at a time. Included as rows_impl.h is: inside a namespace and a target region,
// after all other headers, and without std:: for the same reason.
//
// Needs Doubles, Longs (vectors of four), load_four (floats to doubles), store_four (back), four_bytes (bytes to
// Longs), lane_bits (a bit for each lane), kFourDoubles (whether loops in double use them); Wide, WideInts,
// wide_bytes; square_root of each; multiply_add (a b + c), multiply_subtract (a b - c) and subtract_product (c - a b),
// fused or not, for Doubles and Wide.
//
// A quad (a, b, c, d) split along a-c encloses a . ((b - d) x c) / 6 with the origin, split along b-d the same with the
// corners turned by one: one determinant for two triangles.

template <class T, class From>
static DGM_INLINE T fetch(const From* p) {
    struct __attribute__((packed, may_alias)) Raw {
        T value;
    };
    return reinterpret_cast<const Raw*>(p)->value;
}
template <class T, class To>
static DGM_INLINE void put_raw(To* p, const T& v) {
    struct __attribute__((packed, may_alias)) Raw {
        T value;
    };
    reinterpret_cast<Raw*>(p)->value = v;
}

/// Lanes of four samples, or one.
struct Four {
    typedef Doubles D;
    static constexpr std::uint32_t kLanes = 4;
    static DGM_INLINE D load(const float* p) { return load_four(p); }
    static DGM_INLINE void store(float* p, const D& v) { store_four(p, v); }
    static DGM_INLINE Longs bytes(const std::uint8_t* p) { return four_bytes(p); }
    template <class Mask>
    static DGM_INLINE D choose(const Mask& c, const D& a, const D& b) {
        return c ? a : b;
    }
    static DGM_INLINE double sum(const D& v) { return (v[0] + v[1]) + (v[2] + v[3]); }
    typedef float Floats __attribute__((vector_size(16)));
    template <class To>
    static DGM_INLINE void store_bits(To* p, const D& v) {
        put_raw(p, __builtin_convertvector(v, Floats));
    }
    static DGM_INLINE D rounded(const D& v) { return __builtin_convertvector(__builtin_convertvector(v, Floats), D); }
    static DGM_INLINE Longs either_not_zero(const D& a, const D& b, const D& c, const D& d, const D& e, const D& f,
                                            const Longs& g) {
        return (a != 0.0) | (b != 0.0) | (c != 0.0) | (d != 0.0) | (e != 0.0) | (f != 0.0) | (g != 0);
    }
};
struct One {
    typedef double D;
    static constexpr std::uint32_t kLanes = 1;
    static DGM_INLINE D load(const float* p) { return static_cast<double>(*p); }
    static DGM_INLINE void store(float* p, D v) { *p = static_cast<float>(v); }
    static DGM_INLINE long long bytes(const std::uint8_t* p) { return *p; }
    static DGM_INLINE D choose(bool c, D a, D b) { return c ? a : b; }
    template <class To>
    static DGM_INLINE void store_bits(To* p, D v) {
        put_raw(p, static_cast<float>(v));
    }
    static DGM_INLINE D rounded(D v) { return static_cast<double>(static_cast<float>(v)); }
    static DGM_INLINE bool either_not_zero(D a, D b, D c, D d, D e, D f, long long g) {
        return a != 0 || b != 0 || c != 0 || d != 0 || e != 0 || f != 0 || g != 0;
    }
};

/// Lanes of as many floats as a register holds.
struct Many {
    typedef Wide D;
    static constexpr std::uint32_t kLanes = sizeof(Wide) / sizeof(float);
    static DGM_INLINE D load(const float* p) { return fetch<Wide>(p); }
    static DGM_INLINE WideInts bytes(const std::uint8_t* p) { return wide_bytes(p); }
    template <class Mask>
    static DGM_INLINE D choose(const Mask& c, const D& a, const D& b) {
        return c ? a : b;
    }
    static DGM_INLINE double sum(const D& v) {
        double s = 0;
        for (std::uint32_t k = 0; k < kLanes; ++k) s += static_cast<double>(v[k]);
        return s;
    }
};

template <class D>
struct Triple {
    D x, y, z;
};
template <class D>
static DGM_INLINE Triple<D> minus(const Triple<D>& a, const Triple<D>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class D>
static DGM_INLINE Triple<D> times(const Triple<D>& a, const Triple<D>& b) {
    return {multiply_subtract(a.y, b.z, a.z * b.y), multiply_subtract(a.z, b.x, a.x * b.z),
            multiply_subtract(a.x, b.y, a.y * b.x)};
}
/// c + a x b.
template <class D>
static DGM_INLINE Triple<D> times_plus(const Triple<D>& a, const Triple<D>& b, const Triple<D>& c) {
    return {subtract_product(multiply_add(a.y, b.z, c.x), a.z, b.y),
            subtract_product(multiply_add(a.z, b.x, c.y), a.x, b.z),
            subtract_product(multiply_add(a.x, b.y, c.z), a.y, b.x)};
}
template <class D>
static DGM_INLINE Triple<D> plus(const Triple<D>& a, const Triple<D>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class D>
static DGM_INLINE D inner(const Triple<D>& a, const Triple<D>& b) {
    return multiply_add(a.z, b.z, multiply_add(a.y, b.y, a.x * b.x));
}
/// c + a . b.
template <class D>
static DGM_INLINE D inner_plus(const Triple<D>& a, const Triple<D>& b, const D& c) {
    return multiply_add(a.z, b.z, multiply_add(a.y, b.y, multiply_add(a.x, b.x, c)));
}
/// c - a . b.
template <class D>
static DGM_INLINE D inner_minus(const Triple<D>& a, const Triple<D>& b, const D& c) {
    return subtract_product(subtract_product(subtract_product(c, a.x, b.x), a.y, b.y), a.z, b.z);
}
template <class L>
static DGM_INLINE Triple<typename L::D> place(const ConstPlanes& p, std::size_t k) {
    return {L::load(p.x + k), L::load(p.y + k), L::load(p.z + k)};
}
template <class L, class C>
static DGM_INLINE Triple<typename L::D> either(const C& c, const Triple<typename L::D>& a,
                                               const Triple<typename L::D>& b) {
    return {L::choose(c, a.x, b.x), L::choose(c, a.y, b.y), L::choose(c, a.z, b.z)};
}

/// Corners p q r s of a quad, turned so that it is split along p-r.
template <class D>
struct Corners {
    Triple<D> p, q, r, s;
};
template <class L, class C>
static DGM_INLINE Corners<typename L::D> turned(const C& second, const Triple<typename L::D>& a,
                                                const Triple<typename L::D>& b, const Triple<typename L::D>& c,
                                                const Triple<typename L::D>& d) {
    return {either<L>(second, b, a), either<L>(second, c, b), either<L>(second, d, c), either<L>(second, a, d)};
}
template <class L>
static DGM_INLINE Corners<typename L::D> corners(const QuadJob& j, std::size_t k) {
    const Triple<typename L::D> o{typename L::D{} + j.origin[0], typename L::D{} + j.origin[1],
                                  typename L::D{} + j.origin[2]};
    const std::size_t n = j.cols;
    return turned<L>(L::bytes(j.kind + k) == 1, minus(place<L>(j.at, k), o), minus(place<L>(j.at, k + n), o),
                     minus(place<L>(j.at, k + n + 1), o), minus(place<L>(j.at, k + 1), o));
}

/// Kinds of the quads from k on, of which `left` are asked for; planes are padded for the lanes beyond.
template <class L>
static DGM_INLINE auto kinds_at(const QuadJob& j, std::size_t k, std::uint32_t left) {
    auto kinds = L::bytes(j.kind + k), lanes = kinds;
    for (std::uint32_t a = 0; a < L::kLanes; ++a) lanes[a] = static_cast<int>(a);
    return lanes < static_cast<int>(left) ? kinds : decltype(kinds){} + kQuadNone;
}

/// Quads of a rectangle by strips of as many columns as there are lanes: quad(k, kinds, a, b, c, d) with what load()
/// gave for its corners, row k + 1 of one being row k of the next; then end() of the strip.
template <class L, class Load, class Quad, class End>
static DGM_INLINE void strips(const QuadJob& j, Load load, Quad quad, End end) {
    for (std::uint32_t first = j.rect.j0; first <= j.rect.j1; first += L::kLanes) {
        std::size_t k = static_cast<std::size_t>(j.rect.i0) * j.cols + first;
        auto a = load(k), d = load(k + 1);
        for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i, k += j.cols) {
            const auto b = load(k + j.cols), c = load(k + j.cols + 1);
            quad(k, kinds_at<L>(j, k, j.rect.j1 + 1 - first), a, b, c, d);
            a = b;
            d = c;
        }
        end();
    }
}

double volume(const QuadJob& job) noexcept {
    typedef Four L;
    const QuadJob j = job;
    const Triple<Doubles> o{Doubles{} + j.origin[0], Doubles{} + j.origin[1], Doubles{} + j.origin[2]};
    Doubles six = {};
    strips<L>(
        j, [&](std::size_t k) DGM_INLINED { return minus(place<L>(j.at, k), o); },
        [&](std::size_t, const Longs& kinds, const Triple<Doubles>& a, const Triple<Doubles>& b,
            const Triple<Doubles>& c, const Triple<Doubles>& d) DGM_INLINED {
            const Corners<Doubles> x = turned<L>(kinds == 1, a, b, c, d);
            six += L::choose(kinds != kQuadNone, inner(x.p, times(minus(x.q, x.s), x.r)), Doubles{});
        },
        []() DGM_INLINED {});
    return L::sum(six);
}

/// A corner of a quad and how it moves.
template <class D>
struct Mover {
    Triple<D> at, by;
    WideInts moves;  ///< lanes
};

/// Quads by strips: load(k) gives a corner's place and move, quad(there, p, q, r, s) gets them turned so that all are
/// split along p-r. Mostly all quads of a block are split alike: then nothing is chosen lane by lane.
template <class Load, class Quad, class End>
static DGM_INLINE void moving_strips(const QuadJob& j, Load load, Quad quad, End end) {
    typedef Mover<Wide> M;
    strips<Many>(
        j, load,
        [&](std::size_t, const WideInts& kinds, const M& a, const M& b, const M& c, const M& d) DGM_INLINED {
            if (!any_lane(a.moves | b.moves | c.moves | d.moves)) return;
            const auto second = kinds == 1;
            if (any_lane(second)) {
                const auto at = turned<Many>(second, a.at, b.at, c.at, d.at);
                const auto by = turned<Many>(second, a.by, b.by, c.by, d.by);
                quad(kinds != kQuadNone, M{at.p, by.p, second}, M{at.q, by.q, second}, M{at.r, by.r, second},
                     M{at.s, by.s, second});
            } else {
                quad(kinds != kQuadNone, a, b, c, d);
            }
        },
        end);
}

// A triangle whose corners move evenly sweeps the integral of (mean of the moves) . (its area vector). With t = r - p,
// y = s - q, u = q - p, v = s - p for the edges and b for the moves, six times the rate of a quad's two triangles is
//   f = (b_p + b_r) . (t x y) + t . (v x b_s + b_q x u),
// quadratic along the way: its value half way and a bend. Only differences of coordinates enter: float is enough,
// however far the origin is.
template <bool kTurned>
static DGM_INLINE Wide swept_block(const QuadJob& j, const ConstPlanes& from, std::size_t k, const WideInts& kinds) {
    typedef Many L;
    const auto middle = [](const Triple<Wide>& now, const Triple<Wide>& by) DGM_INLINED {
        const Wide half = Wide{} + 0.5f;
        return Triple<Wide>{subtract_product(now.x, half, by.x), subtract_product(now.y, half, by.y),
                            subtract_product(now.z, half, by.z)};
    };
    const std::size_t at[4] = {k, k + j.cols, k + j.cols + 1, k + 1};
    Corners<Wide> x{place<L>(j.at, at[0]), place<L>(j.at, at[1]), place<L>(j.at, at[2]), place<L>(j.at, at[3])};
    Corners<Wide> m{minus(x.p, place<L>(from, at[0])), minus(x.q, place<L>(from, at[1])),
                    minus(x.r, place<L>(from, at[2])), minus(x.s, place<L>(from, at[3]))};
    if constexpr (kTurned) {
        x = turned<L>(kinds == 1, x.p, x.q, x.r, x.s);
        m = turned<L>(kinds == 1, m.p, m.q, m.r, m.s);
    }
    const Triple<Wide> mt = minus(m.r, m.p), my = minus(m.s, m.q);
    const Triple<Wide> t = middle(minus(x.r, x.p), mt), y = middle(minus(x.s, x.q), my);
    const Wide f = inner(plus(m.p, m.r), times(t, y)), bend = inner(m.p, times(mt, my));
    const Triple<Wide> u = middle(minus(x.q, x.p), minus(m.q, m.p)), v = plus(u, y);
    const Wide six = multiply_add(bend, Wide{} + 0.25f, inner_plus(t, times_plus(m.q, u, times(v, m.s)), f));
    return L::choose(kinds != kQuadNone, six, Wide{});
}

double swept(const QuadJob& job, ConstPlanes from, const std::uint8_t* marks, const float* weight) noexcept {
    const QuadJob j = job;
    Doubles six = {};
    const auto is_still = [&](std::size_t k) DGM_INLINED {
        const auto sunk = [&](std::size_t at) DGM_INLINED { return fetch<std::uint64_t>(marks + at) | marks[at + 8]; };
        if ((sunk(k) | sunk(k + j.cols)) != 0) return false;
        const auto bulged = [&](std::size_t at) DGM_INLINED {
            return fetch<WideInts>(weight + at);  // no weight is -0
        };
        return !any_lane((bulged(k) | bulged(k + 1) | bulged(k + j.cols) | bulged(k + j.cols + 1)) != 0);
    };
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        for (std::uint32_t left = j.rect.j1 - j.rect.j0 + 1;; left -= Many::kLanes, k += Many::kLanes) {
            const WideInts kinds = kinds_at<Many>(j, k, left);
            if (is_still(k)) {
                if (left <= Many::kLanes) break;
                continue;
            }
            if (any_lane(kinds == 1))
                add_to(swept_block<true>(j, from, k, kinds), six);
            else
                add_to(swept_block<false>(j, from, k, kinds), six);
            if (left <= Many::kLanes) break;
        }
    }
    return Four::sum(six);
}

// The rate in fewer operations, which round more coarsely: it is for finding beta. With S = b_p + b_r + b_s, m for the
// moves of the edges, X = m_t x m_y and Z = t x m_y
//   f = S . (t x y) - u . Z,   f' = S . (Z + m_t x y) - u . X - m_u . Z,   f'' / 2 = 3 b_p . X.
void cubic(const QuadJob& job, ConstPlanes normal, const float* weight, double* out) noexcept {
    typedef Many L;
    typedef Wide D;
    const QuadJob j = job;
    D sums[3] = {};
    moving_strips(
        j,
        [&](std::size_t k) DGM_INLINED {
            const D w = L::load(weight + k);
            const Triple<D> n = place<L>(normal, k);
            return Mover<D>{place<L>(j.at, k), {w * n.x, w * n.y, w * n.z}, w > 0.0f};
        },
        [&](const auto& there, const Mover<D>& p, const Mover<D>& q, const Mover<D>& r, const Mover<D>& s) DGM_INLINED {
            const Triple<D> t = minus(r.at, p.at), y = minus(s.at, q.at), u = minus(q.at, p.at);
            const Triple<D> mt = minus(r.by, p.by), my = minus(s.by, q.by);
            const Triple<D> both = plus(plus(p.by, r.by), s.by), turn = times(mt, my), z = times(t, my);
            sums[0] += L::choose(there, inner_minus(u, z, inner(both, times(t, y))), D{});
            const D begun = inner_minus(u, turn, inner(both, times_plus(mt, y, z)));
            const D slope = inner_minus(minus(q.by, p.by), z, begun);
            sums[1] += L::choose(there, 0.5f * slope, D{});
            sums[2] += L::choose(there, inner(p.by, turn), D{});
        },
        [&]() DGM_INLINED {
            for (int a = 0; a < 3; ++a) {
                out[a] += L::sum(sums[a]);
                sums[a] = D{};
            }
        });
}

double area(const QuadJob& job, const std::uint8_t* marks) noexcept {
    typedef Many L;
    const QuadJob j = job;
    double sum = 0;
    Wide area = {};
    strips<L>(
        j, [&](std::size_t k) DGM_INLINED { return place<L>(j.at, k); },
        [&](std::size_t k, const WideInts& kinds, const Triple<Wide>& a, const Triple<Wide>& b, const Triple<Wide>& c,
            const Triple<Wide>& d) DGM_INLINED {
            const Triple<Wide> v = times(minus(c, a), minus(d, b));
            const auto counts = (L::bytes(marks + k) & 1) > (kinds >> 1);
            area += L::choose(counts, 0.5f * square_root(inner(v, v)), Wide{});
        },
        [&]() DGM_INLINED {
            sum += L::sum(area);
            area = Wide{};
        });
    return sum;
}

#include "rows/contact_rows_marks.h"

/// exp(-x) for 0 <= x <= 64 within 2e-7: a Taylor polynomial of exp(-x / 64), squared six times.
template <class F>
static DGM_INLINE F decay(F x) {
    const F y = x * (1.0f / 64);
    F e = 1.0f - y * (1.0f - y * (0.5f - y * (1.0f / 6 - y * (1.0f / 24 - y * (1.0f / 120 - y * (1.0f / 720))))));
    e = e * e;
    e = e * e;
    e = e * e;
    e = e * e;
    e = e * e;
    return e * e;
}

template <class F>
static DGM_INLINE F weight_of(const WeightJob& j, float scale, std::size_t k) {
    const F square = fetch<F>(j.square + k), zero = F{};
    const auto in = square < j.limit;
    const F x = (in ? square : zero) * j.factor;
    F w = (decay(x) - j.end * (1.0f + (j.slope - x))) * scale;
    if (j.mobility != nullptr) w = w * fetch<F>(j.mobility + k);
    w = in ? w : zero;
    return w > 0.0f ? w : zero;
}

WeightSums weights(const WeightJob& job) noexcept {
    const WeightJob j = job;
    const float scale = 1.0f / (1.0f - j.end * (1.0f + j.slope));
    WeightSums sums;
    WideInts count = {};
    Wide top = {}, total = {};
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        for (; k + Many::kLanes <= end; k += Many::kLanes) {
            if (!any_lane(fetch<Wide>(j.square + k) < j.limit)) {
                put_raw(j.weight + k, Wide{});
                continue;
            }
            const Wide w = weight_of<Wide>(j, scale, k);
            put_raw(j.weight + k, w);
            count -= w > 0.0f;
            top = w > top ? w : top;
            total += w;
        }
        for (; k < end; ++k) {
            const float w = weight_of<float>(j, scale, k);
            j.weight[k] = w;
            sums.count += w > 0 ? 1 : 0;
            sums.largest = w > sums.largest ? w : sums.largest;
            sums.total += static_cast<double>(w);
        }
    }
    sums.total += Many::sum(total);
    for (std::uint32_t lane = 0; lane < Many::kLanes; ++lane) {
        sums.count += static_cast<std::uint32_t>(count[lane]);
        sums.largest = top[lane] > sums.largest ? top[lane] : sums.largest;
    }
    return sums;
}

void spread(const SpreadJob& job) noexcept {
    SpreadJob j = job;
    float d[9], across[3][8];
    for (int k = 0; k < 9; ++k) {
        const float root = __builtin_sqrtf(__builtin_fabsf(j.nodes[k]));
        d[k] = j.nodes[k] < 0 ? -root : root;
    }
    for (int m = 0; m < 3; ++m)
        for (int k = 0; k < 8; ++k) {
            const float from = d[3 * m + k / 4], to = d[3 * m + k / 4 + 1];
            across[m][k] = from + (to - from) * (0.25f * static_cast<float>(k % 4));
        }
    for (int i = 0; i < 8; ++i) {
        const float share = 0.25f * static_cast<float>(i % 4);
        for (std::uint32_t k = 0; k < 8; k += Many::kLanes) {
            const Wide from = fetch<Wide>(across[i / 4] + k), to = fetch<Wide>(across[i / 4 + 1] + k);
            const Wide v = from + (to - from) * share;
            const Wide square = v > 0.0f ? v * v : Wide{};
            const auto inside = (wide_bytes(j.marks + k) & 1) != 0;
            put_raw(j.square + k, Wide(inside ? Wide{} + __builtin_inff() : square));
        }
        j.marks += j.cols;
        j.square += j.cols;
    }
}

// In float: it is the result's own precision, and the volume is measured afterwards.
template <class F>
static DGM_INLINE void bulge_block(const BulgeJob& j, std::size_t k) {
    const F w = fetch<F>(j.weight + k);
    const auto moving = w > 0.0f;
    if constexpr (sizeof(F) == sizeof(Wide))
        if (!any_lane(moving)) return;
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

// Samples taken beyond the plane go back along its normal n by h: with t, u, v as above a quad loses
//   n . (area vectors weighed with h) = (T . v) (h_p + h_r + h_s) - (T . u) (h_p + h_r + h_q), T = n x t.
double held_back(const QuadJob& job, const HoldJob& hold_job) noexcept {
    typedef Many L;
    typedef Wide D;
    const QuadJob j = job;
    const HoldJob hold = hold_job;
    double sum = 0;
    struct Held {
        Triple<D> at;
        D back;
    };
    const Triple<D> n{D{} + hold.n[0], D{} + hold.n[1], D{} + hold.n[2]};
    D six = {};
    strips<L>(
        j,
        [&](std::size_t k) DGM_INLINED {
            const D w = L::load(hold.weight + k), step = w * hold.beta;
            const Triple<D> now = place<L>(j.at, k), by = place<L>(hold.normal, k);
            const Triple<D> at{multiply_add(step, by.x, now.x), multiply_add(step, by.y, now.y),
                               multiply_add(step, by.z, now.z)};
            const D height = inner(n, at) - hold.d;
            return Held{at, L::choose((w > 0.0f) & (height < 0.0f), height, D{})};
        },
        [&](std::size_t, const WideInts& kinds, const Held& a, const Held& b, const Held& c, const Held& d)
            DGM_INLINED {
                if (!any_lane(a.back + b.back + c.back + d.back < 0.0f)) return;
                const auto second = kinds == 1;
                const Corners<D> x = turned<L>(second, a.at, b.at, c.at, d.at);
                const D both = L::choose(second, b.back + d.back, a.back + c.back);
                const Triple<D> t = minus(x.r, x.p), side = times(n, t);
                const D far = both + L::choose(second, a.back, d.back), near = both + L::choose(second, c.back, b.back);
                const D lost = inner(side, minus(x.s, x.p)) * far - inner(side, minus(x.q, x.p)) * near;
                six += L::choose(kinds != kQuadNone, lost, D{});
            },
        [&]() DGM_INLINED {
            sum += L::sum(six);
            six = D{};
        });
    return sum;
}
