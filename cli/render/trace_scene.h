// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/trace_scene.h
// The surface and its lines in Embree, in a frame of about unit size (private to the renderer).
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "model/tri_mesh.h"
#include "render/renderer.h"

namespace dgm::render {

/// Immutable after construction; rays may be traced from any number of threads.
class TraceScene {
 public:
    TraceScene(const model::TriMesh& mesh, std::span<const Segment> segments);
    ~TraceScene();
    TraceScene(const TraceScene&) = delete;
    TraceScene& operator=(const TraceScene&) = delete;

    struct Hit {
        double distance = 0;
        std::uint32_t face = 0;  ///< of the mesh
        double barycentric[3] = {1, 0, 0};
        bool is_segment = false;
        std::uint32_t segment = 0;
        model::Vec3d segment_normal;  ///< unit
    };
    /// Points and distances are in the scene's frame: (p - centre) / size.
    [[nodiscard]] model::Vec3d to_scene(const model::Vec3d& p) const { return (p - centre_) / size_; }
    [[nodiscard]] bool first_hit(const model::Vec3d& origin, const model::Vec3d& direction, Hit& hit) const;
    /// Whether the surface (lines do not count) stands within `distance`.
    [[nodiscard]] bool occluded(const model::Vec3d& origin, const model::Vec3d& direction, double distance) const;
    [[nodiscard]] bool empty() const { return kept_.empty(); }
    [[nodiscard]] model::Vec3d low() const { return low_; }
    [[nodiscard]] model::Vec3d high() const { return high_; }

 private:
    struct Device;
    std::unique_ptr<Device> device_;
    std::vector<std::uint32_t> kept_;  // face of each Embree triangle
    model::Vec3d centre_, low_, high_;
    double size_ = 1;
};

}  // namespace dgm::render
