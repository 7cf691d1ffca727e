// SPDX-License-Identifier: MIT
// libdgm/src/physics/kernels_impl.h
// Bodies of the loops for one number of lanes. Included inside a namespace, after Floats, Ints, kLanes and root().

#include "rows/vectors.h"

static DGM_INLINE V3 choose(const Ints& c, const V3& a, const V3& b) {
    return {c ? a.x : b.x, c ? a.y : b.y, c ? a.z : b.z};
}
static DGM_INLINE const float* block_of(const float* stencil, std::size_t s, std::size_t entries) {
    return stencil + blocked(s, 0, entries);
}

static void sweep(const SweepJob& job) noexcept {
    const std::ptrdiff_t n = job.cols;
    const Floats keep = all(job.keep), step = all(job.step), carry = all(job.carry);
    for (std::size_t at = 0; at < job.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const float* c = block_of(job.stencil, at, kNear);
        V3 sum{};
#pragma GCC unroll 3
        for (int di = -1; di <= 1; ++di)
#pragma GCC unroll 3
            for (int dj = -1; dj <= 1; ++dj, c += kBlock) sum = sum + load(c) * load(job.way, s + di * n + dj);
        const V3 way = load(job.way, s);
        const V3 r = load(job.residual, s) - (sum + load(job.extra + s) * way);
        store(job.residual, s, r);
        if (job.next.p[0] == nullptr) continue;
        const V3 next = keep * way + (step * load(job.inverse + s)) * r;
        store(job.next, s, next);
        store(job.sum, s, load(job.sum, s) + (next + carry * way));
    }
}

static void near(const NearJob& job) noexcept {
    const std::ptrdiff_t n = job.cols;
    for (std::size_t at = 0; at < job.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const float* c = block_of(job.stencil, at, kNear);
        const V3 middle = job.differences ? load(job.from, s) : V3{};
        V3 sum{};
#pragma GCC unroll 3
        for (int di = -1; di <= 1; ++di)
#pragma GCC unroll 3
            for (int dj = -1; dj <= 1; ++dj, c += kBlock)
                sum = sum + load(c) * (load(job.from, s + di * n + dj) - middle);
        store(job.to, s, sum);
    }
}

/// Corners of a quad: rest and displacement.
struct Corner {
    V3 rest, moved;
};
static DGM_INLINE V3 edge(const Corner& to, const Corner& from) {
    return (to.rest - from.rest) + (to.moved - from.moved);
}
struct Quad {
    Corner a, b, c, d;
    Ints other;  ///< diagonal 1
};
static DGM_INLINE Quad load_quad(const Quads& on, std::ptrdiff_t s) {
    const auto corner = [&](std::ptrdiff_t k) DGM_INLINED { return Corner{load(on.rest, k), load(on.moved, k)}; };
    return {corner(s), corner(s + on.cols), corner(s + on.cols + 1), corner(s + 1), load(on.other + s) > 0.5f};
}
static DGM_INLINE Corner choose(const Ints& c, const Corner& a, const Corner& b) {
    return {choose(c, a.rest, b.rest), choose(c, a.moved, b.moved)};
}
/// Deformation gradient of a triangle in its rest plane, and the invariants of its stretch S = (F^T F)^(1/2).
struct Gradient {
    V3 f1, f2, e1, e2;
    Floats i11, i12, i22, weight;
    Floats c11, c12, c22;  ///< F^T F
    Floats j, trace;       ///< det S and tr S
};
static DGM_INLINE Gradient gradient_of(const V3& e1, const V3& e2, const float* data) {
    Gradient g;
    g.e1 = e1;
    g.e2 = e2;
    g.i11 = load(data);
    g.i12 = load(data + kBlock);
    g.i22 = load(data + 2 * kBlock);
    g.weight = load(data + 3 * kBlock);
    g.f1 = g.i11 * e1;
    g.f2 = g.i12 * e1 + g.i22 * e2;
    g.c11 = dot(g.f1, g.f1);
    g.c12 = dot(g.f1, g.f2);
    g.c22 = dot(g.f2, g.f2);
    // The cross product, not c11 c22 - c12^2, which cancels.
    const V3 n = cross(g.f1, g.f2);
    g.j = root(dot(n, n));
    g.trace = root(g.c11 + g.c22 + 2.0f * g.j);
    return g;
}

