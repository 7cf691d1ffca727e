// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/atlas.h
// UVs for closed organs, and textures that are functions of space, so they run on across the borders of the charts.
#pragma once
#include <functional>

#include "image.h"
#include "poly_mesh.h"

namespace dgm::samples {

/// Gives a triangle mesh UVs: regions that face one of the six axis directions are projected along it, one chart each,
/// at one scale, and packed into a size x size picture without overlap.
void project_to_atlas(PolyMesh& mesh, int size);

/// Colour and relief (0..1) of the organ at a point of its surface.
struct Shade {
    Colour colour;
    double relief = 0.5;
};

/// Evaluates `shade` for every texel a chart covers and a few texels beyond each chart border, so that bilinear reads
/// at the border meet no background.
Picture paint_atlas(const PolyMesh& mesh, int size, const std::function<Shade(const model::Vec3d&)>& shade);

}  // namespace dgm::samples
