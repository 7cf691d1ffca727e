// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/physics_peers.h
// A body of point masses and springs on the samples of a map, and solvers of its implicit steps.
#pragma once
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "physics_map.h"

namespace dgm::bench {

using Point = std::array<double, 3>;
using Points = std::vector<Point>;

/// Seam copies are one mass. Metres, kilograms, newtons.
struct Springs {
    Points rest;
    std::vector<double> mass;  ///< 0: held by the hand
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    double stiffness = 0;                  ///< N/m of an edge
    std::vector<std::uint32_t> node_of;    ///< by sample
    std::vector<std::uint32_t> sample_of;  ///< by node
};
/// `reach`: masses within this of the highest sample are held.
[[nodiscard]] Springs make_springs(const PhysicsMap& map, const Material& material, double reach);
[[nodiscard]] double volume_of(const Springs& s, const Points& at);

/// Something that makes steps in which the hand moves.
class Solver {
 public:
    Solver() = default;
    Solver(const Solver&) = delete;
    Solver& operator=(const Solver&) = delete;
    virtual ~Solver() = default;
    /// The hand goes to rest + offset within dt, and all else by `effort` iterations.
    virtual void step(const Point& offset, std::uint32_t effort) = 0;
    [[nodiscard]] virtual Points points() const = 0;
};
using Make = std::unique_ptr<Solver> (*)(const PhysicsMap&, const Springs&, double dt);

[[nodiscard]] std::unique_ptr<Solver> make_xpbd(const PhysicsMap&, const Springs&, double dt);
[[nodiscard]] std::unique_ptr<Solver> make_xpbd_with_volume(const PhysicsMap&, const Springs&, double dt);
/// btSoftRigidDynamicsWorld: links of stiffness 1, effort: position iterations.
[[nodiscard]] std::unique_ptr<Solver> make_bullet_links(const PhysicsMap&, const Springs&, double dt);
/// btDeformableMultiBodyDynamicsWorld: implicit springs, effort: conjugate residuals of each of three Newton steps, and
/// of a single one.
[[nodiscard]] std::unique_ptr<Solver> make_bullet_implicit(const PhysicsMap&, const Springs&, double dt);
[[nodiscard]] std::unique_ptr<Solver> make_bullet_once(const PhysicsMap&, const Springs&, double dt);

}  // namespace dgm::bench
