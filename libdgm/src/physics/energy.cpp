// SPDX-License-Identifier: MIT
// libdgm/src/physics/energy.cpp
// Evaluates the potential of a step and its gradient.
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

void place_samples(PhysicsImpl& p) noexcept {
    for (int c = 0; c < 3; ++c) {
        float* __restrict to = p.moved.p[c];
        const double* __restrict at = p.at[c].data();
        const float* __restrict delta = p.delta.p[c];
        for (std::uint32_t s = 0; s < p.fine().grid; ++s) to[s] = static_cast<float>(at[s] + double{delta[s]});
    }
}

/// Inertia and foundation: diagonal, so they are added after copies have been summed.
void add_diagonal(PhysicsImpl& p, Potential& to) noexcept {
    const Level& l = p.fine();
    const auto by_dt2 = static_cast<float>(1 / (double{p.options.dt} * double{p.options.dt}));
    double inertial[4] = {}, anchored[4] = {};
    for (int c = 0; c < 3; ++c) {
        float* g = p.gradient.p[c];
        const float *delta = p.delta.p[c], *inertia = p.inertial.p[c], *moved = p.moved.p[c], *aim = p.target.p[c];
        for (std::size_t s = 0; s < l.count(); s += 4)
            for (std::size_t k = s; k < s + 4; ++k) {
                const float m = p.mass[k] * by_dt2, d = delta[k] - inertia[k], u = moved[k] - aim[k];
                const float f = m * d, a = p.anchor[k] * u;
                g[k] = p.free[k] * (g[k] + f + a);
                inertial[k - s] += double{l.own[k]} * (double{f} * double{d});
                anchored[k - s] += double{l.own[k]} * (double{a} * double{u});
            }
    }
    to.inertial += 0.5 * ((inertial[0] + inertial[1]) + (inertial[2] + inertial[3]));
    to.elastic += 0.5 * ((anchored[0] + anchored[1]) + (anchored[2] + anchored[3]));
}

/// The augmented Lagrangian of  gap >= 0: (max(0, multiplier - stiffness gap)^2 - multiplier^2) / (2 stiffness).
void add_contacts(PhysicsImpl& p, Potential& to) noexcept {
    Array<Touching>& list = p.touching[p.touching_now];
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        Touching& t = list[k];
        const Double3 d{p.delta.p[0][t.sample], p.delta.p[1][t.sample], p.delta.p[2][t.sample]};
        const double gap = t.gap + dot(t.normal, d);
        t.force = t.multiplier - t.stiffness * gap;
        if (t.force > 0)
            t.met = true;
        else
            t.force = 0;
        to.contact += (t.force * t.force - t.multiplier * t.multiplier) / (2 * t.stiffness);
        const Vec3 f = narrow(t.force * t.normal);
        const float away[3] = {f.x, f.y, f.z};
        for (int c = 0; c < 3; ++c) p.gradient.p[c][t.sample] -= p.free[t.sample] * away[c];
    }
}

/// The same of  position = aim  for grasped samples.
void add_grasps(PhysicsImpl& p, Potential& to) noexcept {
    for (std::uint32_t k = 0; k < p.grasped_count; ++k) {
        Grasped& g = p.grasped[k];
        const Double3 d{p.delta.p[0][g.sample], p.delta.p[1][g.sample], p.delta.p[2][g.sample]};
        g.force = g.multiplier + g.stiffness * (g.aim - d);
        to.contact += (dot(g.force, g.force) - dot(g.multiplier, g.multiplier)) / (2 * g.stiffness);
        const Vec3 f = narrow(g.force);
        const float pull[3] = {f.x, f.y, f.z};
        for (int c = 0; c < 3; ++c) p.gradient.p[c][g.sample] -= p.free[g.sample] * pull[c];
    }
}
}  // namespace

double sum_plane(const PhysicsImpl& p, const float* plane) noexcept {
    double sum[8] = {};
    for (std::size_t s = 0; s < p.fine().count(); s += 8)
        for (std::size_t k = 0; k < 8; ++k) sum[k] += double{plane[s + k]};
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

void sum_classes(const PhysicsImpl& p, const Field& f) noexcept {
    const Level& l = p.fine();
    for (float* plane : f.p)
        for (std::size_t k = 0; k < l.copies.size(); k += 2) plane[l.copies[k + 1]] += plane[l.copies[k]];
    share_copies(l, f);
}

Potential evaluate(PhysicsImpl& p) noexcept {
    const Kernels& loops = *p.solver.kernels;
    const Level& l = p.fine();
    const std::size_t count = l.count();
    const auto cols = static_cast<std::ptrdiff_t>(p.cols);
    place_samples(p);
    QuadJob job{};
    job.on = p.on();
    job.shear = p.shear;
    job.dilate = p.dilate;
    for (int k = 0; k < 4; ++k) job.corner[k] = p.corner[k];
    for (int k = 0; k < 2; ++k) job.area[k] = p.face[k];
    job.energy = p.energy;
    if (p.stretch[0] != nullptr) {
        job.stretch = p.stretch;
        job.viscous = 2 * p.shear * p.options.material.viscosity / p.options.dt;
    }
    loops.quads(job);
    loops.gather_areas(job.on, p.face, p.area);
    loops.near({count, cols, p.near.data(), p.moved, p.curvature, true});
    sum_classes(p, p.area);
    sum_classes(p, p.curvature);
    loops.bend({count, p.modulus, p.height, p.rest_normal, p.area, p.curvature, p.moment, p.twist, p.bent, l.own});
    TwistJob twist{job.on, p.twist, {p.corner[0], p.corner[1], p.corner[2], p.corner[3]}};
    loops.twist(twist);
    loops.gather(count, cols, p.corner, p.gradient);
    loops.near({count, cols, p.near_turned.data(), p.moment, p.curvature, false});
    add_field(l, p.gradient, p.curvature);
    sum_classes(p, p.gradient);
    Potential potential;
    potential.elastic = sum_plane(p, p.energy) + sum_plane(p, p.bent);
    add_diagonal(p, potential);
    add_contacts(p, potential);
    add_grasps(p, potential);
    if (p.touching_count + p.grasped_count != 0) share_copies(l, p.gradient);
    return potential;
}

double volume_of(const PhysicsImpl& p, const Field& delta, double step, const Field* way) noexcept {
    if (!p.closed) return 0;
    const auto at = [&](std::size_t s) {
        double x[3] = {};
        for (int c = 0; c < 3; ++c) {
            x[c] = double{p.rest.p[c][s]} + p.at[c][s] + double{delta.p[c][s]};
            if (way != nullptr) x[c] += step * double{way->p[c][s]};
        }
        return Double3{x[0], x[1], x[2]};
    };
    double six = 0;
    for (std::uint32_t i = 0; i + 1 < p.rows; ++i) {
        const std::size_t row = std::size_t{i} * p.cols;
        Double3 a = at(row), b = at(row + p.cols);
        double sum = 0;
        for (std::uint32_t j = 0; j + 1 < p.cols; ++j) {
            const std::size_t s = row + j;
            const Double3 c = at(s + p.cols + 1), d = at(s + 1);
            const bool other = p.other[s] > 0.5f;
            sum += dot(a, cross(b, other ? d : c)) + dot(other ? b : a, cross(c, d));
            a = d;
            b = c;
        }
        six += sum;
    }
    return six / 6;
}

}  // namespace dgm::detail::physics
