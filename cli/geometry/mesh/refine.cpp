// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/refine.cpp
// [Rivara 1984] Algorithms for refining triangular grids suitable for adaptive and multigrid techniques. IJNME 20.
// [Lawson 1977] Software for C1 surface interpolation. Mathematical Software III.
#include "geometry/mesh/refine.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <queue>
#include <unordered_set>
#include <utility>
#include <vector>

#include "geometry/mesh/flip_edge.h"
#include "geometry/mesh/split_edge.h"

namespace dgm::bake {
namespace {

constexpr double kFlat = 2e-7;  // diagonals; coordinates of files are rounded to floats
// Relative, of corner attributes that are linear over a quad: files have four digits and more.
constexpr double kLinear = 1e-3;
constexpr double kDelaunay = 1e-6;      // of cotangents, against flips to and fro
constexpr std::size_t kMostFlips = 64;  // a face

struct Edge {
    double squared;           // length
    std::uint32_t low, high;  // vertices
    std::uint32_t half_edge;  // that joined them when this was queued

    /// True if `other` goes first.
    [[nodiscard]] bool operator<(const Edge& other) const {
        if (squared != other.squared) return squared < other.squared;
        if (low != other.low) return low > other.low;
        if (high != other.high) return high > other.high;
        return half_edge > other.half_edge;
    }
};

/// Half-edges of the quad (p, s, q, r) around an edge p -> q: those that leave p, q and r in the face with r, and q, p
/// and s in the face with s.
struct Quad {
    std::uint32_t p, q, r, across_q, across_p, s;
};

double diagonal(const TriMesh& mesh) {
    Vec3d low = mesh.positions.front(), high = low;
    for (const Vec3d& at : mesh.positions) {
        low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
        high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
    }
    return length(high - low);
}

/// A mesh whose longest edges are halved, and whose flat places stay Delaunay.
class Refinement {
 public:
    explicit Refinement(TriMesh mesh)
        : mesh_(std::move(mesh)), opposite_(opposite_half_edges(mesh_.faces)), flat_(kFlat * diagonal(mesh_)) {
        find_creases();
        for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) touch(f);
        make_delaunay();
    }

    void halve(std::size_t faces) {
        while (mesh_.faces.size() < faces && !longest_.empty()) {
            const Edge longest = longest_.top();
            longest_.pop();
            const Edge now = edge_of(longest.half_edge);
            if (now.low == longest.low && now.high == longest.high) split(longest.half_edge);
        }
    }

    [[nodiscard]] TriMesh take() && { return std::move(mesh_); }

 private:
    [[nodiscard]] const Vec3d& at(std::uint32_t h) const { return mesh_.positions[origin(mesh_.faces, h)]; }

    [[nodiscard]] Edge edge_of(std::uint32_t h) const {
        const std::uint32_t a = origin(mesh_.faces, h), b = target(mesh_.faces, h);
        const Vec3d along = mesh_.positions[b] - mesh_.positions[a];
        return {dot(along, along), std::min(a, b), std::max(a, b), h};
    }

    [[nodiscard]] Quad quad_of(std::uint32_t h) const {
        const std::uint32_t o = opposite_[h];
        return {h, next_half_edge(h), previous_half_edge(h), o, next_half_edge(o), previous_half_edge(o)};
    }

    /// True if the two faces look the same way and the other diagonal would not move the surface.
    [[nodiscard]] bool is_flat(const Quad& quad) const {
        const Vec3d q = at(quad.q) - at(quad.p), r = at(quad.r) - at(quad.p), s = at(quad.s) - at(quad.p);
        const Vec3d one = cross(q, r), other = cross(s, q);
        if (!(dot(one, other) > 0)) return false;
        const double area = std::max({length(one), length(other), length(cross(s, r)), length(cross(r - q, s - q))});
        return std::abs(dot(one, s)) <= flat_ * area;
    }

    /// True if `corners` have one value at each end of the edge, and another diagonal would not change what is between.
    template <class T>
    [[nodiscard]] bool is_linear(const std::vector<T>& corners, const Quad& quad) const {
        if (corners.empty()) return true;
        const T p = corners[quad.p], q = corners[quad.q], r = corners[quad.r], s = corners[quad.s];
        const Vec3d along = at(quad.q) - at(quad.p), to_r = at(quad.r) - at(quad.p), to_s = at(quad.s) - at(quad.p);
        const double above = length(cross(along, to_r)), below = length(cross(to_s, along));
        // The line from r to s crosses that of the edge at these shares of the two.
        const double u = above / (above + below);
        const double t = dot(to_r * (1 - u) + to_s * u, along) / dot(along, along);
        const double tolerance =
            kLinear * (length(p) * (1 + std::abs(t)) + length(q) * (1 + std::abs(t)) + length(r) + length(s));
        return length(corners[quad.across_p] - p) <= tolerance && length(corners[quad.across_q] - q) <= tolerance &&
               length(p * (1 - t) + q * t - r * (1 - u) - s * u) <= tolerance;
    }