struct Push {
    V3 one, two;  ///< gradient by the ends of the first and second edge
    Floats energy;
};
/// Energy  weight (mu |F - R|^2 + lambda/2 (tr S - 2)^2)  and its gradient; R = (F + cof F) / tr S is the nearest
/// rotation. Below kThin the cofactor of a collapsed triangle has no direction and is left out.
static DGM_INLINE Push membrane(const Gradient& g, float shear, float dilate, const float* const* stretch,
                                float viscous, std::ptrdiff_t s) {
    const float thin = 1e-6f;
    const Floats over = 1.0f / larger(g.j, all(thin)), by_trace = 1.0f / larger(g.trace, all(thin));
    const V3 r1 = by_trace * (g.f1 + (g.c22 * over) * g.f1 - (g.c12 * over) * g.f2);
    const V3 r2 = by_trace * (g.f2 + (g.c11 * over) * g.f2 - (g.c12 * over) * g.f1);
    const Floats growth = g.trace - 2.0f;
    // tr C - 2 tr S + 2 cancels where S is nearly 1; (s1 - 1)^2 + (s2 - 1)^2 = (growth^2 + (s1 - s2)^2) / 2 does not.
    const Floats skew = (g.c11 - g.c22) * (g.c11 - g.c22) + 4.0f * g.c12 * g.c12;
    const Floats apart = skew * by_trace * by_trace;
    Push p;
    p.energy = g.weight * ((0.5f * shear) * (growth * growth + apart) + (0.5f * dilate) * growth * growth);
    const Floats turn = dilate * growth - 2.0f * shear;
    V3 p1 = (2.0f * shear) * g.f1 + turn * r1, p2 = (2.0f * shear) * g.f2 + turn * r2;
    if (stretch != nullptr) {
        const Floats s11 = load(stretch[0] + s), s12 = load(stretch[1] + s), s22 = load(stretch[2] + s);
        p1 = p1 + viscous * (g.f1 - s11 * r1 - s12 * r2);
        p2 = p2 + viscous * (g.f2 - s12 * r1 - s22 * r2);
    }
    p.one = g.weight * (g.i11 * p1 + g.i12 * p2);
    p.two = (g.weight * g.i22) * p2;
    return p;
}

static void quads(const QuadJob& job) noexcept {
    for (std::size_t at = 0; at < job.on.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const Quad q = load_quad(job.on, s);
        const float* data = block_of(job.on.data, at, kQuadData);
        // Triangles (a, b, third) and (first, c, d).
        const Corner third = choose(q.other, q.d, q.c), first = choose(q.other, q.b, q.a);
        const Gradient g = gradient_of(edge(q.b, q.a), edge(third, q.a), data);
        const Gradient h = gradient_of(edge(q.c, first), edge(q.d, first), data + 4 * kBlock);
        const Push p = membrane(g, job.shear, job.dilate, job.stretch, job.viscous, s);
        const Push o =
            membrane(h, job.shear, job.dilate, job.stretch == nullptr ? nullptr : job.stretch + 3, job.viscous, s);
        const V3 none{}, p0 = none - p.one - p.two, o0 = none - o.one - o.two;
        store(job.corner[0], s, p0 + choose(q.other, none, o0));
        store(job.corner[1], s, p.one + choose(q.other, o0, none));
        store(job.corner[2], s, o.one + choose(q.other, none, p.two));
        store(job.corner[3], s, o.two + choose(q.other, p.two, none));
        const Floats zero{};
        const Ints is1 = g.weight > 0.0f, is2 = h.weight > 0.0f;
        const V3 t1 = cross(g.e1, g.e2), t2 = cross(h.e1, h.e2);
        store(job.area[0], s, {is1 ? t1.x : zero, is1 ? t1.y : zero, is1 ? t1.z : zero});
        store(job.area[1], s, {is2 ? t2.x : zero, is2 ? t2.y : zero, is2 ? t2.z : zero});
        store(job.energy + s, p.energy + o.energy);
    }
}

