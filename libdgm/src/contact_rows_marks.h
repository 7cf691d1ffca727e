// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows_marks.h
// Bodies of contact_rows.h that find samples beyond an obstacle and bring them out. Included by contact_rows_impl.h.
//
// Distances are in double, by the same single operations as probe() in obstacle.cpp: a sample gets the same bits in a
// lane, alone, and there.

struct HalfSpace {
    double n[3], d;
    explicit HalfSpace(const MarkJob& j) : n{j.a[0], j.a[1], j.a[2]}, d(j.d) {}
    template <class L, class D>
    inline __attribute__((always_inline)) D distance(const Triple<D>& p) const {
        return n[0] * p.x + n[1] * p.y + n[2] * p.z - d;
    }
    template <class L, class D>
    inline __attribute__((always_inline)) Triple<D> out(const Triple<D>& p, const D& distance) const {
        return {p.x - distance * n[0], p.y - distance * n[1], p.z - distance * n[2]};
    }
};

/// Around a segment; around a point where kSegment is false.
template <bool kSegment>
struct Round {
    double a[3], along[3], square, radius;
    explicit Round(const MarkJob& j)
        : a{j.a[0], j.a[1], j.a[2]}, along{j.along[0], j.along[1], j.along[2]}, square(j.square), radius(j.d) {}
    template <class L, class D>
    inline __attribute__((always_inline)) Triple<D> centre(const Triple<D>& p) const {
        if constexpr (!kSegment) return {D{} + a[0], D{} + a[1], D{} + a[2]};
        const D share = ((p.x - a[0]) * along[0] + (p.y - a[1]) * along[1] + (p.z - a[2]) * along[2]) / square;
        const D one = D{} + 1.0, t = L::choose(share < 0.0, D{}, L::choose(share > 1.0, one, share));
        return {a[0] + t * along[0], a[1] + t * along[1], a[2] + t * along[2]};
    }
    template <class L, class D>
    inline __attribute__((always_inline)) D length(const Triple<D>& v) const {
        return square_root(v.x * v.x + v.y * v.y + v.z * v.z);
    }
    template <class L, class D>
    inline __attribute__((always_inline)) D distance(const Triple<D>& p) const {
        return length<L>(minus(p, centre<L>(p))) - radius;
    }
    template <class L, class D>
    inline __attribute__((always_inline)) Triple<D> nearest(const Triple<D>& p) const {
        const Triple<D> c = centre<L>(p), v = minus(p, c);
        const D far = length<L>(v), share = 1.0 / far;
        // At the centre every way out is as good.
        const auto none = far == 0.0;
        const Triple<D> way = {L::choose(none, D{}, share * v.x), L::choose(none, D{}, share * v.y),
                               L::choose(none, D{} + 1.0, share * v.z)};
        return {c.x + radius * way.x, c.y + radius * way.y, c.z + radius * way.z};
    }
    template <class L, class D>
    inline __attribute__((always_inline)) Triple<D> out(const Triple<D>& p, const D&) const {
        const Triple<D> to = minus(nearest<L>(p), p);
        return {p.x + to.x, p.y + to.y, p.z + to.z};
    }
};

template <class Mask>
static inline __attribute__((always_inline)) bool any_of(const Mask& v) {
    if constexpr (sizeof(Mask) == sizeof(Longs))
        return lane_bits(reinterpret_cast<Longs>(v)) != 0;
    else
        return v != 0;
}
/// Sets bit 0 of four bytes by the bits of `lanes`.
static inline __attribute__((always_inline)) void mark_lanes(std::uint8_t* marks, unsigned lanes) {
    put_raw(marks, fetch<std::uint32_t>(marks) | ((lanes * 0x00204081u) & 0x01010101u));
}

template <class L, class Mask>
static inline __attribute__((always_inline)) void put_if(const Mask& c, const Triple<typename L::D>& v, const Planes& to,
                                                         std::size_t k) {
    L::store(to.x + k, L::choose(c, v.x, L::load(to.x + k)));
    L::store(to.y + k, L::choose(c, v.y, L::load(to.y + k)));
    L::store(to.z + k, L::choose(c, v.z, L::load(to.z + k)));
}

template <class Obstacle>
static inline __attribute__((always_inline)) void mark_beyond(const MarkJob& job, MarkSums& sums) {
    const MarkJob j = job;
    const Obstacle o(j);
    double deepest = sums.deepest, total = 0;
    std::uint32_t count = 0;
    Doubles deep = {}, totals = {};
    const double limit = -j.tolerance;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * j.cols + j.rect.j0;
        const std::size_t end = k + j.rect.j1 - j.rect.j0 + 1;
        for (; k + 4 <= end; k += 4) {
            const Triple<Doubles> p = place<Four>(j.at, k);
            const Doubles d = o.template distance<Four>(p);
            const Longs in = (d < limit) & (four_bytes(j.skip + k) == 0);
            const unsigned bits = lane_bits(in);
            if (bits == 0) continue;
            mark_lanes(j.marks + k, bits);
            put_if<Four>(in, o.template out<Four>(p, d), j.to, k);
            const Doubles depth = in ? -d : Doubles{};
            deep = depth > deep ? depth : deep;
            totals += depth;
            count += static_cast<std::uint32_t>(__builtin_popcount(bits));
        }
        for (; k < end; ++k) {
            const Triple<double> p = place<One>(j.at, k);
            const double d = o.template distance<One>(p);
            if (!(d < limit) || j.skip[k] != 0) continue;
            j.marks[k] |= 1;
            put_if<One>(true, o.template out<One>(p, d), j.to, k);
            deepest = -d > deepest ? -d : deepest;
            total -= d;
            ++count;
        }
    }
    for (int lane = 0; lane < 4; ++lane) deepest = deep[lane] > deepest ? deep[lane] : deepest;
    sums.deepest = deepest;
    sums.total += total + Four::sum(totals);
    sums.count += count;
}

