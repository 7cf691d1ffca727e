// SPDX-License-Identifier: MIT
// libdgm/src/physics/rigid.cpp
// Moves a body as a whole to where the forces on it balance.
//
// A search that has not converged leaves forces on the whole body that nothing has: they are gone when no motion as a
// rigid body lowers the potential. Such a motion changes inertia and contacts alone, so it needs no more than the
// contacts and six unknowns: a way and a turn, around the middle.
#include <algorithm>
#include <cmath>

#include "physics/physics_impl.h"

namespace dgm::detail::physics {
namespace {

constexpr int kWays = 6;  ///< three ways, three turns
using Row = double[kWays];

/// Solves a x = b with a positive definite `a`, whose lower half is overwritten. @return false: it is not
bool solve(Row (&a)[kWays], Row& b) noexcept {
    for (int i = 0; i < kWays; ++i) {
        for (int j = 0; j < i; ++j) {
            for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
            a[i][i] -= a[i][j] * a[i][j];
            b[i] -= a[i][j] * b[j];
        }
        if (!(a[i][i] > 0)) return false;
        a[i][i] = std::sqrt(a[i][i]);
        b[i] /= a[i][i];
    }
    for (int i = kWays; i-- > 0;) {
        for (int k = i + 1; k < kWays; ++k) b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
    return true;
}

/// `to` = the force on the six ways of one on a place; also how far the place goes in a direction by each of them.
void on_ways(Double3 place, Double3 direction, Row& to) noexcept {
    const Double3 turn = cross(place, direction);
    const double all[kWays] = {direction.x, direction.y, direction.z, turn.x, turn.y, turn.z};
    std::copy_n(all, kWays, to);
}

class Whole {
 public:
    explicit Whole(PhysicsImpl& p) noexcept : p_(p) {
        for (int c = 0; c < 3; ++c) std::copy_n(p.delta.p[c], p.fine().count(), p.before.p[c]);
        for (std::uint32_t k = 0; k < p.fine().grid; ++k) {
            mass_ += mass_of(k);
            middle_ = middle_ + mass_of(k) * place(k);
        }
        middle_ = (1 / mass_) * middle_;
    }

    /// Finds the motion of one step of Newton's method. @return false: there is none
    bool find() noexcept {
        Row h[kWays] = {}, to;
        std::fill_n(by_, kWays, 0.0);
        const auto stiffen = [&](Double3 at, Double3 direction, double stiffness) {
            on_ways(at, direction, to);
            for (int i = 0; i < kWays; ++i)
                for (int j = 0; j <= i; ++j) h[i][j] += stiffness * to[i] * to[j];
        };
        for (std::uint32_t k = 0; k < p_.fine().grid; ++k) {
            if (p_.fine().own[k] == 0) continue;
            const Double3 at = place(k) - middle_;
            const double m = by_dt2_ * mass_of(k);
            const double xx = m * at.x * at.x, yy = m * at.y * at.y, zz = m * at.z * at.z;
            h[3][3] += yy + zz, h[4][4] += xx + zz, h[5][5] += xx + yy;
            h[4][3] -= m * at.x * at.y, h[5][3] -= m * at.x * at.z, h[5][4] -= m * at.y * at.z;
            on_ways(at, point(p_.gradient, k), to);
            for (int i = 0; i < kWays; ++i) by_[i] -= to[i];
        }
        for (int i = 0; i < 3; ++i) h[i][i] += by_dt2_ * mass_;
        constexpr Double3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        const Array<Touching>& list = p_.touching[p_.touching_now];
        for (std::uint32_t k = 0; k < p_.touching_count; ++k) {
            const Touching& t = list[k];
            const Double3 at = place(t.sample) - middle_, way = point(p_.before, t.sample);
            stiffen(at, t.normal, press_of(t, t.gap + dot(t.normal, way)).stiffness);
            if (!t.sticks() || rub_of(t, way).slides) continue;
            for (const Double3 axis : kAxes) stiffen(at, t.flat(axis), t.stiffness);
        }
        return solve(h, by_);
    }

    /// Goes a part of that motion. @return what inertia and contacts have gained, J
    double go(double part, double contact_before) noexcept {
        const Double3 way = part * Double3{by_[0], by_[1], by_[2]}, turn = part * Double3{by_[3], by_[4], by_[5]};
        for (std::uint32_t k = 0; k < p_.total; ++k) {
            const Double3 d = point(p_.before, k) + way + cross(turn, place(k) - middle_);
            const double x[3] = {d.x, d.y, d.z};
            for (int c = 0; c < 3; ++c) p_.delta.p[c][k] = static_cast<float>(x[c]);
        }
        double gained = 0;
        for (int c = 0; c < 3; ++c)
            for (std::uint32_t k = 0; k < p_.fine().grid; ++k) {
                const double before = double{p_.before.p[c][k]}, now = double{p_.delta.p[c][k]};
                gained += mass_of(k) * (now - before) * (0.5 * (now + before) - double{p_.inertial.p[c][k]});
            }
        inertia_ = by_dt2_ * gained;
        return inertia_ + press(p_) - contact_before;
    }
    [[nodiscard]] double inertia() const noexcept { return inertia_; }

    /// The gradient takes what has been gone.
    void end() noexcept {
        for (int c = 0; c < 3; ++c)
            for (std::uint32_t k = 0; k < p_.total; ++k)
                p_.smooth.p[c][k] += static_cast<float>(by_dt2_ * double{p_.mass[k]} *
                                                        (double{p_.delta.p[c][k]} - double{p_.before.p[c][k]}));
        (void)press(p_);
    }

 private:
    [[nodiscard]] double mass_of(std::uint32_t k) const noexcept {
        return double{p_.fine().own[k]} * double{p_.mass[k]};
    }
    /// Where the search has led.
    [[nodiscard]] Double3 place(std::uint32_t k) const noexcept {
        return point(p_.rest, k) + Double3{p_.at[0][k], p_.at[1][k], p_.at[2][k]} + point(p_.before, k);
    }

    PhysicsImpl& p_;
    double by_dt2_ = 1 / (double{p_.options.dt} * double{p_.options.dt});
    double inertia_ = 0, mass_ = 0;
    Double3 middle_;
    Row by_ = {};
};
}  // namespace

double move_whole(PhysicsImpl& p, double contact) noexcept {
    constexpr int kTries = 4;
    Whole whole(p);
    if (!whole.find()) return 0;
    double part = 1;
    for (int tries = 0; tries < kTries; ++tries, part *= 0.5) {
        if (!(whole.go(part, contact) <= 0)) continue;
        whole.end();
        return whole.inertia();
    }
    (void)whole.go(0, contact);
    return 0;
}

}  // namespace dgm::detail::physics
