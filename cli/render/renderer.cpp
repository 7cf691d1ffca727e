// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/renderer.cpp
//
// The light: a bright sky that is whiter above than below, with the surface's own occlusion of it, and a key light of
// 5 degrees radius from above the camera's left shoulder. Shadow rays leave from a point that is lifted towards the
// smooth surface [Hanika 2021], or coarse meshes would show their facets along the shadow's edge.
//
// [Hanika 2021] Johannes Hanika. Hacking the shadow terminator. Ray Tracing Gems II, chapter 4.
#include "render/renderer.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "math/portable.h"
#include "model/codes.h"
#include "render/colour.h"
#include "render/normals.h"
#include "render/sampling.h"
#include "render/trace_scene.h"

namespace dgm::render {
namespace {
using model::Rgba8;
using model::Vec2d;
using model::Vec3d;

constexpr double kRayOffset = 2e-5;       // of the bounding-box diagonal; float positions are good to 1e-7
constexpr double kOcclusionReach = 0.45;  // farther walls than this share of the diagonal do not darken
constexpr double kKeySine = 0.087;
constexpr float kSkyStrength = 0.62f, kKeyStrength = 0.62f;
constexpr float kGlossPower = 40;
constexpr float kGroundShadow = 0.55f;

Rgb sky(double upness) {
    return mix({0.80f, 0.78f, 0.76f}, {1.04f, 1.05f, 1.07f}, static_cast<float>(0.5 + 0.5 * upness));
}

/// Keeps highlights from clipping: the identity up to 0.8, then bends to stay below 1.
float shoulder(float x) {
    return x <= 0.8f ? x : 0.8f + 0.2f * (1 - static_cast<float>(math::exp((0.8f - x) / 0.2f)));
}

Rgb texel(const formats::Image& image, std::int64_t x, std::int64_t y) {
    const auto wrap = [](std::int64_t k, std::uint32_t n) {
        const std::int64_t r = k % n;
        return static_cast<std::uint32_t>(r < 0 ? r + n : r);
    };
    return linear(image.at(wrap(x, image.width), wrap(y, image.height)));
}

Rgb bilinear(const formats::Image& image, Vec2d uv) {
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return {1, 0, 1};
    const double x = (uv.x - std::floor(uv.x)) * image.width - 0.5;
    const double y = (1 - (uv.y - std::floor(uv.y))) * image.height - 0.5;
    const auto x0 = static_cast<std::int64_t>(std::floor(x)), y0 = static_cast<std::int64_t>(std::floor(y));
    const auto tx = static_cast<float>(x - std::floor(x)), ty = static_cast<float>(y - std::floor(y));
    return mix(mix(texel(image, x0, y0), texel(image, x0 + 1, y0), tx),
               mix(texel(image, x0, y0 + 1), texel(image, x0 + 1, y0 + 1), tx), ty);
}

class Renderer {
 public:
    Renderer(const Surface& surface, const Camera& camera, const RenderOptions& options)
        : surface_(surface),
          mesh_(*surface.mesh),
          camera_(camera),
          options_(options),
          scene_(mesh_, surface.segments),
          background_(linear(options.background)) {
        if (mesh_.corner_normals.size() == 3 * mesh_.faces.size())
            normals_ = mesh_.corner_normals;
        else
            normals_ = smooth_corner_normals(mesh_, options.crease_degrees);
        const Frame& f = camera.frame;
        key_ = normalized(-0.45 * f.right + 0.85 * f.up + 0.75 * f.towards);
        up_ = camera.vertical;
        ground_ = dot(scene_.low(), up_);
        has_ground_ = options.ground_shadow && !scene_.empty() && dot(f.towards, up_) > 0.05 && dot(key_, up_) > 0.2;
    }

    [[nodiscard]] Rgba8 pixel(std::uint32_t x, std::uint32_t y) const {
        const std::uint32_t n = options_.samples_per_pixel;
        Rgb sum;
        for (std::uint32_t s = 0; s < n; ++s) sum += sample(x, y, s, {(s + 0.5) / n, radical_inverse(s) + 0.5 / n});
        return encoded(sum * (1.0f / static_cast<float>(n)));
    }

 private:
    struct Point {
        Vec3d position, lifted, normal, facing;  // facing: of the flat face; both normals face the camera
        Rgb colour;
        float shading;
        float gloss = kGloss;
    };

