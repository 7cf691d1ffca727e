// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/matches.cpp
#include "geometry/fit/matches.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "geometry/fit/pieces.h"
#include "geometry/mesh/infinity.h"

namespace dgm::bake {
namespace {

constexpr double kVertexWeight = 0.25;

/// Of the matches begin .. end; the sum is over those before `counted`.
PieceOfMatches measured(const std::vector<Match>& list, std::size_t begin, std::size_t end, std::size_t counted) {
    PieceOfMatches out;
    for (std::size_t k = begin; k < end; ++k) {
        out.farthest = std::max(out.farthest, list[k].hit.squared);
        if (k < counted) out.sum += list[k].hit.squared;
    }
    return out;
}

/// Calls body(k, looked) for each match of `list`, then measures every piece while it is in the cache: the lists are
/// long, and all passes need these pieces.
/// @return  sum of what the bodies have added to `looked`
template <class Body>
std::uint64_t look_up(const std::vector<Match>& list, std::size_t counted, std::vector<PieceOfMatches>& pieces,
                      const Body& body) {
    pieces.assign(pieces_of(list.size()), {});
    std::atomic<std::uint64_t> all_looked{0};
    in_pieces(list.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
        std::uint64_t looked = 0;
        for (std::size_t k = begin; k < end; ++k) body(k, &looked);
        pieces[piece] = measured(list, begin, end, counted);
        all_looked += looked;
    });
    return all_looked;
}

/// Numbers of the faces that may be nearer to a point farther off than the root of `limit` than its match is: those
/// whose box meets a cell, of a coarse division of space, that the ball about such a point meets; ascending.
std::vector<std::uint32_t> faces_in_reach(const LinkedSurface& surface, const std::vector<Match>& points,
                                          double limit) {
    constexpr int kCells = 64;
    Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (const Vec3d& p : surface.positions)
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    const auto cell = [&](double x, int k) {
        const double size = high[k] - low[k];
        return size > 0 ? static_cast<int>(std::clamp((x - low[k]) / size * kCells, 0.0, kCells - 1.0)) : 0;
    };
    /// Calls body(cell) for the cells of a box until it returns true; whether it did.
    const auto any_cell = [&](const Vec3d& from, const Vec3d& to, const auto& body) {
        for (int x = cell(from.x, 0); x <= cell(to.x, 0); ++x)
            for (int y = cell(from.y, 1); y <= cell(to.y, 1); ++y)
                for (int z = cell(from.z, 2); z <= cell(to.z, 2); ++z)
                    if (body((std::size_t(x) * kCells + std::size_t(y)) * kCells + std::size_t(z))) return true;
        return false;
    };
    std::vector<char> reached(std::size_t{kCells} * kCells * kCells, 0);
    for (const Match& m : points) {
        if (!(m.hit.squared > limit)) continue;
        const double reach = std::sqrt(m.hit.squared) * (1 + 1e-9);
        const Vec3d around{reach, reach, reach};
        any_cell(m.position - around, m.position + around, [&](std::size_t at) {
            reached[at] = 1;
            return false;
        });
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
        const auto q = surface.corners(f);
        Vec3d from = q[0], to = q[0];
        for (int k = 0; k < 3; ++k) {
            from[k] = std::min({q[0][k], q[1][k], q[2][k]});
            to[k] = std::max({q[0][k], q[1][k], q[2][k]});
        }
        if (any_cell(from, to, [&](std::size_t at) { return reached[at] != 0; })) out.push_back(f);
    }
    return out;
}

}  // namespace

Matches::Matches(const SampledChart& chart, const LinkedSurface& source, const WeldedGrid& grid, std::size_t count,
                 const Hold& hold)
    : source_(source), grid_(grid), hold_(hold) {
    if (source.faces.size() > grid.surface.faces.size()) {
        source_index_ = &chart.disk.index();
        slack_ = 0.25 * std::sqrt(surface_area(source) / static_cast<double>(chart.grid_count()));
    }
    spread(chart, count);
    start(chart);
}

