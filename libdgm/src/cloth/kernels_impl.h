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

static DGM_INLINE void bend_way(const ProductJob& job, std::uint32_t i) {
    const Sheet& on = job.on;
    const std::ptrdiff_t n = on.pitch;
    const BentRows to = bent_rows(on, i);
    for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
        const std::ptrdiff_t s = i * n + j;
        const V3 d = load(job.from, s), up = load(job.from, s + n), down = load(job.from, s - n);
        const V3 right = load(job.from, s + 1), left = load(job.from, s - 1);
        const Floats weight = load(on.bending + s);
        const V3 bu =
            (load(on.u_up + s) * (up - d) + load(on.u_down + s) * (down - d)) + load(on.u_side + s) * (right - left);
        const V3 bv =
            (load(on.v_up + s) * (right - d) + load(on.v_down + s) * (left - d)) + load(on.v_side + s) * (up - down);
        store(to.u, j, weight * bu);
        store(to.v, j, weight * bv);
    }
}

static DGM_INLINE void stiff_row(const ProductJob& job, std::uint32_t i) {
    const Sheet& on = job.on;
    const Moduli& m = on.moduli;
    const QuadRows to = quad_rows(on, i);
    for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
        const std::ptrdiff_t s = i * on.pitch + j;
        V3 u, v;
        const Quad k = load_quad(on, s, u, v);
        const V3 a = load(job.from, s), b = load(job.from, s + on.pitch);
        const V3 c = load(job.from, s + 1), d = load(job.from, s + on.pitch + 1);
        const V3 ab = b - a, cd = d - c, du = 0.5f * (ab + cd), dv = 0.5f * ((c - a) + (d - b));
        const V3 dh = (cd - ab) - (k.twist_u * du + k.twist_v * dv);
        const V3 d1 = k.q11 * du, d2 = k.q12 * du + k.q22 * dv;
        const Floats e1 = dot(k.f1, d1), e2 = dot(k.f2, d2), e3 = dot(k.f1, d2) + dot(k.f2, d1);
        const Floats t1 = m.warp * e1 + m.cross * e2, t2 = m.cross * e1 + m.weft * e2, t3 = m.shear * e3;
        const Floats s1 = load(on.s1 + s), s2 = load(on.s2 + s), z1 = k.q11 * k.q11, z2 = k.q22 * k.q22;
        const V3 p1 = k.area * ((t1 * k.f1 + t3 * k.f2) + s1 * d1), p2 = k.area * ((t2 * k.f2 + t3 * k.f1) + s2 * d2);
        const Floats w1 = (m.warp * z1) * dot(k.f1, dh), w2 = (m.weft * z2) * dot(k.f2, dh);
        const Floats across = (s1 * z1 + s2 * z2) + (24 * on.plate) * (z1 * z2);
        const V3 r = ((k.uneven * k.area) * (1.0f / 12)) * ((w1 * k.f1 + w2 * k.f2) + across * dh);
        hand_out(to, j, (k.q11 * p1 + k.q12 * p2) - k.twist_u * r, k.q22 * p2 - k.twist_v * r, r);
    }
}

