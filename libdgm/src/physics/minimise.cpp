// SPDX-License-Identifier: MIT
// libdgm/src/physics/minimise.cpp
// Lowers the potential of a step: limited-memory BFGS whose first guess of the inverse is one V-cycle.
//
// [Liu, Bouaziz, Kavan 2017] Quasi-Newton methods for real-time simulation of hyperelastic materials, with multigrid in
// place of their Cholesky factor; the recursion is that of [Nocedal 1980]. The volume is kept by one more vector, the
// V-cycle of its gradient: directions are made to meet the linearised constraint, and the last move solves the exact
// one along that vector.
#include <algorithm>
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

void copy(const PhysicsImpl& p, const Field& to, const Field& from) noexcept {
    for (int c = 0; c < 3; ++c) std::copy(from.p[c], from.p[c] + p.fine().count(), to.p[c]);
}
/// to += factor from
void add(const PhysicsImpl& p, const Field& to, double factor, const Field& from) noexcept {
    p.solver.kernels->add(p.fine().count(), to, static_cast<float>(factor), from);
}
double inner(const PhysicsImpl& p, const Field& a, const Field& b) noexcept {
    return p.solver.kernels->inner(p.fine().count(), p.fine().own, a, b);
}
void hold(const PhysicsImpl& p, const Field& f) noexcept {
    for (int c = 0; c < 3; ++c) {
        float* __restrict t = f.p[c];
        const float* __restrict free = p.free;
        for (std::size_t s = 0; s < p.fine().count(); ++s) t[s] *= free[s];
    }
}
/// to = A^-1 from, about.
void precondition(PhysicsImpl& p, const Field& to, const Field& from) noexcept {
    copy(p, p.fine().r, from);
    run_cycle(p.solver);
    copy(p, to, p.fine().x);
    hold(p, to);
}

/// Work that waits: a volume to restore, and the response to a pressure.
struct Swelling {
    bool on = false;
    double volume = 0;    ///< now
    double response = 0;  ///< volume gained by `swell`
};

/// gradient -= pressure * gradient of the volume, with the pressure that makes the rest keep the volume.
void take_pressure(PhysicsImpl& p, const Swelling& v) noexcept {
    if (!v.on) return;
    p.pressure = inner(p, p.gradient, p.swell) / v.response;
    add(p, p.gradient, -p.pressure / 6, p.area);
    hold(p, p.gradient);
}

void find_way(PhysicsImpl& p, const Swelling& v) noexcept {
    const Level& l = p.fine();
    double share[kHistory] = {};
    copy(p, p.way, p.gradient);
    for (int k = 0; k < p.pairs; ++k) {
        const int at = (p.next_pair - 1 - k + 2 * kHistory) % kHistory;
        share[at] = inner(p, p.moves[at], p.way) / p.products[at];
        add(p, p.way, -share[at], p.turns[at]);
    }
    precondition(p, p.way, p.way);
    for (int k = p.pairs - 1; k >= 0; --k) {
        const int at = (p.next_pair - 1 - k + 2 * kHistory) % kHistory;
        add(p, p.way, share[at] - inner(p, p.turns[at], p.way) / p.products[at], p.moves[at]);
    }
    for (float* f : p.way.p)
        for (std::size_t s = 0; s < l.count(); ++s) f[s] = -f[s];
    if (!v.on) return;
    const double gained = inner(p, p.area, p.way) / 6;
    add(p, p.way, (p.rest_volume - v.volume - gained) / v.response, p.swell);
}

/// Remembers the last move and how the gradient turned.
void learn(PhysicsImpl& p, double step) noexcept {
    const Field &move = p.moves[p.next_pair], &turn = p.turns[p.next_pair];
    const Level& l = p.fine();
    for (int c = 0; c < 3; ++c)
        for (std::size_t s = 0; s < l.count(); ++s) {
            move.p[c][s] = p.delta.p[c][s] - p.before.p[c][s];
            turn.p[c][s] = p.gradient.p[c][s] - p.last.p[c][s];
        }
    const double product = inner(p, move, turn), expected = -step * inner(p, p.last, move);
    if (!(product > 1e-3 * std::fabs(expected)) || !std::isfinite(product)) return;
    p.products[p.next_pair] = product;
    p.next_pair = (p.next_pair + 1) % kHistory;
    p.pairs = std::min(p.pairs + 1, kHistory);
}

/// Square root of the sum of squared forces over the diagonal: the length of a Jacobi step in the energy's norm.
double unbalanced(const PhysicsImpl& p) noexcept {
    const Level& l = p.fine();
    double sum = 0;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t s = 0; s < l.grid; ++s) {
            const double g = p.gradient.p[c][s];
            if (l.own[s] != 0) sum += g * g / double{p.firm[s] + p.pressed[s]};
        }
    return std::sqrt(sum);
}

