// SPDX-License-Identifier: MIT
// libdgm/src/physics/model.cpp
// Measures the rest shape of a map and assembles the matrix of its physics.
//
// Membrane: constant-strain triangles. In the matrix each stands for (2 mu + lambda) times its Dirichlet energy, whose
// stencil has half the cotangents of its angles [Pinkall, Polthier 1993]: it bounds the membrane's own second
// derivatives near rest whatever the rotation of the triangle, so it is made once [Bouaziz et al. 2014; Liu, Bouaziz,
// Kavan 2017]. For the solver the matrix is taken apart into factors of second order (multigrid.cpp).
//
// Bending: 1/2 sum B / A |L u - h (n - n0)|^2 over samples. L x is the cotangent Laplacian: twice mean curvature times
// area times normal. Its part along the surface at rest is removed by a stencil C over the same triangles, the smallest
// that reproduces it; so L - C of the rest shape is h n0, and turning a shape turns both terms alike. What it has along
// the surface is no curvature and counts by kFlat: without it, a sheet that is folded flat would stay folded, and with
// all of it, motion along the surface is stiffer than the membrane (docs/physics.md).
#include <algorithm>
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

constexpr double kAsSquare = 3;  ///< see take_step_length()
constexpr double kThin = 1e-4;   ///< height over longest edge below which a triangle counts as none

struct Measured {
    Double3 e[3];     ///< edges opposite to the corners: from corner k + 1 to corner k + 2
    Double3 area2;    ///< twice the area vector
    double area = 0;  ///< 0: no triangle
};

double length(Double3 v) noexcept {
    return std::sqrt(dot(v, v));
}
Double3 unit(Double3 v) noexcept {
    const double l = length(v);
    return l > 0 ? (1 / l) * v : Double3{};
}

Measured measure(const PhysicsImpl& p, const Triangle& t) noexcept {
    Measured m;
    const auto& dof = p.fine().dof_of;
    Double3 x[3];
    for (int k = 0; k < 3; ++k) x[k] = point(p.rest, t.corner[k]);
    double longest = 0;
    for (int k = 0; k < 3; ++k) {
        m.e[k] = x[(k + 2) % 3] - x[(k + 1) % 3];
        longest = std::max(longest, length(m.e[k]));
        if (dof[t.corner[k]] == dof[t.corner[(k + 1) % 3]]) return m;
    }
    m.area2 = cross(m.e[0], m.e[1]);
    const double doubled = length(m.area2);
    if (doubled > kThin * longest * longest) m.area = doubled / 2;
    return m;
}

template <class F>
void each_triangle(const PhysicsImpl& p, F f) noexcept {
    const std::uint32_t n = p.cols;
    for (std::uint32_t i = 0; i + 1 < p.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::uint32_t a = i * n + j, b = a + n, c = b + 1, d = a + 1;
            const bool other = p.other[a] > 0.5f;
            f(Triangle{{a, b, other ? d : c}, a, 0});
            f(Triangle{{other ? b : a, c, d}, a, 1});
        }
}

/// What samples know of the triangles around them; by unknown.
struct Around {
    Array<double> area, stiffness;
    Array<Double3> normal, bend, slide;  ///< slide: coefficients of C by an edge
    Array<double> laplace;               ///< L - C, by the matrix's pattern
};

bool make_unknowns(PhysicsImpl& p, const StateImpl& s) noexcept {
    Level& l = p.fine();
    l.rows = p.rows;
    l.cols = p.cols;
    l.grid = p.rows * p.cols;
    if (!l.dof_of.allocate(p.allocator, l.grid)) return false;
    for (std::uint32_t k = 0; k < l.grid; ++k) {
        const std::uint32_t first = s.representative(k);
        l.dof_of[k] = first == k ? l.dofs++ : l.dof_of[first];
    }
    if (!list_unknowns(l, p.allocator) || !p.next_copy.allocate(p.allocator, l.grid, kNone)) return false;
    for (std::size_t k = l.copies.size(); k > 0; k -= 2) {
        const std::uint32_t copy = l.copies[k - 2], first = l.copies[k - 1];
        p.next_copy[copy] = p.next_copy[first];
        p.next_copy[first] = copy;
    }
    return true;
}

