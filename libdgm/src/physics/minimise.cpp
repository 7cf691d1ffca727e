// SPDX-License-Identifier: MIT
// libdgm/src/physics/minimise.cpp
// Lowers the potential of a step: conjugate gradients with V-cycles as preconditioner.
//
// A step's potential is nearly quadratic over the few hundredths of a millimetre that samples go in it beyond where
// inertia leads. So a cycle evaluates the gradient once, a whole step ahead; its difference stands for the product of
// second derivatives and direction [Hestenes, Stiefel 1952], and the step goes where the slope of the line is 0, with
// the contacts that are met on the way. Where the energy there says that the potential is not quadratic, the step is
// halved until it is lower, by gradients in place. Directions are those of [Polak, Ribiere 1969].
//
// The volume is kept by one more vector, the preconditioner's answer to its gradient: gradients and directions are
// freed of it, and the last move solves the exact constraint along it.
#include <algorithm>
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

constexpr std::uint32_t kAnew = 4;           ///< cycles after which the gradient is evaluated in place
constexpr double kClose = 0.02, kFar = 0.5;  ///< of the energy from a quadratic one, in curvatures of the line
constexpr int kSwellKept = 16;               ///< steps
constexpr double kMended = 0.1;              ///< most of its length that a step grows or shrinks at its end
constexpr double kFarthest = 3;              ///< of a step, in multiples of the preconditioner's

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
    p.solver.kernels->weigh(p.fine().count(), f, 1, p.free, f);
}
/// to = A^-1 from, about.
void precondition(PhysicsImpl& p, const Field& to, const Field& from) noexcept {
    if (p.factored()) return apply_inverse(p, to, from);
    copy(p, p.fine().r, from);
    run_cycle(p.solver);
    p.solver.kernels->weigh(p.fine().count(), to, 1, p.free, p.fine().x);
}
/// Square root of the sum of squared forces over the diagonal: the length of a Jacobi step in the energy's norm.
double unbalanced(const PhysicsImpl& p) noexcept {
    return std::sqrt(p.solver.kernels->inner(p.fine().count(), p.give, p.gradient, p.gradient));
}

/// The pressure and the response to it.
struct Swelling {
    bool on = false;
    double response = 0;  ///< volume gained by `swell`
};

/// gradient -= pressure * gradient of the volume, with the pressure that makes the rest keep the volume.
void take_pressure(PhysicsImpl& p, const Swelling& v) noexcept {
    if (!v.on) return;
    p.pressure = inner(p, p.gradient, p.swell) / v.response;
    add(p, p.gradient, -p.pressure / 6, p.push);
}
Swelling prepare_swelling(PhysicsImpl& p) noexcept {
    Swelling v;
    copy(p, p.push, p.area);
    hold(p, p.push);
    if (!p.closed || !p.options.keep_volume) return v;
    // Any vector along which the volume grows will do to free directions of it, and one of some steps ago is near.
    const bool solved = p.factored() && p.factor.swell_age != 0;
    if (solved)
        hold(p, p.swell);
    else
        precondition(p, p.swell, p.push);
    p.factor.swell_age = p.factored() ? (p.factor.swell_age + 1) % kSwellKept : 0;
    v.response = inner(p, p.push, p.swell) / 6;
    v.on = v.response > 0;
    if (!v.on) p.factor.swell_age = 0;
    return v;
}

/// Applies the constraint anew after the shape has changed.
void renew_swelling(PhysicsImpl& p, Swelling& v) noexcept {
    copy(p, p.push, p.area);
    hold(p, p.push);
    if (!v.on) return;
    v.response = inner(p, p.push, p.swell) / 6;
    v.on = v.response > 0;
}

