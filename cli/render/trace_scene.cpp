// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/trace_scene.cpp
#include "render/trace_scene.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/spatial/without_parent.h"
#include "model/codes.h"

namespace dgm::render {
namespace {
using model::Vec3d;
constexpr unsigned kSurfaceId = 0, kSegmentsId = 1;

void check(bool ok) {
    if (!ok) throw model::Error(model::codes::kSystemBusy, "Embree could not build the scene");
}

template <class Element>
std::span<Element> new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
    void* data = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Element), count);
    check(data != nullptr);
    return {static_cast<Element*>(data), count};
}

/// Owns a geometry of Embree; scenes that it is attached to keep it alive.
class Geometry {
 public:
    Geometry(RTCDevice device, RTCGeometryType type) : geometry_(rtcNewGeometry(device, type)) {}
    ~Geometry() { rtcReleaseGeometry(geometry_); }
    Geometry(const Geometry&) = delete;
    Geometry& operator=(const Geometry&) = delete;
    operator RTCGeometry() const { return geometry_; }

 private:
    RTCGeometry geometry_;
};

struct Float3 {
    float x, y, z;
};
struct Float4 {
    float x, y, z, w;
};
struct Index3 {
    std::uint32_t a, b, c;
};

/// Faces whose corners exist and are finite.
std::vector<std::uint32_t> usable_faces(const model::TriMesh& mesh) {
    const auto usable = [&](std::uint32_t v) { return v < mesh.positions.size() && is_finite(mesh.positions[v]); };
    std::vector<std::uint32_t> out;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
        if (std::all_of(mesh.faces[f].begin(), mesh.faces[f].end(), usable)) out.push_back(f);
    return out;
}

struct Box {
    Vec3d low, high;
};

Box bounding_box(const model::TriMesh& mesh, std::span<const std::uint32_t> faces) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (const std::uint32_t f : faces)
        for (const std::uint32_t v : mesh.faces[f])
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], mesh.positions[v][k]);
                high[k] = std::max(high[k], mesh.positions[v][k]);
            }
    return {low, high};
}

void fill_triangles(RTCGeometry geometry, const TraceScene& scene, const model::TriMesh& mesh,
                    std::span<const std::uint32_t> faces) {
    const std::vector<Vec3d>& positions = mesh.positions;
    const auto corners = new_buffer<Float3>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Vec3d p = is_finite(positions[v]) ? scene.to_scene(positions[v]) : Vec3d{};
        corners[v] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    }
    const auto indices = new_buffer<Index3>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, faces.size());
    for (std::size_t t = 0; t < faces.size(); ++t) {
        const model::Face& face = mesh.faces[faces[t]];
        indices[t] = {face[0], face[1], face[2]};
    }
}

/// @param size  source units of one unit of the scene
void fill_tubes(RTCGeometry geometry, const TraceScene& scene, double size, std::span<const Segment> segments) {
    const auto ends = new_buffer<Float4>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 2 * segments.size());
    const auto firsts = new_buffer<std::uint32_t>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, segments.size());
    for (std::size_t s = 0; s < segments.size(); ++s) {
        const auto radius = static_cast<float>(segments[s].radius / size);
        std::size_t end = 2 * s;
        firsts[s] = static_cast<std::uint32_t>(end);
        for (const Vec3d& source : {segments[s].a, segments[s].b}) {
            const Vec3d p = scene.to_scene(source);
            ends[end++] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), radius};
        }
    }
}
}  // namespace

struct TraceScene::Device {
    RTCDevice device = nullptr;
    RTCScene surface = nullptr, everything = nullptr;

    void open() {
        device = rtcNewDevice(nullptr);
        check(device != nullptr);
        surface = rtcNewScene(device);
        everything = rtcNewScene(device);
        check(surface != nullptr && everything != nullptr);
        for (RTCScene scene : {surface, everything}) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    }
    ~Device() {
        if (surface != nullptr) rtcReleaseScene(surface);
        if (everything != nullptr) rtcReleaseScene(everything);
        if (device != nullptr) rtcReleaseDevice(device);
    }
};

TraceScene::~TraceScene() = default;

TraceScene::TraceScene(const model::TriMesh& mesh, std::span<const Segment> segments)
    : device_(std::make_unique<Device>()), kept_(usable_faces(mesh)) {
    if (kept_.empty()) return;
    const auto [low, high] = bounding_box(mesh, kept_);
    centre_ = 0.5 * low + 0.5 * high;
    size_ = length(0.5 * high - 0.5 * low) * 2;
    if (!(size_ > 0) || !std::isfinite(size_)) size_ = 1;
    low_ = to_scene(low);
    high_ = to_scene(high);

    device_->open();
    const Geometry triangles(device_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    fill_triangles(triangles, *this, mesh, kept_);
    rtcAttachGeometryByID(device_->surface, triangles, kSurfaceId);
    rtcAttachGeometryByID(device_->everything, triangles, kSurfaceId);
    std::optional<Geometry> tubes;
    if (!segments.empty()) {
        tubes.emplace(device_->device, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
        fill_tubes(*tubes, *this, size_, segments);
        rtcAttachGeometryByID(device_->everything, *tubes, kSegmentsId);
    }
    // One thread builds: Embree's parallel build orders the triangles of a leaf by the number of threads, and the
    // order decides which of two faces a ray through their common edge meets.
    tbb::task_arena alone(1);
    alone.execute([&] {
        rtcCommitGeometry(triangles);
        if (tubes) rtcCommitGeometry(*tubes);
        bake::without_parent([this] {
            rtcJoinCommitScene(device_->surface);
            rtcJoinCommitScene(device_->everything);
        });
    });
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