static DGM_INLINE void store_stretch(const Gradient& g, float* const* to, std::ptrdiff_t s) {
    const Floats by_trace = 1.0f / larger(g.trace, all(1e-6f));
    store(to[0] + s, (g.c11 + g.j) * by_trace);
    store(to[1] + s, g.c12 * by_trace);
    store(to[2] + s, (g.c22 + g.j) * by_trace);
}
static void stretches(const StretchJob& job) noexcept {
    for (std::size_t at = 0; at < job.on.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const Quad q = load_quad(job.on, s);
        const float* data = block_of(job.on.data, at, kQuadData);
        const Corner third = choose(q.other, q.d, q.c), first = choose(q.other, q.b, q.a);
        store_stretch(gradient_of(edge(q.b, q.a), edge(third, q.a), data), job.to, s);
        store_stretch(gradient_of(edge(q.c, first), edge(q.d, first), data + 4 * kBlock), job.to + 3, s);
    }
}

static void twist(const TwistJob& job) noexcept {
    for (std::size_t at = 0; at < job.on.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const std::ptrdiff_t n = job.on.cols;
        const Quad q = load_quad(job.on, s);
        const float* data = block_of(job.on.data, at, kQuadData);
        const Corner third = choose(q.other, q.d, q.c), first = choose(q.other, q.b, q.a);
        const V3 fa = load(job.field, s), fb = load(job.field, s + n), fc = load(job.field, s + n + 1),
                 fd = load(job.field, s + 1);
        const Floats zero{}, one = all(1), w1 = load(data + 3 * kBlock) > 0.0f ? one : zero,
                             w2 = load(data + 7 * kBlock) > 0.0f ? one : zero;
        const V3 f1 = w1 * (fa + fb + choose(q.other, fd, fc)), f2 = w2 * (choose(q.other, fb, fa) + fc + fd);
        // The gradient of f . (a x b + b x c + c x a) by a is (b - c) x f.
        const V3 g0 = cross(edge(q.b, third), f1), g1 = cross(edge(third, q.a), f1), g2 = cross(edge(q.a, q.b), f1);
        const V3 h0 = cross(edge(q.c, q.d), f2), h1 = cross(edge(q.d, first), f2), h2 = cross(edge(first, q.c), f2);
        const V3 none{};
        store(job.corner[0], s, load(job.corner[0], s) + g0 + choose(q.other, none, h0));
        store(job.corner[1], s, load(job.corner[1], s) + g1 + choose(q.other, h0, none));
        store(job.corner[2], s, load(job.corner[2], s) + h1 + choose(q.other, none, g2));
        store(job.corner[3], s, load(job.corner[3], s) + h2 + choose(q.other, g2, none));
    }
}

static void bend(const BendJob& job) noexcept {
    for (std::size_t at = 0; at < job.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const V3 area = load(job.area, s);
        const Floats length = root(dot(area, area)), over = 1.0f / larger(length, all(1e-30f));
        const V3 normal = over * area;
        const Floats modulus = load(job.modulus + s), height = load(job.height + s);
        const V3 off = load(job.curvature, s) - height * (normal - load(job.rest_normal, s));
        const Floats across = dot(off, normal), moment = modulus * across, flat = job.flat * modulus;
        const V3 along = off - across * normal;
        store(job.energy + s, (0.5f * load(job.own + s)) * (moment * across + flat * dot(along, along)));
        store(job.moment, s, moment * normal + flat * along);
        store(job.field, s, (over * (moment - flat * (height + across))) * along);
    }
}

static void gather(std::size_t count, std::ptrdiff_t n, const Field* corner, const Field& to) noexcept {
    for (std::size_t at = 0; at < count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        store(to, s, load(corner[0], s) + load(corner[1], s - n) + load(corner[2], s - n - 1) + load(corner[3], s - 1));
    }
}

