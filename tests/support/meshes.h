// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/meshes.h
// Small surfaces of known topology and size. Closed ones are wound outward.
#pragma once
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::test {

using model::Face;
using model::TriMesh;
using model::Vec2d;
using model::Vec3d;

/// Cells of an a x b lattice of vertices (i*b + j), two faces each, counter-clockwise in (i, j); a wrapped direction
/// joins its last line to its first.
inline std::vector<Face> lattice_faces(std::uint32_t a, std::uint32_t b, bool wrap_i = false, bool wrap_j = false) {
    std::vector<Face> faces;
    for (std::uint32_t i = 0; i < (wrap_i ? a : a - 1); ++i)
        for (std::uint32_t j = 0; j < (wrap_j ? b : b - 1); ++j) {
            const std::uint32_t i1 = (i + 1) % a, j1 = (j + 1) % b;
            faces.push_back({i * b + j, i1 * b + j, i1 * b + j1});
            faces.push_back({i * b + j, i1 * b + j1, i * b + j1});
        }
    return faces;
}

/// Rectangle [0, width] x [0, height] in z = 0, normal +z: (rows + 1) x (cols + 1) vertices.
inline TriMesh grid_sheet(std::uint32_t rows, std::uint32_t cols, double width = 1, double height = 1) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j <= cols; ++j) mesh.positions.push_back({width * i / rows, height * j / cols, 0});
    mesh.faces = lattice_faces(rows + 1, cols + 1);
    return mesh;
}

/// The sheet without the quads (i, j) of `holes`: one boundary loop more for each that touches no other and no rim.
inline TriMesh sheet_with_holes(std::uint32_t cells, std::span<const std::array<std::uint32_t, 2>> holes) {
    TriMesh mesh = grid_sheet(cells, cells);
    std::vector<Face> kept;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
        bool gone = false;
        for (const auto& h : holes) gone |= f / 2 == h[0] * cells + h[1];
        if (!gone) kept.push_back(mesh.faces[f]);
    }
    mesh.faces = kept;
    return mesh;
}

/// The unit sheet with a slit of the given width from the middle of the side x = 0 to its centre; `cells` is even.
inline TriMesh slit_sheet(std::uint32_t cells, double width) {
    TriMesh mesh = grid_sheet(cells, cells);
    const std::uint32_t middle = cells / 2;
    for (std::uint32_t i = 0; i < middle; ++i) {
        const std::uint32_t v = i * (cells + 1) + middle;
        const auto upper = static_cast<std::uint32_t>(mesh.positions.size());
        const double half = 0.5 * width * (middle - i) / middle;
        mesh.positions.push_back(mesh.positions[v] + Vec3d{0, half, 0});
        mesh.positions[v].y -= half;
        for (Face& f : mesh.faces) {
            double mean = 0;  // faces above the slit get the copy
            for (std::uint32_t w : f) mean += w < (cells + 1) * (cells + 1) ? w % (cells + 1) : middle;
            if (mean > 3.0 * middle)
                for (std::uint32_t& w : f)
                    if (w == v) w = upper;
        }
    }
    return mesh;
}

/// 20 * 4^levels faces, 10 * 4^levels + 2 vertices.
inline TriMesh icosphere(int levels, double radius = 1) {
    const double g = std::numbers::phi;
    TriMesh mesh;
    mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    mesh.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [it, fresh] = middles.try_emplace(std::minmax(a, b), mesh.positions.size());
            if (fresh) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.5);
            return it->second;
        };
        std::vector<Face> faces;
        for (const Face& f : mesh.faces) {
            const std::uint32_t a = middle(f[0], f[1]), b = middle(f[1], f[2]), c = middle(f[2], f[0]);
            faces.insert(faces.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
        }
        mesh.faces = std::move(faces);
    }
    for (Vec3d& p : mesh.positions) p = p * (radius / length(p));
    return mesh;
}

/// Torus of tube radius `tube` about the circle of radius `ring`: a x b vertices, a around the axis.
inline TriMesh torus(double ring, double tube, std::uint32_t a, std::uint32_t b) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i < a; ++i)
        for (std::uint32_t j = 0; j < b; ++j) {
            const double u = 2 * std::numbers::pi * i / a, v = 2 * std::numbers::pi * j / b;
            const double r = ring + tube * std::cos(v);
            mesh.positions.push_back({r * std::cos(u), r * std::sin(u), tube * std::sin(v)});
        }
    mesh.faces = lattice_faces(a, b, true, true);
    return mesh;
}

