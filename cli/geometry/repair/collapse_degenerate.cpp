// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/collapse_degenerate.cpp
// An edge v-w is known by its ends: repair() leaves no two edges between the same two vertices, and neither does the
// link condition.
#include "geometry/repair/collapse_degenerate.h"

#include <algorithm>
#include <array>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "geometry/repair/face_height.h"

namespace dgm::bake {
namespace {

constexpr std::size_t kMostFaces = 64;  // at a vertex after a move: collapses must not make one large fan
constexpr std::size_t kLeastFaces = 2;  // of the component

class Collapser {
 public:
    explicit Collapser(TriMesh& mesh) : mesh_(mesh), faces_at_(mesh.positions.size()), left_(mesh.faces.size()) {
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
            for (const std::uint32_t v : mesh.faces[f]) faces_at_[v].push_back(f);
        gone_.assign(mesh.faces.size(), false);
        fixed_.assign(mesh.positions.size(), false);
        for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
            if (mesh.points[v] != v) fixed_[v] = fixed_[mesh.points[v]] = true;
    }

    std::uint64_t run() {
        bool moved = true;
        while (moved) {  // each move removes a face
            moved = false;
            for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f)
                if (!gone_[f] && without_height(mesh_.corners(f)) && collapse_edge_of(f)) moved = true;
        }
        const std::uint64_t removed = mesh_.faces.size() - left_;
        if (removed > 0) compact();
        return removed;
    }

 private:
    /// The shortest edge that may go.
    bool collapse_edge_of(std::uint32_t f) {
        const Face face = mesh_.faces[f];
        std::array<int, 3> order{0, 1, 2};
        const auto edge = [&](int k) { return length(mesh_.positions[face[(k + 1) % 3]] - mesh_.positions[face[k]]); };
        std::sort(order.begin(), order.end(), [&](int a, int b) {
            const double p = edge(a), q = edge(b);
            return p != q ? p < q : a < b;
        });
        for (const int k : order) {
            const std::uint32_t a = face[k], b = face[(k + 1) % 3];
            if (collapse(a, b) || collapse(b, a)) return true;
        }
        return false;
    }

    bool collapse(std::uint32_t v, std::uint32_t w) {
        std::vector<std::uint32_t>&at_v = faces_at_[v], &at_w = faces_at_[w];
        if (fixed_[v] || at_v.size() + at_w.size() > kMostFaces) return false;
        if (!keeps_surface(v, w) || !keeps_topology(v, w)) return false;
        std::size_t corner_at_w = 0;  // of a face that goes: corners that move there take its attributes
        for (const std::uint32_t f : at_v)
            for (std::size_t k = 0; k < 3; ++k)
                if (mesh_.faces[f][k] == w) corner_at_w = 3 * std::size_t{f} + k;
        for (const std::uint32_t f : at_v) {
            Face& face = mesh_.faces[f];
            if (std::find(face.begin(), face.end(), w) != face.end()) {
                gone_[f] = true;
                --left_;
                for (const std::uint32_t u : face)
                    if (u != v) std::erase(faces_at_[u], f);
            } else {
                const auto corner = std::find(face.begin(), face.end(), v);
                *corner = w;
                copy_corner(corner_at_w, 3 * std::size_t{f} + static_cast<std::size_t>(corner - face.begin()));
                at_w.push_back(f);
            }
        }
        at_v.clear();
        return true;
    }

    void copy_corner(std::size_t from, std::size_t to) {
        const auto copy = [&](auto& of_corners) {
            if (!of_corners.empty()) of_corners[to] = of_corners[from];
        };
        copy(mesh_.corner_normals);
        copy(mesh_.corner_uvs);
        copy(mesh_.corner_colours);
    }

    [[nodiscard]] bool keeps_surface(std::uint32_t v, std::uint32_t w) const {
        const Vec3d &from = mesh_.positions[v], &to = mesh_.positions[w];
        if (from == to) return true;
        return std::all_of(faces_at_[v].begin(), faces_at_[v].end(), [&](std::uint32_t f) {
            std::array<Vec3d, 3> q = mesh_.corners(f);
            if (!without_height(q)) return false;
            for (int k = 0; k < 3; ++k)
                if (mesh_.faces[f][k] == v) q[k] = to;
            return without_height(q);
        });
    }

