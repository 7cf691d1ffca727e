// SPDX-License-Identifier: MIT
// libdgm/src/rows/contact_rows_marks.h
// Bodies of contact_rows.h that find samples beyond an obstacle and bring them out. Included by contact_rows_impl.h.
//
// Distances are in double, by the same single operations as probe() in obstacle.cpp: a sample gets the same bits in a
// lane, alone, and there.

struct HalfSpace {
    double n[3], d;
    explicit HalfSpace(const MarkJob& j) : n{j.a[0], j.a[1], j.a[2]}, d(j.d) {}
    template <class L, class D>
    DGM_INLINE D distance(const Triple<D>& p) const {
        return n[0] * p.x + n[1] * p.y + n[2] * p.z - d;
    }
    template <class L, class D>
    DGM_INLINE Triple<D> out(const Triple<D>& p, const D& distance) const {
        return {p.x - distance * n[0], p.y - distance * n[1], p.z - distance * n[2]};
    }
};

/// Around a segment, which may be a point.
struct Round {
    double a[3], along[3], square, radius;
    explicit Round(const MarkJob& j)
        : a{j.a[0], j.a[1], j.a[2]}, along{j.along[0], j.along[1], j.along[2]}, square(j.square), radius(j.d) {}
    template <class L, class D>
    DGM_INLINE Triple<D> centre(const Triple<D>& p) const {
        const D share = ((p.x - a[0]) * along[0] + (p.y - a[1]) * along[1] + (p.z - a[2]) * along[2]) / square;
        const D one = D{} + 1.0, t = L::choose(share < 0.0, D{}, L::choose(share > 1.0, one, share));
        return {a[0] + t * along[0], a[1] + t * along[1], a[2] + t * along[2]};
    }
    template <class L, class D>
    DGM_INLINE D distance(const Triple<D>& p) const {
        const Triple<D> v = minus(p, centre<L>(p));
        return square_root(v.x * v.x + v.y * v.y + v.z * v.z) - radius;
    }
    template <class L, class D>
    DGM_INLINE Triple<D> nearest(const Triple<D>& p) const {
        const Triple<D> c = centre<L>(p), v = minus(p, c);
        const D far = square_root(v.x * v.x + v.y * v.y + v.z * v.z), share = 1.0 / far;
        // At the centre every way out is as good.
        const auto none = far == 0.0;
        const Triple<D> way = {L::choose(none, D{}, share * v.x), L::choose(none, D{}, share * v.y),
                               L::choose(none, D{} + 1.0, share * v.z)};
        return {c.x + radius * way.x, c.y + radius * way.y, c.z + radius * way.z};
    }
    template <class L, class D>
    DGM_INLINE Triple<D> out(const Triple<D>& p, const D&) const {
        const Triple<D> to = minus(nearest<L>(p), p);
        return {p.x + to.x, p.y + to.y, p.z + to.z};
    }
};

/// Sets bit 0 of four bytes by the bits of `lanes`.
static DGM_INLINE void mark_lanes(std::uint8_t* marks, unsigned lanes) {
    put_raw(marks, fetch<std::uint32_t>(marks) | ((lanes * 0x00204081u) & 0x01010101u));
}

template <class L, class Mask>
static DGM_INLINE void put_if(const Mask& c, const Triple<typename L::D>& v, const Planes& to, std::size_t k) {
    L::store(to.x + k, L::choose(c, v.x, L::load(to.x + k)));
    L::store(to.y + k, L::choose(c, v.y, L::load(to.y + k)));
    L::store(to.z + k, L::choose(c, v.z, L::load(to.z + k)));
}

/// The first `left` of four lanes; planes are padded for the others.
static DGM_INLINE Longs first_lanes(std::size_t left) {
    return Longs{0, 1, 2, 3} < static_cast<long long>(left);
}

/// Calls lanes(k, left) for four samples at a time, or alone(k) for each.
template <class Lanes, class Alone>
static DGM_INLINE void each_four(const Rect& rect, std::uint32_t cols, Lanes lanes, Alone alone) {
    for (std::uint32_t i = rect.i0; i <= rect.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * cols + rect.j0;
        const std::size_t end = k + rect.j1 - rect.j0 + 1;
        if constexpr (kFourDoubles)
            for (; k < end; k += 4) lanes(k, end - k);
        else
            for (; k < end; ++k) alone(k);
    }
}

template <class Obstacle>
static DGM_INLINE void mark_beyond(const MarkJob& job, MarkSums& sums) {
    const MarkJob j = job;
    const Obstacle o(j);
    const double limit = -j.tolerance;
    double deepest = sums.deepest, total = 0;
    std::uint32_t count = 0;
    Doubles deep = {}, totals = {};
    each_four(
        j.rect, j.cols,
        [&](std::size_t k, std::size_t left) DGM_INLINED {
            const Triple<Doubles> p = place<Four>(j.at, k);
            const Doubles d = o.template distance<Four>(p);
            const Longs in = (d < limit) & (four_bytes(j.skip + k) == 0) & first_lanes(left);
            const unsigned bits = lane_bits(in);
            if (bits == 0) return;
            mark_lanes(j.marks + k, bits);
            put_if<Four>(in, o.template out<Four>(p, d), j.to, k);
            const Doubles depth = in ? -d : Doubles{};
            deep = depth > deep ? depth : deep;
            totals += depth;
            count += static_cast<std::uint32_t>(__builtin_popcount(bits));
        },
        [&](std::size_t k) DGM_INLINED {
            const Triple<double> p = place<One>(j.at, k);
            const double d = o.template distance<One>(p);
            if (!(d < limit) || j.skip[k] != 0) return;
            j.marks[k] |= 1;
            put_if<One>(true, o.template out<One>(p, d), j.to, k);
            deepest = -d > deepest ? -d : deepest;
            total -= d;
            ++count;
        });
    for (int lane = 0; lane < 4; ++lane) deepest = deep[lane] > deepest ? deep[lane] : deepest;
    sums.deepest = deepest;
    sums.total += total + Four::sum(totals);
    sums.count += count;
}