/// Flat ring, two boundary loops; `around` x (rings + 1) vertices, normal +z.
inline TriMesh annulus(double inner, double outer, std::uint32_t around, std::uint32_t rings) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i <= rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double r = inner + (outer - inner) * i / rings, t = 2 * std::numbers::pi * j / around;
            mesh.positions.push_back({r * std::cos(t), r * std::sin(t), 0});
        }
    mesh.faces = lattice_faces(rings + 1, around, false, true);
    return mesh;
}

/// Open tube about the z axis from z = 0 to `height`, two boundary loops: `around` x (along + 1) vertices, vertex j of
/// ring i has the number i * around + j. A cone's frustum where the radii differ.
inline TriMesh tube(double bottom, double top, double height, std::uint32_t around, std::uint32_t along) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i <= along; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double r = bottom + (top - bottom) * i / along, t = 2 * std::numbers::pi * j / around;
            mesh.positions.push_back({r * std::cos(t), r * std::sin(t), height * i / along});
        }
    for (const Face& f : lattice_faces(along + 1, around, false, true)) mesh.faces.push_back({f[0], f[2], f[1]});
    return mesh;
}

/// Fan of `corners` triangles about the origin, radius 1.
inline TriMesh polygon_disk(std::uint32_t corners) {
    TriMesh mesh;
    mesh.positions.push_back({0, 0, 0});
    for (std::uint32_t k = 0; k < corners; ++k) {
        const double t = 2 * std::numbers::pi * k / corners;
        mesh.positions.push_back({std::cos(t), std::sin(t), 0});
        mesh.faces.push_back({0, k + 1, (k + 1) % corners + 1});
    }
    return mesh;
}

/// Tube of the given length on the rim z = 0 (open), closed above by a half ball: a glove's finger.
inline TriMesh finger(double radius, double tube_length, std::uint32_t around, std::uint32_t along, std::uint32_t cap) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i < along + cap; ++i) {
        const double angle = i <= along ? 0 : 0.5 * std::numbers::pi * (i - along) / cap;
        const double z = i <= along ? tube_length * i / along : tube_length + radius * std::sin(angle);
        for (std::uint32_t j = 0; j < around; ++j) {
            const double t = 2 * std::numbers::pi * j / around;
            mesh.positions.push_back(
                {radius * std::cos(angle) * std::cos(t), radius * std::cos(angle) * std::sin(t), z});
        }
    }
    for (Face f : lattice_faces(along + cap, around, false, true)) mesh.faces.push_back({f[0], f[2], f[1]});
    const auto tip = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back({0, 0, tube_length + radius});
    const std::uint32_t last = (along + cap - 1) * around;
    for (std::uint32_t j = 0; j < around; ++j) mesh.faces.push_back({last + j, last + (j + 1) % around, tip});
    return mesh;
}

/// Möbius strip: `around` x (across + 1) vertices, one boundary loop, no sides.
inline TriMesh moebius(std::uint32_t around, std::uint32_t across) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j <= across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, w = -0.3 + 0.6 * j / across;
            const double r = 1 + w * std::cos(u / 2);
            mesh.positions.push_back({r * std::cos(u), r * std::sin(u), w * std::sin(u / 2)});
        }
    mesh.faces = lattice_faces(around, across + 1);
    const std::uint32_t last = (around - 1) * (across + 1);
    for (std::uint32_t j = 0; j < across; ++j) {  // the last line meets the first one upside down
        mesh.faces.push_back({last + j, across - j, across - j - 1});
        mesh.faces.push_back({last + j, across - j - 1, last + j + 1});
    }
    return mesh;
}

