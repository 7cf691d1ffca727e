// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/renderer_test.cpp
#include "render/renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "model/error.h"
#include "render/chart_surface.h"
#include "render/colour.h"
#include "render/normals.h"
#include "sample_chart.h"

namespace dgm::render {
namespace {
using model::Rgba8;
using model::Vec3d;

model::TriMesh sphere(std::uint32_t rings, std::uint32_t around) {
    model::TriMesh mesh;
    for (std::uint32_t r = 0; r <= rings; ++r)
        for (std::uint32_t a = 0; a < around; ++a) {
            const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * a / around;
            const double radius = r == rings ? 0 : std::sin(theta);  // the pole is one point
            mesh.positions.push_back({radius * std::sin(phi), std::cos(theta), radius * std::cos(phi)});
        }
    for (std::uint32_t r = 0; r < rings; ++r)
        for (std::uint32_t a = 0; a < around; ++a) {
            const std::uint32_t b = (a + 1) % around, p = r * around + a, q = r * around + b;
            mesh.faces.push_back({p, p + around, q + around});
            mesh.faces.push_back({p, q + around, q});
        }
    return mesh;
}

/// Unit square in the plane z = 0, front to +z.
model::TriMesh square() {
    model::TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face) mesh.corner_uvs.push_back({mesh.positions[v].x, mesh.positions[v].y});
    return mesh;
}

Camera front(double half, Vec3d centre = {}) {
    Camera camera;
    camera.frame = view_frame({0, 0});
    camera.orthographic = true;
    camera.half_width = camera.half_height = half;
    camera.eye = centre + Vec3d{0, 0, 10};
    return camera;
}

RenderOptions bare(std::uint32_t side) {
    RenderOptions options;
    options.width = options.height = side;
    options.shading = 0;
    options.ground_shadow = false;
    options.background = {255, 255, 255, 255};
    return options;
}

TEST(Renderer, SphereCoversPiRSquared) {
    const model::TriMesh mesh = sphere(96, 192);
    Surface surface;
    surface.mesh = &mesh;
    surface.plain = {0, 0, 0, 255};
    const formats::Image image = render_mesh(surface, front(1.25), bare(250));
    double covered = 0;  // in pixels; partly covered ones are gray in linear light
    for (const Rgba8& pixel : image.pixels) covered += 1 - linear(pixel).g;
    const double pixel_side = 2.5 / 250;
    EXPECT_NEAR(covered * pixel_side * pixel_side, std::numbers::pi, 0.01 * std::numbers::pi);
}

TEST(Renderer, CentreOfASphereIsLitBySkyAndKeyLight) {
    const model::TriMesh mesh = sphere(96, 192);
    Surface surface;
    surface.mesh = &mesh;
    surface.plain = {188, 188, 188, 255};
    RenderOptions options = bare(101);
    options.shading = 1;
    options.samples_per_pixel = 64;
    const formats::Image image = render_mesh(surface, front(1.25), options);
    // The normal looks at the camera: half the sky above the horizon, half below, nothing hides it. Green: sky 0.78
    // below to 1.05 above with strength 0.62; key (-0.45, 0.85, 0.75) / 1.2197, 0.62 strong, times 0.985; highlight
    // 0.15 cos(a / 2)^40 with cos a = 0.6149.
    const double sky = 0.62 * 0.915, key = 0.62 * 0.985 * 0.75 / 1.21963, half = std::sqrt((1 + 0.75 / 1.21963) / 2);
    const double expected = 0.5029 * (sky + key) + 0.15 * std::pow(half, 40);
    EXPECT_NEAR(linear(image.at(50, 50)).g, expected, 0.02);
    // From above the left shoulder: the upper left is brighter than the lower right.
    EXPECT_GT(linear(image.at(36, 30)).g, linear(image.at(66, 72)).g + 0.15);
}

TEST(Renderer, TextureIsUprightAndItsColoursAreExact) {
    const model::TriMesh mesh = square();
    Surface surface;
    surface.mesh = &mesh;
    const Rgba8 red{220, 10, 20, 255}, green{10, 200, 30, 255}, blue{20, 30, 210, 255}, yellow{230, 220, 10, 255};
    surface.textures = {{4,
                         4,
                         {red, red, green, green, red, red, green, green,  // row 0 is the top one
                          blue, blue, yellow, yellow, blue, blue, yellow, yellow}}};
    const formats::Image image = render_mesh(surface, front(0.5, {0.5, 0.5, 0}), bare(64));
    EXPECT_EQ(image.at(16, 16), red);  // between texels of one colour
    EXPECT_EQ(image.at(48, 16), green);
    EXPECT_EQ(image.at(16, 48), blue);
    EXPECT_EQ(image.at(48, 48), yellow);

    RenderOptions lit = bare(64);
    lit.shading = 1;
    const Rgba8 pixel = render_mesh(surface, front(0.5, {0.5, 0.5, 0}), lit).at(16, 16);
    EXPECT_GT(pixel.r, 150);
    EXPECT_LT(pixel.g, 80);
}

TEST(Renderer, ScalarsAreMappedBetweenTheirEnds) {
    const model::TriMesh mesh = square();
    Surface surface;
    surface.mesh = &mesh;
    surface.scalars = {2, 4, 4, 2};
    surface.scalar_low = 2;
    surface.scalar_high = 4;
    RenderOptions options = bare(65);
    options.samples_per_pixel = 1;
    const formats::Image image = render_mesh(surface, front(0.5, {0.5, 0.5, 0}), options);
    for (const std::uint32_t x : {0u, 20u, 64u}) {
        const Rgba8 is = image.at(x, 32), want = sequential_colour((x + 0.5) / 65);
        EXPECT_NEAR(is.r, want.r, 3);
        EXPECT_NEAR(is.g, want.g, 3);
        EXPECT_NEAR(is.b, want.b, 3);
    }
}

TEST(Renderer, BackSidesLookLikeFrontSides) {
    model::TriMesh mesh = square(), turned = square();
    turned.faces = {{0, 2, 1}, {0, 3, 2}};
    turned.corner_uvs.clear();
    mesh.corner_uvs.clear();
    Surface surface;
    RenderOptions options = bare(32);
    options.shading = 1;
    surface.mesh = &mesh;
    const auto front_side = render_mesh(surface, front(0.6, {0.5, 0.5, 0}), options);
    surface.mesh = &turned;
    const auto back_side = render_mesh(surface, front(0.6, {0.5, 0.5, 0}), options);
    for (const std::uint32_t x : {8u, 16u, 24u}) EXPECT_NEAR(front_side.at(x, 16).g, back_side.at(x, 16).g, 3);
}

TEST(Renderer, AWallInTheWayMakesShadow) {
    model::TriMesh mesh = square();
    mesh.corner_uvs.clear();
    Surface surface;
    surface.mesh = &mesh;
    RenderOptions options = bare(64);
    options.shading = 1;
    const formats::Image open = render_mesh(surface, front(0.5, {0.5, 0.5, 0}), options);
    // A shelf along the upper edge keeps the key light and half the sky from the part below it.
    mesh.positions.insert(mesh.positions.end(), {{-1, 1.01, 0}, {2, 1.01, 0}, {2, 1.01, 0.8}, {-1, 1.01, 0.8}});
    mesh.faces.insert(mesh.faces.end(), {{4, 5, 6}, {4, 6, 7}});
    const formats::Image shaded = render_mesh(surface, front(0.5, {0.5, 0.5, 0}), options);
    EXPECT_LT(linear(shaded.at(32, 4)).g, 0.6f * linear(open.at(32, 4)).g);
}

TEST(Renderer, SegmentsAreDrawnWhereTheyAreVisible) {
    const model::TriMesh mesh = square();
    Surface surface;
    surface.mesh = &mesh;
    surface.plain = {255, 255, 255, 255};
    const Rgba8 red{200, 0, 0, 255}, blue{0, 0, 200, 255};
    surface.segments = {{{0.25, 0, 0}, {0.25, 1, 0}, red, 0.05}, {{0.75, 0, -0.2}, {0.75, 1, -0.2}, blue, 0.05}};
    const formats::Image image = render_mesh(surface, front(0.5, {0.5, 0.5, 0}), bare(100));
    EXPECT_EQ(image.at(25, 50), red);
    EXPECT_EQ(image.at(75, 50), (Rgba8{255, 255, 255, 255}));  // behind the square
    EXPECT_EQ(image.at(50, 50), (Rgba8{255, 255, 255, 255}));
}

TEST(Renderer, SameBytesWhateverTheNumberOfThreads) {
    const model::Chart chart = test::torus_chart(129, 257);
    const ChartSurface torus = chart_surface({&chart, 1});
    Surface surface;
    surface.mesh = &torus.mesh;
    surface.textures = torus.textures;
    add_segments(surface, torus.grid, {60, 60, 60, 255}, 0.004);
    RenderOptions options;
    options.width = 160;
    options.height = 120;
    std::vector<formats::Image> images;
    for (const std::size_t threads : {1u, 2u, 5u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        images.push_back(render_mesh(surface, std::nullopt, options));
    }
    EXPECT_EQ(images[0], images[1]);
    EXPECT_EQ(images[0], images[2]);
}

TEST(Renderer, MeshesWithoutSurfaceGiveTheBackground) {
    model::TriMesh mesh;
    Surface surface;
    surface.mesh = &mesh;
    const RenderOptions options = bare(8);
    EXPECT_EQ(render_mesh(surface, std::nullopt, options).pixels, std::vector<Rgba8>(64, options.background));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {nan, 1, 0}};
    mesh.faces = {{0, 1, 2}, {0, 1, 7}};
    EXPECT_EQ(render_mesh(surface, front(1), options).pixels, std::vector<Rgba8>(64, options.background));
}

TEST(Renderer, OffsetAndSizeDoNotMatter) {
    model::TriMesh near = sphere(24, 48), far = near;
    for (Vec3d& p : far.positions) p = 1e-4 * p + Vec3d{1e4, -1e4, 1e4};
    Surface surface;
    RenderOptions options;
    options.width = options.height = 48;
    surface.mesh = &near;
    const auto a = render_mesh(surface, View{30, 20}, options);
    surface.mesh = &far;
    const auto b = render_mesh(surface, View{30, 20}, options);
    double difference = 0;
    for (std::size_t k = 0; k < a.pixels.size(); ++k) difference += std::abs(a.pixels[k].g - b.pixels[k].g);
    EXPECT_LT(difference / static_cast<double>(a.pixels.size()), 0.5);
}

TEST(Renderer, RefusesImpossibleSizes) {
    const model::TriMesh mesh = square();
    Surface surface;
    surface.mesh = &mesh;
    RenderOptions options = bare(0);
    EXPECT_THROW(static_cast<void>(render_mesh(surface, front(1), options)), model::Error);
    options.width = options.height = 1u << 31;
    EXPECT_THROW(static_cast<void>(render_mesh(surface, front(1), options)), model::Error);
}

TEST(Normals, SmoothOverASphereAndSharpAtACubesEdges) {
    const model::TriMesh ball = sphere(32, 64);
    const auto smooth = smooth_corner_normals(ball, 50);
    for (std::size_t c = 0; c < smooth.size(); ++c)
        EXPECT_GT(dot(smooth[c], ball.positions[ball.faces[c / 3][c % 3]]), 0.99);
    model::TriMesh corner;  // two squares at a right angle that repeat their common vertices
    corner.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 1}};
    corner.faces = {{0, 1, 2}, {3, 5, 4}};
    for (const Vec3d& n : smooth_corner_normals(corner, 50))
        EXPECT_NEAR(std::max(std::abs(n.z), std::abs(n.y)), 1, 1e-12);
    const Vec3d shared = smooth_corner_normals(corner, 120)[0];
    EXPECT_NEAR(std::abs(shared.z), std::abs(shared.y), 0.4);
    EXPECT_GT(std::min(std::abs(shared.z), std::abs(shared.y)), 0.3);
}

}  // namespace
}  // namespace dgm::render