static void product(const ProductJob& job) noexcept {
    const Sheet& on = job.on;
    clear_scratch(on);
    bend_way(job, 0);
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        if (i + 1 < on.rows) {
            bend_way(job, i + 1);
            stiff_row(job, i);
        } else {
            clear_last(on);
        }
        const QuadRows own = quad_rows(on, i), before = quad_rows(on, i + 1);
        const BentRows above = bent_rows(on, i + 3), row = bent_rows(on, i), below = bent_rows(on, i + 1);
        const bool touched = on.touched[i] != 0;
        for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
            const std::ptrdiff_t s = i * on.pitch + j;
            const V3 d = load(job.from, s);
            V3 sum = taken_in(own, before, j) + unbend(on, s, j, above, row, below);
            sum = sum + (job.by_dt2 * load(on.mass + s)) * d;
            if (touched) {
                const V3 n = load(on.normal, s);
                const Floats drag = load(on.drag + s);
                sum = sum + drag * d + ((load(on.press + s) - drag) * dot(n, d)) * n;
            }
            if (job.right.p[0] != nullptr) sum = load(job.free + s) * (load(job.own + s) * load(job.right, s) - sum);
            store(job.to, s, sum);
        }
    }
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
/// Block of the two opposite corners whose displacement changes the columns of the gradient by c1 and c2 times itself,
/// up to sign. Their shares of the twist are 1 + t/2 and 1 - t/2: the larger one counts for both. In a quad of
/// thin triangles it may be 20; blocks without it would let the smoother grow what it should damp.
static DGM_INLINE Sym corner_block(const Sheet& on, const Quad& k, const Floats& c1, const Floats& c2, const Floats& t,
                                   std::ptrdiff_t s) {
    const Moduli& m = on.moduli;
    Sym sum{};
    const V3 a = c1 * k.f1, b = c2 * k.f2;
    add_to(sum, all(m.warp - m.cross), outer(a));
    add_to(sum, all(m.weft - m.cross), outer(b));
    add_to(sum, all(m.cross), outer(a + b));
    add_to(sum, all(m.shear), outer(c2 * k.f1 + c1 * k.f2));
    const Floats turn = t > 0 ? t : -t;
    const Floats share = turn > 1e-4f ? 1 + 0.5f * turn : all(1), weight = k.uneven * (share * share);
    const Floats z1 = k.q11 * k.q11 * (1.0f / 12), z2 = k.q22 * k.q22 * (1.0f / 12);
    add_to(sum, weight * (m.warp * z1), outer(k.f1));
    add_to(sum, weight * (m.weft * z2), outer(k.f2));
    const Floats s1 = load(on.s1 + s), s2 = load(on.s2 + s);
    const Floats same =
        ((c1 * c1 + weight * z1) * s1 + (c2 * c2 + weight * z2) * s2) + weight * ((288 * on.plate) * (z1 * z2));
    for (int c = 0; c < 3; ++c) sum.v[c] += same;
    for (Floats& v : sum.v) v = k.area * v;
    return sum;
}

static void diagonal(const DiagonalJob& job) noexcept {
    const Sheet& on = job.on;
    const std::ptrdiff_t n = on.pitch;
    clear_scratch(on);
    // Rows 0 .. 1 of the scratch: blocks of corners (0, 0) and (1, 1); 2 .. 3 of the others; then those of the row
    // before.
    const auto part = [&](std::size_t k, std::size_t c) DGM_INLINED { return scratch_row(on, k + c / 3).p[c % 3]; };
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        const std::size_t now = i % 2 == 0 ? 0 : 4, before = 4 - now;
        for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
            const std::ptrdiff_t s = i * n + j;
            Sym plus{}, minus{};
            if (i + 1 < on.rows) {
                V3 u, v;
                const Quad k = load_quad(on, s, u, v);
                plus = corner_block(on, k, 0.5f * k.q11, 0.5f * (k.q12 + k.q22), k.twist_u + k.twist_v, s);
                minus = corner_block(on, k, 0.5f * k.q11, 0.5f * (k.q12 - k.q22), k.twist_u - k.twist_v, s);
            }
            for (std::size_t c = 0; c < 6; ++c) {
                store(part(now, c) + j, plus.v[c]);
                store(part(now + 2, c) + j, minus.v[c]);
            }
        }
        const bool touched = on.touched[i] != 0;
        for (std::ptrdiff_t j = 0; j < n; j += kLanes) {
            const std::ptrdiff_t s = i * n + j;
            Sym sum;
            for (std::size_t c = 0; c < 6; ++c)
                sum.v[c] = (load(part(now, c) + j) + load(part(now + 2, c) + j - 1)) +
                           (load(part(before + 2, c) + j) + load(part(before, c) + j - 1));
            const auto square = [&](const float* coefficient, std::ptrdiff_t at) DGM_INLINED {
                const Floats v = load(coefficient + at);
                return load(on.bending + at) * (v * v);
            };
            const Floats mu = load(on.u_up + s) + load(on.u_down + s), mv = load(on.v_up + s) + load(on.v_down + s);
            Floats same = job.by_dt2 * load(on.mass + s) + load(on.bending + s) * (mu * mu + mv * mv);
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
            for (int c = 0; c < 6; ++c) store(job.to.p[c] + s, sum.v[c]);
        }
    }
}

