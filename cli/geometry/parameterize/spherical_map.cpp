// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/spherical_map.cpp
// [Praun, Hoppe 2003] Spherical parametrization and remeshing. SIGGRAPH 2003.
#include "geometry/parameterize/spherical_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/mesh/infinity.h"
#include "geometry/mesh/vertex_corners.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/simplify/simplify.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

double squared(const Vec3d& v) {
    return dot(v, v);
}

Vec3d unit(const Vec3d& v) {
    return v / length(v);
}

/// One face about a vertex: the map of its far side, and its shape on the surface.
struct Wedge {
    Vec3d p1, p2;
    double area;
    double l0, l1, l2;  ///< squared lengths opposite the vertex, p1 and p2
};

/// Two unit vectors that make a right-handed frame with x.
std::array<Vec3d, 2> tangents(const Vec3d& x) {
    const Vec3d axis = std::abs(x.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d e1 = unit(cross(axis, x));
    return {e1, cross(x, e1)};
}

/// Squared L2 stretch, squared, of the flat triangles about a vertex of the sphere, by surface area.
class SphereRing {
 public:
    std::vector<Wedge> wedges;

    [[nodiscard]] double energy(const Vec3d& x) const {
        double sum = 0;
        for (const Wedge& w : wedges) {
            if (!surely_outward(x, w.p1, w.p2)) return kInfinity;
            const Vec3d d0 = w.p2 - w.p1, d1 = x - w.p2, d2 = w.p1 - x;
            // Edge form of (|S_s|^2 + |S_t|^2) / 2 [Sander 2001], as in convex_map.cpp.
            const double n = -(w.l0 * dot(d1, d2) + w.l1 * dot(d2, d0) + w.l2 * dot(d0, d1));
            // Volume in place of area: the same for small triangles, and none where a large one nears a great circle.
            const double t = dot(x, cross(d1, d0)), stretch = n / (t * t);
            sum += w.area * stretch * stretch;
        }
        return std::isfinite(sum) ? sum : kInfinity;
    }

    /// Newton steps by differences in the tangent plane; each lowers the energy.
    [[nodiscard]] Vec3d relax(Vec3d x, int steps) const {
        double e = energy(x);
        double radius = kInfinity;
        for (const Wedge& w : wedges) radius = std::min(radius, length(w.p1 - x));
        for (int k = 0; k < steps && std::isfinite(e); ++k) {
            const auto [first, second] = tangents(x);
            const Vec3d e1 = first, e2 = second;  // clang 14 captures no structured binding
            const double h = 1e-3 * radius;
            const auto at = [&](double s, double t) { return unit(x + e1 * s + e2 * t); };
            const double r = energy(at(h, 0)), l = energy(at(-h, 0)), u = energy(at(0, h)), d = energy(at(0, -h));
            const double ru = energy(at(h, h)), ld = energy(at(-h, -h));
            if (!std::isfinite(r + l + u + d + ru + ld)) return x;
            const double gx = (r - l) / (2 * h), gy = (u - d) / (2 * h), q = h * h;
            const double xx = (r - 2 * e + l) / q, yy = (u - 2 * e + d) / q;
            const double xy = (ru + ld - r - l - u - d + 2 * e) / (2 * q);
            // As multilevel_map.cpp: the energy need not be convex.
            const double mean = 0.5 * (xx + yy), spread = math::hypot(0.5 * (xx - yy), xy);
            const double shift = std::max(0.0, 0.01 * (mean + spread) - (mean - spread));
            const double a = xx + shift, c = yy + shift, det = a * c - xy * xy;
            if (!(det > 0)) return x;
            double sx = -(c * gx - xy * gy) / det, sy = -(a * gy - xy * gx) / det;
            bool moved = false;
            for (int halving = 0; halving < 12 && !moved; ++halving, sx *= 0.5, sy *= 0.5) {
                const Vec3d y = at(sx, sy);
                const double now = energy(y);
                if (!(now < e)) continue;
                x = y;
                e = now;
                moved = true;
            }
            if (!moved) return x;
        }
        return x;
    }

    /// A point inside the kernel of the ring, of which `kept`, a corner of it, sees all others: as near to the middle
    /// as there is room.
    [[nodiscard]] std::optional<Vec3d> inside(const Vec3d& kept) const {
        Vec3d middle, normals;
        for (const Wedge& w : wedges) {
            middle = middle + w.p1;
            // The sides that meet in `kept` are the half-spaces on whose border it lies.
            if (squared(w.p1 - kept) == 0 || squared(w.p2 - kept) == 0) normals = normals + unit(cross(w.p1, w.p2));
        }
        Vec3d best;
        double least = kInfinity;
        const auto consider = [&](const Vec3d& x) {
            if (!(squared(x) > 0)) return;
            const Vec3d y = unit(x);
            if (const double e = energy(y); e < least) {
                least = e;
                best = y;
            }
        };
        if (squared(middle) > 1e-24)
            for (double share = 1; share > 1e-3; share *= 0.5) consider(kept + (unit(middle) - kept) * share);
        for (double step = 1; step > 1e-9 && least == kInfinity; step *= 0.25) {
            for (int refine = 0; refine < 2; ++refine) consider(kept + normals * (refine == 0 ? step : 0.5 * step));
        }
        return least < kInfinity ? std::optional(best) : std::nullopt;
    }
};

std::array<double, 4> shape(std::span<const Vec3d> positions, const Face& f) {
    const Vec3d e0 = positions[f[2]] - positions[f[1]], e1 = positions[f[0]] - positions[f[2]],
                e2 = positions[f[1]] - positions[f[0]];
    return {0.5 * length(cross(e2, e0)), squared(e0), squared(e1), squared(e2)};
}

void relax(const TriMesh& mesh, std::vector<Vec3d>& sphere, int sweeps, const model::Progress& progress) {
    const std::span<const Face> faces = mesh.faces;
    const std::size_t n = sphere.size();
    const VertexCorners corners(faces, n);
    SphereRing ring;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        progress.update("cut", 0);
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t v = sweep % 2 == 0 ? i : static_cast<std::uint32_t>(n - 1 - i);
            ring.wedges.clear();
            for (std::uint32_t k = corners.first[v]; k < corners.first[v + 1]; ++k) {
                const std::uint32_t h = corners.of[k], a = target(faces, h), b = origin(faces, previous_half_edge(h));
                const auto [area, l0, l1, l2] = shape(mesh.positions, {v, a, b});
                ring.wedges.push_back({sphere[a], sphere[b], area, l0, l1, l2});
            }
            sphere[v] = ring.relax(sphere[v], 1);
        }
    }
}