static void gather_areas(const Quads& on, const Field* area, const Field& to) noexcept {
    const std::ptrdiff_t n = on.cols;
    for (std::size_t at = 0; at < on.count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        // Corner a of quad s, b of s - n, c of s - n - 1, d of s - 1: of both triangles where the diagonal ends there.
        const auto at_end = [&](std::ptrdiff_t q) DGM_INLINED {  // a or c
            return load(area[0], q) + load(area[1], q);
        };
        const auto other = [&](std::ptrdiff_t q) DGM_INLINED { return load(on.other + q) > 0.5f; };
        const Ints oa = other(s), ob = other(s - n), oc = other(s - n - 1), od = other(s - 1);
        const V3 a = choose(oa, load(area[0], s), at_end(s));
        const V3 b = choose(ob, at_end(s - n), load(area[0], s - n));
        const V3 c = choose(oc, load(area[1], s - n - 1), at_end(s - n - 1));
        const V3 d = choose(od, at_end(s - 1), load(area[1], s - 1));
        store(to, s, a + b + c + d);
    }
}

static void add(std::size_t count, const Field& to, float factor, const Field& from) noexcept {
    const Floats by = all(factor);
    for (std::size_t at = 0; at < count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        store(to, s, load(to, s) + by * load(from, s));
    }
}

static void weigh(std::size_t count, const Field& to, float factor, const float* weight, const Field& from) noexcept {
    for (std::size_t at = 0; at < count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        store(to, s, (factor * load(weight + s)) * load(from, s));
    }
}

static void turn(std::size_t count, const Field& to, float factor, const Field& from) noexcept {
    for (std::size_t at = 0; at < count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        store(to, s, factor * load(to, s) - load(from, s));
    }
}

static void blend(std::size_t count, const Field& to, float factor, const Field& from) noexcept {
    for (std::size_t at = 0; at < count; at += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        const V3 start = load(from, s);
        store(to, s, start + factor * (load(to, s) - start));
    }
}

