// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/source_match.cpp
#include "geometry/layers/source_match.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/fit/welded_grid.h"
#include "geometry/spatial/closest_point.h"

namespace dgm::bake {
namespace {
/// The stored surface with its seams closed, to walk on: faces in the order of SampledChart::faces().
WeldedGrid weld_stored(const SampledChart& chart, std::span<const Vec3d> positions) {
    WeldedGrid grid(chart);
    for (std::size_t c = 0; c < grid.sample_of.size(); ++c) grid.surface.positions[c] = positions[grid.sample_of[c]];
    grid.surface.update_normals();
    return grid;
}

/// ClosestPointIndex::query() and query_facing() among some hundred faces around a start.
class FacingSearch {
 public:
    FacingSearch(const LinkedSurface& surface, double min_cosine)
        : surface_(surface), nearby_(surface), min_cosine_(min_cosine) {}

    /// The closest point whose face looks the same way, at most twice as far as the closest of all, plus `slack`; face
    /// is kNone where there is none.
    [[nodiscard]] SurfaceHit from(const Vec3d& p, const Vec3d& normal, std::uint32_t start, double slack) {
        double any = INFINITY;  // squared
        SurfaceHit same{kNone, INFINITY, {}};
        nearby_.visit(walk_to_closest(surface_, p, start).face, [&](std::uint32_t face) {
            SurfaceHit hit{face, 0, {}};
            hit.squared = closest_on_triangle(p, surface_.corners(face), hit.b);
            any = std::min(any, hit.squared);
            if (hit.squared < same.squared && dot(surface_.normals[face], normal) > min_cosine_) same = hit;
        });
        if (std::sqrt(same.squared) > 2 * std::sqrt(any) + slack) same.face = kNone;
        return same;
    }

 private:
    const LinkedSurface& surface_;
    NearbyFaces nearby_;
    double min_cosine_;
};
}  // namespace

Vec3d local_position(const LayerInput& in, const SurfaceSample& at) {
    Vec3d p = position_at(in.chart.disk->mesh, at);
    // source - offset, without forming a large source coordinate first
    for (int k = 0; k < 3; ++k) p[k] = (in.frame.centre[k] - in.stored.offset[k]) + in.frame.diagonal * p[k];
    return p;
}

Vec3d normal_of_face(const TriMesh& mesh, std::uint32_t face) {
    return unit_normal(mesh.corners(face));
}

Vec3d source_normal(const TriMesh& mesh, const SurfaceSample& at) {
    Vec3d own;
    if (!mesh.corner_normals.empty())
        for (int k = 0; k < 3; ++k) own += mesh.corner_normals[3 * at.face + k] * at.b[k];
    return length(own) > 0.1 ? normalized(own) : normal_of_face(mesh, at.face);
}

Vec2d grid_coordinates(const SampledChart& chart, const MatchedPoint& p) {
    Vec2d out;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t s = p.sample[k];
        const Vec2d at = s < chart.grid_count()
                             ? Vec2d{static_cast<double>(s / chart.n), static_cast<double>(s % chart.n)}
                             : Vec2d{chart.border_uv[s - chart.grid_count()].x * (chart.m - 1),
                                     chart.border_uv[s - chart.grid_count()].y * (chart.n - 1)};
        out = out + at * p.b[k];
    }
    return out;
}

namespace {

constexpr double kMinCosine = 0.3;

/// Points of the source spread by area, and the stored grid surface that they are matched with.
class Matching {
 public:
    Matching(const LayerInput& in, const StoredPositions& positions, std::vector<SurfaceSample> spread)
        : in_(in),
          positions_(positions.local),
          spread_(std::move(spread)),
          faces_(in.chart.faces()),
          grid_(weld_stored(in.chart, positions.local)),
          slack_(0.25 * in.frame.diagonal *
                 std::sqrt(surface_area(in.chart.disk->mesh) / static_cast<double>(in.chart.grid_count()))),
          points_(spread_.size()),
          open_(spread_.size(), 0) {}

    /// Samples move while they are fitted, but not far: a walk from where the map puts a point mostly ends close to it.
    void walk() {
        in_chunks([&](std::size_t k, const Vec3d& position, const Vec3d& normal, std::uint32_t& hint) {
            open_[k] = 1;
            const std::uint32_t start = start_of(k, hint);
            if (start == kNone) return;
            const SurfaceHit hit = walk_to_closest(grid_.surface, position, start);
            if (hit.squared > slack_ * slack_ || dot(grid_.surface.normals[hit.face], normal) <= kMinCosine) return;
            match(k, hint = hit.face, hit.b);
            open_[k] = 0;
        });
    }