struct Level {
    TriMesh mesh;
    std::vector<std::uint32_t> original;  ///< vertices on the next finer level; none on the finest
    Simplified coarser;                   ///< how the next coarser level was made of this one
};

[[noreturn]] void fail(const char* what) {
    throw model::Error(model::codes::kMapInvalid, std::string("sphere: ") + what);
}

std::vector<Level> build_ladder(const TriMesh& mesh, const model::Progress& progress) {
    // Small levels are halved: crowding among a few vertices would crowd all later ones.
    constexpr std::size_t kSmall = 400;
    std::vector<Level> ladder(1);
    ladder[0].mesh.positions = mesh.positions;
    ladder[0].mesh.faces = mesh.faces;
    while (ladder.back().mesh.faces.size() > 4) {
        Level& fine = ladder.back();
        const std::size_t count = fine.mesh.faces.size();
        const std::size_t wanted = count > kSmall ? std::max(kSmall, count / 4) : std::max<std::size_t>(4, count / 2);
        SimplifyOptions options;
        options.regularity = 1e-2;  // round rings matter, detail does not
        if (count > kSmall) fine.coarser = simplify(fine.mesh, wanted, options, progress);
        if (count <= kSmall || fine.coarser.faces.size() > wanted) {
            options.least_cosine = -1;
            options.max_valence = 1000;
            fine.coarser = simplify(fine.mesh, wanted, options, progress);
        }
        if (fine.coarser.faces.size() == count) fail("the surface could not be simplified to a tetrahedron");
        CompactMesh small = compact(fine.mesh.positions, fine.coarser.faces);
        Level next;
        next.mesh = std::move(small.mesh);
        next.original = std::move(small.original);
        ladder.push_back(std::move(next));
    }
    return ladder;
}

