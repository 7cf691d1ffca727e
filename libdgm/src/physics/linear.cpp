// SPDX-License-Identifier: MIT
// libdgm/src/physics/linear.cpp
#include "physics/linear.h"

#include <algorithm>
#include <cmath>

namespace dgm::detail::physics {
namespace {

constexpr double kAhead = 0.02;  ///< mean steps that the sample moves whose gradients are compared

void add_at(const Field& f, std::uint32_t k, Double3 v) noexcept {
    const Vec3 n = narrow(v);
    f.p[0][k] += n.x;
    f.p[1][k] += n.y;
    f.p[2][k] += n.z;
}
/// Of a contact, before anything moves. Its gap is that of the start of the step before.
double force_now(const PhysicsImpl& p, const Touching& t) noexcept {
    const double gap = t.gap + double{p.options.dt} * dot(t.normal, point(p.velocity, t.sample));
    return std::max(0.0, t.multiplier - t.stiffness * gap);
}
/// Contacts that press, but the tool's own.
template <class F>
void each_other(const PhysicsImpl& p, std::uint32_t tool, F f) noexcept {
    const Array<Touching>& list = p.touching[p.touching_now];
    for (std::uint32_t k = 0; k < p.touching_count; ++k)
        if (list[k].obstacle != tool && list[k].multiplier > 0 && p.free[list[k].sample] != 0) f(list[k]);
}
template <class F>
void each_grasp(const PhysicsImpl& p, F f) noexcept {
    for (std::uint32_t k = 0; k < p.grasped_count; ++k)
        if (p.free[p.grasped[k].sample] != 0) f(p.grasped[k]);
}
}  // namespace

Linear::Linear(PhysicsImpl& p, const StateImpl& s, const StepOptions& o, std::uint32_t tool) noexcept
    : p_(p), tool_(tool), ahead_(kAhead * double{s.mean_step} * p.scale) {
    const double dt = p.options.dt;
    const float gravity[3] = {o.gravity.x, o.gravity.y, o.gravity.z};
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k)
            p.inertial.p[c][k] = static_cast<float>(dt * (double{p.velocity.p[c][k]} + dt * double{gravity[c]}));
    clear(p_.delta);
    static_cast<void>(evaluate(p_));
    copy(p_.smooth_before, p_.smooth);
    swelling_ = p_.closed && p_.options.keep_volume;
    if (!swelling_) return;
    copy(p_.push, p_.area);
    weigh(p_.push);
    precondition(p_.swell, p_.push);
    response_ = inner(p_.push, p_.swell);
    swelling_ = response_ > 0;
}
Linear::~Linear() {
    clear(p_.delta);
}

void Linear::begin_unbalanced() const noexcept {
    for (int c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < p_.fine().count(); ++k) p_.gradient.p[c][k] = -p_.smooth_before.p[c][k];
    each_other(p_, tool_, [&](const Touching& t) { add_at(p_.gradient, t.sample, force_now(p_, t) * t.normal); });
    each_grasp(p_, [&](const Grasped& g) {
        if (g.tool != tool_) add_at(p_.gradient, g.sample, g.multiplier);
    });
}
void Linear::begin_empty() const noexcept {
    clear(p_.gradient);
}
void Linear::push(std::uint32_t sample, Double3 force) const noexcept {
    add_at(p_.gradient, sample, double{p_.free[sample]} * force);
}

void Linear::solve(const Field& x, std::uint32_t cycles, bool begun) const noexcept {
    share_copies(p_.fine(), p_.gradient);
    weigh(p_.gradient);
    if (begun) {
        weigh(x);
        if (swelling_) add(x, -inner(p_.push, x) / response_, p_.swell);
        static_cast<void>(product(x));
        add(p_.gradient, -1, p_.before);
    } else {
        clear(x);
    }
    balance();
    double last = 0;
    for (std::uint32_t k = 0; k < cycles; ++k) {
        precondition(p_.fresh, p_.gradient);
        if (swelling_) add(p_.fresh, -inner(p_.push, p_.fresh) / response_, p_.swell);
        const double now = inner(p_.fresh, p_.gradient);
        if (!(now > 0)) return;
        const double turn = last > 0 ? std::max(0.0, (now - inner(p_.fresh, p_.last)) / last) : 0;
        last = now;
        copy(p_.last, p_.gradient);
        for (int c = 0; c < 3; ++c)
            for (std::size_t s = 0; s < p_.fine().count(); ++s)
                p_.way.p[c][s] = p_.fresh.p[c][s] + (turn > 0 ? static_cast<float>(turn) * p_.way.p[c][s] : 0);
        const double bend = product(p_.way), slope = inner(p_.gradient, p_.way);
        if (!(bend > 0) || !(slope > 0)) return;
        add(x, slope / bend, p_.way);
        add(p_.gradient, -slope / bend, p_.before);
        balance();
    }
}

void Linear::clear(const Field& f) const noexcept {
    for (float* v : f.p) std::fill(v, v + p_.fine().count(), 0.0f);
}
void Linear::copy(const Field& to, const Field& from) const noexcept {
    for (int c = 0; c < 3; ++c) std::copy(from.p[c], from.p[c] + p_.fine().count(), to.p[c]);
}
void Linear::add(const Field& to, double factor, const Field& from) const noexcept {
    p_.solver.kernels->add(p_.fine().count(), to, static_cast<float>(factor), from);
}
void Linear::weigh(const Field& f) const noexcept {
    p_.solver.kernels->weigh(p_.fine().count(), f, 1, p_.free, f);
}
double Linear::inner(const Field& a, const Field& b) const noexcept {
    return p_.solver.kernels->inner(p_.fine().count(), p_.fine().own, a, b);
}
void Linear::precondition(const Field& to, const Field& from) const noexcept {
    copy(p_.fine().r, from);
    run_cycle(p_.solver);
    p_.solver.kernels->weigh(p_.fine().count(), to, 1, p_.free, p_.fine().x);
}
void Linear::balance() const noexcept {
    if (swelling_) add(p_.gradient, -inner(p_.gradient, p_.swell) / response_, p_.push);
}
double Linear::product(const Field& way) const noexcept {
    float most = 0;
    for (const float* v : way.p)
        for (std::size_t k = 0; k < p_.fine().count(); ++k) most = std::max(most, std::fabs(v[k]));
    clear(p_.before);
    if (!(most > 0) || !std::isfinite(most)) return 0;
    const double by = ahead_ / double{most};
    clear(p_.delta);
    add(p_.delta, by, way);
    static_cast<void>(evaluate(p_));
    const auto back = static_cast<float>(1 / by);
    for (int c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < p_.fine().count(); ++k)
            p_.before.p[c][k] = back * (p_.smooth.p[c][k] - p_.smooth_before.p[c][k]);
    each_other(p_, tool_, [&](const Touching& t) {
        add_at(p_.before, t.sample, t.stiffness * dot(t.normal, point(way, t.sample)) * t.normal);
    });
    each_grasp(p_, [&](const Grasped& g) { add_at(p_.before, g.sample, g.stiffness * point(way, g.sample)); });
    share_copies(p_.fine(), p_.before);
    return inner(way, p_.before);
}

}  // namespace dgm::detail::physics
