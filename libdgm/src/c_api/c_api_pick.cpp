// SPDX-License-Identifier: MIT
// libdgm/src/c_api/c_api_pick.cpp
// dgm.h: rays and changed samples.
#include <dgm/changed.h>
#include <dgm/pick.h>

#include "c_api/c_api_impl.h"

namespace {
using dgm::ErrorCode;
using dgm::kNoOffset;
using namespace dgm::c_api;

constexpr std::size_t kMaxRanges = 256;

/// The caller's list: elements as far apart as the first one says.
dgm::Result<void> check_ranges(const dgm_changed_range* ranges, std::size_t capacity,
                               const std::size_t* count) noexcept {
    if (ranges == nullptr || count == nullptr) return kNull;
    if (capacity == 0) return dgm::Error{ErrorCode::BufferTooSmall, kNoOffset, "there is no room for the ranges"};
    if (ranges->struct_size < sizeof(std::uint32_t) || ranges->struct_size > kMaxStruct) return kBadSize;
    return {};
}
void give_ranges(const dgm::ChangedRange* from, std::size_t written, dgm_changed_range* ranges,
                 std::size_t* count) noexcept {
    for (std::size_t k = 0; k < written; ++k) {
        dgm_changed_range* to = element(ranges, k);
        to->struct_size = ranges->struct_size;
        put(to, dgm_changed_range{0, from[k].first, from[k].columns, from[k].rows});
    }
    *count = written;
}
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

dgm_code dgm_state_changed_rows(const dgm_state* state, uint64_t* cursor, dgm_changed_range* ranges, size_t capacity,
                                size_t* count, dgm_error* error) {
    if (state == nullptr || cursor == nullptr) return finish(kNull, error);
    if (auto r = check_ranges(ranges, capacity, count); !r) return finish(r.error(), error);
    dgm::ChangedRange list[kMaxRanges];
    const auto done = dgm::changed_rows(state->value, *cursor, {list, std::min(capacity, kMaxRanges)});
    if (!done) return finish(done.error(), error);
    give_ranges(list, done.value(), ranges, count);
    return finish({}, error);
}

dgm_code dgm_snapshots_read_changed(const dgm_snapshots* snapshots, float* positions, float* normals,
                                    size_t floats_each, uint64_t since, dgm_changed_range* ranges, size_t capacity,
                                    size_t* count, dgm_snapshot_info* info, dgm_error* error) {
    if (snapshots == nullptr) return finish(kNull, error);
    if (auto r = check_ranges(ranges, capacity, count); !r) return finish(r.error(), error);
    if ((positions != nullptr || normals != nullptr) && floats_each == 0)
        return finish({ErrorCode::BufferTooSmall, kNoOffset, "the memory for the snapshot is too small"}, error);
    dgm::ChangedRange list[kMaxRanges];
    const auto done = snapshots->value.read_changed({positions, positions == nullptr ? 0 : floats_each},
                                                    {normals, normals == nullptr ? 0 : floats_each}, since,
                                                    {list, std::min(capacity, kMaxRanges)});
    if (!done) return finish(done.error(), error);
    give_ranges(list, done.value().ranges, ranges, count);
    put(info, dgm_snapshot_info{0, done.value().info.retries, done.value().info.frame, done.value().info.tag});
    return finish({}, error);
}

}  // extern "C"