/// Finds the multiple of `swell` that gives the rest volume, by secants: the volume is a cubic that is nearly a line.
/// @return volume / rest volume - 1
double restore_volume(PhysicsImpl& p, const Swelling& v) noexcept {
    if (!v.on) return 0;
    double slope = v.response, now = volume_of(p, p.delta, 0, nullptr);
    for (int k = 0; k < 12; ++k) {
        const double wanted = p.rest_volume - now;
        if (std::fabs(wanted) <= 1e-10 * std::fabs(p.rest_volume) || !(slope > 0)) break;
        const auto by = static_cast<float>(wanted / slope);
        add(p, p.delta, double{by}, p.swell);
        const double volume = volume_of(p, p.delta, 0, nullptr);
        if (std::fabs(p.rest_volume - volume) < std::fabs(wanted)) {
            p.unsure += std::fabs(p.pressure * wanted);
            slope = (volume - now) / double{by};
            now = volume;
        } else if (std::fabs(wanted) > 1e-7 * std::fabs(p.rest_volume)) {  // far from a line there: a shorter way
            add(p, p.delta, -double{by}, p.swell);
            slope *= 4;
        } else {
            now = volume;
            break;
        }
    }
    return now / p.rest_volume - 1;
}

/// The step starts where the velocity leads, or where the body is if that has the lower potential.
Potential start(PhysicsImpl& p) noexcept {
    const auto here = [&] {
        Potential now = evaluate(p);
        now.contact = press(p);
        return now;
    };
    const Potential now = here();
    if (now.sum() <= p.elastic + p.at_rest) return now;
    copy(p, p.before, p.delta);
    for (float* f : p.delta.p)
        for (std::size_t s = 0; s < p.fine().count(); ++s) f[s] *= 1 - p.free[s];
    const Potential still = here();
    if (still.sum() <= now.sum() || !std::isfinite(now.sum())) return still;
    copy(p, p.delta, p.before);
    return here();
}

/// Where the search is: potential without contacts, that of contacts, and the line along `way`.
struct Search {
    double smooth = 0, contact = 0;
    double product = 0;  ///< gradient . preconditioned gradient of the cycle before; 0: begin anew
    double slope = 0;
};

/// way = the next conjugate direction. @return false: there is none
bool find_way(PhysicsImpl& p, const Swelling& v, Search& s) noexcept {
    precondition(p, p.fresh, p.gradient);
    if (v.on) add(p, p.fresh, -inner(p, p.push, p.fresh) / 6 / v.response, p.swell);
    const double product = inner(p, p.fresh, p.gradient);
    const double turn = s.product > 0 ? std::max(0.0, (product - inner(p, p.fresh, p.last)) / s.product) : 0;
    s.product = product;
    copy(p, p.last, p.gradient);
    p.solver.kernels->turn(p.fine().count(), p.way, static_cast<float>(turn), p.fresh);
    s.slope = inner(p, p.gradient, p.way);
    if (s.slope < 0) return true;
    p.solver.kernels->turn(p.fine().count(), p.way, 0, p.fresh);
    s.slope = -product;
    return s.slope < 0;
}

/// Where the line's slope is 0: `bend` is its growth without contacts.
double lowest_on_line(const PhysicsImpl& p, const Search& s, double bend) noexcept {
    const double smooth = s.slope - pressed_slope(p, p.way, 0).first;
    double low = 0, high = kFarthest, at = 0;
    for (int k = 0; k < 12; ++k) {
        const Slope pressed = pressed_slope(p, p.way, at);
        const double slope = smooth + bend * at + pressed.first;
        if (std::fabs(slope) <= 1e-3 * std::fabs(s.slope)) break;
        (slope < 0 ? low : high) = at;
        at -= slope / (bend + pressed.second);
        if (!(at > low && at < high)) at = (low + high) / 2;
    }
    return at;
}

