// SPDX-License-Identifier: MIT
// libdgm/src/physics/linear.h
// How a body answers small forces in its next step.
//
// Second derivatives are differences of gradients over a fiftieth of a grid step, as in minimise.cpp, and the same
// V-cycles are the preconditioner.
#pragma once
#include "physics/physics_impl.h"

namespace dgm::detail::physics {

/// The second derivatives H of a step's potential at the present shape, and conjugate gradients on them, with the
/// volume kept and contacts that press as springs. Works in memory that each step writes anew.
class Linear {
 public:
    /// The tool's own contacts are left out; its grasp is not.
    Linear(PhysicsImpl& p, const StateImpl& s, const StepOptions& o, std::uint32_t tool) noexcept;
    ~Linear();
    Linear(const Linear&) = delete;
    Linear& operator=(const Linear&) = delete;

    /// p.gradient = what is left unbalanced without the tool: minus the gradient at the present shape.
    void begin_unbalanced() const noexcept;
    /// p.gradient = 0.
    void begin_empty() const noexcept;
    /// Adds to p.gradient, at a class's first sample.
    void push(std::uint32_t sample, Double3 force) const noexcept;
    /// x, begun somewhere or anew, becomes H^-1 p.gradient.
    void solve(const Field& x, std::uint32_t cycles, bool begun) const noexcept;

 private:
    void clear(const Field& f) const noexcept;
    void copy(const Field& to, const Field& from) const noexcept;
    void add(const Field& to, double factor, const Field& from) const noexcept;
    void weigh(const Field& f) const noexcept;
    double inner(const Field& a, const Field& b) const noexcept;
    void precondition(const Field& to, const Field& from) const noexcept;
    /// Takes the pressure out of p.gradient that makes the rest keep the volume.
    void balance() const noexcept;
    /// p.before = H way. @return way . H way
    double product(const Field& way) const noexcept;

    PhysicsImpl& p_;
    std::uint32_t tool_;
    double ahead_, response_ = 0;
    bool swelling_ = false;
};

}  // namespace dgm::detail::physics
