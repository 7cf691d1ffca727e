// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/camera.cpp
#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "math/portable.h"

namespace dgm::render {
namespace {
using model::Vec3d;

constexpr double radians(double degrees) {
    return degrees * std::numbers::pi / 180;
}

struct Extent {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
    void add(double x) {
        low = std::min(low, x);
        high = std::max(high, x);
    }
    [[nodiscard]] double middle() const { return 0.5 * (low + high); }
    [[nodiscard]] double half() const { return 0.5 * (high - low); }
};

struct Extents {
    Extent x, y, z;
    void add(const Vec3d& p) {
        x.add(p.x);
        y.add(p.y);
        z.add(p.z);
    }
};
}  // namespace

Vec3d up_direction(UpAxis up) {
    return up == UpAxis::kY ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
}

Frame view_frame(const View& view) {
    const double yaw = radians(view.yaw_degrees), pitch = radians(view.pitch_degrees);
    const Vec3d up = up_direction(view.up);
    const Vec3d front = view.up == UpAxis::kY ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0};
    const Vec3d side = cross(up, front);
    const Vec3d level = math::cos(yaw) * front + math::sin(yaw) * side;
    Frame frame;
    frame.towards = math::cos(pitch) * level + math::sin(pitch) * up;
    frame.right = math::cos(yaw) * side - math::sin(yaw) * front;
    frame.up = cross(frame.towards, frame.right);
    return frame;
}

View choose_view(const model::TriMesh& mesh, UpAxis up) {
    constexpr double kYaws[] = {30, -30, 0, 60, -60, 90, -90, 120, -120, 150, -150, 180};
    constexpr double kPitches[] = {20, 50};
    constexpr double kBackSideWorth = 0.8;  // a back side is drawn, but is less often the side of interest
    constexpr double kPreference = 0.03;    // each later candidate has to show so much more than the first
    std::vector<Vec3d> areas;
    areas.reserve(mesh.faces.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto p = mesh.corners(f);
        const Vec3d area = cross(p[1] - p[0], p[2] - p[0]);
        if (is_finite(area)) areas.push_back(area);
    }
    View best{kYaws[0], kPitches[0], up};
    double best_score = -1;
    double worth = 1;
    for (const double pitch : kPitches)
        for (const double yaw : kYaws) {
            const View candidate{yaw, pitch, up};
            const Vec3d towards = view_frame(candidate).towards;
            double shown = 0;
            for (const Vec3d& area : areas) {
                const double projected = dot(area, towards);
                shown += projected > 0 ? projected : -kBackSideWorth * projected;
            }
            if (shown * worth > best_score) {
                best_score = shown * worth;
                best = candidate;
            }
            worth *= 1 - kPreference;
        }
    return best;
}

Camera::Ray Camera::ray(double x, double y) const {
    const Vec3d across = (2 * x - 1) * half_width * frame.right + (1 - 2 * y) * half_height * frame.up;
    if (orthographic) return {eye + across, -frame.towards};
    return {eye, normalized(across - frame.towards)};
}

Camera fit_camera(std::span<const Vec3d> points, const View& view, std::uint32_t width, std::uint32_t height,
                  const CameraOptions& options) {
    Camera camera;
    camera.frame = view_frame(view);
    camera.vertical = up_direction(view.up);
    camera.orthographic = options.orthographic;
    const auto [right, up, towards] = camera.frame;
    const double w = std::max(1u, width), h = std::max(1u, height);
    const double share = 1 - 2 * std::clamp(options.margin, 0.0, 0.45);

    std::vector<Vec3d> local;  // right, up, towards: relative to the box's centre in the camera's frame
    Extents box;
    for (const Vec3d& p : points) {
        if (!is_finite(p)) continue;
        local.push_back({dot(p, right), dot(p, up), dot(p, towards)});
        box.add(local.back());
    }
    if (local.empty()) {
        local = {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
        for (const Vec3d& q : local) box.add(q);
    }
    const auto [ex, ey, ez] = box;
    double cx = ex.middle(), cy = ey.middle();
    const double cz = ez.middle();
    const double size = std::max({ex.half(), ey.half(), ez.half()});
    const double smallest = size > 0 ? size : 1;  // a single point still has a picture

    if (options.orthographic) {
        const double scale = std::max({ex.half() / (w * share), ey.half() / (h * share), 1e-3 * smallest / w});
        camera.half_width = scale * w;
        camera.half_height = scale * h;
        camera.eye = cx * right + cy * up + (cz + 4 * smallest) * towards;
        return camera;
    }
    const double shorter = math::tan(radians(0.5 * options.field_of_view_degrees));
    camera.half_width = shorter * w / std::min(w, h);
    camera.half_height = shorter * h / std::min(w, h);
    double distance = 0;
    // Near parts look larger, so the middle of the picture is not that of the box; four rounds settle it to under a
    // pixel.
    for (int round = 0; round < 4; ++round) {
        distance = 1.05 * ez.half() + 1e-3 * smallest;
        for (const Vec3d& q : local) {
            const double nearer = q.z - cz;
            distance = std::max({distance, std::abs(q.x - cx) / (camera.half_width * share) + nearer,
                                 std::abs(q.y - cy) / (camera.half_height * share) + nearer});
        }
        if (round == 3) break;
        Extent px, py;
        for (const Vec3d& q : local) {
            const double depth = distance - (q.z - cz);
            px.add((q.x - cx) / depth);
            py.add((q.y - cy) / depth);
        }
        cx += px.middle() * distance;
        cy += py.middle() * distance;
    }
    camera.eye = cx * right + cy * up + (cz + distance) * towards;
    return camera;
}

}  // namespace dgm::render
