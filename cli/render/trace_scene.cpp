// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/trace_scene.cpp
#include "render/trace_scene.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/codes.h"

namespace dgm::render {
namespace {
using model::Vec3d;
constexpr unsigned kSurfaceId = 0, kSegmentsId = 1;

void check(bool ok) {
    if (!ok) throw model::Error(model::codes::kInternal, "Embree could not build the scene");
}

template <class Element>
std::span<Element> new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
    void* data = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Element), count);
    check(data != nullptr);
    return {static_cast<Element*>(data), count};
}

struct Float3 {
    float x, y, z;
};
struct Float4 {
    float x, y, z, w;
};
struct Index3 {
    std::uint32_t a, b, c;
};
}  // namespace

struct TraceScene::Device {
    RTCDevice device = nullptr;
    RTCScene surface = nullptr, everything = nullptr;
    ~Device() {
        if (surface != nullptr) rtcReleaseScene(surface);
        if (everything != nullptr) rtcReleaseScene(everything);
        if (device != nullptr) rtcReleaseDevice(device);
    }
};

TraceScene::~TraceScene() = default;

TraceScene::TraceScene(const model::TriMesh& mesh, std::span<const Segment> segments)
    : device_(std::make_unique<Device>()) {
    const std::vector<Vec3d>& positions = mesh.positions;
    const auto usable = [&](std::uint32_t v) { return v < positions.size() && is_finite(positions[v]); };
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        const model::Face& face = mesh.faces[f];
        if (!std::all_of(face.begin(), face.end(), usable)) continue;
        for (const std::uint32_t v : face)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], positions[v][k]);
                high[k] = std::max(high[k], positions[v][k]);
            }
        kept_.push_back(f);
    }
    if (kept_.empty()) return;
    centre_ = 0.5 * low + 0.5 * high;
    size_ = length(0.5 * high - 0.5 * low) * 2;
    if (!(size_ > 0) || !std::isfinite(size_)) size_ = 1;
    low_ = to_scene(low), high_ = to_scene(high);

    device_->device = rtcNewDevice(nullptr);
    check(device_->device != nullptr);
    device_->surface = rtcNewScene(device_->device);
    device_->everything = rtcNewScene(device_->device);
    check(device_->surface != nullptr && device_->everything != nullptr);
    for (RTCScene scene : {device_->surface, device_->everything}) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);

    RTCGeometry triangles = rtcNewGeometry(device_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto corners = new_buffer<Float3>(triangles, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Vec3d p = is_finite(positions[v]) ? to_scene(positions[v]) : Vec3d{};
        corners[v] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    }
    const auto indices = new_buffer<Index3>(triangles, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, kept_.size());
    for (std::size_t t = 0; t < kept_.size(); ++t) {
        const model::Face& face = mesh.faces[kept_[t]];
        indices[t] = {face[0], face[1], face[2]};
    }
    rtcAttachGeometryByID(device_->surface, triangles, kSurfaceId);
    rtcAttachGeometryByID(device_->everything, triangles, kSurfaceId);

    RTCGeometry tubes = nullptr;
    if (!segments.empty()) {
        tubes = rtcNewGeometry(device_->device, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
        const auto ends = new_buffer<Float4>(tubes, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 2 * segments.size());
        const auto firsts = new_buffer<std::uint32_t>(tubes, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, segments.size());
        for (std::size_t s = 0; s < segments.size(); ++s) {
            const auto radius = static_cast<float>(segments[s].radius / size_);
            std::size_t end = 2 * s;
            firsts[s] = static_cast<std::uint32_t>(end);
            for (const Vec3d& source : {segments[s].a, segments[s].b}) {
                const Vec3d p = to_scene(source);
                ends[end++] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), radius};
            }
        }
        rtcAttachGeometryByID(device_->everything, tubes, kSegmentsId);
    }
    // One thread builds: Embree's parallel build orders the triangles of a leaf by the number of threads, and the
    // order decides which of two faces a ray through their common edge meets.
    tbb::task_arena alone(1);
    alone.execute([&] {
        rtcCommitGeometry(triangles);
        if (tubes != nullptr) rtcCommitGeometry(tubes);
        rtcJoinCommitScene(device_->surface);
        rtcJoinCommitScene(device_->everything);
    });
    rtcReleaseGeometry(triangles);
    if (tubes != nullptr) rtcReleaseGeometry(tubes);
    check(rtcGetDeviceError(device_->device) == RTC_ERROR_NONE);
}

bool TraceScene::first_hit(const Vec3d& origin, const Vec3d& direction, Hit& hit) const {
    if (kept_.empty()) return false;
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(origin.x);
    query.ray.org_y = static_cast<float>(origin.y);
    query.ray.org_z = static_cast<float>(origin.z);
    query.ray.dir_x = static_cast<float>(direction.x);
    query.ray.dir_y = static_cast<float>(direction.y);
    query.ray.dir_z = static_cast<float>(direction.z);
    query.ray.tfar = std::numeric_limits<float>::infinity();
    query.ray.mask = ~0u;
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(device_->everything, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit.distance = query.ray.tfar;
    hit.is_segment = query.hit.geomID == kSegmentsId;
    if (hit.is_segment) {
        hit.segment = query.hit.primID;
        hit.segment_normal = model::normalized(Vec3d{query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z});
        return true;
    }
    hit.face = kept_[query.hit.primID];
    hit.barycentric[1] = query.hit.u;
    hit.barycentric[2] = query.hit.v;
    hit.barycentric[0] = std::max(0.0, 1.0 - query.hit.u - query.hit.v);
    return true;
}

bool TraceScene::occluded(const Vec3d& origin, const Vec3d& direction, double distance) const {
    if (kept_.empty()) return false;
    RTCRay ray{};
    ray.org_x = static_cast<float>(origin.x);
    ray.org_y = static_cast<float>(origin.y);
    ray.org_z = static_cast<float>(origin.z);
    ray.dir_x = static_cast<float>(direction.x);
    ray.dir_y = static_cast<float>(direction.y);
    ray.dir_z = static_cast<float>(direction.z);
    ray.tfar = static_cast<float>(distance);
    ray.mask = ~0u;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(device_->surface, &context, &ray);
    return ray.tfar < 0;
}

}  // namespace dgm::render
