// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_force.h
// Forces and energy of the present shape. Included by kernels_impl.h.

static DGM_INLINE Doubles place_at(const double* at) {
    Doubles v;
    __builtin_memcpy(&v, at, sizeof v);
    return v;
}
template <bool kAhead>
static DGM_INLINE void make_edges(const ForceJob& job, std::uint32_t i) {
    const std::ptrdiff_t pitch = job.on.pitch;
    const BentRows to = edge_rows(job.on, i);
    const bool last = i + 1 == job.on.rows;
    for (int c = 0; c < 3; ++c) {
        float *u = to.u.p[c], *v = to.v.p[c];
        const double* at = job.at[c] + i * pitch;
        for (std::ptrdiff_t j = 0; j < pitch; j += 8) {
            const Doubles here = place_at(at + j);
            put_eight(v + j, place_at(at + j + 1) - here);
            put_eight(u + j, place_at(at + j + pitch) - here);
        }
        const float* ahead = kAhead ? job.ahead.p[c] + i * pitch : nullptr;
        const auto by = static_cast<float>(job.by);
        for (std::ptrdiff_t j = 0; kAhead && j < pitch; j += kLanes) {
            const Floats here = load(ahead + j);
            store(v + j, load(v + j) + by * (load(ahead + j + 1) - here));
            store(u + j, load(u + j) + by * (load(ahead + j + pitch) - here));
        }
        v[job.on.cols - 1] = 0;  // no edge
        for (std::ptrdiff_t j = job.on.cols; j < pitch; ++j) u[j] = v[j] = 0;
        if (last) __builtin_memset(u, 0, static_cast<std::size_t>(pitch) * sizeof(float));
    }
}

/// Moments of samples side by side, and twice their energy.
static DGM_INLINE Bent bend_shape(const ForceJob& job, std::uint32_t i, std::ptrdiff_t j, Floats& energy) {
    const Sheet& on = job.on;
    const BentRows own = edge_rows(on, i), before = edge_rows(on, i + 1);
    const std::ptrdiff_t s = i * on.pitch + j;
    const V3 up = load(own.u, j), down = load(before.u, j), right = load(own.v, j), left = load(own.v, j - 1);
    V3 bu = load(on.u_up + s) * up - load(on.u_down + s) * down + load(on.u_side + s) * (right + left);
    V3 bv = load(on.v_up + s) * right - load(on.v_down + s) * left + load(on.v_side + s) * (up + down);
    if (on.u_curved != nullptr) {
        const V3 a = cross(up + down, right + left);
        const Floats square = dot(a, a), length = root(square);
        const Floats by = length > 0 ? 1.0f / length : Floats{};
        bu = bu - (load(on.u_curved + s) * by) * a;
        bv = bv - (load(on.v_curved + s) * by) * a;
    }
    energy = dot(bu, bu) + dot(bv, bv);
    return {bu, bv};
}

/// Stresses of quads side by side, and twice their energy.
template <bool kAhead>
static DGM_INLINE Handed stress(const ForceJob& job, std::uint32_t i, std::ptrdiff_t j, Floats& energy) {
    const Sheet& on = job.on;
    const Moduli& m = on.moduli;
    const BentRows own = edge_rows(on, i), next = edge_rows(on, i + 1);
    const std::ptrdiff_t s = i * on.pitch + j;
    const V3 u0 = load(own.u, j), u1 = load(own.u, j + 1);
    const V3 u = 0.5f * (u0 + u1), v = 0.5f * (load(own.v, j) + load(next.v, j));
    Quad k = rest_quad(on, s);
    k.f1 = k.q11 * u;
    k.f2 = k.q12 * u + k.q22 * v;
    const V3 h = (u1 - u0) - (k.twist_u * u + k.twist_v * v);
    const Floats square1 = dot(k.f1, k.f1), square2 = dot(k.f2, k.f2);
    const Floats e1 = 0.5f * (square1 - 1), e2 = 0.5f * (square2 - 1), e3 = dot(k.f1, k.f2);
    const Floats t1 = m.warp * e1 + m.cross * e2, t2 = m.cross * e1 + m.weft * e2, t3 = m.shear * e3;
    const Floats g1 = k.q11 * dot(k.f1, h), g2 = k.q22 * dot(k.f2, h);
    const Floats w1 = k.uneven * (m.warp_uneven * g1), w2 = k.uneven * (m.weft_uneven * g2);
    V3 t = h;  // what bends the plate
    if (on.saddle != nullptr) {
        const V3 n = cross(u, v);
        const Floats length = root(dot(n, n));
        t = t - (length > 0 ? load(on.saddle + s) / length : Floats{}) * n;
    }
    const Floats plate = k.uneven * ((2 * on.plate) * ((k.q11 * k.q11) * (k.q22 * k.q22)));
    energy = k.area * ((((t1 * e1 + t2 * e2) + t3 * e3) + (w1 * g1 + w2 * g2)) + plate * dot(t, t));
    if (kAhead) return {};
    const Floats across = t3 > 0 ? t3 : -t3;
    store(on.s1 + s, larger(t1 + across, Floats{}));
    store(on.s2 + s, larger(t2 + across, Floats{}));
    store(on.square1 + s, square1);
    store(on.square2 + s, square2);
    store(on.f1, s, k.f1);
    store(on.f2, s, k.f2);
    const Floats c1 = k.area * (w1 * k.q11), c2 = k.area * (w2 * k.q22);
    const V3 p1 = k.area * (t1 * k.f1 + t3 * k.f2) + c1 * h, p2 = k.area * (t2 * k.f2 + t3 * k.f1) + c2 * h;
    const V3 r = (c1 * k.f1 + c2 * k.f2) + (k.area * plate) * t;
    return hand_out((k.q11 * p1 + k.q12 * p2) - k.twist_u * r, k.q22 * p2 - k.twist_v * r, r);
}