/// Each point starts on the quad that the map puts it on.
void Matches::spread(const SampledChart& chart, std::size_t count) {
    const TriMesh& mesh = chart.disk->mesh;
    const auto add = [&](const Vec3d& position, std::uint32_t face, double weight) {
        points.push_back({position, {face, 0, {}}, weight});
    };
    points.reserve(count + source_.positions.size());
    for (const SurfaceSample& at : spread_by_area(mesh, count)) add(position_at(mesh, at), grid_.face_at(chart, at), 1);
    area_points = points.size();
    std::vector<char> seen(source_.positions.size(), 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const std::uint32_t point = chart.disk->weld[v];
        if (!seen[point]) {
            seen[point] = 1;
            add(mesh.positions[v], grid_.face_at(chart, chart.uv[v]), kVertexWeight);
        }
    }
}

/// Points that fall on no quad (beside the border of a free chart) and samples without a face start at the closest of
/// all faces.
void Matches::start(const SampledChart& chart) {
    std::unique_ptr<ClosestPointIndex> index;
    const auto find = [&](const LinkedSurface& surface, const Vec3d& p) {
        if (!index) index = std::make_unique<ClosestPointIndex>(surface.positions, surface.faces);
        const std::uint32_t face = index->query(p).face;
        return face == kNone ? 0 : face;
    };
    for (Match& m : points)
        if (m.hit.face == kNone) m.hit.face = find(grid_.surface, m.position);
    index.reset();
    classes.resize(grid_.sample_of.size());
    for (std::size_t c = 0; c < classes.size(); ++c) {
        const std::uint32_t face = chart.samples[grid_.sample_of[c]].face;
        classes[c].hit.face = face != kNone ? face : find(source_, grid_.surface.positions[c]);
    }
    middles.resize(grid_.surface.faces.size());
    for (std::size_t f = 0; f < middles.size(); ++f) middles[f].hit.face = classes[grid_.surface.faces[f][0]].hit.face;
}

SurfaceHit Matches::on_source(const Vec3d& p, const Vec3d& normal, std::uint32_t start, std::uint64_t* looked) const {
    if (source_index_ == nullptr) return walk_to_closest(source_, p, start, looked);
    const ClosestPoint hit = source_index_->query_preferring(p, normal, slack_, start);
    if (hit.face == kNone) return walk_to_closest(source_, p, start);
    return {hit.face, hit.distance * hit.distance, {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]}};
}

void Matches::update(bool with_edges, std::span<const char> near) {
    const LinkedSurface& grid = grid_.surface;
    std::vector<Vec3d> normal(source_index_ != nullptr ? classes.size() : 0);
    if (source_index_ != nullptr) {
        for (std::size_t f = 0; f < grid.faces.size(); ++f) {
            const auto q = grid.corners(f);
            for (const std::uint32_t c : grid.faces[f]) grid_.add_facing(normal[c], cross(q[1] - q[0], q[2] - q[0]), c);
        }
        for (Vec3d& n : normal) n = normalized(n, Vec3d{});
    }
    std::vector<char> near_class(near.empty() ? 0 : classes.size(), 0);
    for (std::size_t f = 0; f < near.size(); ++f)
        if (near[f])
            for (const std::uint32_t c : grid.faces[f]) near_class[c] = 1;
    looked_ += look_up(points, area_points, pieces_[0], [&](std::size_t k, std::uint64_t* looked) {
        if (near.empty() || near[points[k].hit.face])
            points[k].hit = walk_to_closest(grid, points[k].position, points[k].hit.face, looked);
    });
    looked_ += look_up(classes, 0, pieces_[1], [&](std::size_t c, std::uint64_t* looked) {
        if (!near.empty() && !near_class[c]) return;
        classes[c].position = grid.positions[c];
        classes[c].hit =
            on_source(classes[c].position, normal.empty() ? Vec3d{} : normal[c], classes[c].hit.face, looked);
    });
    looked_ += look_up(middles, 0, pieces_[2], [&](std::size_t f, std::uint64_t* looked) {
        if (near.empty() || near[f]) update_middle(f, looked);
    });
    if (!with_edges || edges.size() != grid_.edges.size()) {
        edges.clear();
        pieces_[3].clear();
    }
    if (with_edges) update_edges(edges.empty() ? std::span<const char>{} : near);
    look_again_far_off(near);
    weigh_and_measure();
}