bool make_planes(PhysicsImpl& p) noexcept {
    const Allocator& a = p.allocator;
    constexpr std::uint64_t kFields = 20 + 6, kPlanes = 14;
    const bool viscous = p.material.viscosity > 0;
    const std::uint64_t count = 3 * kFields + kPlanes + (viscous ? 6 : 0);
    if (!p.planes.allocate(a, count * plane_size(p.rows, p.cols))) return false;
    PlaneCutter cut(p.planes, p.rows, p.cols);
    // From `moved` to `face`: what a step writes anew, so that forget() can clear it all.
    for (Field* f : {&p.rest,     &p.rest_normal, &p.target, &p.moved,         &p.delta,  &p.before, &p.inertial,
                     &p.velocity, &p.gradient,    &p.area,   &p.curvature,     &p.moment, &p.twist,  &p.swell,
                     &p.way,      &p.last,        &p.smooth, &p.smooth_before, &p.push,   &p.fresh})
        *f = cut.field();
    for (Field& f : p.corner) f = cut.field();
    for (Field& f : p.face) f = cut.field();
    for (float** f : {&p.energy, &p.bent, &p.other, &p.modulus, &p.height, &p.mass, &p.anchor, &p.free, &p.weight,
                      &p.is_quad, &p.firm, &p.pressed, &p.grip, &p.give})
        *f = cut.plane();
    if (viscous)
        for (float*& f : p.stretch) f = cut.plane();
    const Level& l = p.fine();
    for (Array<double>& x : p.at)
        if (!x.allocate(a, l.count() + 2 * std::uint64_t{l.cols} + kBlock)) return false;
    for (Array<Touching>& t : p.touching)
        if (!t.allocate(a, 2 * std::uint64_t{l.dofs})) return false;
    const std::uint64_t tiles = std::uint64_t{(l.rows + kTile - 1) / kTile} * ((l.cols + kTile - 1) / kTile);
    if (!p.near_tiles.allocate(a, PhysicsImpl::kSurfaces) || !p.tiles.allocate(a, tiles) ||
        !p.tiles_seen.allocate(a, PhysicsImpl::kSurfaces * tiles) ||
        !p.sights.allocate(a, std::uint64_t{kTile} * l.cols))
        return false;
    return p.pinned.allocate(a, l.dofs) && p.grasped.allocate(a, l.dofs) &&
           p.quads.allocate(a, kQuadData * std::uint64_t{l.count()}) &&
           p.near.allocate(a, kNear * std::uint64_t{l.count()}) &&
           p.near_turned.allocate(a, kNear * std::uint64_t{l.count()});
}

/// Rest shape in metres around the middle of its box.
void take_rest(PhysicsImpl& p, const StateImpl& s) noexcept {
    const float* from[3] = {s.rest.x, s.rest.y, s.rest.z};
    for (int c = 0; c < 3; ++c) {
        const auto [low, high] = std::minmax_element(from[c], from[c] + p.fine().grid);
        const double middle = 0.5 * (double{*low} + double{*high});
        for (std::uint32_t k = 0; k < p.fine().grid; ++k)
            p.rest.p[c][k] = static_cast<float>((double{from[c][k]} - middle) * p.scale);
    }
    for (std::uint32_t i = 0; i + 1 < p.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < p.cols; ++j) {
            p.other[i * p.cols + j] = static_cast<float>(s.tables.diagonal(i, j));
            p.is_quad[i * p.cols + j] = 1;
        }
}

/// Neighbours of each unknown, itself among them: the 3 x 3 around all of its copies, ascending.
bool make_ring(const Level& l, Rows& ring, const Allocator& a) noexcept {
    Array<std::uint32_t> first, next, seen;
    if (!first.allocate(a, l.dofs, ~0u) || !next.allocate(a, l.grid, ~0u) || !seen.allocate(a, l.dofs, ~0u) ||
        !ring.start.allocate(a, std::uint64_t{l.dofs} + 1) || !ring.col.allocate(a, 9 * std::uint64_t{l.grid}))
        return false;
    for (std::uint32_t s = l.grid; s-- > 0;) {
        next[s] = first[l.dof_of[s]];
        first[l.dof_of[s]] = s;
    }
    std::uint32_t at = 0;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const std::uint32_t begin = at;
        for (std::uint32_t s = first[d]; s != ~0u; s = next[s])
            for (std::uint32_t i = std::max(s / l.cols, 1u) - 1; i <= std::min(s / l.cols + 1, l.rows - 1); ++i)
                for (std::uint32_t j = std::max(s % l.cols, 1u) - 1; j <= std::min(s % l.cols + 1, l.cols - 1); ++j) {
                    const std::uint32_t q = l.dof_of[i * l.cols + j];
                    if (seen[q] == d) continue;
                    seen[q] = d;
                    ring.col[at++] = q;
                }
        std::sort(ring.col.begin() + begin, ring.col.begin() + at);
        ring.start[d + 1] = at;
    }
    return true;
}