    [[nodiscard]] Rgb sample(std::uint32_t x, std::uint32_t y, std::uint32_t s, Vec2d inside) const {
        const Camera::Ray ray = camera_.ray((x + inside.x) / options_.width, (y + inside.y) / options_.height);
        const Vec3d origin = scene_.to_scene(ray.origin);
        TraceScene::Hit hit;
        if (!scene_.first_hit(origin, ray.direction, hit)) return backdrop(origin, ray.direction, x, y, s);
        const Point point =
            hit.is_segment ? point_on_segment(hit, origin, ray.direction) : point_on_face(hit, ray.direction);
        return shade(point, -ray.direction, x, y, s);
    }

    [[nodiscard]] Point point_on_segment(const TraceScene::Hit& hit, const Vec3d& origin,
                                         const Vec3d& direction) const {
        Point p;
        p.normal = p.facing = dot(hit.segment_normal, direction) > 0 ? -hit.segment_normal : hit.segment_normal;
        p.position = origin + hit.distance * direction;
        // The tube is half sunk into the surface: lift its shadow rays out of it.
        p.lifted = p.position;
        p.colour = linear(surface_.segments[hit.segment].colour);
        p.shading = static_cast<float>(options_.shading * 0.5);
        return p;
    }

    [[nodiscard]] Point point_on_face(const TraceScene::Hit& hit, const Vec3d& direction) const {
        const model::Face& face = mesh_.faces[hit.face];
        const auto& b = hit.barycentric;
        std::array<Vec3d, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = scene_.to_scene(mesh_.positions[face[k]]);
        Point p;
        p.facing = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]), -direction);
        if (dot(p.facing, direction) > 0) p.facing = -p.facing;
        std::array<Vec3d, 3> n;
        for (std::size_t k = 0; k < 3; ++k) {
            n[k] = normals_[3 * hit.face + k];
            if (!is_finite(n[k]) || n[k] == Vec3d{}) n[k] = p.facing;
            if (dot(n[k], p.facing) < 0) n[k] = -n[k];
            p.position += b[k] * corners[k];
            p.normal += b[k] * n[k];
        }
        p.normal = normalized(p.normal, p.facing);
        for (std::size_t k = 0; k < 3; ++k)
            p.lifted += b[k] * (p.position - std::min(0.0, dot(p.position - corners[k], n[k])) * n[k]);
        p.colour = colour_at(hit.face, b);
        const std::size_t material = hit.face < mesh_.face_materials.size() ? mesh_.face_materials[hit.face] : 0;
        if (material < surface_.gloss.size()) p.gloss = surface_.gloss[material];
        p.shading = static_cast<float>(options_.shading);
        return p;
    }

    [[nodiscard]] Rgb colour_at(std::uint32_t f, const double (&b)[3]) const {
        const model::Face& face = mesh_.faces[f];
        if (surface_.scalars.size() == mesh_.positions.size() && !surface_.scalars.empty()) {
            double value = 0;
            for (std::size_t k = 0; k < 3; ++k) value += b[k] * surface_.scalars[face[k]];
            const double range = surface_.scalar_high - surface_.scalar_low;
            return linear(sequential_colour(range > 0 ? (value - surface_.scalar_low) / range : 0 * value));
        }
        if (surface_.only_plain) return linear(surface_.plain);
        const bool has_material = f < mesh_.face_materials.size() && mesh_.face_materials[f] < mesh_.materials.size();
        const std::uint32_t material = has_material ? mesh_.face_materials[f] : 0;
        if (material < surface_.textures.size() && !surface_.textures[material].pixels.empty() &&
            mesh_.corner_uvs.size() == 3 * mesh_.faces.size()) {
            Vec2d uv;
            for (std::size_t k = 0; k < 3; ++k) uv = uv + b[k] * mesh_.corner_uvs[3 * f + k];
            return bilinear(surface_.textures[material], uv);
        }
        if (mesh_.corner_colours.size() == 3 * mesh_.faces.size()) {
            Rgb colour;
            for (std::size_t k = 0; k < 3; ++k)
                colour += linear(mesh_.corner_colours[3 * f + k]) * static_cast<float>(b[k]);
            return colour;
        }
        return linear(has_material ? mesh_.materials[material].diffuse : surface_.plain);
    }

    /// Sky and key light that reach a point on the ground or a surface, as shares of the light in an open field.
    struct Light {
        Rgb sky;
        float key = 0;
    };
    [[nodiscard]] Light light_at(const Vec3d& from, const Vec3d& normal, std::uint32_t x, std::uint32_t y,
                                 std::uint32_t s) const {
        Light light;
        const Vec2d sky_shift = pixel_shift(x, y, 1), key_shift = pixel_shift(x, y, 2);
        const std::uint32_t rays = options_.sky_rays;
        for (std::uint32_t r = 0; r < rays; ++r) {
            const Vec3d direction = cosine_direction(normal, r2_point(s * rays + r, sky_shift));
            if (!scene_.occluded(from, direction, kOcclusionReach)) light.sky += sky(dot(direction, up_));
        }
        light.sky = light.sky * (1.0f / static_cast<float>(rays));
        const double cosine = dot(normal, key_);
        if (cosine > 0 && !scene_.occluded(from, cone_direction(key_, kKeySine, r2_point(s, key_shift)), 4))
            light.key = static_cast<float>(cosine);
        return light;
    }

    [[nodiscard]] Rgb shade(const Point& p, const Vec3d& to_eye, std::uint32_t x, std::uint32_t y,
                            std::uint32_t s) const {
        if (p.shading <= 0) return p.colour;
        const Light light = light_at(p.lifted + kRayOffset * p.facing, p.normal, x, y, s);
        Rgb lit = p.colour * (light.sky * kSkyStrength + Rgb{1, 0.985f, 0.96f} * (kKeyStrength * light.key));
        const Vec3d half = normalized(key_ + to_eye, p.normal);
        const auto shine = static_cast<float>(std::max(0.0, dot(half, p.normal)));
        if (light.key > 0) lit += Rgb{1, 1, 1} * (p.gloss * static_cast<float>(math::pow(shine, kGlossPower)));
        return mix(p.colour, {shoulder(lit.r), shoulder(lit.g), shoulder(lit.b)}, p.shading);
    }

    /// Background, with the object's shadow where the ray meets the ground near it.
    [[nodiscard]] Rgb backdrop(const Vec3d& origin, const Vec3d& direction, std::uint32_t x, std::uint32_t y,
                               std::uint32_t s) const {
        const double fall = dot(direction, up_);
        if (!has_ground_ || fall > -1e-3) return background_;
        const double distance = (ground_ - dot(origin, up_)) / fall;
        const Vec3d position = origin + distance * direction;
        const Vec3d middle = 0.5 * (scene_.low() + scene_.high());
        const Vec3d aside = position - middle - dot(position - middle, up_) * up_;
        const double fade = std::clamp(1.6 - length(aside) / 0.75, 0.0, 1.0);
        if (distance <= 0 || fade <= 0) return background_;
        const Light light = light_at(position + kRayOffset * up_, up_, x, y, s);
        const float open = kSkyStrength * 1.0f + kKeyStrength * static_cast<float>(dot(key_, up_));
        const float reached = kSkyStrength * light.sky.g + kKeyStrength * light.key;
        const float shadow = std::clamp(1 - reached / open, 0.0f, 1.0f);
        return background_ * (1 - kGroundShadow * shadow * static_cast<float>(fade * fade * (3 - 2 * fade)));
    }

    const Surface& surface_;
    const model::TriMesh& mesh_;
    const Camera& camera_;
    const RenderOptions options_;
    TraceScene scene_;
    std::vector<Vec3d> normals_;
    Rgb background_;
    Vec3d key_, up_;
    double ground_ = 0;
    bool has_ground_ = false;
};
}  // namespace

