// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/renderer.h
// Shaded pictures of meshes by ray tracing (Embree): soft key light, sky light with occlusion, shadow on the ground.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "image/image.h"
#include "model/tri_mesh.h"
#include "render/camera.h"

namespace dgm::render {

/// A line on the surface, drawn as a thin tube that the surface hides but that throws no shadow.
struct Segment {
    model::Vec3d a, b;
    model::Rgba8 colour;
    double radius = 0;  ///< source units, > 0
};

inline constexpr float kGloss = 0.15F;

/// A surface to draw. The first of these that a face has gives its colour: scalars, the texture of its material, the
/// mesh's corner colours, its material's diffuse colour, `plain`.
struct Surface {
    const model::TriMesh* mesh = nullptr;
    std::vector<formats::Image>
        textures;              ///< one a material (or a single one for a mesh without materials); may be empty images
    std::vector<float> gloss;  ///< one a material: strength of its highlights; kGloss where there is none
    std::vector<double> scalars;  ///< one a vertex, mapped by sequential_colour from low..high; NaN shows magenta
    double scalar_low = 0, scalar_high = 1;
    model::Rgba8 plain{214, 190, 172, 255};
    bool only_plain = false;  ///< ignore every other source of colour but scalars
    std::vector<Segment> segments;
};

struct RenderOptions {
    std::uint32_t width = 960, height = 720;
    std::uint32_t samples_per_pixel = 16;  ///< 1..256, fixed pattern
    std::uint32_t sky_rays = 3;            ///< occlusion rays of each sample, 1..64
    double shading = 1;                    ///< 1 lit; 0 the bare colours (for maps that have a legend)
    bool ground_shadow = true;             ///< only seen from above
    model::Rgba8 background{246, 246, 244, 255};
    double crease_degrees = 50;  ///< smooth shading up to this angle, where the mesh has no normals
};

/// Both sides of faces are drawn. Faces with an index out of range or a position that is not finite are left out; a
/// mesh without faces gives the background. Texture coordinates follow OBJ (v up), repeat, and are filtered bilinearly
/// in linear light. The same bits for the same input, whatever the number of threads.
/// Cost: width * height * samples * (2 + sky_rays) rays, in parallel.
/// @throws model::Error kTooLarge for more than 2^28 pixels or none, kInternal if Embree fails
[[nodiscard]] formats::Image render_mesh(const Surface& surface, const Camera& camera,
                                         const RenderOptions& options = {});

/// With a camera that fits the mesh, from `view` or else from choose_view().
[[nodiscard]] formats::Image render_mesh(const Surface& surface, std::optional<View> view,
                                         const RenderOptions& options = {});

}  // namespace dgm::render