static void invert(const InvertJob& job) noexcept {
    // In doubles: what is stiff along the cloth may be 1e6 times as stiff as across it.
    for (std::size_t s = 0; s < job.count; s += 8) {
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
        const Doubles by = sound ? free / det : none, same = sound ? none : free / trace;
        put_eight(job.of.p[0] + s, by * xx + same);
        put_eight(job.of.p[1] + s, by * yy + same);
        put_eight(job.of.p[2] + s, by * zz + same);
        put_eight(job.of.p[3] + s, by * xy);
        put_eight(job.of.p[4] + s, by * xz);
        put_eight(job.of.p[5] + s, by * yz);
    }
}

static DGM_INLINE V3 times(const Blocks& of, std::ptrdiff_t s, const V3& r) {
    Floats v[6];
    for (int c = 0; c < 6; ++c) v[c] = load(of.p[c] + s);
    return {(v[0] * r.x + v[3] * r.y) + v[4] * r.z, (v[3] * r.x + v[1] * r.y) + v[5] * r.z,
            (v[4] * r.x + v[5] * r.y) + v[2] * r.z};
}
static void sweep(const SweepJob& job) noexcept {
    for (std::size_t k = 0; k < job.count; k += kLanes) {
        const auto s = static_cast<std::ptrdiff_t>(k);
        V3 r = load(job.residual, s);
        if (job.kind == Sweep::Next) {
            r = r - load(job.product, s);
            store(job.residual, s, r);
        }
        V3 way = job.step * times(job.inverse, s, r);
        if (job.kind == Sweep::Next) way = way + job.keep * load(job.way, s);
        store(job.way, s, way);
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

static DGM_INLINE Doubles eight_of(const double* from) {
    Doubles v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
static double start(const StartJob& job) noexcept {
    Doubles sum{};
    for (std::size_t s = 0; s < job.count; s += 8) {
        const Doubles free = eight_at(job.free + s), fall = eight_at(job.fall + s);
        Doubles square{};
        for (int c = 0; c < 3; ++c) {
            const Doubles at = eight_of(job.at[c] + s), go = job.h * eight_at(job.velocity.p[c] + s);
            const double drop = job.h * job.h * job.gravity[c];
            const Doubles to = at + free * (go + drop * fall), led = free * (go + drop);
            __builtin_memcpy(job.was[c] + s, &at, sizeof at);
            __builtin_memcpy(job.at[c] + s, &to, sizeof to);
            put_eight(job.inertial.p[c] + s, free * (drop * (fall - 1)));
            square += led * led;
        }
        sum += eight_at(job.mass + s) * square;
    }
    return sum_of(sum);
}
static void finish(FinishJob& job) noexcept {
    Doubles kinetic{}, moment[3] = {};
    for (std::size_t s = 0; s < job.count; s += 8) {
        const Doubles mass = eight_at(job.mass + s);
        Doubles fell{};
        for (int c = 0; c < 3; ++c) {
            const Doubles at = eight_of(job.at[c] + s), v = job.by_h * (at - eight_of(job.was[c] + s));
            fell += job.direction[c] * (v - eight_at(job.velocity.p[c] + s));
            const Doubles now = job.slow * v;
            put_eight(job.velocity.p[c] + s, now);
            kinetic += mass * (now * now);
            moment[c] += mass * at;
        }
        const Doubles none{}, one = none + 1;
        fell = fell > 0 ? fell : none;
        put_eight(job.fall + s, fell < 1 ? fell : one);
    }
    job.kinetic = 0.5 * sum_of(kinetic);
    for (int c = 0; c < 3; ++c) job.moment[c] = sum_of(moment[c]);
}
static void move(const MoveJob& job) noexcept {
    for (int c = 0; c < 3; ++c)
        for (std::size_t s = 0; s < job.count; s += 8) {
            const Doubles to = eight_of(job.at[c] + s) + job.by * eight_at(job.way.p[c] + s);
            __builtin_memcpy(job.at[c] + s, &to, sizeof to);
        }
}
