// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/welded_surface.h
#pragma once
#include <dgm/state.h>

#include <cstdint>

#include "model/tri_mesh.h"

namespace dgm::bench {

/// The present shape of a state as triangles between samples, in local coordinates. `weld`: seam copies stand as their
/// representative. @throws model::Error kReadFailed with what the runtime says
[[nodiscard]] model::TriMesh surface_of(const State& state, std::uint32_t stride, bool weld);

/// The representative of a sample: itself, or the lowest of its weld class.
[[nodiscard]] std::uint32_t representative(const State& state, std::uint32_t sample);

}  // namespace dgm::bench
