// SPDX-License-Identifier: MIT
// libdgm/src/c_api/c_api_contact.cpp
// dgm.h: contact, snapshots, usage.
#include "c_api/c_api_impl.h"

namespace {
using dgm::ErrorCode;
using dgm::kNoOffset;
using dgm::Result;
using namespace dgm::c_api;

constexpr std::size_t kMaxRings = 16;  // of ContactOptions

static_assert(same(DGM_OBSTACLE_KIND_PLANE, dgm::ObstacleKind::Plane));
static_assert(same(DGM_OBSTACLE_KIND_SPHERE, dgm::ObstacleKind::Sphere));
static_assert(same(DGM_OBSTACLE_KIND_CAPSULE, dgm::ObstacleKind::Capsule));
static_assert(same(DGM_OBSTACLE_KIND_BOX, dgm::ObstacleKind::Box));
static_assert(same(DGM_OBSTACLE_KIND_SURFACE, dgm::ObstacleKind::Surface));
static_assert(same(DGM_BULGE_EXACT, dgm::Bulge::Exact));
static_assert(same(DGM_BULGE_PAPER, dgm::Bulge::Paper));
static_assert(same(DGM_BULGE_NONE, dgm::Bulge::None));
static_assert(same(DGM_CONTACT_STATUS_CLEAR, dgm::ContactStatus::Clear));
static_assert(same(DGM_CONTACT_STATUS_CONTACT, dgm::ContactStatus::Contact));
static_assert(same(DGM_CONTACT_STATUS_RESTORED, dgm::ContactStatus::Restored));
static_assert(same(DGM_CONTACT_STATUS_OPEN, dgm::ContactStatus::Open));
}  // namespace

