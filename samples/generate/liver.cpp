// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/liver.cpp
// Two blended ellipsoids, the lobes, with the underside hollowed out by a third and the ligament's groove pressed in.
#include <algorithm>

#include "atlas.h"
#include "implicit_surface.h"
#include "math/portable.h"
#include "noise.h"
#include "organs.h"

namespace dgm::samples {
namespace {
using model::Vec3d;

// Scaled so that the field has slope about 1 near the surface; exact distance is not needed.
double ellipsoid(const Vec3d& p, const Vec3d& centre, const Vec3d& radii) {
    const Vec3d q{(p.x - centre.x) / radii.x, (p.y - centre.y) / radii.y, (p.z - centre.z) / radii.z};
    const Vec3d g{q.x / radii.x, q.y / radii.y, q.z / radii.z};
    const double k = length(q);
    return k * (k - 1) / std::max(length(g), 1e-6);
}

// x of the groove between the lobes; it leans a little towards the back.
double groove_offset(const Vec3d& p) {
    return p.x - 2.6 - 0.12 * p.y;
}

double liver_field(const Vec3d& p) {
    const double right = ellipsoid(p, {-4.6, 0.4, 0.2}, {8.0, 6.9, 7.2});
    // The left lobe rises towards its tip.
    const Vec3d tilted{p.x, p.y, p.z - 0.06 * (p.x - 4)};
    const double left = ellipsoid(tilted, {4.0, -0.6, 1.9}, {9.6, 5.2, 4.0});
    double d = smooth_min(right, left, 4.0);
    const double slope = 0.36 * p.x - 0.10 * p.y;  // the underside climbs to the left and falls to the front
    d = smooth_max(d, (slope - 2.6 - p.z) / 1.07, 1.3);
    d = smooth_max(d, -ellipsoid(p, {1.5, 2.5, -7.4}, {11.5, 6.5, 8.2}), 1.4);
    const double s = groove_offset(p);
    const double front = smooth_step(3.0, -4.0, p.y);
    d += (0.25 + 0.40 * front) * math::exp(-s * s / 0.35) * smooth_step(-3.5, 0.5, p.z + 0.3 * p.x);
    return d + 0.20 * fractal3(p * 0.22, 2, 51);
}

Shade liver_shade(const Vec3d& p) {
    const double cloud = fractal3(p * 0.35, 4, 61);
    const Vec3d bent = p + Vec3d{noise3(p * 1.5, 62), noise3(p * 1.5, 63), noise3(p * 1.5, 64)} * 0.07;
    const Cells lobule = cells3(bent * 4.6, 65);
    const double rim = 1 - smooth_step(0.02, 0.22, lobule.second - lobule.nearest);
    Colour c = mix(rgb(122, 44, 34), rgb(92, 26, 24), 0.5 + 0.7 * cloud);
    c = c * (0.93 + 0.14 * lobule.id);
    c = mix(c, rgb(62, 14, 16), 0.35 * (1 - smooth_step(0.0, 0.35, lobule.nearest)));  // central veins
    c = mix(c, rgb(158, 82, 62), 0.30 * rim);
    c = c * (1 + 0.07 * fractal3(p * 6.0, 2, 66));
    const double s = groove_offset(p);
    const double ligament = math::exp(-s * s / 0.05) * smooth_step(-1.5, 1.5, p.z);
    c = mix(c, rgb(206, 164, 140), 0.75 * ligament);
    return {c, std::clamp(0.55 + 0.15 * cloud - 0.28 * rim + 0.06 * lobule.id + 0.1 * ligament, 0.0, 1.0)};
}
}  // namespace

Textured make_liver(int texture_size) {
    PolyMesh mesh = mesh_zero_set(liver_field, {{-14.5, -8.5, -9.5}, {15.5, 9.5, 9.5}, 0.47});
    orient_outward(mesh);
    project_to_atlas(mesh, texture_size);
    Picture picture = paint_atlas(mesh, texture_size, liver_shade);
    return {"liver", 0.05, std::move(mesh), std::move(picture)};
}

}  // namespace dgm::samples
