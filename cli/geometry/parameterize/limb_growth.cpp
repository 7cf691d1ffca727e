// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/limb_growth.cpp
#include "geometry/parameterize/limb_growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/infinity.h"
#include "geometry/mesh/vertex_corners.h"
#include "geometry/parameterize/flip_free_problem.h"
#include "geometry/parameterize/slim.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

/// a b as complex numbers.
Vec2d times(Vec2d a, Vec2d b) {
    return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x};
}

/// Edges from the border to each vertex.
std::vector<std::uint32_t> depths(const DiskView& disk, const VertexCorners& corners) {
    std::vector<std::uint32_t> depth(disk.positions.size(), kNone), queue(disk.border.begin(), disk.border.end());
    for (const std::uint32_t v : queue) depth[v] = 0;
    for (std::size_t k = 0; k < queue.size(); ++k)
        for (std::uint32_t c = corners.first[queue[k]]; c < corners.first[queue[k] + 1]; ++c)
            for (const std::uint32_t to : disk.faces[corners.of[c] / 3])
                if (depth[to] == kNone) {
                    depth[to] = depth[queue[k]] + 1;
                    queue.push_back(to);
                }
    return depth;
}

/// What lies beyond a ring, the ring included, and how a sweep moves it: x to `to` + by (x - from), as complex numbers.
struct Region {
    std::uint32_t parent = kNone;  ///< beyond the next ring outwards; numbers fall inwards
    std::uint32_t first_vertex = 0,
                  first_face = 0;  ///< of `vertices` (the ring) and `faces` (which it is moved against)
    double inside = 0;             ///< energy of the faces that move along, before the sweep
    Vec2d from, to, by{1, 0};
};

class LimbGrowth {
 public:
    LimbGrowth(const DiskView& disk, std::vector<Vec2d> uv)
        : disk_(disk),
          uv_(std::move(uv)),
          corners_(disk.faces, disk.positions.size()),
          depth_(depths(disk, corners_)),
          region_of_(disk.positions.size(), kNone) {
        for (std::size_t f = 0; f < disk.faces.size(); ++f) shapes_.push_back(shape(disk.faces[f]));
        find_regions();
    }

    /// Returns the share of the energy that is left.
    double sweep() {
        before_ = uv_;
        const double energy = measure_insides();
        for (std::size_t r = regions_.size(); r-- > 0;) move(regions_[r]);
        return total_energy() / energy;
    }
    void take_back() { uv_.swap(before_); }
    [[nodiscard]] const std::vector<Vec2d>& uv() const { return uv_; }

 private:
    /// Area, and squared lengths of the sides opposite the corners.
    struct Shape {
        double area, l0, l1, l2;
    };
    [[nodiscard]] Shape shape(const Face& f) const {
        const std::span<const Vec3d> q = disk_.positions;
        const Vec3d e0 = q[f[2]] - q[f[1]], e1 = q[f[0]] - q[f[2]], e2 = q[f[1]] - q[f[0]];
        return {0.5 * length(cross(e2, e0)), dot(e0, e0), dot(e1, e1), dot(e2, e2)};
    }

    /// Area times squared L2 stretch with corners at a, b and c; infinity if they do not turn left.
    [[nodiscard]] static double energy(const Shape& s, Vec2d a, Vec2d b, Vec2d c) {
        const Vec2d e0 = c - b, e1 = a - c, e2 = b - a;
        const double t = difference_of_products(e2.x, -e1.y, e2.y, -e1.x);
        if (!(t > 0)) return kInfinity;
        return -s.area * (s.l0 * dot(e1, e2) + s.l1 * dot(e2, e0) + s.l2 * dot(e0, e1)) / (t * t);
    }
    [[nodiscard]] double energy_of(std::size_t f) const {
        const Face& c = disk_.faces[f];
        return energy(shapes_[f], uv_[c[0]], uv_[c[1]], uv_[c[2]]);
    }
    [[nodiscard]] double total_energy() const {
        double sum = 0;
        for (std::size_t f = 0; f < disk_.faces.size(); ++f) sum += energy_of(f);
        return sum;
    }

    /// The region whose ring the face is moved against, or kNone if it lies along a ring or the border.
    [[nodiscard]] std::uint32_t moved_against(const Face& f) const {
        const std::uint32_t least = std::min({depth_[f[0]], depth_[f[1]], depth_[f[2]]});
        for (const std::uint32_t v : f)
            if (depth_[v] > least) return region_of_[v];
        return kNone;
    }