// Eight doubles whatever the number of lanes: their sum then has the same parts.
typedef double Doubles __attribute__((vector_size(64)));
typedef float Eight __attribute__((vector_size(32)));
#ifdef DGM_WIDE_LOAD
#define DGM_EIGHT(name, from) const Doubles name = static_cast<Doubles>(eight_doubles(from))
#else
#define DGM_EIGHT(name, from)                                     \
    Eight name##_floats;                                          \
    __builtin_memcpy(&name##_floats, from, sizeof name##_floats); \
    const Doubles name = __builtin_convertvector(name##_floats, Doubles)
#endif
#define DGM_EIGHT_PARTS(sum) \
    (((sum)[0] + (sum)[1]) + ((sum)[2] + (sum)[3])) + (((sum)[4] + (sum)[5]) + ((sum)[6] + (sum)[7]))

static double inner(std::size_t count, const float* own, const Field& a, const Field& b) noexcept {
    Doubles sum[3] = {};  // one a coordinate: additions need not wait for each other
    for (std::size_t s = 0; s < count; s += 8) {
        DGM_EIGHT(weight, own + s);
#pragma GCC unroll 3
        for (int c = 0; c < 3; ++c) {
            DGM_EIGHT(x, a.p[c] + s);
            DGM_EIGHT(y, b.p[c] + s);
            sum[c] = sum[c] + weight * (x * y);
        }
    }
    const Doubles both = sum[0] + sum[1] + sum[2];
    return DGM_EIGHT_PARTS(both);
}

static double total(std::size_t count, const float* plane) noexcept {
    Doubles sum{};
    for (std::size_t s = 0; s < count; s += 8) {
        DGM_EIGHT(x, plane + s);
        sum = sum + x;
    }
    return DGM_EIGHT_PARTS(sum);
}

static void place(const PlaceJob& job) noexcept {
    for (int c = 0; c < 3; ++c)
        for (std::size_t s = 0; s < job.count; s += 8) {
            Doubles at;
            __builtin_memcpy(&at, job.at[c] + s, sizeof at);
            DGM_EIGHT(delta, job.delta.p[c] + s);
            const Eight to = __builtin_convertvector(at + delta, Eight);
            __builtin_memcpy(job.moved.p[c] + s, &to, sizeof to);
        }
}

static void diagonal(const DiagonalJob& job, double* energies) noexcept {
    Doubles inertial{}, anchored{};
    for (std::size_t s = 0; s < job.count; s += 8) {
        Eight mass, anchor, free;
        __builtin_memcpy(&mass, job.mass + s, sizeof mass);
        __builtin_memcpy(&anchor, job.anchor + s, sizeof anchor);
        __builtin_memcpy(&free, job.free + s, sizeof free);
        mass = mass * job.by_dt2;
        DGM_EIGHT(own, job.own + s);
        for (int c = 0; c < 3; ++c) {
            Eight delta, way, moved, aim, g;
            __builtin_memcpy(&delta, job.delta.p[c] + s, sizeof delta);
            __builtin_memcpy(&way, job.inertial.p[c] + s, sizeof way);
            __builtin_memcpy(&moved, job.moved.p[c] + s, sizeof moved);
            __builtin_memcpy(&aim, job.target.p[c] + s, sizeof aim);
            __builtin_memcpy(&g, job.gradient.p[c] + s, sizeof g);
            const Eight d = delta - way, u = moved - aim, f = mass * d, a = anchor * u;
            g = free * (g + f + a);
            __builtin_memcpy(job.gradient.p[c] + s, &g, sizeof g);
            inertial = inertial + own * (__builtin_convertvector(f, Doubles) * __builtin_convertvector(d, Doubles));
            anchored = anchored + own * (__builtin_convertvector(a, Doubles) * __builtin_convertvector(u, Doubles));
        }
    }
    energies[0] = DGM_EIGHT_PARTS(inertial);
    energies[1] = DGM_EIGHT_PARTS(anchored);
}

struct Place8 {
    Doubles x[3];
};
static DGM_INLINE void place_of(const VolumeJob& job, std::ptrdiff_t s, Place8& to) {
    for (int c = 0; c < 3; ++c) {
        Doubles at;
        __builtin_memcpy(&at, job.at[c] + s, sizeof at);
        DGM_EIGHT(rest, job.rest.p[c] + s);
        DGM_EIGHT(delta, job.delta.p[c] + s);
        to.x[c] = rest + at + delta;
        if (job.way.p[0] == nullptr) continue;
        DGM_EIGHT(way, job.way.p[c] + s);
        to.x[c] = to.x[c] + job.step * way;
    }
}
static double volume(const VolumeJob& job) noexcept {
    Doubles six{};
    for (std::size_t at = 0; at < job.count; at += 8) {
        const auto s = static_cast<std::ptrdiff_t>(at);
        Place8 a, b, c, d, third, first;
        place_of(job, s, a);
        place_of(job, s + job.cols, b);
        place_of(job, s + job.cols + 1, c);
        place_of(job, s + 1, d);
        DGM_EIGHT(other, job.other + at);
        DGM_EIGHT(quad, job.quad + at);
        for (int k = 0; k < 3; ++k) {
            third.x[k] = other > 0.5 ? d.x[k] : c.x[k];
            first.x[k] = other > 0.5 ? b.x[k] : a.x[k];
        }
        const Doubles one = a.x[0] * (b.x[1] * third.x[2] - b.x[2] * third.x[1]) +
                            a.x[1] * (b.x[2] * third.x[0] - b.x[0] * third.x[2]) +
                            a.x[2] * (b.x[0] * third.x[1] - b.x[1] * third.x[0]);
        const Doubles two = first.x[0] * (c.x[1] * d.x[2] - c.x[2] * d.x[1]) +
                            first.x[1] * (c.x[2] * d.x[0] - c.x[0] * d.x[2]) +
                            first.x[2] * (c.x[0] * d.x[1] - c.x[1] * d.x[0]);
        six = six + quad * (one + two);
    }
    return (DGM_EIGHT_PARTS(six)) / 6;
}
#undef DGM_EIGHT
#undef DGM_EIGHT_PARTS