/// mass |inertial + by ahead|^2 of a row.
template <bool kAhead>
static DGM_INLINE void add_inertia(const ForceJob& job, std::uint32_t i, Doubles& sum) {
    const auto row = static_cast<std::ptrdiff_t>(i * job.on.pitch);
    for (std::ptrdiff_t s = row; s < row + job.on.pitch; s += 8) {
        Doubles square{};
        for (int c = 0; c < 3; ++c) {
            Doubles way = eight_at(job.inertial.p[c] + s);
            if (kAhead) way += job.by * eight_at(job.ahead.p[c] + s);
            square += way * way;
        }
        sum += eight_at(job.on.mass + s) * square;
    }
}

template <bool kAhead>
static DGM_INLINE double all_forces(const ForceJob& job) {
    const Sheet& on = job.on;
    Doubles energy{}, inertia{};
    clear_first(on);
    clear(edge_rows(on, 1).u, on.pitch);
    make_edges<kAhead>(job, 0);
    const Row line = line_row(on);
    Floats bends, stretches;
    const auto add_line = [&]() DGM_INLINED {
        for (std::ptrdiff_t j = 0; j < on.pitch; j += 8) widen_add(energy, line.p[0] + j);
    };
    const auto bend = [&](std::uint32_t i, std::ptrdiff_t j) DGM_INLINED {
        const BentRows to = bent_rows(on, i);
        const Bent out = bend_shape(job, i, j, bends);
        store(to.u, j, out.u);
        store(to.v, j, out.v);
        return out;
    };
    for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
        bend(0, j);
        store(line.p[0] + j, bends);
    }
    add_line();
    for (std::uint32_t i = 0; i < on.rows; ++i) {
        const bool quads = i + 1 < on.rows;
        if (quads) make_edges<kAhead>(job, i + 1);
        const BentRows row = bent_rows(on, i), other = bent_rows(on, i + 1);
        Handed before{};
        for (std::ptrdiff_t j = 0; j < on.pitch; j += kLanes) {
            const std::ptrdiff_t s = i * on.pitch + j;
            const Bent above{load(other.u, j), load(other.v, j)};
            Bent below{};
            Handed handed{};
            if (quads) {
                below = bend(i + 1, j);
                handed = stress<kAhead>(job, i, j, stretches);
                store(line.p[0] + j, bends + stretches);
            }
            if (kAhead) continue;
            const V3 slope = take_in(on, j, handed, before) + unbend(on, s, j, above, row, below);
            store(job.gradient, s, slope + (job.by_dt2 * load(on.mass + s)) * load(job.inertial, s));
        }
        if (quads) add_line();
        add_inertia<kAhead>(job, i, inertia);
    }
    *job.inertia = sum_of(inertia);
    return 0.5 * sum_of(energy);
}
static double force(const ForceJob& job) noexcept {
    return job.ahead.p[0] == nullptr ? all_forces<false>(job) : all_forces<true>(job);
}
