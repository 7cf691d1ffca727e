// SPDX-License-Identifier: MIT
// libdgm/src/physics/factor_matrix.cpp
// Assembles the second derivatives of a step's potential at rest, without contacts. Runs once a body: built small.
#include "physics/factor_matrix.h"

#include <cmath>

namespace dgm::detail::physics {
namespace {

void add_outer(Block& to, double by, Double3 a, Double3 b) noexcept {
    const double x[3] = {a.x, a.y, a.z}, y[3] = {b.x, b.y, b.z};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) to.at[3 * i + j] += by * x[i] * y[j];
}

/// Triangle t of quad q: its corners; rest edges inverted and weight, see kernels.h. @return whether there is one
bool take_corners(const PhysicsImpl& p, std::uint32_t q, std::size_t t, std::uint32_t (&to)[3],
                  float (&data)[4]) noexcept {
    const std::uint32_t a = q, b = a + p.cols, c = b + 1, d = a + 1;
    const bool other = p.other[q] > 0.5f;
    const std::uint32_t corners[2][3] = {{a, b, other ? d : c}, {other ? b : a, c, d}};
    std::copy_n(corners[t], 3, to);
    for (std::size_t k = 0; k < 4; ++k) data[k] = p.quads[blocked(q, 4 * t + k, kQuadData)];
    return data[3] > 0;
}
template <class F>
void each_triangle(const PhysicsImpl& p, F f) noexcept {
    for (std::uint32_t q = 0; q < p.total; ++q)
        for (std::size_t t = 0; t < 2 && p.is_quad[q] != 0; ++t) {
            std::uint32_t corners[3];
            float data[4];
            if (take_corners(p, q, t, corners, data)) f(corners, data);
        }
}

/// Second derivatives of the membrane at rest: 2 mu (a^2 + b^2) + mu c^2 + lambda (a + b)^2 of strains a, b, c.
[[gnu::cold]] void add_membrane(Making& m) noexcept {
    const PhysicsImpl& p = m.p;
    const double viscous = 1 + double{p.material.viscosity} / double{p.options.dt};
    const double mu = viscous * double{p.shear}, lambda = p.dilate;
    each_triangle(p, [&](const std::uint32_t(&c)[3], const float(&q)[4]) {
        const Double3 e1 = point(p.rest, c[1]) - point(p.rest, c[0]), e2 = point(p.rest, c[2]) - point(p.rest, c[0]);
        const double i11 = q[0], i12 = q[1], i22 = q[2];
        const Double3 x = i11 * e1, y = i12 * e1 + i22 * e2;  // the frame of its plane
        const double g1[3] = {-i11, i11, 0}, g2[3] = {-i12 - i22, i12, i22};
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t s = 0; s < 3; ++s) {
                Block b;
                const Double3 ar = g1[r] * x, br = g2[r] * y, cr = g2[r] * x + g1[r] * y;
                const Double3 as = g1[s] * x, bs = g2[s] * y, cs = g2[s] * x + g1[s] * y;
                const double w = q[3];
                add_outer(b, 2 * w * mu, ar, as);
                add_outer(b, 2 * w * mu, br, bs);
                add_outer(b, w * mu, cr, cs);
                add_outer(b, w * lambda, ar + br, as + bs);
                m.add(p.fine().dof_of[c[r]], p.fine().dof_of[c[s]], b);
            }
    });
}

/// Derivatives of b = (L - C) u - w (n - n0) of all unknowns by those around them.
struct Bends {
    Array<Block> by;  ///< as Level::matrix
    [[nodiscard]] bool take(const PhysicsImpl& p) noexcept;
};
[[gnu::cold]] bool Bends::take(const PhysicsImpl& p) noexcept {
    const Level& l = p.fine();
    Array<Double3> area;
    if (!by.allocate(p.allocator, l.matrix.col.size()) || !area.allocate(p.allocator, l.dofs)) return false;
    const auto at = [&](std::uint32_t d, std::uint32_t q) -> Block& {
        const std::uint32_t* k =
            std::lower_bound(l.matrix.col.begin() + l.matrix.start[d], l.matrix.col.begin() + l.matrix.start[d + 1], q);
        return by[static_cast<std::size_t>(k - l.matrix.col.begin())];
    };
    for (std::uint32_t s = 0; s < l.grid; ++s)
        for (std::uint32_t k = 0; k < kNear; ++k) {
            const double w = p.near[blocked(s, k, kNear)];
            if (w == 0) continue;
            Block& b = at(l.dof_of[s], l.dof_of[s + (k / 3) * l.cols + k % 3 - l.cols - 1]);
            for (std::size_t c = 0; c < 9; c += 4) b.at[c] += w;
        }
    each_triangle(p, [&](const std::uint32_t(&c)[3], const float(&)[4]) {
        const Double3 n = cross(point(p.rest, c[1]) - point(p.rest, c[0]), point(p.rest, c[2]) - point(p.rest, c[0]));
        for (const std::uint32_t s : c) area[l.dof_of[s]] = area[l.dof_of[s]] + n;
    });
    each_triangle(p, [&](const std::uint32_t(&c)[3], const float(&)[4]) {
        for (std::size_t y = 0; y < 3; ++y) {
            // The area vector changes by (edge x u) where its corner opposite to that edge moves by u.
            const Double3 e = point(p.rest, c[(y + 2) % 3]) - point(p.rest, c[(y + 1) % 3]);
            const Double3 columns[3] = {{0, e.z, -e.y}, {-e.z, 0, e.x}, {e.y, -e.x, 0}};
            for (const std::uint32_t s : c) {
                const std::uint32_t d = l.dof_of[s];
                const double length = std::sqrt(dot(area[d], area[d]));
                if (!(length > 0)) continue;
                const Double3 n = (1 / length) * area[d];
                Block& b = at(d, l.dof_of[c[y]]);
                for (std::size_t k = 0; k < 3; ++k) {
                    const Double3 v =
                        (-double{p.height[l.sample_of[d]]} / length) * (columns[k] - dot(columns[k], n) * n);
                    b.at[k] += v.x;
                    b.at[3 + k] += v.y;
                    b.at[6 + k] += v.z;
                }
            }
        }
    });
    return true;
}

