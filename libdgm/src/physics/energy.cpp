// SPDX-License-Identifier: MIT
// libdgm/src/physics/energy.cpp
// Evaluates the potential of a step and its gradient.
#include <algorithm>
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

/// Inertia and foundation: diagonal, so they are added after copies have been summed.
void add_diagonal(PhysicsImpl& p, Potential& to) noexcept {
    const Level& l = p.fine();
    const auto by_dt2 = static_cast<float>(1 / (double{p.options.dt} * double{p.options.dt}));
    double energies[2];
    p.solver.kernels->diagonal(
        {l.count(), p.mass, p.anchor, p.free, l.own, by_dt2, p.delta, p.inertial, p.moved, p.target, p.smooth},
        energies);
    to.inertial += 0.5 * energies[0];
    to.elastic += 0.5 * energies[1];
}

double add_contacts(PhysicsImpl& p) noexcept {
    Array<Touching>& list = p.touching[p.touching_now];
    double energy = 0;
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        Touching& t = list[k];
        const double gap = t.gap + dot(t.normal, point(p.delta, t.sample));
        const Press now = press_of(t, gap);
        t.force = now.force;
        t.met = t.met || now.force > 0 || t.rubs();
        energy += now.energy;
        Double3 force = t.force * t.normal;
        if (t.sticks()) {
            const Rub rub = rub_of(t, point(p.delta, t.sample));
            energy += rub.energy;
            force = force + rub.force;
        }
        const Vec3 f = narrow(force);
        const float away[3] = {f.x, f.y, f.z};
        for (int c = 0; c < 3; ++c) p.gradient.p[c][t.sample] -= p.free[t.sample] * away[c];
    }
    return energy;
}

/// The same of  position = aim  for grasped samples.
double add_grasps(PhysicsImpl& p) noexcept {
    double energy = 0;
    for (std::uint32_t k = 0; k < p.grasped_count; ++k) {
        Grasped& g = p.grasped[k];
        g.force = g.multiplier + g.stiffness * (g.aim - point(p.delta, g.sample));
        energy += (dot(g.force, g.force) - dot(g.multiplier, g.multiplier)) / (2 * g.stiffness);
        const Vec3 f = narrow(g.force);
        const float pull[3] = {f.x, f.y, f.z};
        for (int c = 0; c < 3; ++c) p.gradient.p[c][g.sample] -= p.free[g.sample] * pull[c];
    }
    return energy;
}
}  // namespace

// Hard: the augmented Lagrangian of  gap >= 0, (max(0, multiplier - stiffness gap)^2 - multiplier^2) / (2 stiffness).
// Soft: springs side by side [Johnson 1985, 4.3]. A ball touches 2 pi R depth of a sample's cell, which is flat for it,
// until that is all of the cell: `stiffness` is that of all of it.
Press press_of(const Touching& t, double gap) noexcept {
    Press out;
    if (!t.soft()) {
        const double force = t.multiplier - t.stiffness * gap;
        if (force > 0) out = {force, t.stiffness, 0};
        out.energy = (out.force * out.force - t.multiplier * t.multiplier) / (2 * t.stiffness);
        return out;
    }
    const double depth = -gap, part = depth / t.blunt;
    if (!(depth > 0)) return out;
    if (part < 1) return {0.5 * t.stiffness * depth * part, t.stiffness * part, t.stiffness * depth * depth * part / 6};
    return {t.stiffness * (depth - 0.5 * t.blunt), t.stiffness,
            t.stiffness * (0.5 * depth * (depth - t.blunt) + t.blunt * t.blunt / 6)};
}

// The augmented Lagrangian of  slid = 0  while its force is at most `most`, which makes the potential grow like
// a line from there on: Coulomb's friction with the normal force of the step before.
Rub rub_of(const Touching& t, Double3 way) noexcept {
    const Double3 hold = widen(t.hold), to = widen(t.slid) + t.flat(way);
    const Double3 wanted = hold - t.stiffness * to;
    const double size = std::sqrt(dot(wanted, wanted)), most = double{t.most}, by = 1 / (2 * t.stiffness);
    if (size <= most) return {wanted, to, (size * size - dot(hold, hold)) * by, t.stiffness, false};
    return {(most / size) * wanted, to, (most * (2 * size - most) - dot(hold, hold)) * by, t.stiffness * most / size,
            true};
}