    [[nodiscard]] std::size_t open_count() const {
        return static_cast<std::size_t>(std::count(open_.begin(), open_.end(), 1));
    }

    /// Matches open points with faces near the start of their walks.
    void search_nearby() {
        FacingSearch search(grid_.surface, kMinCosine);
        std::uint32_t hint = kNone;
        for (std::size_t k = 0; k < open_.size(); ++k) {
            if (open_[k] == 0) {
                hint = points_[k].face;
                continue;
            }
            const std::uint32_t start = start_of(k, hint);
            if (start == kNone) continue;
            const SurfaceHit hit = search.from(local_position(in_, spread_[k]),
                                               normal_of_face(in_.chart.disk->mesh, spread_[k].face), start, slack_);
            if (hit.face != kNone) match(k, hit.face, hit.b);
        }
    }

    /// Matches open points with all faces.
    void search_all() {
        const ClosestPointIndex index(positions_, faces_);
        in_chunks([&](std::size_t k, const Vec3d& position, const Vec3d& normal, std::uint32_t& hint) {
            if (open_[k] == 0) return;
            ClosestPoint hit = index.query(position, hint);
            hint = hit.face;
            if (hit.face != ClosestPointIndex::kNoFace && dot(index.unit_normal(hit.face), normal) <= kMinCosine) {
                const double limit = 2 * hit.distance + slack_;
                hit = index.query_facing(position, normal, kMinCosine, ClosestPointIndex::kNoFace, limit);
                if (hit.distance > limit) hit.face = ClosestPointIndex::kNoFace;
            }
            if (hit.face != ClosestPointIndex::kNoFace) match(k, hit.face, hit.barycentric);
        });
    }

    [[nodiscard]] std::vector<MatchedPoint> matched() && {
        std::erase_if(points_, [](const MatchedPoint& p) { return p.at.face == kNone; });
        return std::move(points_);
    }

 private:
    template <class Visit>
    void in_chunks(const Visit& visit) const {
        constexpr std::size_t kChunk = 1024;  // neighbours share a hint, and a face's normal
        const std::size_t count = spread_.size();
        tbb::parallel_for(std::size_t{0}, (count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
            std::uint32_t hint = kNone, last = kNone;
            Vec3d normal;
            for (std::size_t k = chunk * kChunk; k < std::min(count, (chunk + 1) * kChunk); ++k) {
                if (spread_[k].face != last) {
                    last = spread_[k].face;
                    normal = normal_of_face(in_.chart.disk->mesh, last);
                }
                visit(k, local_position(in_, spread_[k]), normal, hint);
            }
        });
    }

    template <class Weights>
    void match(std::size_t k, std::uint32_t face, const Weights& b) {
        points_[k] = {spread_[k], face, faces_[face], {b[0], b[1], b[2]}};
    }

    /// Beside the border of a free chart a walk starts where the last one ended.
    [[nodiscard]] std::uint32_t start_of(std::size_t k, std::uint32_t last) const {
        const std::uint32_t face = grid_.face_at(in_.chart, spread_[k]);
        return face != kNone ? face : last;
    }

    const LayerInput& in_;
    std::span<const Vec3d> positions_;
    std::vector<SurfaceSample> spread_;
    std::vector<Face> faces_;
    WeldedGrid grid_;
    double slack_;
    std::vector<MatchedPoint> points_;
    std::vector<char> open_;  // per point: not matched by its walk
};

}  // namespace

std::vector<MatchedPoint> match_source(const LayerInput& in, const StoredPositions& positions, std::size_t count) {
    constexpr std::size_t kMany = 100;  // one in so many is worth an index
    std::vector<SurfaceSample> spread = spread_by_area(in.chart.disk->mesh, count);
    if (spread.empty()) return {};
    Matching matching(in, positions, std::move(spread));
    matching.walk();
    if (matching.open_count() * kMany <= count)
        matching.search_nearby();
    else
        matching.search_all();
    return std::move(matching).matched();
}

}  // namespace dgm::bake