extern "C" {

dgm_code dgm_contact_solver_create(const dgm_state* state, const dgm_allocator* allocator, dgm_contact_solver** solver,
                                   dgm_error* error) {
    if (state == nullptr || solver == nullptr) return finish(kNull, error);
    *solver = nullptr;
    auto a = allocator_of(allocator);
    if (!a) return finish(a.error(), error);
    return hand_out(dgm::ContactSolver::create(state->value, a.value()), a.value(), solver, error);
}
void dgm_contact_solver_destroy(dgm_contact_solver* solver) {
    dgm::detail::destroy(solver);
}
uint32_t dgm_contact_solver_closed(const dgm_contact_solver* solver) {
    return solver != nullptr && solver->value.closed() ? 1 : 0;
}
double dgm_contact_solver_volume(const dgm_contact_solver* solver, const dgm_state* state) {
    return solver == nullptr || state == nullptr ? 0.0 : solver->value.volume(state->value);
}
dgm_code dgm_contact_solver_enclosed_volume(const dgm_contact_solver* solver, const dgm_state* state, double* volume,
                                            dgm_error* error) {
    if (solver == nullptr || state == nullptr || volume == nullptr) return finish(kNull, error);
    auto r = solver->value.enclosed_volume(state->value);
    if (!r) return finish(r.error(), error);
    *volume = r.value();
    return finish({}, error);
}

dgm_code dgm_resolve_contact(dgm_state* state, const dgm_contact_solver* solver, const dgm_obstacle* obstacle,
                             const dgm_contact_options* options, dgm_contact_report* report, dgm_error* error) {
    if (state == nullptr || solver == nullptr) return finish(kNull, error);
    auto shape = obstacle_of(obstacle);
    if (!shape) return finish(shape.error(), error);
    dgm_contact_options o;
    if (auto r = get(options, o); !r) return finish(r.error(), error);
    if (o.rings == nullptr && o.ring_count != 0) return finish(kNull, error);
    if (o.ring_count > kMaxRings)
        return finish({ErrorCode::BadArgument, kNoOffset, "more ring sizes than allowed"}, error);
    dgm::RingSize rings[kMaxRings];
    const auto read = get_each(o.rings, o.ring_count, [&](std::size_t k, const dgm_ring_size& size) {
        rings[k] = {size.total, size.reach, size.sigma};
    });
    if (!read) return finish(read.error(), error);
    dgm::ContactOptions wishes;
    wishes.bulge = static_cast<dgm::Bulge>(o.bulge);
    wishes.mode = static_cast<dgm::DeformMode>(o.mode);
    if (o.smoothing != 0) wishes.smoothing = o.smoothing;
    if (o.no_smoothing != 0) wishes.smoothing = 0;
    if (o.max_depth != 0) wishes.max_depth = o.max_depth;
    if (o.max_total != 0) wishes.max_total = o.max_total;
    wishes.rings = {rings, o.ring_count};
    auto done = dgm::resolve_contact(state->value, solver->value, shape.value(), wishes);
    if (!done) return finish(done.error(), error);
    const dgm::ContactReport& r = done.value();
    put(report, dgm_contact_report{0, static_cast<std::uint32_t>(r.status), r.volume_kept ? 1u : 0u, r.sunk ? 1u : 0u,
                                   r.samples, r.ring, r.passes, r.deepest, r.total, r.ring_reach, r.ring_sigma, r.beta,
                                   r.removed, r.volume_error, r.first_order_error, r.paper_error});
    return finish({}, error);
}

dgm_code dgm_obstacle_distance(const dgm_obstacle* obstacle, const float point[3], float* distance, float nearest[3],
                               dgm_error* error) {
    if (point == nullptr) return finish(kNull, error);
    auto shape = obstacle_of(obstacle);
    if (!shape) return finish(shape.error(), error);
    auto found = dgm::obstacle_distance(shape.value(), vec(point));
    if (!found) return finish(found.error(), error);
    if (distance != nullptr) *distance = found.value().distance;
    if (nearest != nullptr) store(found.value().nearest, nearest);
    return finish({}, error);
}

dgm_code dgm_snapshots_create(const dgm_state* state, const dgm_snapshot_options* options,
                              const dgm_allocator* allocator, dgm_snapshots** snapshots, dgm_error* error) {
    if (state == nullptr || snapshots == nullptr) return finish(kNull, error);
    *snapshots = nullptr;
    dgm_snapshot_options o;
    auto a = get(options, o, allocator);
    if (!a) return finish(a.error(), error);
    dgm::SnapshotOptions wishes;
    if (o.slots != 0) wishes.slots = o.slots;
    if (o.max_bytes != 0) wishes.max_bytes = o.max_bytes;
    wishes.normals = o.no_normals == 0;
    wishes.allocator = a.value();
    return hand_out(dgm::Snapshots::create(state->value, wishes), a.value(), snapshots, error);
}
void dgm_snapshots_destroy(dgm_snapshots* snapshots) {
    dgm::detail::destroy(snapshots);
}
dgm_code dgm_snapshots_publish(dgm_snapshots* snapshots, const dgm_state* state, uint64_t tag, uint64_t* frame,
                               dgm_error* error) {
    if (snapshots == nullptr || state == nullptr) return finish(kNull, error);
    auto done = snapshots->value.publish(state->value, tag);
    if (!done) return finish(done.error(), error);
    if (frame != nullptr) *frame = done.value();
    return finish({}, error);
}
uint64_t dgm_snapshots_frame(const dgm_snapshots* snapshots) {
    return snapshots == nullptr ? 0 : snapshots->value.frame();
}
dgm_code dgm_snapshots_read(const dgm_snapshots* snapshots, float* positions, float* normals, size_t floats_each,
                            dgm_snapshot_info* info, dgm_error* error) {
    if (snapshots == nullptr) return finish(kNull, error);
    if ((positions != nullptr || normals != nullptr) && floats_each == 0)
        return finish({ErrorCode::BufferTooSmall, kNoOffset, "the memory for the snapshot is too small"}, error);
    const auto done = snapshots->value.read({positions, positions == nullptr ? 0 : floats_each},
                                            {normals, normals == nullptr ? 0 : floats_each});
    if (!done) return finish(done.error(), error);
    put(info, dgm_snapshot_info{0, done.value().retries, done.value().frame, done.value().tag});
    return finish({}, error);
}

dgm_code dgm_asset_get_usage(const dgm_asset* asset, dgm_asset_usage* usage, dgm_error* error) {
    if (asset == nullptr || usage == nullptr) return finish(kNull, error);
    const dgm::AssetUsage u = asset->value.usage();
    put(usage, dgm_asset_usage{0, u.mapped_bytes, u.heap_bytes});
    return finish({}, error);
}
dgm_code dgm_state_get_usage(const dgm_state* state, dgm_state_usage* usage, dgm_error* error) {
    if (state == nullptr || usage == nullptr) return finish(kNull, error);
    const dgm::StateUsage u = state->value.usage();
    put(usage, dgm_state_usage{0, u.samples, u.active_samples, u.dirty_samples, u.bytes});
    return finish({}, error);
}

}  // extern "C"
