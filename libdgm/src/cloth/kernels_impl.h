// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_impl.h
// Bodies of the loops for one number of lanes. Included inside a namespace, after Floats, Ints, kLanes and root().
//
// A row of samples takes what the quads before and after it hand out. What the row of quads after it hands to its left
// and right corners is added while it is made; what it hands to the next row, and moments of bending of two rows, wait
// in the scratch, which stays in the nearest cache.

#include "cloth/kernels_vectors.h"

/// Rest shape and present shape of quads side by side.
struct Quad {
    Floats q11, q12, q22, area, uneven, twist_u, twist_v;
    V3 f1, f2;  ///< deformation gradient, along u and across
};
static DGM_INLINE Quad rest_quad(const Sheet& on, std::ptrdiff_t s) {
    return {load(on.q11 + s),
            load(on.q12 + s),
            load(on.q22 + s),
            load(on.area + s),
            load(on.uneven + s),
            load(on.twist_u + s),
            load(on.twist_v + s),
            V3{},
            V3{}};
}
/// Of a shape whose deformation gradients are known.
static DGM_INLINE Quad known_quad(const Sheet& on, std::ptrdiff_t s) {
    Quad q = rest_quad(on, s);
    q.f1 = load(on.f1, s);
    q.f2 = load(on.f2, s);
    return q;
}

/// A scratch row of three coordinates.
typedef Field Row;
static DGM_INLINE Row scratch_row(const Sheet& on, std::size_t k) {
    float* at =
        on.scratch + static_cast<std::ptrdiff_t>(3 * k) * (on.pitch + 2 * static_cast<std::ptrdiff_t>(kBlock)) + kBlock;
    const std::ptrdiff_t step = on.pitch + 2 * static_cast<std::ptrdiff_t>(kBlock);
    return {{at, at + step, at + 2 * step}};
}
static DGM_INLINE void clear(const Row& r, std::ptrdiff_t pitch) {
    for (float* p : r.p)
        __builtin_memset(p - kBlock, 0, (static_cast<std::size_t>(pitch) + 2 * kBlock) * sizeof(float));
}
/// Rows of the scratch. What lies past the ends of all but the last four stays 0.
static DGM_INLINE Row handed_row(const Sheet& on) {
    return scratch_row(on, 0);
}
/// Moments of a row of samples, along u and along v.
struct BentRows {
    Row u, v;
};
static DGM_INLINE BentRows bent_rows(const Sheet& on, std::uint32_t i) {
    const std::size_t at = 1 + 2 * (i % 2);
    return {scratch_row(on, at), scratch_row(on, at + 1)};
}
static DGM_INLINE Row line_row(const Sheet& on) {
    return scratch_row(on, 5);
}
/// Edges of the present shape from a row on, along u and along v.
static DGM_INLINE BentRows edge_rows(const Sheet& on, std::uint32_t i) {
    const std::size_t at = 6 + 2 * (i % 2);
    return {scratch_row(on, at), scratch_row(on, at + 1)};
}
static DGM_INLINE Row spare_row(const Sheet& on, std::size_t k) {
    return scratch_row(on, 10 + k);
}
/// Before row 0.
static DGM_INLINE void clear_first(const Sheet& on) {
    clear(handed_row(on), on.pitch);
    const BentRows bent = bent_rows(on, 1);
    clear(bent.u, on.pitch);
    clear(bent.v, on.pitch);
}

/// Moments of samples side by side.
struct Bent {
    V3 u, v;
};
/// What quads hand to the samples of the row before them, and to those of the row after them.
struct Handed {
    V3 near[2], far[2];  ///< at (i, j), (i, j + 1); at (i + 1, j), (i + 1, j + 1)
};
/// From the slopes by mean edges and twist.
static DGM_INLINE Handed hand_out(const V3& p, const V3& q, const V3& r) {
    const V3 plus = 0.5f * (p + q), minus = 0.5f * (p - q);
    return {{r - plus, V3{} - minus - r}, {minus - r, plus + r}};
}
/// What samples get from quads; `before`: what the quads on the left handed out.
static DGM_INLINE V3 take_in(const Sheet& on, std::ptrdiff_t j, const Handed& quads, Handed& before) {
    const Row waiting = handed_row(on);
    const V3 sum = (quads.near[0] + left_of(before.near[1], quads.near[1])) + load(waiting, j);
    store(waiting, j, quads.far[0] + left_of(before.far[1], quads.far[1]));
    before = quads;
    return sum;
}
/// The stencils' transposes, of moments in three rows.
static DGM_INLINE V3 unbend(const Sheet& on, std::ptrdiff_t s, std::ptrdiff_t j, const Bent& above, const BentRows& own,
                            const Bent& below) {
    const std::ptrdiff_t n = on.pitch;
    V3 sum = load(on.u_up + s - n) * above.u + load(on.u_down + s + n) * below.u;
    sum = sum + (load(on.v_up + s - 1) * load(own.v, j - 1) + load(on.v_down + s + 1) * load(own.v, j + 1));
    sum = sum + (load(on.u_side + s - 1) * load(own.u, j - 1) - load(on.u_side + s + 1) * load(own.u, j + 1));
    sum = sum + (load(on.v_side + s - n) * above.v - load(on.v_side + s + n) * below.v);
    const Floats u = load(on.u_up + s) + load(on.u_down + s), v = load(on.v_up + s) + load(on.v_down + s);
    return sum - (u * load(own.u, j) + v * load(own.v, j));
}

#include "cloth/kernels_force.h"
#include "cloth/kernels_frame.h"
#include "cloth/kernels_levels.h"
#include "cloth/kernels_solve.h"
