// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/organs.h
// A stomach and a liver: closed, genus 0, life size. x points to the patient's left, y to the back, z up; centimetres.
#pragma once
#include <filesystem>
#include <string>

#include "image.h"
#include "poly_mesh.h"

namespace dgm::samples {

inline constexpr int kOrganTexture = 1024;  ///< pixels a side of the samples' textures

/// A mesh and the picture its UVs refer to.
struct Textured {
    std::string name;
    double bump_scale = 0;  ///< centimetres between black and white of the bump map
    PolyMesh mesh;
    Picture picture;
};

/// J-shaped sack with fundus, body, antrum, pylorus, a stub of duodenum and one of oesophagus, and soft folds.
Textured make_stomach(int texture_size);

/// The stomach's atlas again, painted with a cloth that tiles: wrapped around the sack with its warp along it, and
/// around the oesophagus, with a seam where they meet.
Picture dress_stomach(const PolyMesh& stomach, const Picture& cloth, int texture_size);

/// Wedge of a large right and a tapering left lobe, domed above, hollow below, with the groove of the falciform
/// ligament.
Textured make_liver(int texture_size);

/// Material that write_organ() writes for the surface.
MaterialText organ_material(const Textured& organ);

/// Writes NAME.obj, NAME.mtl, colour.png and bump.png into `folder`, which is there. The same bytes on every run.
/// @return path of NAME.obj. @throws model::Error kWriteFailed
std::filesystem::path write_organ(const Textured& organ, const std::filesystem::path& folder);

}  // namespace dgm::samples