    /// Neighbours of v, each as often as a face at v has it: once on a border edge, else twice.
    [[nodiscard]] std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
        std::vector<std::uint32_t> out;
        for (const std::uint32_t f : faces_at_[v])
            for (const std::uint32_t u : mesh_.faces[f])
                if (u != v) out.push_back(u);
        std::sort(out.begin(), out.end());
        return out;
    }

    /// The link condition, with one more vertex that every border edge is joined to.
    [[nodiscard]] bool keeps_topology(std::uint32_t v, std::uint32_t w) const {
        const std::vector<std::uint32_t> by_v = neighbours(v), by_w = neighbours(w);
        const auto times = [](const std::vector<std::uint32_t>& sorted, std::uint32_t u) {
            const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), u);
            return last - first;
        };
        const auto on_border = [&](const std::vector<std::uint32_t>& sorted) {
            return std::any_of(sorted.begin(), sorted.end(), [&](std::uint32_t u) { return times(sorted, u) == 1; });
        };
        const std::ptrdiff_t shared = times(by_v, w);
        if (shared == 0) return false;
        if (shared == 2 && on_border(by_v)) return false;  // it would leave its border, or pinch the surface
        std::ptrdiff_t common = 0;
        for (std::size_t k = 0; k < by_v.size(); ++k) {
            const std::uint32_t u = by_v[k];
            if (u == w || (k > 0 && by_v[k - 1] == u) || times(by_w, u) == 0) continue;
            ++common;
            if (times(by_v, u) == 1 && times(by_w, u) == 1 && shared == 1) return false;  // a hole of three edges
        }
        if (common != shared) return false;
        if (left_ < static_cast<std::size_t>(shared) + kLeastFaces) return false;
        return shared == 1 || !is_tetrahedron(v, w);
    }

    /// For an inner edge that meets the link condition: may both v and w have a face with the two vertices across it?
    [[nodiscard]] bool is_tetrahedron(std::uint32_t v, std::uint32_t w) const {
        return faces_at_[v].size() == 3 && faces_at_[w].size() == 3;
    }

    void compact() {
        std::size_t n = 0;
        for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
            if (gone_[f]) continue;
            mesh_.faces[n] = mesh_.faces[f];
            if (!mesh_.face_materials.empty()) mesh_.face_materials[n] = mesh_.face_materials[f];
            const auto take = [&](auto& of_corners) {
                if (!of_corners.empty()) std::copy_n(of_corners.begin() + 3 * f, 3, of_corners.begin() + 3 * n);
            };
            take(mesh_.corner_normals);
            take(mesh_.corner_uvs);
            take(mesh_.corner_colours);
            ++n;
        }
        mesh_.faces.resize(n);
        if (!mesh_.face_materials.empty()) mesh_.face_materials.resize(n);
        const auto shorten = [&](auto& of_corners) {
            if (!of_corners.empty()) of_corners.resize(3 * n);
        };
        shorten(mesh_.corner_normals);
        shorten(mesh_.corner_uvs);
        shorten(mesh_.corner_colours);
        std::vector<std::uint32_t> place(mesh_.positions.size(), kNone);
        for (const Face& face : mesh_.faces)
            for (const std::uint32_t v : face) place[v] = 0;
        std::uint32_t used = 0;
        for (std::size_t v = 0; v < place.size(); ++v)
            if (place[v] != kNone) {
                mesh_.positions[used] = mesh_.positions[v];
                place[v] = used++;
                // The first vertex of a point is before its others, and stays with them.
                if (!mesh_.points.empty()) mesh_.points[place[v]] = place[mesh_.points[v]];
            }
        mesh_.positions.resize(used);
        if (!mesh_.points.empty()) mesh_.points.resize(used);
        for (Face& face : mesh_.faces)
            for (std::uint32_t& v : face) v = place[v];
    }

    TriMesh& mesh_;
    std::vector<std::vector<std::uint32_t>> faces_at_;
    std::vector<bool> gone_;
    std::vector<bool> fixed_;  ///< vertices whose point has another one, which would have to move too
    std::size_t left_;
};

}  // namespace

std::uint64_t collapse_degenerate(TriMesh& mesh) {
    return Collapser(mesh).run();
}

}  // namespace dgm::bake
