// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/repair.cpp
// Corner gluing: union-find over the 3F corners of the soup (see repair.h for the five steps).
//
// Our choice over a polygon-soup library: per-corner normals, UVs and colours must follow every change, and a soup
// library renames points without saying which corner became which.
#include "geometry/repair/repair.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <unordered_map>

#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/split_edge.h"
#include "geometry/mesh/union_find.h"
#include "geometry/repair/collapse_degenerate.h"
#include "geometry/repair/face_height.h"
#include "geometry/repair/flip_degenerate.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

class Repairer {
 public:
    explicit Repairer(const TriMesh& source) : source_(source) {}

    RepairedMesh run() {
        drop_unusable_faces();
        normalise();
        weld_open_vertices();
        drop_repeated_corners();
        drop_duplicate_faces();
        if (faces_.empty()) throw Error(codes::kNoFaces, "no face with three distinct, finite corners is left");
        glue_edges();
        orient();
        build_components();
        drop_components_without_height();
        for (TriMesh& component : out_.components) remove_degenerate(component);
        double area = 0;
        for (const TriMesh& component : out_.components)
            for (std::size_t f = 0; f < component.faces.size(); ++f) area += face_area(component.corners(f));
        constexpr double kLeastArea = 1e-12;  // of the squared diagonal
        if (!(area > kLeastArea)) throw Error(codes::kNoFaces, "the faces have no area: all corners lie on one line");
        return std::move(out_);
    }

 private:
    void count(const std::string& what, std::uint64_t n) {
        if (n == 0) return;
        for (auto& [name, total] : out_.counts)
            if (name == what) {
                total += n;
                return;
            }
        out_.counts.emplace_back(what, n);
    }

    void drop_unusable_faces() {
        std::uint64_t not_finite = 0, out_of_range = 0;
        for (std::uint32_t f = 0; f < source_.faces.size(); ++f) {
            bool in_range = true, finite = true;
            for (std::uint32_t v : source_.faces[f]) {
                if (v >= source_.positions.size())
                    in_range = false;
                else if (!is_finite(source_.positions[v]))
                    finite = false;
            }
            if (!in_range)
                ++out_of_range;
            else if (!finite)
                ++not_finite;
            else
                faces_.push_back(source_.faces[f]), original_.push_back(f);
        }
        count("faces with a corner out of range dropped", out_of_range);
        count("faces with a non-finite corner dropped", not_finite);
        if (faces_.empty())
            throw Error(codes::kNoFaces, source_.faces.empty() ? "the file holds no faces"
                                         : not_finite > 0      ? "every face has a NaN or infinite corner"
                                                               : "no face refers to existing vertices");
    }