void mark(const MarkJob& job, MarkSums& sums) noexcept {
    if (job.kind == Beyond::kPlane)
        mark_beyond<HalfSpace>(job, sums);
    else if (job.square > 0)
        mark_beyond<Round<true>>(job, sums);
    else
        mark_beyond<Round<false>>(job, sums);
}

template <class Obstacle>
static inline __attribute__((always_inline)) void put_back_from(const MarkJob& job, const float* weight, const Planes& at) {
    const MarkJob j = job;
    const Obstacle o(j);
    each_row(
        j.rect, j.cols, [&](auto lanes, std::size_t k) __attribute__((always_inline)) {
            typedef decltype(lanes) L;
            const auto p = place<L>({at.x, at.y, at.z}, k);
            const auto in = (o.template distance<L>(p) < 0.0) & (L::load(weight + k) > 0.0);
            if (!any_of(in)) return;
            put_if<L>(in, o.template nearest<L>(p), at, k);
        });
}

void put_back(const MarkJob& job, const float* weight, Planes at) noexcept {
    if (job.square > 0)
        put_back_from<Round<true>>(job, weight, at);
    else
        put_back_from<Round<false>>(job, weight, at);
}

void exchange(const std::uint8_t* marks, Planes now, Planes saved, const Rect& rect, std::uint32_t cols) noexcept {
    const Rect r = rect;
    for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * cols + r.j0;
        const std::size_t end = k + r.j1 - r.j0 + 1;
        const auto swap = [](float* a, float* b, bool both) {
            const float old = *a;
            *a = both ? *b : old;
            *b = old;
        };
        for (; k + Many::kLanes <= end; k += Many::kLanes) {
            const WideInts in = (wide_bytes(marks + k) & 1) != 0;
            const Wide x = fetch<Wide>(now.x + k), y = fetch<Wide>(now.y + k), z = fetch<Wide>(now.z + k);
            if (any_lane(in)) {
                put_raw(now.x + k, Wide(in ? fetch<Wide>(saved.x + k) : x));
                put_raw(now.y + k, Wide(in ? fetch<Wide>(saved.y + k) : y));
                put_raw(now.z + k, Wide(in ? fetch<Wide>(saved.z + k) : z));
            }
            put_raw(saved.x + k, x);
            put_raw(saved.y + k, y);
            put_raw(saved.z + k, z);
        }
        for (; k < end; ++k) {
            const bool in = (marks[k] & 1) != 0;
            swap(now.x + k, saved.x + k, in);
            swap(now.y + k, saved.y + k, in);
            swap(now.z + k, saved.z + k, in);
        }
    }
}

/// How far samples in front of k moved, those that are members.
static inline __attribute__((always_inline)) Triple<Doubles> moved(const SmoothJob& j, std::size_t k) {
    const Longs member = (four_bytes(j.marks + k) & 4) != 0;
    const Triple<Doubles> by = minus(place<Four>(j.now, k), place<Four>(j.before, k));
    return {member ? by.x : Doubles{}, member ? by.y : Doubles{}, member ? by.z : Doubles{}};
}

void smooth(const SmoothJob& job) noexcept {
    typedef float FourFloats __attribute__((vector_size(16)));
    const SmoothJob j = job;
    for (std::uint32_t i = j.rect.i0; i <= j.rect.i1; ++i)
        for (std::uint32_t first = j.rect.j0; first <= j.rect.j1; first += 4) {
            const std::size_t k = static_cast<std::size_t>(i) * j.cols + first;
            std::uint32_t marks = fetch<std::uint32_t>(j.marks + k) & ~0x08080808u;
            if ((marks & 0x04040404u) == 0) continue;
            const Triple<Doubles> zero{}, own = moved(j, k);
            const Triple<Doubles> sum = plus(
                plus(plus(plus(zero, moved(j, k - j.cols)), moved(j, k - 1)), moved(j, k + 1)), moved(j, k + j.cols));
            const auto mean = [&](const Doubles& a, const Doubles& b) __attribute__((always_inline)) {
                return 0.5 * a + 0.125 * b;
            };
            Triple<Doubles> d{mean(own.x, sum.x), mean(own.y, sum.y), mean(own.z, sum.z)};
            if (j.mobility != nullptr) {
                const Doubles m = load_four(j.mobility + k);
                d = {m * d.x, m * d.y, m * d.z};
            }
            const FourFloats x = __builtin_convertvector(d.x, FourFloats), y = __builtin_convertvector(d.y, FourFloats),
                             z = __builtin_convertvector(d.z, FourFloats);
            put_raw(j.x + k, x);
            put_raw(j.y + k, y);
            put_raw(j.z + k, z);
            const Longs bytes = four_bytes(j.marks + k);
            const auto none = [&](const FourFloats& v) __attribute__((always_inline)) {
                return __builtin_convertvector(v == 0.0f, Longs);
            };
            const Longs still = none(x) & none(y) & none(z) & (own.x == 0.0) & (own.y == 0.0) & (own.z == 0.0) &
                                ((bytes & 1) == 0);
            const unsigned lanes = lane_bits(~still & ((bytes & 4) != 0));
            put_raw(j.marks + k, marks | (((lanes * 0x00204081u) & 0x01010101u) << 3));
        }
}