Swelling prepare_swelling(PhysicsImpl& p) noexcept {
    Swelling v;
    if (!p.closed || !p.options.keep_volume) return v;
    copy(p, p.way, p.area);
    hold(p, p.way);
    for (float* f : p.way.p)
        for (std::size_t s = 0; s < p.fine().count(); ++s) f[s] *= 1.0f / 6;
    precondition(p, p.swell, p.way);
    v.response = inner(p, p.area, p.swell) / 6;
    v.volume = volume_of(p, p.delta, 0, nullptr);
    v.on = v.response > 0;
    return v;
}

/// Finds the multiple of `swell` that gives the rest volume, by secants: the volume is a cubic that is nearly a line.
void restore_volume(PhysicsImpl& p, const Swelling& v) noexcept {
    if (!v.on) return;
    double now = v.volume, slope = v.response, at = 0;
    for (int k = 0; k < 6; ++k) {
        const double wanted = p.rest_volume - now;
        if (std::fabs(wanted) <= 1e-12 * std::fabs(p.rest_volume) || !(slope > 0)) break;
        const double next = at + wanted / slope, volume = volume_of(p, p.delta, next, &p.swell);
        if (!(std::fabs(p.rest_volume - volume) < std::fabs(wanted))) break;
        slope = (volume - now) / (next - at);
        at = next;
        now = volume;
    }
    add(p, p.delta, at, p.swell);
}

/// The step starts where the velocity leads, or where the body is if that has the lower potential.
Potential start(PhysicsImpl& p) noexcept {
    Potential now = evaluate(p);
    if (now.sum() <= p.elastic + p.at_rest) return now;
    copy(p, p.before, p.delta);
    for (float* f : p.delta.p)
        for (std::size_t s = 0; s < p.fine().count(); ++s) f[s] *= 1 - p.free[s];
    const Potential still = evaluate(p);
    if (still.sum() <= now.sum() || !std::isfinite(now.sum())) return still;
    copy(p, p.delta, p.before);
    return evaluate(p);
}
}  // namespace

bool minimise(PhysicsImpl& p, std::uint32_t cycles, StepReport& report) noexcept {
    Potential now = start(p);
    Swelling v = prepare_swelling(p);
    report.cycles = v.on ? 1 : 0;
    const double first = unbalanced(p);
    take_pressure(p, v);
    for (std::uint32_t k = 0; k < cycles; ++k) {
        if (!(unbalanced(p) > 1e-7 * first)) break;
        find_way(p, v);
        ++report.cycles;
        copy(p, p.before, p.delta);
        copy(p, p.last, p.gradient);
        const double merit = now.sum() - p.pressure * v.volume, slope = inner(p, p.last, p.way);
        const double noise = 1e-6 * (std::fabs(now.elastic) + now.inertial + std::fabs(now.contact));
        const double old_pressure = p.pressure;
        double step = 1;
        bool lower = false;
        for (int tries = 0; tries < 8 && !lower; ++tries) {
            if (tries > 0) step *= 0.5;
            copy(p, p.delta, p.before);
            add(p, p.delta, step, p.way);
            now = evaluate(p);
            v.volume = v.on ? volume_of(p, p.delta, 0, nullptr) : 0;
            lower = now.sum() - old_pressure * v.volume <= merit + 1e-4 * step * std::min(slope, 0.0) + noise;
        }
        if (!lower) {
            copy(p, p.delta, p.before);
            now = evaluate(p);
            v.volume = v.on ? volume_of(p, p.delta, 0, nullptr) : 0;
            take_pressure(p, v);
            p.pairs = 0;
            // Obstacles that the way ran into were not in the matrix: a shorter way would not help, another one does.
            if (!hold_met(p)) break;
            continue;
        }
        if (v.on) {
            add(p, p.gradient, -old_pressure / 6, p.area);
            hold(p, p.gradient);
            learn(p, step);
            add(p, p.gradient, old_pressure / 6, p.area);
            hold(p, p.gradient);
        } else {
            learn(p, step);
        }
        take_pressure(p, v);
    }
    restore_volume(p, v);
    const double left = unbalanced(p);
    report.residual = first > 0 ? left / first : 0;
    p.elastic = now.elastic;
    report.pressure = v.on ? p.pressure : 0;
    if (v.on) report.volume_error = volume_of(p, p.delta, 0, nullptr) / p.rest_volume - 1;
    return std::isfinite(now.sum()) && std::isfinite(left) && std::isfinite(report.volume_error);
}

}  // namespace dgm::detail::physics