namespace {
/// Adds what friction has along a line.
void add_slope(const Touching& t, Double3 way, Double3 speed, Slope& to) noexcept {
    const Rub rub = rub_of(t, way);
    const Double3 along = t.flat(speed);
    const double by = dot(rub.force, along), most = double{t.most};
    const double with = rub.slides ? by * by / (most * most) : 0;  // the force keeps its size and turns
    to.first -= by;
    to.second += rub.stiffness * std::max(0.0, dot(along, along) - with);
}
}  // namespace

double press(PhysicsImpl& p) noexcept {
    for (int c = 0; c < 3; ++c) std::copy(p.smooth.p[c], p.smooth.p[c] + p.fine().count(), p.gradient.p[c]);
    const double energy = add_contacts(p) + add_grasps(p);
    if (p.touching_count + p.grasped_count != 0) share_copies(p.fine(), p.gradient);
    return energy;
}

Slope pressed_slope(const PhysicsImpl& p, const Field& way, double step) noexcept {
    Slope slope;
    const Array<Touching>& list = p.touching[p.touching_now];
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        const Touching& t = list[k];
        const Double3 there = point(p.delta, t.sample), moves = double{p.free[t.sample]} * point(way, t.sample);
        const double speed = dot(t.normal, moves), gap = t.gap + dot(t.normal, there) + step * speed;
        const Press now = press_of(t, gap);
        slope.first -= now.force * speed;
        slope.second += now.stiffness * speed * speed;
        if (t.sticks()) add_slope(t, there + step * moves, moves, slope);
    }
    for (std::uint32_t k = 0; k < p.grasped_count; ++k) {
        const Grasped& g = p.grasped[k];
        const Double3 speed = double{p.free[g.sample]} * point(way, g.sample);
        const Double3 force = g.multiplier + g.stiffness * (g.aim - point(p.delta, g.sample) - step * speed);
        slope.first -= dot(force, speed);
        slope.second += g.stiffness * dot(speed, speed);
    }
    return slope;
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
    loops.place({count, {p.at[0].data(), p.at[1].data(), p.at[2].data()}, p.delta, p.moved});
    QuadJob job{};
    job.on = p.on();
    job.shear = p.shear;
    job.dilate = p.dilate;
    for (int k = 0; k < 4; ++k) job.corner[k] = p.corner[k];
    for (int k = 0; k < 2; ++k) job.area[k] = p.face[k];
    job.energy = p.energy;
    if (p.stretch[0] != nullptr) {
        job.stretch = p.stretch;
        job.viscous = 2 * p.shear * p.material.viscosity / p.options.dt;
    }
    loops.quads(job);
    loops.gather_areas(job.on, p.face, p.area);
    loops.near({count, cols, p.near.data(), p.moved, p.curvature, true});
    sum_classes(p, p.area);
    sum_classes(p, p.curvature);
    loops.bend(
        {count, p.modulus, p.height, p.rest_normal, p.area, p.curvature, p.moment, p.twist, p.bent, l.own, kFlat});
    TwistJob twist{job.on, p.twist, {p.corner[0], p.corner[1], p.corner[2], p.corner[3]}};
    loops.twist(twist);
    loops.gather(count, cols, p.corner, p.smooth);
    loops.near({count, cols, p.near_turned.data(), p.moment, p.curvature, false});
    loops.add(count, p.smooth, 1, p.curvature);
    sum_classes(p, p.smooth);
    Potential potential;
    potential.elastic = loops.total(count, p.energy) + loops.total(count, p.bent);
    add_diagonal(p, potential);
    return potential;
}

double volume_of(const PhysicsImpl& p, const Field& delta, double step, const Field* way) noexcept {
    if (!p.closed) return 0;
    return p.solver.kernels->volume({p.fine().count(),
                                     static_cast<std::ptrdiff_t>(p.cols),
                                     p.other,
                                     p.is_quad,
                                     {p.at[0].data(), p.at[1].data(), p.at[2].data()},
                                     p.rest,
                                     delta,
                                     way == nullptr ? Field{} : *way,
                                     step});
}

}  // namespace dgm::detail::physics