/// Takes the collapses below `fine` back, last one first.
void put_back(const Level& fine, std::vector<Vec3d>& sphere) {
    SphereRing ring;
    for (std::size_t k = fine.coarser.collapses.size(); k-- > 0;) {
        const Collapse& c = fine.coarser.collapses[k];
        const auto link = fine.coarser.link(c);
        ring.wedges.clear();
        for (std::size_t j = 0; j < link.size(); ++j) {
            const std::uint32_t a = link[j], b = link[(j + 1) % link.size()];
            const auto [area, l0, l1, l2] = shape(fine.mesh.positions, {c.removed, a, b});
            ring.wedges.push_back({sphere[a], sphere[b], area, l0, l1, l2});
        }
        const std::optional<Vec3d> x = ring.inside(sphere[c.kept]);
        if (!x) fail("the surface crowds on the sphere beyond double precision");
        sphere[c.removed] = ring.relax(*x, 3);
    }
}

}  // namespace

bool surely_outward(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    // det(a, b, c) = a . (b - a) x (c - a): short edges keep their digits.
    const Vec3d u = b - a, v = c - a;
    const double det = dot(a, cross(u, v));
    const auto both = [](double p, double q, double r, double s) { return std::abs(p * q) + std::abs(r * s); };
    const double size = std::abs(a.x) * both(u.y, v.z, u.z, v.y) + std::abs(a.y) * both(u.z, v.x, u.x, v.z) +
                        std::abs(a.z) * both(u.x, v.y, u.y, v.x);
    // Every term is rounded eight times at most (edges are exact differences rounded once), by half an ulp.
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    return det > 8 * kEpsilon * size;
}

std::vector<Vec3d> spherical_map(const TriMesh& mesh, const SphericalOptions& options,
                                 const model::Progress& progress) {
    const Topology topology = measure_topology(mesh.positions.size(), mesh.faces);
    if (!topology.manifold || !topology.oriented || topology.components != 1 || topology.boundary_loops != 0 ||
        topology.genus != 0)
        throw model::Error(model::codes::kMethodUnsuited,
                           "sphere: only closed surfaces without handles have a map to the sphere; this one has " +
                               std::to_string(topology.boundary_loops) + " borders and genus " +
                               std::to_string(topology.genus));
    const std::vector<Level> ladder = build_ladder(mesh, progress);
    const double third = 1 / std::sqrt(3.0);
    std::vector<Vec3d> sphere{
        {third, third, third}, {-third, -third, third}, {-third, third, -third}, {third, -third, -third}};
    const Face& base = ladder.back().mesh.faces[0];
    if (!surely_outward(sphere[base[0]], sphere[base[1]], sphere[base[2]])) std::swap(sphere[0], sphere[1]);
    for (std::size_t l = ladder.size() - 1; l-- > 0;) {
        std::vector<Vec3d> finer(ladder[l].mesh.positions.size());
        for (std::size_t v = 0; v < sphere.size(); ++v) finer[ladder[l + 1].original[v]] = sphere[v];
        put_back(ladder[l], finer);
        sphere = std::move(finer);
        // The coarsest levels cost nothing and decide the shape.
        relax(ladder[l].mesh, sphere, ladder[l].mesh.faces.size() <= 400 ? 3 * options.sweeps : options.sweeps,
              progress);
    }
    for (const Face& f : mesh.faces)
        if (!surely_outward(sphere[f[0]], sphere[f[1]], sphere[f[2]])) fail("a face is too thin on the sphere");
    return sphere;
}

}  // namespace dgm::bake