    /// Rings from the innermost outwards.
    void find_regions() {
        const std::size_t n = depth_.size();
        std::vector<std::uint32_t> order(n), set(n);
        for (std::uint32_t v = 0; v < n; ++v) order[v] = set[v] = v;
        std::stable_sort(order.begin(), order.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return depth_[a] > depth_[b]; });
        const auto root = [&](std::uint32_t v) {
            while (set[v] != v) v = set[v] = set[set[v]];
            return v;
        };
        const auto neighbours = [&](std::uint32_t v, const auto& visit) {
            for (std::uint32_t c = corners_.first[v]; c < corners_.first[v + 1]; ++c)
                for (const std::uint32_t u : disk_.faces[corners_.of[c] / 3])
                    if (u != v) visit(u);
        };
        std::vector<std::uint32_t> region_of_root(n, kNone);
        for (std::size_t begin = 0; begin < n && depth_[order[begin]] > 0;) {
            const std::uint32_t level = depth_[order[begin]];
            std::size_t end = begin;
            for (; end < n && depth_[order[end]] == level; ++end)
                neighbours(order[end], [&](std::uint32_t u) {
                    if (depth_[u] >= level) set[root(u)] = root(order[end]);
                });
            const auto first = static_cast<std::uint32_t>(regions_.size());
            for (std::size_t k = begin; k < end; ++k) {
                std::uint32_t& region = region_of_root[root(order[k])];
                if (region == kNone || region < first) {
                    region = static_cast<std::uint32_t>(regions_.size());
                    regions_.emplace_back();
                }
                region_of_[order[k]] = region;
                neighbours(order[k], [&](std::uint32_t u) {
                    if (depth_[u] == level + 1) regions_[region_of_[u]].parent = region;
                });
            }
            begin = end;
        }
        list_rings();
    }

    void list_rings() {
        std::vector<std::uint32_t> against(disk_.faces.size());
        for (std::size_t f = 0; f < against.size(); ++f) {
            against[f] = moved_against(disk_.faces[f]);
            if (against[f] != kNone) ++regions_[against[f]].first_face;
        }
        for (const std::uint32_t r : region_of_)
            if (r != kNone) ++regions_[r].first_vertex;
        std::uint32_t vertices = 0, faces = 0;
        for (Region& r : regions_) {
            vertices += std::exchange(r.first_vertex, vertices);
            faces += std::exchange(r.first_face, faces);
        }
        regions_.emplace_back();
        regions_.back().first_vertex = vertices;
        regions_.back().first_face = faces;
        vertices_.resize(vertices);
        faces_.resize(faces);
        std::vector<std::uint32_t> next_vertex, next_face;
        for (const Region& r : regions_) {
            next_vertex.push_back(r.first_vertex);
            next_face.push_back(r.first_face);
        }
        for (std::uint32_t v = 0; v < region_of_.size(); ++v)
            if (region_of_[v] != kNone) vertices_[next_vertex[region_of_[v]]++] = v;
        for (std::uint32_t f = 0; f < against.size(); ++f)
            if (against[f] != kNone) faces_[next_face[against[f]]++] = f;
        regions_.pop_back();
    }

    /// Energies of what moves along with each ring, before anything has moved. Returns that of the whole map.
    double measure_insides() {
        for (Region& r : regions_) r.inside = 0;
        double all = 0;
        for (std::size_t f = 0; f < disk_.faces.size(); ++f) {
            const Face& face = disk_.faces[f];
            const double e = energy_of(f);
            all += e;
            const std::uint32_t against = moved_against(face);
            const std::uint32_t within = against != kNone ? regions_[against].parent : region_of_[face[0]];
            if (within != kNone) regions_[within].inside += e;
        }
        for (const Region& r : regions_)
            if (r.parent != kNone) regions_[r.parent].inside += r.inside;
        return all;
    }

    [[nodiscard]] std::span<const std::uint32_t> ring(const Region& r) const {
        const std::size_t next = &r + 1 < regions_.data() + regions_.size() ? (&r + 1)->first_vertex : vertices_.size();
        return std::span(vertices_).subspan(r.first_vertex, next - r.first_vertex);
    }
    [[nodiscard]] std::span<const std::uint32_t> faces_at(const Region& r) const {
        const std::size_t next = &r + 1 < regions_.data() + regions_.size() ? (&r + 1)->first_face : faces_.size();
        return std::span(faces_).subspan(r.first_face, next - r.first_face);
    }

    /// Energy of a region and the faces at its ring if it is moved by to + by (x - from).
    [[nodiscard]] double energy_if(const Region& r, Vec2d to, Vec2d by) const {
        const std::uint32_t own = static_cast<std::uint32_t>(&r - regions_.data());
        double sum = r.inside > 0 ? r.inside / dot(by, by) : 0;
        for (const std::uint32_t f : faces_at(r)) {
            std::array<Vec2d, 3> x;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = disk_.faces[f][k];
                x[k] = region_of_[v] == own ? to + times(by, before_[v] - r.from) : uv_[v];
            }
            sum += energy(shapes_[f], x[0], x[1], x[2]);
            if (!(sum < kInfinity)) return kInfinity;
        }
        return sum;
    }

    /// Moves a region along with the one about it, then by the best similarity a search by coordinates finds.
    void move(Region& r) {
        const std::span<const std::uint32_t> own = ring(r);
        r.from = {};
        for (const std::uint32_t v : own) r.from = r.from + before_[v] * (1.0 / static_cast<double>(own.size()));
        r.to = r.from;
        r.by = {1, 0};
        if (r.parent != kNone) {
            const Region& about = regions_[r.parent];
            r.to = about.to + times(about.by, r.from - about.from);
            r.by = about.by;
        }
        search(r);
        for (const std::uint32_t v : own) uv_[v] = r.to + times(r.by, before_[v] - r.from);
    }

    void search(Region& r) const {
        constexpr int kRounds = 6, kLongest = 40;
        constexpr double kFactor = 1.6, kTurn = 0.3, kShift = 0.3;
        double least = energy_if(r, r.to, r.by);
        if (!(least < kInfinity)) return;
        double reach = 0;
        for (const std::uint32_t f : faces_at(r))
            for (const std::uint32_t v : disk_.faces[f])
                if (depth_[v] < depth_[vertices_[r.first_vertex]]) {
                    const Vec2d away = uv_[v] - r.to;
                    reach = std::max(reach, dot(away, away));
                }
        reach = std::sqrt(reach);
        const auto takes = [&](Vec2d to, Vec2d by) {
            const double now = energy_if(r, to, by);
            if (!(now < least)) return false;
            least = now;
            r.to = to;
            r.by = by;
            return true;
        };
        double part = 1;  // of the steps above
        for (int round = 0; round < kRounds; ++round, part *= 0.5) {
            const double grown = 1 + (kFactor - 1) * part, turn = kTurn * part, shift = kShift * part * reach;
            const double norm = 1 / std::sqrt(1 + turn * turn);
            const std::array<Vec2d, 4> factors{{{grown, 0}, {1 / grown, 0}, {norm, turn * norm}, {norm, -turn * norm}}};
            for (const Vec2d by : factors)
                for (int k = 0; k < kLongest && takes(r.to, times(by, r.by)); ++k) {}
            for (const Vec2d way : {Vec2d{shift, 0}, Vec2d{-shift, 0}, Vec2d{0, shift}, Vec2d{0, -shift}})
                for (int k = 0; k < kLongest && takes(r.to + way, r.by); ++k) {}
        }
    }

    const DiskView& disk_;
    std::vector<Vec2d> uv_, before_;
    VertexCorners corners_;
    std::vector<std::uint32_t> depth_;
    std::vector<std::uint32_t> region_of_;  ///< of the ring that a vertex is on; kNone on the border
    std::vector<Shape> shapes_;
    std::vector<Region> regions_;  ///< innermost rings first
    std::vector<std::uint32_t> vertices_, faces_;
};

}  // namespace

std::vector<Vec2d> grow_limbs(const DiskView& disk, std::vector<Vec2d> uv, int sweeps,
                              const model::Progress& progress) {
    constexpr double kGain = 0.99;
    LimbGrowth growth(disk, std::move(uv));
    for (int k = 0; k < sweeps; ++k) {
        progress.update("parameterize", static_cast<double>(k) / sweeps);
        const double left = growth.sweep();
        if (!(left < 1) || count_not_positive(disk.faces, growth.uv()) > 0) {
            growth.take_back();
            break;
        }
        if (left > kGain) break;
    }
    return growth.uv();
}

}  // namespace dgm::bake