double& entry(const Rows& rows, Array<double>& values, std::uint32_t row, std::uint32_t col) noexcept {
    const std::uint32_t* at =
        std::lower_bound(rows.col.begin() + rows.start[row], rows.col.begin() + rows.start[row + 1], col);
    return values[static_cast<std::size_t>(at - rows.col.begin())];
}

double half_cotangent(const Measured& m, int corner) noexcept {
    return -0.5 * dot(m.e[(corner + 1) % 3], m.e[(corner + 2) % 3]) / (2 * m.area);
}

float stiffness_of(const StateImpl& s, const Triangle& t) noexcept {
    if (s.stiffness.empty()) return 1;
    const float mean = (s.stiffness[t.corner[0]] + s.stiffness[t.corner[1]] + s.stiffness[t.corner[2]]) / 3;
    return std::max(mean, 1e-3f);
}

/// Rest edges of a triangle in its own plane, inverted, and its weight.
void take_triangle(PhysicsImpl& p, const Triangle& t, const Measured& m, float stiffness) noexcept {
    if (m.area == 0) return;
    const Double3 e1 = m.e[2], e2 = -1 * m.e[1];
    const double base = length(e1), along = dot(e1, e2) / base, height = 2 * m.area / base;
    const double entries[4] = {1 / base, -along / (base * height), 1 / height, m.area * double{stiffness}};
    for (std::size_t k = 0; k < 4; ++k)
        p.quads[blocked(t.quad, 4 * static_cast<std::size_t>(t.which) + k, kQuadData)] = static_cast<float>(entries[k]);
}

bool measure_samples(PhysicsImpl& p, const StateImpl& s, Around& to) noexcept {
    const Allocator& a = p.allocator;
    Level& l = p.fine();
    if (!to.area.allocate(a, l.dofs) || !to.normal.allocate(a, l.dofs) || !to.bend.allocate(a, l.dofs) ||
        !to.slide.allocate(a, l.dofs) || !make_ring(l, l.matrix, a))
        return false;
    const std::uint64_t entries = l.matrix.col.size();
    if (!to.laplace.allocate(a, entries) || !p.laplace.allocate(a, entries) || !p.membrane.allocate(a, entries) ||
        !p.membrane_firm.allocate(a, l.dofs) || !p.other_firm.allocate(a, l.dofs))
        return false;
    each_triangle(p, [&](const Triangle& t) {
        const Measured m = measure(p, t);
        const float soft = stiffness_of(s, t);
        take_triangle(p, t, m, soft);
        if (m.area == 0) return;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t d = l.dof_of[t.corner[k]], e = l.dof_of[t.corner[(k + 1) % 3]];
            to.area[d] += m.area / 3;
            to.normal[d] = to.normal[d] + m.area2;
            const double w = half_cotangent(m, (k + 2) % 3);
            const Double3 way = point(p.rest, t.corner[k]) - point(p.rest, t.corner[(k + 1) % 3]);
            to.bend[d] = to.bend[d] + w * way;
            to.bend[e] = to.bend[e] - w * way;
            for (const auto& [values, weight] : {std::pair{&p.laplace, w}, std::pair{&p.membrane, w * double{soft}}}) {
                entry(l.matrix, *values, d, d) += weight;
                entry(l.matrix, *values, e, e) += weight;
                entry(l.matrix, *values, d, e) -= weight;
                entry(l.matrix, *values, e, d) -= weight;
            }
        }
    });
    for (Double3& n : to.normal) n = unit(n);
    return true;
}

/// Tangential coefficients q with  sum area (e . q) e = the part of `bend` along the surface, e over the edges from a
/// sample in all triangles around it.
bool find_slides(PhysicsImpl& p, Around& to) noexcept {
    struct Spread {
        double xx = 0, xy = 0, yy = 0;
    };
    struct Frame {
        Double3 x, y;
    };
    const Level& l = p.fine();
    const auto frame = [&](std::uint32_t d) {
        const Double3 n = to.normal[d];
        const Double3 other = std::fabs(n.x) < 0.6 ? Double3{1, 0, 0} : Double3{0, 1, 0};
        const Double3 x = unit(cross(n, other));
        return Frame{x, cross(n, x)};
    };
    Array<Spread> spread;
    if (!spread.allocate(p.allocator, l.dofs)) return false;
    each_triangle(p, [&](const Triangle& t) {
        const Measured m = measure(p, t);
        if (m.area == 0) return;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t d = l.dof_of[t.corner[k]];
            const Frame f = frame(d);
            for (const Double3& e : {m.e[(k + 2) % 3], m.e[(k + 1) % 3]}) {
                const double x = dot(e, f.x), y = dot(e, f.y);
                spread[d].xx += m.area * x * x;
                spread[d].xy += m.area * x * y;
                spread[d].yy += m.area * y * y;
            }
        }
    });
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        const Frame f = frame(d);
        const Spread& s = spread[d];
        const double det = s.xx * s.yy - s.xy * s.xy, trace = s.xx + s.yy;
        if (!(det > 1e-8 * trace * trace)) continue;
        const double x = dot(to.bend[d], f.x), y = dot(to.bend[d], f.y);
        to.slide[d] = ((s.yy * x - s.xy * y) / det) * f.x + ((s.xx * y - s.xy * x) / det) * f.y;
    }
    return true;
}

