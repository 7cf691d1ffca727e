// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/welded_surface.cpp
#include "bench/welded_surface.h"

#include <dgm/reconstruct.h>

#include <vector>

#include "bench/runtime_error.h"

namespace dgm::bench {

std::uint32_t representative(const State& state, std::uint32_t sample) {
    const std::uint32_t id = state.class_of(sample);
    return id == kNone ? sample : state.class_members(id).front();
}

model::TriMesh surface_of(const State& state, std::uint32_t stride, bool weld) {
    ReconstructOptions options;
    options.lod_stride = stride;
    std::vector<std::uint32_t> indices(take(mesh_counts(state, options)).indices);
    (void)take(reconstruct(state, {}, indices, options));
    model::TriMesh out;
    const PointView points = state.positions();
    for (std::size_t k = 0; k < points.count; ++k) out.positions.push_back({points[k].x, points[k].y, points[k].z});
    const auto id = [&](std::uint32_t v) { return weld ? representative(state, v) : v; };
    for (std::size_t k = 0; k + 2 < indices.size(); k += 3)
        out.faces.push_back({id(indices[k]), id(indices[k + 1]), id(indices[k + 2])});
    return out;
}

}  // namespace dgm::bench
