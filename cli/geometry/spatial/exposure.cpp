// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/exposure.cpp
#include "geometry/spatial/exposure.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/mesh/infinity.h"
#include "geometry/spatial/without_parent.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {
using model::Face;
using model::TriMesh;
using model::Vec3d;

/// Rays start so far above the surface, of its diagonal: more than what single precision rounds off.
constexpr double kLift = 1e-4;

void check(bool ok) {
    if (!ok) throw model::Error(model::codes::kSystemBusy, "Embree cannot build a hierarchy for rays");
}

/// One device a process. Wider instructions round differently; a ray along a face must meet it on every machine or on
/// none, since cuts follow from it.
RTCDevice device() {
    static RTCDevice instance = rtcNewDevice("set_affinity=0,isa=sse2");
    check(instance != nullptr);
    return instance;
}

/// Directions of equal weight: points spread evenly over the unit disk (a sunflower), lifted to the half sphere.
std::array<Vec3d, ExposureIndex::kRays> directions() {
    std::array<Vec3d, ExposureIndex::kRays> out;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (std::size_t k = 0; k < out.size(); ++k) {
        const double squared = (static_cast<double>(k) + 0.5) / ExposureIndex::kRays, radius = std::sqrt(squared);
        const double turn = golden * static_cast<double>(k);
        out[k] = {radius * math::cos(turn), radius * math::sin(turn), std::sqrt(1 - squared)};
    }
    return out;
}

struct Float3 {
    float x, y, z;
};
}  // namespace

struct ExposureIndex::Impl {
    std::array<Vec3d, kRays> rays = directions();
    Vec3d centre;
    double to_unit = 1;
    RTCScene scene = nullptr;

    explicit Impl(const TriMesh& mesh) {
        Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
        std::vector<Face> faces;
        for (const Face& f : mesh.faces) {
            if (!std::all_of(f.begin(), f.end(), [&](std::uint32_t v) {
                    return v < mesh.positions.size() && is_finite(mesh.positions[v]);
                }))
                continue;
            for (const std::uint32_t v : f)
                for (int k = 0; k < 3; ++k) {
                    low[k] = std::min(low[k], mesh.positions[v][k]);
                    high[k] = std::max(high[k], mesh.positions[v][k]);
                }
            faces.push_back(f);
        }
        if (faces.empty()) return;
        centre = low * 0.5 + high * 0.5;
        const double half = length(high * 0.5 - low * 0.5);
        if (half > 0 && std::isfinite(0.5 / half)) to_unit = 0.5 / half;
        build(mesh.positions, faces);
    }
    ~Impl() {
        if (scene != nullptr) rtcReleaseScene(scene);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void build(const std::vector<Vec3d>& positions, const std::vector<Face>& faces) {
        scene = rtcNewScene(device());
        check(scene != nullptr);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* corners = static_cast<Float3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Float3), positions.size()));
        auto* indices = static_cast<Face*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Face), faces.size()));
        if (corners == nullptr || indices == nullptr) rtcReleaseGeometry(geometry);
        check(corners != nullptr && indices != nullptr);
        for (std::size_t v = 0; v < positions.size(); ++v) {
            const Vec3d p = is_finite(positions[v]) ? (positions[v] - centre) * to_unit : Vec3d{};
            corners[v] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
        }
        std::copy(faces.begin(), faces.end(), indices);
        rtcAttachGeometry(scene, geometry);
        // One thread builds, so that the hierarchy does not depend on how many there are.
        tbb::task_arena alone(1);
        alone.execute([&] {
            rtcCommitGeometry(geometry);
            without_parent([this] { rtcJoinCommitScene(scene); });
        });
        rtcReleaseGeometry(geometry);
        check(rtcGetDeviceError(device()) == RTC_ERROR_NONE);
    }

    [[nodiscard]] bool escapes(const Vec3d& from, const Vec3d& along) const {
        RTCRay ray{};
        ray.org_x = static_cast<float>(from.x);
        ray.org_y = static_cast<float>(from.y);
        ray.org_z = static_cast<float>(from.z);
        ray.dir_x = static_cast<float>(along.x);
        ray.dir_y = static_cast<float>(along.y);
        ray.dir_z = static_cast<float>(along.z);
        ray.tfar = std::numeric_limits<float>::infinity();
        ray.mask = ~0u;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene, &context, &ray);
        return ray.tfar >= 0;  // an obstacle sets it to minus infinity
    }
};

ExposureIndex::ExposureIndex(const TriMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
ExposureIndex::~ExposureIndex() = default;
ExposureIndex::ExposureIndex(ExposureIndex&&) noexcept = default;
ExposureIndex& ExposureIndex::operator=(ExposureIndex&&) noexcept = default;

double ExposureIndex::at(const Vec3d& point, const Vec3d& normal) const {
    if (impl_->scene == nullptr || !is_finite(point) || !(dot(normal, normal) > 0)) return 1;
    // Two directions across the normal, from the axis it is farthest from.
    const Vec3d axis = std::abs(normal.x) <= std::abs(normal.y) && std::abs(normal.x) <= std::abs(normal.z)
                           ? Vec3d{1, 0, 0}
                       : std::abs(normal.y) <= std::abs(normal.z) ? Vec3d{0, 1, 0}
                                                                  : Vec3d{0, 0, 1};
    const Vec3d s = normalized(cross(axis, normal), Vec3d{}), t = cross(normal, s);
    const Vec3d from = (point - impl_->centre) * impl_->to_unit + normal * kLift;
    int free = 0;
    for (const Vec3d& d : impl_->rays) free += impl_->escapes(from, s * d.x + t * d.y + normal * d.z);
    return static_cast<double>(free) / kRays;
}

std::vector<double> vertex_exposure(const TriMesh& mesh) {
    const ExposureIndex index(mesh);
    std::vector<Vec3d> normals(mesh.positions.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto q = mesh.corners(f);
        const Vec3d normal = cross(q[1] - q[0], q[2] - q[0]);
        for (const std::uint32_t v : mesh.faces[f]) normals[v] = normals[v] + normal;
    }
    std::vector<double> out(mesh.positions.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, out.size(), 64), [&](const auto& range) {
        for (std::size_t v = range.begin(); v < range.end(); ++v)
            out[v] = index.at(mesh.positions[v], normalized(normals[v], Vec3d{}));
    });
    return out;
}

}  // namespace dgm::bake
