// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/check_disk.cpp
#include "geometry/parameterize/check_disk.h"

#include <algorithm>
#include <string>

#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {
constexpr std::size_t kMaxVertices = std::size_t{1} << 29;
constexpr std::uint32_t kNobody = 0xffffffff;

[[noreturn]] void fail(const std::string& what) {
    throw model::Error(model::codes::kMapInvalid, what);
}

/// A manifold disk has one outgoing border edge a border vertex; the cycle must be all of them, in order.
bool is_border_of_faces(const DiskView& disk) {
    const std::size_t n = disk.positions.size();
    std::vector<std::uint32_t> next(n, kNobody);
    for (std::size_t k = 0; k < disk.border.size(); ++k) {
        const std::uint32_t v = disk.border[k];
        if (v >= n) fail("the border names a vertex that does not exist");
        if (next[v] != kNobody) return false;
        next[v] = disk.border[(k + 1) % disk.border.size()];
    }
    // An edge that joins consecutive border vertices stands once, in the right direction, if it is a border edge; a
    // chord between them stands both ways.
    std::vector<std::uint8_t> forth(n, 0), back(n, 0);
    std::size_t edges_once = 0;
    for (const Face& f : disk.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            if (next[a] == b) {
                forth[a] = 1;
                ++edges_once;
            }
            if (next[b] == a) back[b] = 1;
        }
    if (edges_once != disk.border.size()) return false;
    for (const std::uint32_t v : disk.border)
        if (forth[v] == 0 || (back[v] != 0 && disk.border.size() > 2)) return false;
    return true;
}
}  // namespace

void check_disk(const DiskView& disk, bool needs_border_uv) {
    const std::size_t n = disk.positions.size();
    if (n > kMaxVertices || disk.faces.size() > 2 * kMaxVertices)
        throw model::Error(model::codes::kTooLarge, "the disk has " + std::to_string(n) + " vertices");
    if (disk.faces.empty()) fail("the disk has no faces");
    for (const Vec3d& p : disk.positions)
        if (!model::is_finite(p)) fail("the disk has a position that is not finite");
    std::vector<std::uint8_t> used(n, 0);
    for (const Face& f : disk.faces)
        for (const std::uint32_t v : f) {
            if (v >= n) fail("a face names a vertex that does not exist");
            used[v] = 1;
        }
    if (std::find(used.begin(), used.end(), 0) != used.end()) fail("a vertex belongs to no face");
    const Topology t = measure_topology(n, disk.faces);
    if (!t.manifold || !t.oriented || t.components != 1 || t.boundary_loops != 1 || t.genus != 0 ||
        t.degenerate_faces != 0)
        fail("the surface is not a disk: " + std::to_string(t.components) + " components, " +
             std::to_string(t.boundary_loops) + " border loops, genus " + std::to_string(t.genus) +
             (t.manifold ? "" : ", not manifold") + (t.oriented ? "" : ", not oriented"));
    // Euler: a disk of V vertices and F faces has 2 V - F - 2 border edges.
    if (disk.border.size() != 2 * n - disk.faces.size() - 2 || !is_border_of_faces(disk))
        fail("the border cycle is not the border of the faces, surface on its left");
    if (!needs_border_uv) return;
    if (disk.border_uv.size() != disk.border.size()) fail("the border needs one map point per vertex");
    for (const Vec2d& p : disk.border_uv)
        if (!(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1)) fail("a border point lies outside the unit square");
}

}  // namespace dgm::bake