/// Klein bottle (figure-8 immersion): closed, one-sided.
inline TriMesh klein_bottle(std::uint32_t a, std::uint32_t b) {
    TriMesh mesh;
    for (std::uint32_t i = 0; i < a; ++i)
        for (std::uint32_t j = 0; j < b; ++j) {
            const double u = 2 * std::numbers::pi * i / a, v = 2 * std::numbers::pi * (j + 0.5) / b;
            const double x = std::sin(v), y = std::sin(2 * v), r = 3 + std::cos(u / 2) * x - std::sin(u / 2) * y;
            mesh.positions.push_back({r * std::cos(u), r * std::sin(u), std::sin(u / 2) * x + std::cos(u / 2) * y});
        }
    mesh.faces = lattice_faces(a, b, false, true);
    const auto turned = [&](std::uint32_t j) { return b - 1 - j % b; };
    for (std::uint32_t j = 0; j < b; ++j) {
        const std::uint32_t last = (a - 1) * b, p = last + j, q = last + (j + 1) % b;
        mesh.faces.push_back({p, turned(j), turned(j + 1)});
        mesh.faces.push_back({p, turned(j + 1), q});
    }
    return mesh;
}

/// Boy's surface [Bryant, Kusner]: a projective plane, closed, one-sided. `rings` rings of `around` (even) vertices
/// about a centre; the outermost is run through twice.
inline TriMesh projective_plane(std::uint32_t rings, std::uint32_t around) {
    TriMesh mesh;
    const auto add = [&](std::complex<double> w) {
        const std::complex<double> w3 = w * w * w, below = w3 * w3 + std::sqrt(5.0) * w3 - 1.0;
        const Vec3d g{-1.5 * (w * (1.0 - w3 * w) / below).imag(), -1.5 * (w * (1.0 + w3 * w) / below).real(),
                      ((1.0 + w3 * w3) / below).imag() - 0.5};
        mesh.positions.push_back(g / dot(g, g));
    };
    add(0);
    for (std::uint32_t k = 1; k <= rings; ++k)
        for (std::uint32_t i = 0; i < (k < rings ? around : around / 2); ++i)
            add(std::polar(double(k) / rings, 2 * std::numbers::pi * i / around));
    const auto at = [&](std::uint32_t k, std::uint32_t i) {
        return 1 + (k - 1) * around + i % (k < rings ? around : around / 2);
    };
    for (std::uint32_t i = 0; i < around; ++i) mesh.faces.push_back({0, at(1, i), at(1, i + 1)});
    for (std::uint32_t k = 1; k < rings; ++k)
        for (std::uint32_t i = 0; i < around; ++i) {
            mesh.faces.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1)});
            mesh.faces.push_back({at(k, i), at(k + 1, i + 1), at(k, i + 1)});
        }
    return mesh;
}

/// Surface of a body of unit cubes, wound outward, lattice vertices shared: cubes that meet only along an edge or at a
/// vertex share it. Each square is cut into detail x detail smaller ones.
inline TriMesh cubes(std::span<const std::array<int, 3>> cells, int detail = 1) {
    std::map<std::array<int, 3>, bool> filled;
    for (const auto& c : cells) filled[c] = true;
    std::map<std::array<int, 3>, std::uint32_t> vertices;
    TriMesh mesh;
    const auto vertex = [&](const std::array<int, 3>& p) {
        const auto [it, fresh] = vertices.try_emplace(p, static_cast<std::uint32_t>(mesh.positions.size()));
        if (fresh) mesh.positions.push_back(Vec3d{double(p[0]), double(p[1]), double(p[2])} / detail);
        return it->second;
    };
    for (const auto& c : cells)
        for (int axis = 0; axis < 3; ++axis)
            for (int side = 0; side < 2; ++side) {
                std::array<int, 3> next = c;
                next[axis] += side == 0 ? -1 : 1;
                if (filled.count(next)) continue;
                const int u = (axis + 1) % 3, v = (axis + 2) % 3;
                for (int a = 0; a < detail; ++a)
                    for (int b = 0; b < detail; ++b) {
                        std::array<std::uint32_t, 4> q{};
                        for (int k = 0; k < 4; ++k) {
                            std::array<int, 3> p{};
                            p[axis] = (c[axis] + side) * detail;
                            p[u] = c[u] * detail + a + (k == 1 || k == 2);
                            p[v] = c[v] * detail + b + (k >= 2);
                            q[k] = vertex(p);
                        }
                        if (side == 0) std::swap(q[1], q[3]);
                        mesh.faces.push_back({q[0], q[1], q[2]});
                        mesh.faces.push_back({q[0], q[2], q[3]});
                    }
            }
    return mesh;
}

