// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/physics_sweep.h
// dgm-bench physics: time of an implicit step of dgm::physics against its distance from the converged step.
#pragma once
#include <dgm/state.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

struct PhysicsSweepOptions {
    std::vector<std::filesystem::path> assets;  ///< meshes, which are baked first, or .dgm files
    std::vector<std::uint32_t> sizes{33, 65, 129};
    std::vector<std::uint32_t> cycles{1, 2, 3, 5};
    std::vector<double> milliseconds{1};            ///< lengths of a step
    std::vector<std::string> solvers{"multigrid"};  ///< multigrid, factors
    std::vector<std::uint32_t> strides;             ///< of coarse states that are shown on all samples; empty: none
    std::size_t steps = 500;                        ///< timed, of each setting
    double metres_per_unit = 0;                     ///< 0: so that the body has a diagonal of 0.15 m
    double time_limit_seconds = 600;                ///< of a bake
};

/// Of a body at rest.
struct Extent {
    Vec3 lowest, highest;  ///< samples, by z
    double diagonal = 0;
};
[[nodiscard]] Extent extent_of(const State& body);
/// `asked`, or if that is 0 so that the diagonal is 0.15 m.
[[nodiscard]] double metres_per_unit_of(const Extent& body, double asked);

/// A body that refuses physics is a row that says why. @throws model::Error kInterrupted; exceptions of bakes and reads
[[nodiscard]] Run sweep_physics(const PhysicsSweepOptions& options, bool quiet);

}  // namespace dgm::bench