void mark(const MarkJob& job, MarkSums& sums) noexcept {
    if (job.kind == Beyond::kPlane)
        mark_beyond<HalfSpace>(job, sums);
    else
        mark_beyond<Round>(job, sums);
}

void put_back(const MarkJob& job, const float* weight, Planes at) noexcept {
    const MarkJob j = job;
    const Round o(j);
    const ConstPlanes from{at.x, at.y, at.z};
    each_four(
        j.rect, j.cols,
        [&](std::size_t k, std::size_t left) DGM_INLINED {
            const Triple<Doubles> p = place<Four>(from, k);
            const Longs in = (o.template distance<Four>(p) < 0.0) & (load_four(weight + k) > 0.0) & first_lanes(left);
            if (lane_bits(in) != 0) put_if<Four>(in, o.template nearest<Four>(p), at, k);
        },
        [&](std::size_t k) DGM_INLINED {
            const Triple<double> p = place<One>(from, k);
            if (weight[k] > 0 && o.template distance<One>(p) < 0) put_if<One>(true, o.template nearest<One>(p), at, k);
        });
}

__attribute__((noinline)) static void exchange_plane(const std::uint8_t* marks, float* now, float* saved, const Rect& r,
                                                     std::uint32_t cols) {
    for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
        std::size_t k = static_cast<std::size_t>(i) * cols + r.j0;
        const std::size_t end = k + r.j1 - r.j0 + 1;
        for (; k + Many::kLanes <= end; k += Many::kLanes) {
            const Wide old = fetch<Wide>(now + k);
            const WideInts in = (wide_bytes(marks + k) & 1) != 0;
            put_raw(now + k, Wide(in ? fetch<Wide>(saved + k) : old));
            put_raw(saved + k, old);
        }
        for (; k < end; ++k) {
            const float old = now[k];
            if ((marks[k] & 1) != 0) now[k] = saved[k];
            saved[k] = old;
        }
    }
}

void exchange(const std::uint8_t* marks, Planes now, Planes saved, const Rect& rect, std::uint32_t cols) noexcept {
    exchange_plane(marks, now.x, saved.x, rect, cols);
    exchange_plane(marks, now.y, saved.y, rect, cols);
    exchange_plane(marks, now.z, saved.z, rect, cols);
}

/// How far samples from k on moved, those that are members.
template <class L>
static DGM_INLINE Triple<typename L::D> moved(const SmoothJob& j, std::size_t k) {
    typedef typename L::D D;
    const auto member = (L::bytes(j.marks + k) & 4) != 0;
    const Triple<D> by = minus(place<L>(j.now, k), place<L>(j.before, k));
    return {L::choose(member, by.x, D{}), L::choose(member, by.y, D{}), L::choose(member, by.z, D{})};
}

/// @return for each lane whether the sample moves, has moved, or is marked.
template <class L>
static DGM_INLINE auto smooth_block(const SmoothJob& j, std::size_t k) {
    typedef typename L::D D;
    const Triple<D> zero{}, own = moved<L>(j, k);
    const Triple<D> sum = plus(plus(plus(plus(zero, moved<L>(j, k - j.cols)), moved<L>(j, k - 1)), moved<L>(j, k + 1)),
                               moved<L>(j, k + j.cols));
    Triple<D> d{0.5 * own.x + 0.125 * sum.x, 0.5 * own.y + 0.125 * sum.y, 0.5 * own.z + 0.125 * sum.z};
    if (j.mobility != nullptr) {
        const D m = L::load(j.mobility + k);
        d = {m * d.x, m * d.y, m * d.z};
    }
    L::store_bits(j.x + k, d.x);
    L::store_bits(j.y + k, d.y);
    L::store_bits(j.z + k, d.z);
    return L::either_not_zero(own.x, own.y, own.z, L::rounded(d.x), L::rounded(d.y), L::rounded(d.z),
                              L::bytes(j.marks + k) & 1);
}

void smooth(const SmoothJob& job) noexcept {
    const SmoothJob j = job;
    each_four(
        j.rect, j.cols,
        [&](std::size_t k, std::size_t) DGM_INLINED {
            const std::uint32_t marks = fetch<std::uint32_t>(j.marks + k) & ~0x08080808u;
            if ((marks & 0x04040404u) == 0) return;
            const unsigned lanes = lane_bits(smooth_block<Four>(j, k));
            put_raw(j.marks + k, marks | (((lanes * 0x00204081u) & 0x01010101u) << 3 & (marks << 1)));
        },
        [&](std::size_t k) DGM_INLINED {
            if ((j.marks[k] & 4) == 0) return;
            const bool moves = smooth_block<One>(j, k);
            j.marks[k] = static_cast<std::uint8_t>((j.marks[k] & ~8) | (moves ? 8 : 0));
        });
}
