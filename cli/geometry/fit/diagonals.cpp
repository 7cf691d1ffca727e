// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/diagonals.cpp
#include "geometry/fit/diagonals.h"

#include <tbb/parallel_for.h>

#include <dgm/grid.h>
#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>

#include "geometry/fit/inverted_faces.h"
#include "geometry/mesh/triangle.h"

namespace dgm::bake {
namespace {

constexpr double kMiddleWeight = 2;  // of a diagonal's middle, in source points

/// Per face of a quad, the quad; strip faces come after them.
std::vector<std::uint32_t> quads_of_faces(const WeldedGrid& grid) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t q = 0; q < grid.face_of_quad.size(); ++q)
        if (grid.face_of_quad[q] != kNone) out.insert(out.end(), 2, q);
    return out;
}

/// Splits quads the other way where the welded surface has no such edge yet: beside a seam that folds back two quads
/// may ask for the same one.
class NewEdges {
 public:
    /// Both must outlive the object; the grid is linked as the chart was split.
    NewEdges(SampledChart& chart, const WeldedGrid& grid) : chart_(chart), grid_(grid) {}

    /// @return  false if the quad has to stay as it is
    bool split_otherwise(std::uint32_t quad) {
        const std::uint32_t n = chart_.n, a = quad / (n - 1) * n + quad % (n - 1), b = a + n;
        const std::uint8_t old = chart_.diagonals[quad];
        const std::uint32_t from = grid_.class_of[old == 0 ? b : a], to = grid_.class_of[old == 0 ? a + 1 : b + 1];
        const std::pair edge(std::min(from, to), std::max(from, to));
        if (from == to || std::binary_search(grid_.edges.begin(), grid_.edges.end(), edge)) return false;
        if (!fresh_.insert(edge).second) return false;
        chart_.diagonals[quad] = !old;
        return true;
    }

 private:
    SampledChart& chart_;
    const WeldedGrid& grid_;
    std::set<std::pair<std::uint32_t, std::uint32_t>> fresh_;
};

/// The points over each quad, in the order of the matches.
class PointsOfQuads {
 public:
    PointsOfQuads(const WeldedGrid& grid, const Matches& matches) : first_(grid.face_of_quad.size() + 2, 0) {
        const std::vector<std::uint32_t> quad_of_face = quads_of_faces(grid);
        const auto each = [&](const auto& body) {
            for (std::uint32_t k = 0; k < matches.points.size(); ++k)
                if (const std::uint32_t face = matches.points[k].hit.face; face < quad_of_face.size())
                    body(quad_of_face[face], k);
        };
        each([&](std::uint32_t quad, std::uint32_t) { ++first_[quad + 2]; });
        for (std::size_t q = 2; q < first_.size(); ++q) first_[q] += first_[q - 1];
        points_.resize(first_.back());
        each([&](std::uint32_t quad, std::uint32_t k) { points_[first_[quad + 1]++] = k; });
    }

    [[nodiscard]] std::span<const std::uint32_t> of(std::size_t quad) const {
        return std::span(points_).subspan(first_[quad], first_[quad + 1] - first_[quad]);
    }

 private:
    std::vector<std::uint32_t> first_, points_;
};

/// True if fewer of a quad's triangles are inverted by this diagonal than by the other.
bool turns_less(const SampledChart& chart, const ClosestPointIndex& source, std::uint32_t i, std::uint32_t j,
                unsigned diagonal) {
    TriMesh both;
    both.positions.reserve(12);
    for (const unsigned d : {diagonal, 1 - diagonal})
        for (const Face& t : quad_triangles(i, j, chart.n, d)) {
            const auto first = static_cast<std::uint32_t>(both.positions.size());
            for (const std::uint32_t s : t) both.positions.push_back(chart.positions[s]);
            both.faces.push_back({first, first + 1, first + 2});
        }
    std::array<char, 4> bad{};
    for (const std::uint32_t f : find_turned_faces(source, both, kSafeTie, kSafeCosine)) bad[f] = 1;
    for (std::uint32_t f = 0; f < bad.size(); ++f) bad[f] |= is_flat(both.corners(f));
    return bad[0] + bad[1] < bad[2] + bad[3];
}

}  // namespace

std::vector<char> fit_diagonals(SampledChart& chart, const WeldedGrid& grid, const Matches& matches,
                                const LinkedSurface& source) {
    const std::uint32_t m = chart.m, n = chart.n;
    grid.write_positions(chart);
    const PointsOfQuads points(grid, matches);
    const auto triangle = [&](const Face& t) {
        return PreparedTriangle({chart.positions[t[0]], chart.positions[t[1]], chart.positions[t[2]]});
    };
    std::vector<char> wanted(grid.face_of_quad.size(), 0);
    tbb::parallel_for(std::uint32_t{0}, m - 1, [&](std::uint32_t i) {
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::size_t quad = std::size_t{i} * (n - 1) + j, a = std::size_t{i} * n + j;
            const std::uint32_t face = grid.face_of_quad[quad];
            if (face == kNone) continue;
            const std::uint8_t old = chart.diagonals[quad];
            const bool old_bad = splits_badly(chart, i, j, old), other_bad = splits_badly(chart, i, j, !old);
            wanted[quad] = old_bad && !other_bad;
            if (old_bad != other_bad || other_bad) continue;
            // The other split is looked at as far as it may gain.
            double before = 0, after = 0;
            for (const std::uint32_t k : points.of(quad)) before += matches.points[k].hit.squared;
            const std::uint32_t start = matches.middles[face].hit.face;
            const auto off = [&](std::size_t from, std::size_t to) {
                const Vec3d middle = (chart.positions[from] + chart.positions[to]) * 0.5;
                return kMiddleWeight * walk_to_closest(source, middle, start).squared;
            };
            const auto middle = [&](unsigned diagonal) {
                return diagonal == 0 ? off(a, a + n + 1) : off(a + n, a + 1);
            };
            before += middle(old);
            const auto split = quad_triangles(i, j, n, !old);
            const std::array other{triangle(split[0]), triangle(split[1])};
            for (const std::uint32_t k : points.of(quad)) {
                const Vec3d& p = matches.points[k].position;
                after += std::min(other[0].squared_distance(p), other[1].squared_distance(p));
                if (!(after < before)) break;
            }
            wanted[quad] = after < before && after + middle(!old) < before;
        }
    });
    std::vector<char> changed(grid.surface.faces.size(), 0);
    NewEdges edges(chart, grid);
    for (std::uint32_t quad = 0; quad < wanted.size(); ++quad) {
        if (!wanted[quad] || !edges.split_otherwise(quad)) continue;
        const std::uint32_t face = grid.face_of_quad[quad];
        changed[face] = changed[face + 1] = 1;
    }
    return changed;
}

bool flip_diagonals(SampledChart& chart, const WeldedGrid& grid, std::span<const std::uint32_t> faces,
                    const ClosestPointIndex* source) {
    grid.write_positions(chart);
    const std::vector<std::uint32_t> quad_of_face = quads_of_faces(grid);
    NewEdges edges(chart, grid);
    bool any = false;
    for (const std::uint32_t f : faces) {
        if (f >= quad_of_face.size()) continue;
        const std::uint32_t quad = quad_of_face[f], i = quad / (chart.n - 1), j = quad % (chart.n - 1);
        const std::uint8_t old = chart.diagonals[quad];
        const bool better = source != nullptr ? turns_less(chart, *source, i, j, !old)
                                              : splits_badly(chart, i, j, old) && !splits_badly(chart, i, j, !old);
        if (better && edges.split_otherwise(quad)) any = true;
    }
    return any;
}

}  // namespace dgm::bake
