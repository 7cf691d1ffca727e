// SPDX-License-Identifier: GPL-3.0-or-later
// samples/support/strip.cpp
#include "support/strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "render/canvas.h"
#include "render/renderer.h"

namespace dgm::samples {
namespace {
constexpr int kRound = 40;              // corners of a circle
constexpr std::uint32_t kCaption = 30;  // pixels of paper below a picture
constexpr model::Rgba8 kTool{206, 210, 216, 255};

Vec3 unit(Vec3 v) {
    const float length = std::sqrt(dot(v, v));
    return length > 0 ? 1 / length * v : Vec3{0, 0, 1};
}
Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// As high, for its width, as the points are seen from there; some more for shadows.
std::uint32_t height_for(std::span<const model::Vec3d> points, const render::View& view, std::uint32_t width) {
    const render::Frame frame = render::view_frame(view);
    const auto extent = [&](const model::Vec3d& axis) {
        double low = 1e300, high = -1e300;
        for (const model::Vec3d& p : points) {
            low = std::min(low, dot(p, axis));
            high = std::max(high, dot(p, axis));
        }
        return points.empty() ? 1 : high - low;
    };
    const double aspect = 1.1 * extent(frame.up) / std::max(extent(frame.right), 1e-9);
    return static_cast<std::uint32_t>(std::clamp(aspect, 0.5, 1.5) * width);
}
}  // namespace

std::uint32_t Scene::material(const Look& look) {
    model::Material m;
    m.diffuse = look.texture.pixels.size() == 1 ? look.texture.pixels[0] : kTool;
    mesh_.materials.push_back(m);
    textures_.push_back(look.texture.pixels.size() == 1 ? formats::Image{} : look.texture);
    gloss_.push_back(look.gloss);
    return static_cast<std::uint32_t>(mesh_.materials.size() - 1);
}

std::uint32_t Scene::vertex(Vec3 p, Vec3 n) {
    mesh_.positions.push_back({p.x, p.y, p.z});
    normals_.push_back({n.x, n.y, n.z});
    uvs_.emplace_back();
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void Scene::face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material) {
    mesh_.faces.push_back({a, b, c});
    mesh_.face_materials.push_back(material);
    for (const std::uint32_t v : {a, b, c}) {
        mesh_.corner_normals.push_back(normals_[v]);
        mesh_.corner_uvs.push_back(uvs_[v]);
    }
}

void Scene::add(std::span<const Vertex> vertices, std::span<const std::uint32_t> triangles, const Look& look) {
    const std::uint32_t m = material(look);
    const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
    // The runtime's (0, 0) and (1, 1) are the middles of the first and the last texel; a cloth that repeats runs on.
    const auto along = [&](float t, std::uint32_t texels) {
        const double margin = look.tiles == 1 && texels > 0 ? 0.5 / texels : 0;
        return look.tiles * (margin + (1 - 2 * margin) * double{t});
    };
    for (const Vertex& v : vertices) {
        const std::uint32_t k =
            vertex({v.position[0], v.position[1], v.position[2]}, {v.normal[0], v.normal[1], v.normal[2]});
        uvs_[k] = {along(v.uv[0], look.texture.width), 1 - along(v.uv[1], look.texture.height)};
    }
    for (std::size_t k = 0; k + 2 < triangles.size(); k += 3)
        face(base + triangles[k], base + triangles[k + 1], base + triangles[k + 2], m);
}

void Scene::add_ball(Vec3 centre, float radius, model::Rgba8 colour) {
    add_rod(centre, centre, radius, colour);
}

void Scene::add_rod(Vec3 a, Vec3 b, float radius, model::Rgba8 colour) {
    const std::uint32_t m = material({{1, 1, {colour}}, 1, 0.5F});
    const Vec3 axis = unit(b - a),
               side = unit(std::abs(axis.z) < 0.9F ? cross(axis, {0, 0, 1}) : cross(axis, {1, 0, 0}));
    const Vec3 up = cross(axis, side);
    const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto row = [&](Vec3 end, double latitude) {
        for (int j = 0; j < kRound; ++j) {
            const double longitude = 2 * std::numbers::pi * j / kRound;
            const Vec3 n = static_cast<float>(std::sin(latitude)) * axis +
                           static_cast<float>(std::cos(latitude) * std::cos(longitude)) * side +
                           static_cast<float>(std::cos(latitude) * std::sin(longitude)) * up;
            static_cast<void>(vertex(end + radius * n, n));
        }
    };
    constexpr int kHalf = kRound / 4;
    for (int i = -kHalf; i <= 0; ++i) row(a, i * std::numbers::pi / 2 / kHalf);
    for (int i = 0; i <= kHalf; ++i) row(b, i * std::numbers::pi / 2 / kHalf);
    for (std::uint32_t i = 0; i + 1 < 2 * kHalf + 2; ++i)
        for (std::uint32_t j = 0; j < kRound; ++j) {
            const std::uint32_t p = base + i * kRound + j, q = base + i * kRound + (j + 1) % kRound;
            face(p, q, q + kRound, m);
            face(p, q + kRound, p + kRound, m);
        }
}

void Scene::add_table(Vec3 centre, float radius, float thickness, model::Rgba8 colour) {
    const std::uint32_t m = material({{1, 1, {colour}}, 1, 0.05F});
    const auto top = vertex(centre, {0, 0, 1});
    const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
    constexpr int kCorners = 4 * kRound;
    for (int j = 0; j < kCorners; ++j) {
        const double angle = 2 * std::numbers::pi * j / kCorners;
        const Vec3 out{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0};
        static_cast<void>(vertex(centre + radius * out, {0, 0, 1}));
        static_cast<void>(vertex(centre + radius * out, out));
        static_cast<void>(vertex(centre + radius * out - Vec3{0, 0, thickness}, out));
    }
    for (std::uint32_t j = 0; j < kCorners; ++j) {
        const std::uint32_t p = base + 3 * j, q = base + 3 * ((j + 1) % kCorners);
        face(top, p, q, m);
        face(p + 1, p + 2, q + 2, m);
        face(p + 1, q + 2, q + 1, m);
    }
}

void Strip::add(Scene scene, std::string caption) {
    scenes_.push_back(std::move(scene));
    captions_.push_back(std::move(caption));
}

void Strip::write(const std::filesystem::path& file) const {
    std::vector<model::Vec3d> points;
    for (const Scene& scene : scenes_)
        points.insert(points.end(), scene.mesh_.positions.begin(), scene.mesh_.positions.end());
    const std::uint32_t height = height_for(points, view_, width_);
    const render::Camera camera = render::fit_camera(points, view_, width_, height, {.margin = 0.04});
    const auto count = static_cast<std::uint32_t>(scenes_.size());
    const std::uint32_t columns = std::max(1U, std::min(columns_, count)), rows = (count + columns - 1) / columns;
    formats::Image out = render::blank(columns * width_, std::max(1U, rows) * (height + kCaption));
    for (std::uint32_t k = 0; k < count; ++k) {
        render::Surface surface;
        surface.mesh = &scenes_[k].mesh_;
        surface.textures = scenes_[k].textures_;
        surface.gloss = scenes_[k].gloss_;
        const formats::Image picture = render::render_mesh(
            surface, camera,
            {.width = width_, .height = height, .samples_per_pixel = 25, .background = render::kPaper});
        const std::uint32_t x = k % columns * width_, y = k / columns * (height + kCaption);
        render::paste(out, picture, x, y);
        const std::uint32_t scale = render::text_width(captions_[k], 2) < width_ ? 2 : 1;
        render::draw_text_centred(out, x + width_ / 2, y + height + 6, captions_[k], scale);
    }
    formats::write_png(file, out);
}

}  // namespace dgm::samples
