// SPDX-License-Identifier: MIT
// libdgm/src/c_api_pick.cpp
// dgm.h: rays.
#include <dgm/pick.h>

#include "c_api_impl.h"

namespace {
using namespace dgm::c_api;
}  // namespace

extern "C" {

dgm_code dgm_pick_ray(dgm_state* state, const float origin[3], const float direction[3],
                      const dgm_pick_options* options, dgm_ray_hit* hit, dgm_error* error) {
    if (state == nullptr || origin == nullptr || direction == nullptr) return finish(kNull, error);
    dgm_pick_options o;
    if (auto r = get(options, o); !r) return finish(r.error(), error);
    dgm::PickOptions wishes;
    wishes.back_faces = o.skip_back_faces == 0;
    if (o.max_distance != 0) wishes.max_distance = o.max_distance;
    const auto found = dgm::pick_ray(state->value, vec(origin), vec(direction), wishes);
    if (!found) return finish(found.error(), error);
    const dgm::RayHit& h = found.value();
    dgm_ray_hit out{};
    out.sample = h.sample;
    out.row = h.row;
    out.column = h.column;
    out.triangle = h.triangle;
    out.front = h.front ? 1 : 0;
    out.distance = h.distance;
    std::copy_n(h.corners, 3, out.corners);
    std::copy_n(h.barycentric, 3, out.barycentric);
    store(h.point, out.point);
    store(h.normal, out.normal);
    put(hit, out);
    return finish({}, error);
}

}  // extern "C"
