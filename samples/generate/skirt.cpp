// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/skirt.cpp
// A skirt cut as a wide cone, and the hips that it hangs on.
#include <array>
#include <numbers>

#include "math/portable.h"
#include "upholstery.h"

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;

/// Quads between rings of `around` points each. Ring i of `rings` has UVs at height i / (rings - 1).
void add_rings(PolyMesh& mesh, std::uint32_t rings, std::uint32_t around) {
    const auto first_uv = static_cast<std::uint32_t>(mesh.uvs.size());
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j <= around; ++j)
            mesh.uvs.push_back({j / static_cast<double>(around), i / static_cast<double>(rings - 1)});
    for (std::uint32_t i = 0; i + 1 < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t next = (j + 1) % around;
            Polygon p;
            p.vertex = {i * around + j, i * around + next, (i + 1) * around + next, (i + 1) * around + j};
            const std::uint32_t uv = first_uv + i * (around + 1) + j;
            p.uv = {uv, uv + 1, uv + around + 2, uv + around + 1};
            mesh.polygons.push_back(p);
        }
}
}  // namespace

PolyMesh make_skirt() {
    constexpr std::uint32_t kRings = 25, kAround = 72;
    constexpr double kWaist = 12.5, kHem = 42, kDrop = 34, kWaves = 9;
    PolyMesh mesh;
    for (std::uint32_t i = 0; i < kRings; ++i)  // from the hem up
        for (std::uint32_t j = 0; j < kAround; ++j) {
            const double t = i / (kRings - 1.0), a = 2 * std::numbers::pi * j / kAround;
            // A round cone would stand by itself: shallow waves show it where to fold.
            const double r = (kHem + t * (kWaist - kHem)) * (1 + 0.1 * (1 - t) * math::cos(kWaves * a));
            mesh.positions.push_back({r * math::cos(a), r * math::sin(a), kDrop * (t - 1)});
        }
    add_rings(mesh, kRings, kAround);
    quantise(mesh);
    return mesh;
}

PolyMesh make_hips() {
    constexpr std::uint32_t kRings = 21, kAround = 40;
    PolyMesh mesh;
    for (std::uint32_t i = 0; i < kRings; ++i)
        for (std::uint32_t j = 0; j < kAround; ++j) {
            // From 5 degrees off the lower pole to 5 off the upper one; the waist is at z = 0, where the radius is
            // 11.4.
            const double latitude = std::numbers::pi * (i / (kRings - 1.0) - 0.5) * (170.0 / 180);
            const double a = 2 * std::numbers::pi * j / kAround, r = 16 * math::cos(latitude);
            mesh.positions.push_back({r * math::cos(a), r * math::sin(a), 20 * math::sin(latitude) - 14});
        }
    add_rings(mesh, kRings, kAround);
    for (const bool top : {false, true}) {  // fans that close both ends
        const auto pole = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back({0, 0, top ? 6.0 : -34.0});
        const std::uint32_t ring = top ? (kRings - 1) * kAround : 0;
        const auto uv = static_cast<std::uint32_t>(mesh.uvs.size());
        mesh.uvs.push_back({0.5, top ? 1.0 : 0.0});
        for (std::uint32_t j = 0; j < kAround; ++j) {
            const std::uint32_t a = ring + j, b = ring + (j + 1) % kAround;
            Polygon p;
            p.n = 3;
            p.vertex = top ? std::array{a, b, pole, 0u} : std::array{b, a, pole, 0u};
            p.uv = {uv, uv, uv, uv};
            mesh.polygons.push_back(p);
        }
    }
    quantise(mesh);
    return mesh;
}

}  // namespace dgm::samples