enum class Move : std::uint8_t { Modelled, InPlace, None };
/// Goes along `way`. @return how the gradient was found
Move advance(PhysicsImpl& p, Search& s) noexcept {
    const Kernels& loops = *p.solver.kernels;
    const std::size_t count = p.fine().count();
    copy(p, p.before, p.delta);
    copy(p, p.smooth_before, p.smooth);
    const double before = inner(p, p.smooth_before, p.way);
    add(p, p.delta, 1, p.way);
    Potential ahead = evaluate(p);
    const double energy = ahead.elastic + ahead.inertial, after = inner(p, p.smooth, p.way), bend = after - before;
    const double off = std::fabs(energy - s.smooth - 0.5 * (before + after)), merit = s.smooth + s.contact;
    // What is unknown of the energy before the move shows as if the move were not quadratic. With factors a second
    // cycle is often shorter than that.
    const double most = 1e-6 * (std::fabs(s.smooth) + std::fabs(s.contact)) + (p.factored() ? p.unsure : 0);
    double step = 1;
    if (bend > 0 && off <= std::max(kFar * bend, most)) {
        copy(p, p.delta, p.before);
        step = lowest_on_line(p, s, bend);
        add(p, p.delta, step, p.way);
        if (off <= std::max(kClose * bend, most)) {
            loops.blend(count, p.smooth, static_cast<float>(step), p.smooth_before);
            s.smooth += step * before + 0.5 * step * step * bend;
            p.unsure += 3 * step * step * off;  // as much if the third derivative is all that the model lacks
            s.contact = press(p);
            return Move::Modelled;
        }
        ahead = evaluate(p);
    }
    for (int tries = 0; tries < 10; ++tries) {
        if (tries > 0) {
            step *= 0.5;
            copy(p, p.delta, p.before);
            add(p, p.delta, step, p.way);
            ahead = evaluate(p);
        }
        ahead.contact = press(p);
        if (!(ahead.sum() <= merit + 1e-4 * step * s.slope + most)) continue;
        s.smooth = ahead.elastic + ahead.inertial;
        s.contact = ahead.contact;
        p.unsure = 0;
        return Move::InPlace;
    }
    copy(p, p.delta, p.before);
    copy(p, p.smooth, p.smooth_before);
    s.contact = press(p);
    return Move::None;
}

/// A search that has not converged leaves a slope along the whole way of the step, and that much energy would come from
/// nowhere: kinetic and elastic energy change by that slope, less what implicit steps always lose. The potential is
/// known at both ends of the way, and the slope at this one: the way gets the length at which the slope is 0. Drift
/// apart, of which it is known where inertia leads.
void mend_length(PhysicsImpl& p, Search& s) noexcept {
    if (outside(p) != Outside::Nothing) return;
    const Level& l = p.fine();
    const Drift wanted = drift_of(p, p.inertial), drift = drift_of(p, p.delta);
    const double dt2 = double{p.options.dt} * double{p.options.dt};
    double slope = 0;
    for (int c = 0; c < 3; ++c) {
        const double off = drift.mean[c] - wanted.mean[c];
        s.smooth -= 0.5 * drift.mass * off * off / dt2;
        for (std::uint32_t k = 0; k < l.grid; ++k)
            slope += double{l.own[k]} * double{p.gradient.p[c][k]} * (double{p.delta.p[c][k]} - drift.mean[c]);
    }
    const double bend = 2 * (p.elastic + p.at_rest - wanted.energy / dt2 - s.smooth + slope);
    double by = -slope / bend;
    if (!(bend > 0) || !(std::fabs(by) <= kMended)) by = 0;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k) {
            float& d = p.delta.p[c][k];
            d = static_cast<float>(wanted.mean[c] + (1 + by) * (double{d} - drift.mean[c]));
        }
    s.smooth += by * (slope + 0.5 * by * bend);
    p.unsure += by * by * bend;
}

