// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/camera.h
// The point of view of a picture.
#pragma once
#include <cstdint>
#include <span>

#include "model/tri_mesh.h"

namespace dgm::render {

enum class UpAxis { kY, kZ };

/// Direction from the object to the camera. Yaw 0, pitch 0 looks at the front: along -z for y up, along +y for z up.
/// Positive yaw walks to the object's left side (+x), positive pitch climbs.
struct View {
    double yaw_degrees = 30, pitch_degrees = 20;
    UpAxis up = UpAxis::kY;
};

/// The view in a ring of views that shows most surface, front sides before back sides, with a slight preference for the
/// default view. Depends on nothing but the mesh.
[[nodiscard]] View choose_view(const model::TriMesh& mesh, UpAxis up = UpAxis::kY);

struct Frame {
    model::Vec3d right, up, towards;  ///< orthonormal; `towards` points from the object to the camera
};
[[nodiscard]] Frame view_frame(const View& view);
[[nodiscard]] model::Vec3d up_direction(UpAxis up);

struct Camera {
    Frame frame;
    model::Vec3d vertical{0, 1, 0};  ///< the world's up, unit
    model::Vec3d eye;                ///< perspective: centre of projection; orthographic: centre of the image plane
    bool orthographic = false;
    double half_width = 1, half_height = 1;  ///< of the image: at distance 1, or in source units if orthographic

    struct Ray {
        model::Vec3d origin, direction;  ///< direction is unit
    };
    /// Ray through the image point (x, y); x runs from 0 at the left edge to 1, y from 0 at the top edge to 1.
    [[nodiscard]] Ray ray(double x, double y) const;
};

struct CameraOptions {
    bool orthographic = false;
    double field_of_view_degrees = 28;  ///< of the image's shorter side
    double margin = 0.08;               ///< share of the image left free on each side
};

/// The camera that shows every point, as large as the margin lets it be. Points that are not finite are left out;
/// without points the unit cube is shown.
[[nodiscard]] Camera fit_camera(std::span<const model::Vec3d> points, const View& view, std::uint32_t width,
                                std::uint32_t height, const CameraOptions& options = {});

}  // namespace dgm::render