/// L - C: by unknown for the matrix, by sample and quad for the loops.
void take_laplacian(PhysicsImpl& p, Around& to) noexcept {
    const Level& l = p.fine();
    const auto cols = static_cast<std::ptrdiff_t>(p.cols);
    each_triangle(p, [&](const Triangle& t) {
        const Measured m = measure(p, t);
        if (m.area == 0) return;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t s = t.corner[k], d = l.dof_of[s];
            for (int o = 1; o <= 2; ++o) {
                const int other = (k + o) % 3, third = 3 - k - other;
                const Double3 e = point(p.rest, t.corner[other]) - point(p.rest, s);
                // L x sums half cotangents times (x - other); C sums area (e . q) times (other - x).
                const double w = half_cotangent(m, third) + m.area * dot(e, to.slide[d]);
                const std::ptrdiff_t off =
                    static_cast<std::ptrdiff_t>(t.corner[other]) - static_cast<std::ptrdiff_t>(s);
                const std::ptrdiff_t di = off > 1 ? 1 : off < -1 ? -1 : 0, dj = off - di * cols;
                const auto place = static_cast<std::size_t>(3 * (di + 1) + dj + 1);
                p.near[blocked(s, 4, kNear)] += static_cast<float>(w);
                p.near[blocked(s, place, kNear)] -= static_cast<float>(w);
                p.near_turned[blocked(s, 4, kNear)] += static_cast<float>(w);
                p.near_turned[blocked(t.corner[other], 8 - place, kNear)] -= static_cast<float>(w);
                entry(l.matrix, to.laplace, d, d) += w;
                entry(l.matrix, to.laplace, d, l.dof_of[t.corner[other]]) -= w;
            }
        }
    });
}

void take_samples(PhysicsImpl& p, const StateImpl& s, const Around& from) noexcept {
    const Level& l = p.fine();
    const Material& material = p.material;
    for (std::uint32_t k = 0; k < l.grid; ++k) {
        const std::uint32_t d = l.dof_of[k], first = l.sample_of[d];
        const bool rim = (s.ring[k] & kRingRim) != 0 || from.area[d] == 0;
        Double3 bend;
        for (std::uint32_t e = l.matrix.start[d]; e < l.matrix.start[d + 1]; ++e)
            bend = bend + from.laplace[e] * point(p.rest, l.sample_of[l.matrix.col[e]]);
        p.modulus[k] = rim ? 0 : static_cast<float>(double{material.bending} / from.area[d]);
        p.height[k] = static_cast<float>(dot(bend, from.normal[d]));
        const Vec3 n = narrow(from.normal[d]);
        p.rest_normal.p[0][k] = n.x;
        p.rest_normal.p[1][k] = n.y;
        p.rest_normal.p[2][k] = n.z;
        p.mass[k] = static_cast<float>(double{material.density} * from.area[d]);
        p.anchor[k] = static_cast<float>(double{material.foundation} * from.area[d]);
        p.free[k] = from.area[d] == 0 || (!s.mobility.empty() && s.mobility[first] == 0) ? 0.0f : 1.0f;
    }
}

/// Diagonals of (2 mu + lambda) L and of (L - C)^T B / A (L - C) + foundation.
void take_firmness(PhysicsImpl& p, const Around& from) noexcept {
    const Level& l = p.fine();
    const double modulus = 2 * double{p.shear} + double{p.dilate};
    for (std::uint32_t k = 0; k < l.dofs; ++k) {
        const double bending = p.modulus[l.sample_of[k]];
        p.other_firm[k] += double{p.anchor[l.sample_of[k]]};
        for (std::uint32_t e = l.matrix.start[k]; e < l.matrix.start[k + 1]; ++e) {
            p.other_firm[l.matrix.col[e]] += bending * from.laplace[e] * from.laplace[e];
            if (l.matrix.col[e] == k) p.membrane_firm[k] = modulus * p.membrane[e];
        }
    }
}

