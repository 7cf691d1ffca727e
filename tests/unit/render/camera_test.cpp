// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/camera_test.cpp
#include "render/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dgm::render {
namespace {
using model::Vec3d;

void expect_near(const Vec3d& a, const Vec3d& b) {
    EXPECT_LT(length(a - b), 1e-12) << a.x << ' ' << a.y << ' ' << a.z;
}

/// Where the camera sees a point; 0..1 inside the picture.
model::Vec2d project(const Camera& camera, const Vec3d& p) {
    const Vec3d q = p - camera.eye;
    const double depth = camera.orthographic ? 1 : -dot(q, camera.frame.towards);
    return {0.5 + 0.5 * dot(q, camera.frame.right) / depth / camera.half_width,
            0.5 - 0.5 * dot(q, camera.frame.up) / depth / camera.half_height};
}

TEST(Camera, FrontSideAndTopViews) {
    expect_near(view_frame({0, 0}).towards, {0, 0, 1});
    expect_near(view_frame({0, 0}).right, {1, 0, 0});
    expect_near(view_frame({90, 0}).towards, {1, 0, 0});
    expect_near(view_frame({90, 0}).right, {0, 0, -1});
    expect_near(view_frame({0, 90}).towards, {0, 1, 0});
    expect_near(view_frame({0, 0, UpAxis::kZ}).towards, {0, -1, 0});
    expect_near(view_frame({0, 0, UpAxis::kZ}).up, {0, 0, 1});
}

TEST(Camera, FitUsesThePictureUpToItsMargin) {
    const std::vector<Vec3d> points{{-3, 1, 2}, {5, 0, 1}, {0, 4, -6}, {1, 1, 9}, {1e7, std::nan(""), 0}};
    for (const bool orthographic : {false, true}) {
        const Camera camera = fit_camera(points, {40, 25}, 300, 500, {orthographic, 28, 0.1});
        double widest = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const model::Vec2d at = project(camera, points[k]);
            widest = std::max({widest, std::abs(at.x - 0.5), std::abs(at.y - 0.5)});
        }
        EXPECT_LE(widest, 0.4 + 1e-9);
        EXPECT_GT(widest, 0.39);
        const Camera::Ray ray = camera.ray(0.25, 0.75);
        const model::Vec2d back = project(camera, ray.origin + 3.0 * ray.direction);
        EXPECT_NEAR(back.x, 0.25, 1e-12);
        EXPECT_NEAR(back.y, 0.75, 1e-12);
    }
}

TEST(Camera, OnePointAndNoPointAtAllStillGiveAPicture) {
    for (const auto& points : {std::vector<Vec3d>{}, std::vector<Vec3d>{{2, 2, 2}}}) {
        const Camera camera = fit_camera(points, {}, 100, 100);
        EXPECT_TRUE(is_finite(camera.eye));
        EXPECT_GT(camera.half_width, 0);
    }
}

TEST(Camera, AutomaticViewFacesASheet) {
    model::TriMesh sheet;  // in the plane x = 0, its front looks along +x
    sheet.positions = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
    sheet.faces = {{0, 1, 2}, {0, 2, 3}};
    EXPECT_GT(view_frame(choose_view(sheet)).towards.x, 0.8);
    sheet.faces = {{0, 2, 1}, {0, 3, 2}};
    EXPECT_LT(view_frame(choose_view(sheet)).towards.x, -0.8);
}

}  // namespace
}  // namespace dgm::render
