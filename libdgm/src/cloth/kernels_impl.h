// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_impl.h
// Bodies of the loops for one number of lanes. Included inside a namespace, after Floats, Ints, kLanes and root().

static DGM_INLINE Floats load(const float* from) {
    Floats v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
static DGM_INLINE void store(float* to, const Floats& v) {
    __builtin_memcpy(to, &v, sizeof v);
}
static DGM_INLINE Floats all(float v) {
    return Floats{} + v;
}
static DGM_INLINE Floats larger(const Floats& a, const Floats& b) {
    return a > b ? a : b;
}

struct V3 {
    Floats x, y, z;
};
static DGM_INLINE V3 operator+(const V3& a, const V3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
static DGM_INLINE V3 operator-(const V3& a, const V3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
static DGM_INLINE V3 operator*(const Floats& s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
static DGM_INLINE V3 operator*(float s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
static DGM_INLINE Floats dot(const V3& a, const V3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static DGM_INLINE V3 cross(const V3& a, const V3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static DGM_INLINE V3 load(const Field& f, std::ptrdiff_t s) {
    return {load(f.p[0] + s), load(f.p[1] + s), load(f.p[2] + s)};
}
static DGM_INLINE void store(const Field& f, std::ptrdiff_t s, const V3& v) {
    store(f.p[0] + s, v.x);
    store(f.p[1] + s, v.y);
    store(f.p[2] + s, v.z);
}

/// Eight doubles whatever the number of lanes: their sum then has the same parts.
typedef double Doubles __attribute__((vector_size(64)));
typedef float Eight __attribute__((vector_size(32)));
static DGM_INLINE Doubles eight_at(const float* from) {
    Eight v;
    __builtin_memcpy(&v, from, sizeof v);
    return __builtin_convertvector(v, Doubles);
}
static DGM_INLINE void put_eight(float* to, const Doubles& from) {
    const Eight v = __builtin_convertvector(from, Eight);
    __builtin_memcpy(to, &v, sizeof v);
}
static DGM_INLINE void widen_add(Doubles& sum, const float* from) {
    sum += eight_at(from);
}
static DGM_INLINE double sum_of(const Doubles& v) {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

static void edges(const EdgesJob& job) noexcept {
    const std::ptrdiff_t pitch = job.on.pitch;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t i = 0; i < job.on.rows; ++i) {
            const std::ptrdiff_t row = i * pitch;
            const double* at = job.at[c] + row;
            float *u = job.on.u.p[c] + row, *v = job.on.v.p[c] + row;
            for (std::ptrdiff_t j = 0; j < pitch; j += 8) {
                Doubles here, below, right;
                __builtin_memcpy(&here, at + j, sizeof here);
                __builtin_memcpy(&below, at + j + pitch, sizeof below);
                __builtin_memcpy(&right, at + j + 1, sizeof right);
                const Eight down = __builtin_convertvector(below - here, Eight);
                const Eight along = __builtin_convertvector(right - here, Eight);
                if (i + 1 < job.on.rows) __builtin_memcpy(u + j, &down, sizeof down);
                __builtin_memcpy(v + j, &along, sizeof along);
            }
            v[job.on.cols - 1] = 0;  // no edge
            for (std::ptrdiff_t j = job.on.cols; j < pitch; ++j) u[j] = v[j] = 0;
        }
}

/// Rest shape and present shape of quads side by side.
struct Quad {
    Floats q11, q12, q22, area, uneven, twist_u, twist_v;
    V3 f1, f2;  ///< deformation gradient, along u and across
};
/// Edges of the present shape, or of one further on.
template <bool kAhead>
struct Edges {
    const ForceJob& job;
    static DGM_INLINE V3 moved(const V3& edge, const V3& by) {
        const Floats square = dot(edge, edge);
        return {square > 0 ? edge.x + by.x : edge.x, square > 0 ? edge.y + by.y : edge.y,
                square > 0 ? edge.z + by.z : edge.z};  // 0: there is none
    }
    DGM_INLINE V3 along(const Field& edges, std::ptrdiff_t s, std::ptrdiff_t step) const {
        const V3 edge = load(edges, s);
        if constexpr (kAhead)
            return moved(edge, job.by * (load(job.ahead, s + step) - load(job.ahead, s)));
        else
            return edge;
    }
    DGM_INLINE V3 u(std::ptrdiff_t s) const { return along(job.on.u, s, job.on.pitch); }
    DGM_INLINE V3 v(std::ptrdiff_t s) const { return along(job.on.v, s, 1); }
};
static DGM_INLINE Quad make_quad(const Sheet& on, std::ptrdiff_t s, const V3& u, const V3& v) {
    Quad q;
    q.q11 = load(on.q11 + s);
    q.q12 = load(on.q12 + s);
    q.q22 = load(on.q22 + s);
    q.area = load(on.area + s);
    q.uneven = load(on.uneven + s);
    q.twist_u = load(on.twist_u + s);
    q.twist_v = load(on.twist_v + s);
    q.f1 = q.q11 * u;
    q.f2 = q.q12 * u + q.q22 * v;
    return q;
}
static DGM_INLINE Quad load_quad(const Sheet& on, std::ptrdiff_t s, V3& u, V3& v) {
    u = 0.5f * (load(on.u, s) + load(on.u, s + 1));
    v = 0.5f * (load(on.v, s) + load(on.v, s + on.pitch));
    return make_quad(on, s, u, v);
}

/// Of a shape whose deformation gradients are known.
static DGM_INLINE Quad known_quad(const Sheet& on, std::ptrdiff_t s) {
    Quad q;
    q.q11 = load(on.q11 + s);
    q.q12 = load(on.q12 + s);
    q.q22 = load(on.q22 + s);
    q.area = load(on.area + s);
    q.uneven = load(on.uneven + s);
    q.twist_u = load(on.twist_u + s);
    q.twist_v = load(on.twist_v + s);
    q.f1 = load(on.f1, s);
    q.f2 = load(on.f2, s);
    return q;
}

/// A scratch row of three coordinates.
struct Row {
    float* p[3];
};
static DGM_INLINE Row scratch_row(const Sheet& on, std::size_t k) {
    float* at =
        on.scratch + static_cast<std::ptrdiff_t>(3 * k) * (on.pitch + 2 * static_cast<std::ptrdiff_t>(kBlock)) + kBlock;
    const std::ptrdiff_t step = on.pitch + 2 * static_cast<std::ptrdiff_t>(kBlock);
    return {{at, at + step, at + 2 * step}};
}
static DGM_INLINE V3 load(const Row& r, std::ptrdiff_t j) {
    return {load(r.p[0] + j), load(r.p[1] + j), load(r.p[2] + j)};
}
static DGM_INLINE void store(const Row& r, std::ptrdiff_t j, const V3& v) {
    store(r.p[0] + j, v.x);
    store(r.p[1] + j, v.y);
    store(r.p[2] + j, v.z);
}

/// What a row of quads hands to the samples of its own row and the next one.
struct QuadRows {
    Row near[2], far[2];  ///< at (i, j), (i, j + 1); at (i + 1, j), (i + 1, j + 1)
};
/// From the slopes by mean edges and twist.
static DGM_INLINE void hand_out(const QuadRows& to, std::ptrdiff_t j, const V3& p, const V3& q, const V3& r) {
    const V3 plus = 0.5f * (p + q), minus = 0.5f * (p - q);
    store(to.near[0], j, r - plus);
    store(to.near[1], j, V3{} - minus - r);
    store(to.far[0], j, minus - r);
    store(to.far[1], j, plus + r);
}
static DGM_INLINE V3 taken_in(const QuadRows& own, const QuadRows& before, std::ptrdiff_t j) {
    return (load(own.near[0], j) + load(own.near[1], j - 1)) + (load(before.far[0], j) + load(before.far[1], j - 1));
}
static DGM_INLINE QuadRows quad_rows(const Sheet& on, std::uint32_t i) {
    const std::size_t far = i % 2 == 0 ? 2 : 4;
    return {{scratch_row(on, 0), scratch_row(on, 1)}, {scratch_row(on, far), scratch_row(on, far + 1)}};
}
static DGM_INLINE void clear(const Row& r, std::ptrdiff_t pitch) {
    for (float* p : r.p)
        __builtin_memset(p - kBlock, 0, (static_cast<std::size_t>(pitch) + 2 * kBlock) * sizeof(float));
}
/// Moments of a row of samples, along u and along v.
struct BentRows {
    Row u, v;
};
static DGM_INLINE BentRows bent_rows(const Sheet& on, std::uint32_t i) {
    const std::size_t at = 6 + 2 * (i % 4);
    return {scratch_row(on, at), scratch_row(on, at + 1)};
}
static DGM_INLINE Row line_row(const Sheet& on) {
    return scratch_row(on, 14);
}
static DGM_INLINE void clear_scratch(const Sheet& on) {
    for (std::size_t k = 0; k < 15; ++k) clear(scratch_row(on, k), on.pitch);
}
/// Before the last row of samples, which no row of quads begins at.
static DGM_INLINE void clear_last(const Sheet& on) {
    clear(scratch_row(on, 0), on.pitch);
    clear(scratch_row(on, 1), on.pitch);
    const BentRows none = bent_rows(on, on.rows);
    clear(none.u, on.pitch);
    clear(none.v, on.pitch);
}

/// The stencils' transposes, of moments in three rows.
static DGM_INLINE V3 unbend(const Sheet& on, std::ptrdiff_t s, std::ptrdiff_t j, const BentRows& above,
                            const BentRows& own, const BentRows& below) {
    const std::ptrdiff_t n = on.pitch;
    V3 sum = load(on.u_up + s - n) * load(above.u, j) + load(on.u_down + s + n) * load(below.u, j);
    sum = sum + (load(on.v_up + s - 1) * load(own.v, j - 1) + load(on.v_down + s + 1) * load(own.v, j + 1));
    sum = sum + (load(on.u_side + s - 1) * load(own.u, j - 1) - load(on.u_side + s + 1) * load(own.u, j + 1));
    sum = sum + (load(on.v_side + s - n) * load(above.v, j) - load(on.v_side + s + n) * load(below.v, j));
    const Floats u = load(on.u_up + s) + load(on.u_down + s), v = load(on.v_up + s) + load(on.v_down + s);
    return sum - (u * load(own.u, j) + v * load(own.v, j));
}

/// Moments of a row of the present shape, and their energy.
template <bool kAhead>
static DGM_INLINE void bend_shape(const ForceJob& job, std::uint32_t i, Doubles& energy) {
    const Sheet& on = job.on;
    const Edges<kAhead> edge{job};
    const std::ptrdiff_t n = on.pitch;
    const BentRows to = bent_rows(on, i);
    const Row line = line_row(on);
    for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
        const std::ptrdiff_t s = i * n + j;
        const V3 up = edge.u(s), down = edge.u(s - n), right = edge.v(s), left = edge.v(s - 1);
        V3 bu = load(on.u_up + s) * up - load(on.u_down + s) * down + load(on.u_side + s) * (right + left);
        V3 bv = load(on.v_up + s) * right - load(on.v_down + s) * left + load(on.v_side + s) * (up + down);
        if (on.u_curved != nullptr) {
            const V3 a = cross(up + down, right + left);
            const Floats square = dot(a, a), length = root(square);
            const Floats by = length > 0 ? 1.0f / length : Floats{};
            bu = bu - (load(on.u_curved + s) * by) * a;
            bv = bv - (load(on.v_curved + s) * by) * a;
        }
        const Floats weight = load(on.bending + s);
        store(to.u, j, weight * bu);
        store(to.v, j, weight * bv);
        store(line.p[0] + j, weight * (dot(bu, bu) + dot(bv, bv)));
    }
    for (std::ptrdiff_t j = 0; j < n; j += 8) widen_add(energy, line.p[0] + j);
}

/// Stresses of a row of quads of the present shape.
template <bool kAhead>
static DGM_INLINE void stress_row(const ForceJob& job, std::uint32_t i, Doubles& energy) {
    const Sheet& on = job.on;
    const Edges<kAhead> edge{job};
    const Moduli& m = on.moduli;
    const QuadRows to = quad_rows(on, i);
    const Row line = line_row(on);
    for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
        const std::ptrdiff_t s = i * on.pitch + j;
        const V3 u0 = edge.u(s), u1 = edge.u(s + 1);
        const V3 u = 0.5f * (u0 + u1), v = 0.5f * (edge.v(s) + edge.v(s + on.pitch));
        const Quad k = make_quad(on, s, u, v);
        const V3 h = (u1 - u0) - (k.twist_u * u + k.twist_v * v);
        const Floats e1 = 0.5f * (dot(k.f1, k.f1) - 1), e2 = 0.5f * (dot(k.f2, k.f2) - 1), e3 = dot(k.f1, k.f2);
        const Floats t1 = m.warp * e1 + m.cross * e2, t2 = m.cross * e1 + m.weft * e2, t3 = m.shear * e3;
        const Floats g1 = k.q11 * dot(k.f1, h), g2 = k.q22 * dot(k.f2, h);
        const Floats w1 = k.uneven * ((m.warp / 12) * g1), w2 = k.uneven * ((m.weft / 12) * g2);
        V3 t = h;  // what bends the plate
        if (on.saddle != nullptr) {
            const V3 n = cross(u, v);
            const Floats length = root(dot(n, n));
            t = t - (length > 0 ? load(on.saddle + s) / length : Floats{}) * n;
        }
        const Floats plate = k.uneven * ((2 * on.plate) * ((k.q11 * k.q11) * (k.q22 * k.q22)));
        store(line.p[0] + j, k.area * ((((t1 * e1 + t2 * e2) + t3 * e3) + (w1 * g1 + w2 * g2)) + plate * dot(t, t)));
        if (kAhead) continue;
        const Floats across = t3 > 0 ? t3 : -t3;
        store(on.s1 + s, larger(t1 + across, Floats{}));
        store(on.s2 + s, larger(t2 + across, Floats{}));
        store(on.square1 + s, dot(k.f1, k.f1));
        store(on.square2 + s, dot(k.f2, k.f2));
        const Floats c1 = k.area * (w1 * k.q11), c2 = k.area * (w2 * k.q22);
        const V3 p1 = k.area * (t1 * k.f1 + t3 * k.f2) + c1 * h, p2 = k.area * (t2 * k.f2 + t3 * k.f1) + c2 * h;
        const V3 r = (c1 * k.f1 + c2 * k.f2) + (k.area * plate) * t;
        hand_out(to, j, (k.q11 * p1 + k.q12 * p2) - k.twist_u * r, k.q22 * p2 - k.twist_v * r, r);
    }
    for (std::ptrdiff_t j = 0; j < on.pitch; j += 8) widen_add(energy, line.p[0] + j);
}

template <bool kAhead>
static DGM_INLINE double all_forces(const ForceJob& job) {
    const Sheet& on = job.on;
    Doubles energy{};
    clear_scratch(on);
    bend_shape<kAhead>(job, 0, energy);
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        if (i + 1 < on.rows) {
            bend_shape<kAhead>(job, i + 1, energy);
            stress_row<kAhead>(job, i, energy);
        } else {
            clear_last(on);
        }
        if (kAhead) continue;
        const QuadRows own = quad_rows(on, i), before = quad_rows(on, i + 1);
        const BentRows above = bent_rows(on, i + 3), row = bent_rows(on, i), below = bent_rows(on, i + 1);
        for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
            const std::ptrdiff_t s = i * on.pitch + j;
            store(job.gradient, s, taken_in(own, before, j) + unbend(on, s, j, above, row, below));
        }
    }
    return 0.5 * sum_of(energy);
}
static double force(const ForceJob& job) noexcept {
    return job.ahead.p[0] == nullptr ? all_forces<false>(job) : all_forces<true>(job);
}

#include "cloth/kernels_frame.h"
#include "cloth/kernels_levels.h"
#include "cloth/kernels_solve.h"