formats::Image render_mesh(const Surface& surface, const Camera& camera, const RenderOptions& asked) {
    RenderOptions options = asked;
    options.samples_per_pixel = std::clamp(options.samples_per_pixel, 1u, 256u);
    options.sky_rays = std::clamp(options.sky_rays, 1u, 64u);
    const std::uint64_t pixels = std::uint64_t{options.width} * options.height;
    if (pixels == 0 || pixels > (std::uint64_t{1} << 28))
        throw model::Error(model::codes::kTooLarge, "a picture of " + std::to_string(options.width) + " x " +
                                                        std::to_string(options.height) + " pixels cannot be drawn")
            .with_hint("ask for another --size");
    const Renderer renderer(surface, camera, options);
    formats::Image image{options.width, options.height, std::vector<Rgba8>(pixels)};
    // A pixel depends on its coordinates alone, so how the tiles are shared out does not matter.
    tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, options.height, 16, 0, options.width, 16),
                      [&](const tbb::blocked_range2d<std::uint32_t>& tile) {
                          for (std::uint32_t y = tile.rows().begin(); y != tile.rows().end(); ++y)
                              for (std::uint32_t x = tile.cols().begin(); x != tile.cols().end(); ++x)
                                  image.pixels[std::size_t{y} * options.width + x] = renderer.pixel(x, y);
                      });
    return image;
}

formats::Image render_mesh(const Surface& surface, std::optional<View> view, const RenderOptions& options) {
    const Camera camera =
        fit_camera(surface.mesh->positions, view ? *view : choose_view(*surface.mesh), options.width, options.height);
    return render_mesh(surface, camera, options);
}

}  // namespace dgm::render