    [[nodiscard]] bool is_one_colour(const Quad& quad) const {
        const std::vector<model::Rgba8>& colours = mesh_.corner_colours;
        if (colours.empty()) return true;
        const std::uint32_t others[] = {quad.q, quad.r, quad.across_q, quad.across_p, quad.s};
        return std::all_of(std::begin(others), std::end(others),
                           [&](std::uint32_t c) { return colours[c] == colours[quad.p]; });
    }

    [[nodiscard]] bool is_one_material(std::uint32_t f, std::uint32_t g) const {
        return mesh_.face_materials.empty() || mesh_.face_materials[f] == mesh_.face_materials[g];
    }

    /// True if the edge of h bounds the surface, or a place that is flat.
    [[nodiscard]] bool is_crease(std::uint32_t h) const {
        return opposite_[h] == kNone || creases_.contains(key_of(origin(mesh_.faces, h), target(mesh_.faces, h)));
    }
    [[nodiscard]] static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
        return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    }

    void find_creases();
    void split(std::uint32_t h);
    [[nodiscard]] bool is_not_delaunay(const Quad& quad) const;
    void make_delaunay();
    void touch(std::uint32_t f);

    TriMesh mesh_;
    std::vector<std::uint32_t> opposite_;
    double flat_;
    std::unordered_set<std::uint64_t> creases_;  ///< edges that flips keep: of the surface, of textures or of materials
    std::priority_queue<Edge> longest_;
    std::vector<std::uint32_t> doubtful_;  ///< half-edges that may not be Delaunay
    std::size_t flips_ = 0;
};

void Refinement::find_creases() {
    for (std::uint32_t h = 0; h < opposite_.size(); ++h) {
        if (opposite_[h] == kNone || opposite_[h] < h) continue;
        const Quad quad = quad_of(h);
        const bool goes_on = is_one_material(h / 3, opposite_[h] / 3) && is_flat(quad) &&
                             is_linear(mesh_.corner_normals, quad) && is_linear(mesh_.corner_uvs, quad) &&
                             is_one_colour(quad);
        if (!goes_on) creases_.insert(key_of(origin(mesh_.faces, h), target(mesh_.faces, h)));
    }
}

/// To be looked at, as its edges have changed.
void Refinement::touch(std::uint32_t f) {
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
        longest_.push(edge_of(h));
        doubtful_.push_back(h);
    }
}

void Refinement::split(std::uint32_t h) {
    const std::size_t before = mesh_.faces.size();
    const std::uint32_t across = opposite_[h], a = origin(mesh_.faces, h), b = target(mesh_.faces, h);
    const std::uint32_t middle = split_edge(mesh_, opposite_, h, 0.5).vertex;
    if (creases_.erase(key_of(a, b)) > 0) {
        creases_.insert(key_of(a, middle));
        creases_.insert(key_of(middle, b));
    }
    touch(h / 3);
    if (across != kNone) touch(across / 3);
    for (std::size_t f = before; f < mesh_.faces.size(); ++f) touch(static_cast<std::uint32_t>(f));
    make_delaunay();
}

/// True if its angles across the edge are more than half a turn in all.
bool Refinement::is_not_delaunay(const Quad& quad) const {
    const auto cotangent = [&](std::uint32_t from) {
        const Vec3d a = at(quad.p) - at(from), b = at(quad.q) - at(from);
        return dot(a, b) / length(cross(a, b));
    };
    const double one = cotangent(quad.r), other = cotangent(quad.s);
    return one + other < -kDelaunay * (1 + std::abs(one) + std::abs(other));
}

void Refinement::make_delaunay() {
    while (!doubtful_.empty()) {
        const std::uint32_t h = doubtful_.back(), o = opposite_[h];
        doubtful_.pop_back();
        if (is_crease(h) || flips_ == kMostFlips * mesh_.faces.size()) continue;
        const Quad quad = quad_of(h);
        if (!is_not_delaunay(quad) || !is_flat(quad) || !may_flip(mesh_.faces, opposite_, h)) continue;
        flip_edge(mesh_, opposite_, h);
        ++flips_;
        touch(h / 3);
        touch(o / 3);
    }
}

}  // namespace

TriMesh refine(TriMesh mesh, std::size_t faces) {
    Refinement refinement(std::move(mesh));
    refinement.halve(faces);
    return std::move(refinement).take();
}

}  // namespace dgm::bake
