// SPDX-License-Identifier: GPL-3.0-or-later
// samples/support/strip.h
// Draws what a sample shows: scenes of triangles, tools and tables, put side by side under one camera and one light.
#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <dgm/vec.h>

#include "image/image.h"
#include "model/tri_mesh.h"
#include "render/camera.h"
#include "support/soft_body.h"

namespace dgm::samples {

/// How a surface looks: its picture, repeated `tiles` times along either side of the chart, and the strength of its
/// highlights.
struct Look {
    formats::Image texture;
    float tiles = 1;
    float gloss = 0.15F;
};

/// Contents of one picture.
class Scene {
 public:
    void add(std::span<const Vertex> vertices, std::span<const std::uint32_t> triangles, const Look& look);
    void add_ball(Vec3 centre, float radius, model::Rgba8 colour);
    /// A rod with round ends.
    void add_rod(Vec3 a, Vec3 b, float radius, model::Rgba8 colour);
    /// A round table top that lies in the plane through `centre`, and reaches `thickness` below it.
    void add_table(Vec3 centre, float radius, float thickness, model::Rgba8 colour);

 private:
    friend class Strip;
    std::uint32_t material(const Look& look);
    void face(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material);
    std::uint32_t vertex(Vec3 position, Vec3 normal);

    model::TriMesh mesh_;
    std::vector<formats::Image> textures_;
    std::vector<float> gloss_;
    std::vector<model::Vec3d> normals_;  // one a vertex
    std::vector<model::Vec2d> uvs_;
};

/// Pictures in rows, one camera that fits them all, a caption below each.
class Strip {
 public:
    /// @param width  of one picture, pixels; the height follows from what is in it
    Strip(const render::View& view, std::uint32_t columns, std::uint32_t width)
        : view_(view), columns_(columns), width_(width) {}
    void add(Scene scene, std::string caption);
    /// @throws model::Error if the file cannot be written
    void write(const std::filesystem::path& file) const;

 private:
    render::View view_;
    std::uint32_t columns_, width_;
    std::vector<Scene> scenes_;
    std::vector<std::string> captions_;
};

/// main() of a sample: runs `body`, says what went wrong, returns the exit code.
template <class Body>
int run_sample(const char* name, Body body) {
    try {
        body();
        return 0;
    } catch (const model::Error& error) {
        std::fprintf(stderr, "%s: %s: %s\n", name, error.place().c_str(), error.what());
        return static_cast<int>(error.code().exit);
    }
}

}  // namespace dgm::samples