/// Samples in degenerate triangles alone, as the end of a fold may be: they go along with a neighbour.
bool find_followers(PhysicsImpl& p, const Around& from) noexcept {
    const Level& l = p.fine();
    std::uint64_t count = 0;
    for (const double a : from.area) count += a == 0 ? 1 : 0;
    if (!p.followers.allocate(p.allocator, 2 * count, kNone)) return false;
    std::size_t at = 0;
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        if (from.area[d] != 0) continue;
        p.followers[at] = d;
        p.followers[at + 1] = l.sample_of[d];
        for (std::uint32_t e = l.matrix.start[d + 1]; e-- > l.matrix.start[d];)
            if (from.area[l.matrix.col[e]] > 0) p.followers[at + 1] = l.sample_of[l.matrix.col[e]];
        at += 2;
    }
    return true;
}
}  // namespace

Result<void> build_model(PhysicsImpl& p, const StateImpl& s) noexcept {
    if (!make_unknowns(p, s) || !make_planes(p)) return kNoMemory;
    take_rest(p, s);
    Around around;
    if (!measure_samples(p, s, around) || !find_slides(p, around)) return kNoMemory;
    take_laplacian(p, around);
    take_samples(p, s, around);
    take_firmness(p, around);
    if (!find_followers(p, around) || !build_levels(p.solver, p.allocator)) return kNoMemory;
    p.rest_volume = volume_of(p, p.delta, 0, nullptr);
    return {};
}

void take_step_length(PhysicsImpl& p) noexcept {
    Level& l = p.fine();
    Multigrid& m = p.solver;
    const Material& material = p.material;
    const double dt = p.options.dt, viscous = 1 + double{material.viscosity} / dt;
    // c0 M + c1 L + c2 L M^-1 L, M the masses.
    const double c0 = 1 / (dt * dt) + double{material.foundation} / double{material.density},
                 c1 = viscous * (2 * double{p.shear} + double{p.dilate}),
                 c2 = double{material.bending} * double{material.density};
    // A plate on a foundation k resists a force on one point by 8 (B k)^(1/2), whatever the size of the quads there
    // [Timoshenko, Woinowsky-Krieger 1959]. A membrane does so by its modulus, but for a logarithm. The diagonal of the
    // matrix is that at the smallest quads many thousand times.
    const auto grip = static_cast<float>(8 * std::sqrt(c0 * c2) + c1);
    for (std::uint32_t s = 0; s < l.grid; ++s) {
        const std::uint32_t d = l.dof_of[s];
        p.firm[s] = static_cast<float>(viscous * p.membrane_firm[d] + p.other_firm[d] + double{p.mass[s]} / (dt * dt));
        if (!(p.firm[s] > 0)) p.firm[s] = 1;  // without a triangle: held
        p.grip[s] = std::min(p.firm[s], grip);
    }
    // A border does not bend. The product cannot say so, but twice the mass there, in between, is near.
    m.mass = p.weight;
    for (std::uint32_t s = 0; s < l.grid; ++s) p.weight[s] = p.modulus[s] > 0 ? p.mass[s] : 2 * p.mass[s];
    m.apart = 0;
    m.scale = 1;
    double shift = c0, laplace = c1;
    m.factors = Factors::One;
    if (c2 > 0) {
        // The membrane resists motion along the surface by c1 and motion across it hardly at all, so a square that has
        // less of it, c1 = 2 (c0 c2)^(1/2), will do as long as the two are not far apart.
        const double square = 2 * std::sqrt(c0 * c2), root = std::sqrt(std::max(0.0, c1 * c1 - square * square));
        m.factors = c1 <= kAsSquare * square ? Factors::Same : Factors::Two;
        m.scale = c2;
        laplace = 1;
        shift = m.factors == Factors::Same ? square / (2 * c2) : 2 * c0 / (c1 + root);
        m.apart = m.factors == Factors::Same ? 0 : root / c2;
    }
    const Array<double>& values = m.factors == Factors::Same ? p.laplace : p.membrane;
    double mean = 0;
    for (std::size_t e = 0; e < l.value.size(); ++e) l.value[e] = laplace * values[e];
    for (std::uint32_t d = 0; d < l.dofs; ++d) {
        double& v = entry(l.matrix, l.value, d, d);
        v += shift * double{p.mass[l.sample_of[d]]};
        mean += v / l.dofs;
    }
    for (std::size_t k = 0; k < p.followers.size(); k += 2)
        entry(l.matrix, l.value, p.followers[k], p.followers[k]) += mean;
    p.hold = static_cast<float>(mean);
    take_values(m);
}

}  // namespace dgm::detail::physics