    void normalise() {
        constexpr double inf = std::numeric_limits<double>::infinity();
        Vec3d lo{inf, inf, inf}, hi{-inf, -inf, -inf};
        std::vector<bool> used(source_.positions.size(), false);
        for (const Face& face : faces_)
            for (std::uint32_t v : face) used[v] = true;
        std::uint64_t unused = 0;
        for (std::size_t v = 0; v < used.size(); ++v) {
            if (!used[v]) {
                ++unused;
                continue;
            }
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], source_.positions[v][k]);
                hi[k] = std::max(hi[k], source_.positions[v][k]);
            }
        }
        count("unused vertices left out", unused);
        const Vec3d size = hi - lo;
        const double extent = std::max({size.x, size.y, size.z});
        if (!(extent > 0)) throw Error(codes::kNoFaces, "all vertices coincide");
        if (!std::isfinite(extent)) throw Error(codes::kTooLarge, "the bounding box overflows double precision");
        out_.frame.diagonal = extent * length(size / extent);  // in this order: 1e200 squared would overflow
        out_.frame.centre = lo + size * 0.5;
        positions_.assign(source_.positions.size(), Vec3d{});
        for (std::size_t v = 0; v < used.size(); ++v)
            if (used[v]) positions_[v] = (source_.positions[v] - out_.frame.centre) / out_.frame.diagonal;
    }

    /// Shortest open edge at each vertex (edges that one face alone uses); infinity for vertices without one.
    [[nodiscard]] std::vector<double> shortest_open_edge() const {
        std::vector<double> shortest(positions_.size(), std::numeric_limits<double>::infinity());
        each_edge([&](std::span<const std::uint32_t> group) {
            if (group.size() != 1) return;
            const std::uint32_t a = origin(faces_, group[0]), b = target(faces_, group[0]);
            if (a == b) return;
            const double l = length(positions_[a] - positions_[b]);
            shortest[a] = std::min(shortest[a], l);
            shortest[b] = std::min(shortest[b], l);
        });
        return shortest;
    }

    void weld_open_vertices() {
        std::vector<double> shortest = shortest_open_edge();
        // Exact: sort the open vertices by position.
        std::vector<std::uint32_t> open;
        for (std::uint32_t v = 0; v < shortest.size(); ++v)
            if (std::isfinite(shortest[v])) open.push_back(v);
        const auto key = [&](std::uint32_t v) {
            const Vec3d& p = positions_[v];
            return std::tuple(p.x + 0.0, p.y + 0.0, p.z + 0.0);  // + 0.0 makes -0 and 0 one
        };
        std::sort(open.begin(), open.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
        UnionFind sets(positions_.size());
        std::uint64_t exact = 0, near = 0;
        for (std::size_t k = 1; k < open.size(); ++k)
            if (key(open[k]) == key(open[k - 1])) exact += sets.unite(open[k - 1], open[k]);
        apply(sets);
        // Within a tolerance: the open vertices that are left, in a grid of cells as large as the largest tolerance.
        shortest = shortest_open_edge();
        constexpr double kLargest = 1e-6, kShareOfEdge = 1e-3;
        std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
        const auto cell = [&](const Vec3d& p, int dx, int dy, int dz) {
            const auto part = [](double x, int d) {
                return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / kLargest)) + d + (1 << 20)) &
                       0x1fffff;
            };
            return part(p.x, dx) << 42 | part(p.y, dy) << 21 | part(p.z, dz);
        };
        for (std::uint32_t v = 0; v < shortest.size(); ++v) {
            if (!std::isfinite(shortest[v])) continue;
            for (int k = 0; k < 27; ++k) {
                const auto it = cells.find(cell(positions_[v], k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1));
                if (it == cells.end()) continue;
                for (std::uint32_t w : it->second) {
                    const double tolerance = std::min(kLargest, kShareOfEdge * std::min(shortest[v], shortest[w]));
                    if (length(positions_[v] - positions_[w]) <= tolerance) near += sets.unite(v, w);
                }
            }
            cells[cell(positions_[v], 0, 0, 0)].push_back(v);
        }
        apply(sets);
        count("open vertices welded", exact);
        count("nearly coincident open vertices welded", near);
    }

    void apply(UnionFind& sets) {
        for (Face& face : faces_)
            for (std::uint32_t& v : face) v = sets.find(v);
    }

    template <class Keep>
    std::uint64_t keep_if(Keep keep) {
        std::size_t n = 0;
        for (std::size_t f = 0; f < faces_.size(); ++f)
            if (keep(f)) faces_[n] = faces_[f], original_[n] = original_[f], ++n;
        const std::uint64_t dropped = faces_.size() - n;
        faces_.resize(n), original_.resize(n);
        return dropped;
    }

    void drop_repeated_corners() {
        count("faces that repeat a corner dropped", keep_if([&](std::size_t f) {
                  const Face& q = faces_[f];
                  return q[0] != q[1] && q[1] != q[2] && q[2] != q[0];
              }));
    }

    void drop_duplicate_faces() {
        std::vector<std::pair<Face, std::uint32_t>> sorted;
        sorted.reserve(faces_.size());
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            Face q = faces_[f];
            std::sort(q.begin(), q.end());
            sorted.emplace_back(q, f);
        }
        std::sort(sorted.begin(), sorted.end());
        std::vector<bool> duplicate(faces_.size(), false);
        for (std::size_t k = 1; k < sorted.size(); ++k)
            if (sorted[k].first == sorted[k - 1].first) duplicate[sorted[k].second] = true;
        count("faces that stand twice dropped", keep_if([&](std::size_t f) { return !duplicate[f]; }));
    }

    /// Calls `visit` with the half-edges of each undirected edge, in a fixed order.
    template <class Visit>
    void each_edge(Visit visit) const {
        std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
        edges.reserve(faces_.size() * 3);
        for (std::uint32_t h = 0; h < faces_.size() * 3; ++h) {
            const std::uint32_t a = origin(faces_, h), b = target(faces_, h);
            edges.emplace_back(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), h);
        }
        std::sort(edges.begin(), edges.end());
        std::vector<std::uint32_t> group;
        for (std::size_t k = 0; k < edges.size(); ++k) {
            group.push_back(edges[k].second);
            if (k + 1 < edges.size() && edges[k + 1].first == edges[k].first) continue;
            visit(std::span<const std::uint32_t>(group));
            group.clear();
        }
    }

    void glue_edges() {
        partner_.assign(faces_.size() * 3, kNone);
        std::uint64_t non_manifold = 0;
        each_edge([&](std::span<const std::uint32_t> group) {
            if (group.size() > 2) {
                ++non_manifold;
                pair_by_angle(group);
            } else if (group.size() == 2) {
                glue(group[0], group[1]);
            }
        });
        count("non-manifold edges taken apart", non_manifold);
    }

    void glue(std::uint32_t a, std::uint32_t b) { partner_[a] = b, partner_[b] = a; }

    /// Faces around one edge, sorted by angle: a face is joined to the next one that runs the other way, so that two
    /// solids that touch along an edge come apart as two solids. What finds no partner stays open.
    void pair_by_angle(std::span<const std::uint32_t> group) {
        const std::uint32_t a = std::min(origin(faces_, group[0]), target(faces_, group[0]));
        const std::uint32_t b = std::max(origin(faces_, group[0]), target(faces_, group[0]));
        const Vec3d axis = normalized(positions_[b] - positions_[a]);
        const auto arm = [&](std::uint32_t h) {
            const std::uint32_t apex = faces_[h / 3][(h + 2) % 3];
            const Vec3d d = positions_[apex] - positions_[a];
            return d - axis * dot(d, axis);
        };
        const Vec3d x = normalized(arm(group[0]), Vec3d{1, 0, 0}), y = cross(axis, x);
        std::vector<std::pair<double, std::uint32_t>> around;
        for (std::uint32_t h : group) {
            const Vec3d d = arm(h);
            around.emplace_back(h == group[0] ? 0.0 : std::fmod(std::atan2(dot(d, y), dot(d, x)) + 2 * M_PI, 2 * M_PI),
                                h);
        }
        std::sort(around.begin(), around.end());
        // Seen along the axis, a face that runs a->b has its inside on the side of falling angle.
        const std::size_t n = around.size();
        std::vector<bool> taken(n, false);
        for (std::size_t k = 0; k < n; ++k) {
            const std::uint32_t h = around[k].second;
            if (taken[k] || origin(faces_, h) != a) continue;
            const std::size_t before = (k + n - 1) % n;
            if (taken[before] || origin(faces_, around[before].second) != b) continue;
            glue(h, around[before].second);
            taken[k] = taken[before] = true;
        }
    }

    void orient() {
        const std::size_t n = faces_.size();
        component_.assign(n, kNone);
        std::vector<char> turned(n, 0);
        std::vector<std::uint32_t> stack;
        std::uint64_t turned_faces = 0;
        for (std::uint32_t seed = 0; seed < n; ++seed) {
            if (component_[seed] != kNone) continue;
            const std::uint32_t id = component_count_++;
            std::vector<std::uint32_t> members{seed};
            component_[seed] = id;
            bool closed = true;
            for (std::size_t at = 0; at < members.size(); ++at) {
                const std::uint32_t f = members[at];
                for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
                    const std::uint32_t g = partner_[h];
                    if (g == kNone) {
                        closed = false;
                        continue;
                    }
                    const bool agree = origin(faces_, h) != origin(faces_, g);
                    const char expected = agree ? turned[f] : static_cast<char>(!turned[f]);
                    if (component_[g / 3] == kNone) {
                        component_[g / 3] = id;
                        turned[g / 3] = expected;
                        members.push_back(g / 3);
                    } else if (turned[g / 3] != expected) {
                        throw Error(codes::kNonOrientable,
                                    "the surface has no inside and outside: following it around, face " +
                                        std::to_string(original_[g / 3]) + " meets itself from its other side",
                                    "face " + std::to_string(original_[g / 3]));
                    }
                }
            }
            double kept_area = 0, turned_area = 0, volume = 0;
            for (std::uint32_t f : members) {
                const auto q = corners(f);
                (turned[f] ? turned_area : kept_area) += face_area(q);
                volume += (turned[f] ? -1 : 1) * dot(q[0], cross(q[1], q[2]));
            }
            const bool mixed = std::min(kept_area, turned_area) > 0.1 * (kept_area + turned_area);
            const bool flip_all = closed && mixed ? volume < 0 : turned_area > kept_area;
            for (std::uint32_t f : members) {
                if (flip_all) turned[f] = static_cast<char>(!turned[f]);
                turned_faces += static_cast<std::uint64_t>(turned[f]);
            }
        }
        turned_ = std::move(turned);
        count("faces turned to agree with their neighbours", turned_faces);
    }

    [[nodiscard]] std::array<Vec3d, 3> corners(std::uint32_t f) const {
        return {positions_[faces_[f][0]], positions_[faces_[f][1]], positions_[faces_[f][2]]};
    }

    void build_components() {
        // Corners are one vertex where gluing joins them.
        UnionFind corner_sets(faces_.size() * 3);
        const auto corner_at = [&](std::uint32_t h, std::uint32_t vertex) {
            return faces_[h / 3][h % 3] == vertex ? h : next_half_edge(h);
        };
        for (std::uint32_t h = 0; h < partner_.size(); ++h) {
            const std::uint32_t g = partner_[h];
            if (g == kNone || g < h) continue;
            for (std::uint32_t v : {origin(faces_, h), target(faces_, h)})
                corner_sets.unite(corner_at(h, v), corner_at(g, v));
        }
        out_.components.resize(component_count_);
        std::vector<std::uint32_t> local(faces_.size() * 3, kNone);
        std::vector<bool> seen(positions_.size(), false);
        std::uint64_t split = 0;
        std::vector<std::uint32_t> local_faces(faces_.size());
        for (TriMesh& component : out_.components) component.materials = source_.materials;
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            TriMesh& mesh = out_.components[component_[f]];
            Face face;
            std::array<std::uint32_t, 3> order{0, 1, 2};
            if (turned_[f]) std::swap(order[1], order[2]);
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t corner = 3 * f + order[k], set = corner_sets.find(corner);
                if (local[set] == kNone) {
                    const std::uint32_t v = faces_[f][order[k]];
                    local[set] = static_cast<std::uint32_t>(mesh.positions.size());
                    mesh.positions.push_back(positions_[v]);
                    split += seen[v];
                    seen[v] = true;
                }
                face[k] = local[set];
            }
            local_faces[f] = static_cast<std::uint32_t>(mesh.faces.size());
            mesh.faces.push_back(face);
            copy_attributes(f, order, mesh);
        }
        count("vertices split where surfaces only touch", split);
        split_double_edges(local_faces);
    }

    /// Gluing may leave two different edges between the same two vertices; the later ones get a vertex in the middle,
    /// so that from here on an edge is known by its ends.
    void split_double_edges(const std::vector<std::uint32_t>& local_faces) {
        std::vector<std::vector<std::uint32_t>> partners(out_.components.size());
        for (std::size_t c = 0; c < partners.size(); ++c)
            partners[c].assign(3 * out_.components[c].faces.size(), kNone);
        const auto local_half_edge = [&](std::uint32_t h) {
            if (h == kNone) return kNone;
            static constexpr std::uint32_t kTurned[3] = {2, 1,
                                                         0};  // corners (0, 2, 1): edge 0-1 is the last, 2-0 the first
            return 3 * local_faces[h / 3] + (turned_[h / 3] ? kTurned[h % 3] : h % 3);
        };
        for (std::uint32_t h = 0; h < partner_.size(); ++h)
            partners[component_[h / 3]][local_half_edge(h)] = local_half_edge(partner_[h]);
        for (std::size_t c = 0; c < partners.size(); ++c)
            count("double edges split", split_repeated_edges(out_.components[c], partners[c]));
    }

    void copy_attributes(std::uint32_t f, const std::array<std::uint32_t, 3>& order, TriMesh& mesh) const {
        const std::size_t base = 3 * std::size_t{original_[f]};
        for (std::uint32_t k : order) {
            if (!source_.corner_normals.empty())
                mesh.corner_normals.push_back(turned_[f] ? -source_.corner_normals[base + k]
                                                         : source_.corner_normals[base + k]);
            if (!source_.corner_uvs.empty()) mesh.corner_uvs.push_back(source_.corner_uvs[base + k]);
            if (!source_.corner_colours.empty()) mesh.corner_colours.push_back(source_.corner_colours[base + k]);
        }
        if (!source_.face_materials.empty()) mesh.face_materials.push_back(source_.face_materials[original_[f]]);
    }

    /// What lies within a line cannot be seen, and has no map. A mesh of nothing else is left for the area to tell.
    void drop_components_without_height() {
        const auto visible = [](const TriMesh& component) {
            for (std::size_t f = 0; f < component.faces.size(); ++f)
                if (!without_height(component.corners(f))) return true;
            return false;
        };
        std::vector<TriMesh> kept;
        std::uint64_t dropped = 0;
        for (TriMesh& component : out_.components) {
            if (visible(component))
                kept.push_back(std::move(component));
            else
                dropped += component.faces.size();
        }
        if (kept.empty()) throw Error(codes::kNoFaces, "the faces have no area: all corners lie on one line");
        out_.components = std::move(kept);
        count("zero-height faces apart from all others dropped", dropped);
    }

    /// Each step makes room for the other: an edge collapsed may leave a face that a neighbour can take in, and a flip
    /// a corner whose faces all lie within a line.
    void remove_degenerate(TriMesh& component) {
        constexpr int kMaxRounds = 32;
        for (int round = 0; round < kMaxRounds; ++round) {
            const std::uint64_t flipped = flip_degenerate(component), collapsed = collapse_degenerate(component);
            count("zero-height faces flipped away", flipped);
            count("zero-height faces collapsed", collapsed);
            if (flipped + collapsed == 0) break;
        }
    }

    const TriMesh& source_;
    RepairedMesh out_;
    std::vector<Vec3d> positions_;  // normalised
    std::vector<Face> faces_;
    std::vector<std::uint32_t> original_;  // face of the source, per face
    std::vector<std::uint32_t> partner_;   // glued half-edge, either direction
    std::vector<std::uint32_t> component_;
    std::vector<char> turned_;
    std::uint32_t component_count_ = 0;
};

}  // namespace

RepairedMesh repair(const TriMesh& source) {
    return Repairer(source).run();
}

}  // namespace dgm::bake