/// Puts samples that the search has let into obstacles back onto them. In this step the impact pays for it; later, when
/// multipliers would lift them out, the body may be slower than that takes. Tools push by multipliers alone, so that
/// their forces are what they feel. @return any were
bool put_out(PhysicsImpl& p) noexcept {
    const Array<Touching>& list = p.touching[p.touching_now];
    bool any = false;
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        const Touching& t = list[k];
        if (is_tool(t)) continue;
        const float* d[3] = {p.delta.p[0] + t.sample, p.delta.p[1] + t.sample, p.delta.p[2] + t.sample};
        const double gap = t.gap + dot(t.normal, Double3{double{*d[0]}, double{*d[1]}, double{*d[2]}});
        if (!(gap < 0)) continue;
        any = true;
        const double out[3] = {gap * t.normal.x, gap * t.normal.y, gap * t.normal.z};
        for (int c = 0; c < 3; ++c) p.delta.p[c][t.sample] -= static_cast<float>(out[c]);
    }
    if (any) share_copies(p.fine(), p.delta);
    return any;
}

double inertia_of(const PhysicsImpl& p) noexcept {
    const Level& l = p.fine();
    double sum = 0;
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t s = 0; s < l.grid; ++s) {
            const double d = double{p.delta.p[c][s]} - double{p.inertial.p[c][s]};
            sum += double{l.own[s]} * double{p.mass[s]} * d * d;
        }
    return sum / (2 * double{p.options.dt} * double{p.options.dt});
}
}  // namespace

bool is_held(const PhysicsImpl& p) noexcept {
    const Level& l = p.fine();
    bool held = p.material.foundation > 0;
    for (std::uint32_t k = 0; k < l.grid && !held; ++k) held = l.own[k] * p.mass[k] > 0 && p.free[k] == 0;
    return held;
}

Drift drift_of(const PhysicsImpl& p, const Field& of) noexcept {
    const Level& l = p.fine();
    Drift out;
    for (std::uint32_t k = 0; k < l.grid; ++k) {
        const double m = double{l.own[k]} * double{p.mass[k]};
        out.mass += m;
        for (int c = 0; c < 3; ++c) out.mean[c] += m * double{of.p[c][k]};
    }
    const bool held = is_held(p);
    for (double& v : out.mean) {
        v = held ? 0 : v / out.mass;
        out.energy += 0.5 * out.mass * v * v;
    }
    return out;
}

bool minimise(PhysicsImpl& p, std::uint32_t cycles, StepReport& report) noexcept {
    const Potential begin = start(p);
    p.unsure = 0;
    Search s{begin.elastic + begin.inertial, begin.contact};
    take_holds(p);
    if (!p.solver.sound) return false;
    if (p.factored()) fit_turn(p);
    Swelling v = prepare_swelling(p);
    const double first = unbalanced(p);
    take_pressure(p, v);
    for (std::uint32_t k = 0; k < cycles; ++k) {
        if (!(unbalanced(p) > 1e-7 * first) || !find_way(p, v, s)) break;
        ++report.cycles;
        const Move move = advance(p, s);
        if (move == Move::None && s.product == 0) break;
        if (move == Move::None) s.product = 0;
        if (move == Move::Modelled && k % kAnew == kAnew - 1 && k + 1 < cycles) {
            const Potential now = evaluate(p);
            s.smooth = now.elastic + now.inertial;
            s.contact = press(p);
            p.unsure = 0;
            renew_swelling(p, v);
        }
        take_pressure(p, v);
    }
    mend_length(p, s);
    if constexpr (kFriction)
        if (p.friction > 0 && outside(p) != Outside::Nothing && !is_held(p)) {
            s.smooth += move_whole(p, s.contact);
            take_pressure(p, v);
        }
    const bool moved = put_out(p);
    report.volume_error = restore_volume(p, v);
    const double left = unbalanced(p);
    report.residual = first > 0 ? left / first : 0;
    report.pressure = v.on ? p.pressure : 0;
    const double elastic = moved ? evaluate(p).elastic : s.smooth - inertia_of(p);
    if (moved) p.unsure = 0;
    const bool sound = std::isfinite(elastic) && std::isfinite(left) && std::isfinite(report.volume_error);
    if (sound) p.elastic = elastic;
    return sound;
}

}  // namespace dgm::detail::physics
