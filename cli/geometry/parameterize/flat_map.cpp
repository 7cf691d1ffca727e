// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flat_map.cpp
#include "geometry/parameterize/flat_map.h"

#include <algorithm>
#include <cmath>

#include "geometry/mesh/triangle.h"
#include "geometry/parameterize/slim.h"

namespace dgm::bake {
namespace {

using model::Face;
using model::Vec2d;
using model::Vec3d;

constexpr double kNeedle = 1000;     // length over height
constexpr double kOffPlane = 1e-12;  // normalised units: rounding of the frame

bool has_needle(std::span<const Vec3d> positions, std::span<const Face> faces) {
    return std::any_of(faces.begin(), faces.end(), [&](const Face& f) {
        const Vec3d ab = positions[f[1]] - positions[f[0]], ac = positions[f[2]] - positions[f[0]], bc = ac - ab;
        const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
        return length(cross(ab, ac)) * kNeedle < longest;
    });
}

}  // namespace

std::optional<std::vector<Vec2d>> flat_needle_map(std::span<const Vec3d> positions, std::span<const Face> faces) {
    if (faces.empty() || !has_needle(positions, faces)) return std::nullopt;
    Vec3d sum;
    for (const Face& f : faces) sum = sum + cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]);
    const Vec3d normal = normalized(sum, {});
    if (normal == Vec3d{}) return std::nullopt;
    // The axis farthest from the normal gives the first direction: for a plane of two axes, exactly one of them.
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(normal[k]) < std::abs(normal[axis])) axis = k;
    Vec3d along;
    along[axis] = 1;
    const Vec3d u = normalized(along - normal * normal[axis], {}), v = cross(normal, u);
    const Vec3d origin = positions[faces.front()[0]];
    std::vector<Vec2d> out;
    out.reserve(positions.size());
    for (const Vec3d& p : positions) {
        const Vec3d d = p - origin;
        if (!(std::abs(dot(d, normal)) <= kOffPlane)) return std::nullopt;
        out.push_back({dot(d, u), dot(d, v)});
    }
    if (count_not_positive(faces, out) > 0) return std::nullopt;
    return out;
}

}  // namespace dgm::bake