void Matches::update_middle(std::size_t face) {
    update_middle(face, nullptr);
}

void Matches::update_middle(std::size_t face, std::uint64_t* looked) {
    const auto q = grid_.surface.corners(face);
    Match& m = middles[face];
    m.position = (q[0] + q[1] + q[2]) / 3;
    m.hit = on_source(m.position, unit_normal(q), m.hit.face, looked);
}

void Matches::update_edges(std::span<const char> near) {
    const LinkedSurface& grid = grid_.surface;
    edges.resize(grid_.edges.size());
    edge_place.resize(edges.size());
    for (std::uint32_t f = 0; f < grid.faces.size(); ++f)
        for (int k = 0; k < 3; ++k) edge_place[grid_.edge_of[f][k]] = {f, k};
    looked_ += look_up(edges, 0, pieces_[3], [&](std::size_t e, std::uint64_t* looked) {
        if (!near.empty() && !near[edge_place[e].first]) return;
        edges[e].position = (grid.positions[grid_.edges[e].first] + grid.positions[grid_.edges[e].second]) / 2;
        const std::uint32_t face = edge_place[e].first;
        edges[e].hit = on_source(edges[e].position, grid.normals[face], middles[face].hit.face, looked);
        edges[e].weight = 0;
    });
}

/// The farthest points are few, decide the largest error, and may have been stopped by a local minimum.
void Matches::look_again_far_off(std::span<const char> near) {
    constexpr double kFar = 0.3;  // of the largest distance
    const std::array lists{&points, &classes, &middles, &edges};
    std::size_t all = 0;
    for (const std::vector<Match>* list : lists) all += list->size();
    const std::size_t most = std::min<std::size_t>(5000, all / 64);  // more of them are far off where all are alike
    const double squared = farthest_squared();
    std::size_t count = 0;
    NearbySearch on_grid_surface(grid_.surface), on_source_surface(source_);
    for (std::size_t which = 0; which < lists.size(); ++which) {
        std::vector<Match>& list = *lists[which];
        for (std::size_t piece = 0; piece < pieces_[which].size(); ++piece) {
            if (!(pieces_[which][piece].farthest > kFar * kFar * squared)) continue;
            const std::size_t begin = piece * kPiece, end = std::min(list.size(), begin + kPiece);
            for (std::size_t k = begin; k < end; ++k) {
                Match& m = list[k];
                const bool on_grid = &list == &points;
                if (m.hit.squared > kFar * kFar * squared && ++count <= most && (on_grid || source_index_ == nullptr) &&
                    (near.empty() || (on_grid ? near[m.hit.face] : &list == &middles && near[k])))
                    m.hit = (on_grid ? on_grid_surface : on_source_surface).from(m.position, m.hit.face);
            }
            pieces_[which][piece] = measured(list, begin, end, counted(which));
        }
    }
}