/// a^T w b
Block squared(const Block& a, const Block& w, const Block& b) noexcept {
    Block wb, out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) wb.at[3 * i + j] += w.at[3 * i + k] * b.at[3 * k + j];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) out.at[3 * i + j] += a.at[3 * k + i] * wb.at[3 * k + j];
    return out;
}
[[gnu::cold]] bool add_bending(Making& m) noexcept {
    const PhysicsImpl& p = m.p;
    Bends bends;
    if (!bends.take(p)) return false;
    const std::uint32_t* start = p.fine().matrix.start.data();
    each_ring(p.fine(), [&](std::uint32_t d, const std::uint32_t* ring, std::uint32_t count) {
        const std::uint32_t s = p.fine().sample_of[d];
        const double modulus = p.modulus[s];
        if (modulus == 0) return;
        Block weight;
        const Double3 n = point(p.rest_normal, s);
        add_outer(weight, modulus * (1 - double{kFlat}), n, n);
        for (std::size_t c = 0; c < 9; c += 4) weight.at[c] += modulus * double{kFlat};
        const Block* by = bends.by.data() + start[d];
        for (std::uint32_t x = 0; x < count; ++x)
            for (std::uint32_t y = 0; y < count; ++y) m.add(ring[x], ring[y], squared(by[x], weight, by[y]));
    });
    return true;
}

/// Inertia and foundation, and what holds samples.
[[gnu::cold]] void add_diagonal(Making& m) noexcept {
    const PhysicsImpl& p = m.p;
    const double by_dt2 = 1 / (double{p.options.dt} * double{p.options.dt});
    for (std::uint32_t d = 0; d < p.fine().dofs; ++d) {
        const std::uint32_t s = p.fine().sample_of[d];
        Block b;
        for (std::size_t c = 0; c < 9; c += 4)
            b.at[c] = double{p.mass[s]} * by_dt2 + double{p.anchor[s]} + (p.free[s] == 0 ? 1e6 * double{p.firm[s]} : 0);
        m.add(d, d, b);
    }
}

[[gnu::cold]] void scale(Making& m, float by) noexcept {
    Factor& to = m.to;
    for (std::size_t k = 0; k < to.scale.size(); ++k) {
        float& v = m.diagonal[k / kTileRows * kTileEntries + k % kTileRows * (kTileRows + 1)];
        to.scale[k] = v > 0 ? 1 / std::sqrt(v) : 0;
        if (!(v > 0)) v = 1;  // a row without an unknown
    }
    const auto scale_tile = [&](float* t, std::size_t i, std::size_t j) {
        for (std::size_t k = 0; k < kTileEntries; ++k)
            t[k] *= to.scale[i * kTileRows + k % kTileRows] * to.scale[j * kTileRows + k / kTileRows];
    };
    for (std::size_t j = 0; j < to.tiles; ++j) {
        float* own = m.diagonal.data() + j * kTileEntries;
        scale_tile(own, j, j);
        for (std::size_t k = 0; k < kTileRows; ++k) own[k * (kTileRows + 1)] = by;
        for (std::size_t e = to.start[j]; e < to.start[j + 1]; ++e)
            scale_tile(m.below.data() + e * kTileEntries, to.row[e], j);
    }
}
}  // namespace

[[gnu::cold]] bool add_matrix(Making& m, float by) noexcept {
    add_membrane(m);
    if (!add_bending(m)) return false;
    add_diagonal(m);
    scale(m, by);
    return true;
}

}  // namespace dgm::detail::physics