/// Plate with `genus` holes in a row.
inline TriMesh genus_plate(int genus, int detail = 1) {
    std::vector<std::array<int, 3>> cells;
    for (int x = 0; x < 2 * genus + 1; ++x)
        for (int y = 0; y < 3; ++y)
            if (x % 2 == 0 || y != 1) cells.push_back({x, y, 0});
    return cubes(cells, detail);
}

/// A bar with `teeth` upright teeth, `tall` cubes high.
inline TriMesh comb(int teeth, int tall, int detail = 1) {
    std::vector<std::array<int, 3>> cells;
    for (int x = 0; x < 2 * teeth - 1; ++x)
        for (int z = 0; z <= (x % 2 == 0 ? tall : 0); ++z) cells.push_back({x, 0, z});
    return cubes(cells, detail);
}

inline TriMesh cubes_touching_at_edge() {
    return cubes(std::array<std::array<int, 3>, 2>{{{0, 0, 0}, {1, 1, 0}}});
}
inline TriMesh cubes_touching_at_vertex() {
    return cubes(std::array<std::array<int, 3>, 2>{{{0, 0, 0}, {1, 1, 1}}});
}

/// Both, the vertices of `b` moved along x.
inline TriMesh joined(TriMesh a, const TriMesh& b, double x = 0) {
    const auto base = static_cast<std::uint32_t>(a.positions.size());
    for (const Vec3d& p : b.positions) a.positions.push_back(p + Vec3d{x, 0, 0});
    for (const Face& f : b.faces) a.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
    return a;
}
/// Two triangles that share one vertex.
inline TriMesh bow_tie() {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}};
    mesh.faces = {{0, 1, 2}, {0, 3, 4}};
    return mesh;
}

/// `pages` unit squares that share the edge from (0,0,0) to (0,0,1), evenly around it; odd pages are wound the other
/// way.
inline TriMesh book(std::uint32_t pages) {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}};
    for (std::uint32_t k = 0; k < pages; ++k) {
        const double t = 2 * std::numbers::pi * k / pages;
        const auto v = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back({std::cos(t), std::sin(t), 1});
        mesh.positions.push_back({std::cos(t), std::sin(t), 0});
        if (k % 2 == 0)
            mesh.faces.insert(mesh.faces.end(), {{0, 1, v}, {0, v, v + 1}});
        else
            mesh.faces.insert(mesh.faces.end(), {{0, v, 1}, {0, v + 1, v}});
    }
    return mesh;
}

/// A square of two faces a side, the sides' diagonals crossed: closed and flat, 4 vertices, 6 edges, 4 faces.
inline TriMesh double_sided_quad() {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    return mesh;
}

/// Every face gets three vertices of its own, at the same bits.
inline TriMesh soup(const TriMesh& mesh) {
    TriMesh out = mesh;
    out.positions.clear();
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
        for (int k = 0; k < 3; ++k) {
            out.positions.push_back(mesh.positions[mesh.faces[f][k]]);
            out.faces[f][k] = 3 * f + k;
        }
    return out;
}

/// Corner arrays that say where the corner lies: uv = (x, y).
inline void paint_positions(TriMesh& mesh) {
    mesh.corner_uvs.clear();
    for (const Face& f : mesh.faces)
        for (std::uint32_t v : f) mesh.corner_uvs.push_back({mesh.positions[v].x, mesh.positions[v].y});
}

inline double surface_area(std::span<const Vec3d> positions, std::span<const Face> faces) {
    double sum = 0;
    for (const Face& f : faces)
        sum += 0.5 * length(cross(positions[f[1]] - positions[f[0]], positions[f[2]] - positions[f[0]]));
    return sum;
}
inline double surface_area(const TriMesh& mesh) {
    return surface_area(mesh.positions, mesh.faces);
}

/// Signed volume; positive where a closed surface is wound outward.
inline double volume(const TriMesh& mesh) {
    double sum = 0;
    for (const Face& f : mesh.faces)
        sum += dot(mesh.positions[f[0]], cross(mesh.positions[f[1]], mesh.positions[f[2]])) / 6;
    return sum;
}

}  // namespace dgm::test