void Matches::settle_farthest(const ClosestPointIndex& source_index) {
    constexpr double kFar = 0.5;  // of the largest distance, which may fall below it on the way
    const LinkedSurface& grid = grid_.surface;
    const std::array lists{&points, &classes, &middles, &edges};
    const double limit = kFar * kFar * farthest_squared();
    // Few points are far off, and only faces within reach of them can be nearer.
    const std::vector<std::uint32_t> number = faces_in_reach(grid, points, limit);
    std::vector<Face> in_reach;
    in_reach.reserve(number.size());
    for (const std::uint32_t f : number) in_reach.push_back(grid.faces[f]);
    const ClosestPointIndex grid_index(grid.positions, in_reach);
    for (std::size_t which = 0; which < lists.size(); ++which) {
        std::vector<Match>& list = *lists[which];
        const bool on_grid = which == 0;
        const ClosestPointIndex& index = on_grid ? grid_index : source_index;
        in_pieces(list.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
            if (!(pieces_[which][piece].farthest > limit)) return;
            for (std::size_t k = begin; k < end; ++k) {
                Match& m = list[k];
                if (m.hit.squared > limit) {
                    ClosestPoint hit = index.query(m.position, on_grid ? kNone : m.hit.face);
                    if (on_grid && hit.face != kNone) hit.face = number[hit.face];
                    if (const double squared = hit.distance * hit.distance; squared < m.hit.squared) {
                        const LinkedSurface& there = on_grid ? grid : source_;
                        if (on_grid || dot(there.normals[hit.face], there.normals[m.hit.face]) > 0)
                            m.hit = {hit.face, squared, {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]}};
                        m.hit.squared = squared;
                    }
                }
            }
            pieces_[which][piece] = measured(list, begin, end, counted(which));
        });
    }
    weigh_and_measure();
}

double Matches::farthest_squared() const {
    double out = 0;
    for (const std::vector<PieceOfMatches>& list : pieces_)
        for (const PieceOfMatches& piece : list) out = std::max(out, piece.farthest);
    return out;
}

std::vector<std::uint32_t> Matches::faces_beyond(double distance) const {
    const double limit = distance * distance;
    std::vector<std::uint32_t> out;
    if (!(farthest_squared() > limit)) return out;
    for (const Match& m : points)
        if (m.hit.squared > limit) out.push_back(m.hit.face);
    for (std::uint32_t f = 0; f < middles.size(); ++f) {
        bool beyond = middles[f].hit.squared > limit;
        for (const std::uint32_t c : grid_.surface.faces[f]) beyond = beyond || classes[c].hit.squared > limit;
        if (beyond) out.push_back(f);
    }
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (edges[e].hit.squared > limit) out.push_back(edge_place[e].first);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

/// By area; a share of what the source's points have in all, none under a twentieth of the mean: a sample in a crowded
/// part of the grid, where no source point falls, is still held to the surface.
void Matches::weigh_and_measure() {
    const LinkedSurface& grid = grid_.surface;
    const double total =
        sum_in_pieces(middles.size(), [&](std::size_t f) { return middles[f].weight = face_area(grid.corners(f)); });
    for (Match& m : classes) m.weight = 0;
    for (std::size_t f = 0; f < grid.faces.size(); ++f)
        for (const std::uint32_t c : grid.faces[f]) classes[c].weight += hold_.corner_share / 3 * middles[f].weight;
    const double mean = total / static_cast<double>(classes.size() + middles.size());
    const double scale = total > 0 ? hold_.grid_share * static_cast<double>(area_points) / total : 0;
    const auto weigh = [&](Match& m, double share) {
        return m.weight = std::max(share * m.weight, 0.05 * mean) * scale;
    };
    const double weight =
        sum_in_pieces(classes.size(), [&](std::size_t c) { return weigh(classes[c], 1); }) +
        sum_in_pieces(middles.size(), [&](std::size_t f) { return weigh(middles[f], 1 - hold_.corner_share); });
    const auto weighed = [](const Match& m) { return m.weight * m.hit.squared; };
    const double backward = sum_in_pieces(classes.size(), [&](std::size_t c) { return weighed(classes[c]); }) +
                            sum_in_pieces(middles.size(), [&](std::size_t f) { return weighed(middles[f]); });
    double forward = 0;
    for (const PieceOfMatches& piece : pieces_[0]) forward += piece.sum;
    const double mean_forward = area_points > 0 ? forward / static_cast<double>(area_points) : 0;
    rms = std::sqrt(std::max(mean_forward, weight > 0 ? backward / weight : 0));
    largest = std::sqrt(farthest_squared());
}

}  // namespace dgm::bake
