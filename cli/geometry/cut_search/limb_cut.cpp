// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/limb_cut.cpp
#include "geometry/cut_search/limb_cut.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "geometry/cut/distance_queue.h"

namespace dgm::bake {
namespace {

using model::Vec3d;

/// Distances to a cut that grows path by path.
class FarthestPoints {
 public:
    explicit FarthestPoints(const CutGraph& cut)
        : graph_(cut.graph()), positions_(cut.mesh().positions), distance_(cut.distance_to_cut()) {}

    [[nodiscard]] std::uint32_t farthest() const {
        return static_cast<std::uint32_t>(std::max_element(distance_.begin(), distance_.end()) - distance_.begin());
    }
    [[nodiscard]] double distance(std::uint32_t v) const { return distance_[v]; }

    /// Half-edges of the shortest path from `v` to the cut, which it becomes a part of.
    std::vector<std::uint32_t> join(std::uint32_t v) {
        std::vector<std::uint32_t> path;
        DistanceQueue queue;
        for (Vec3d before; distance_[v] > 0;) {
            const VertexGraph::Arc* const next = way_on(v, before);
            distance_[v] = 0;
            queue.emplace(0.0, v);
            if (!next) break;
            before = positions_[next->to] - positions_[v];
            path.push_back(next->half_edge);
            v = next->to;
        }
        spread(graph_, queue, distance_);
        return path;
    }

 private:
    /// The arc by which the cut is nearest; of several, as regular meshes have them, the one that goes straight on.
    [[nodiscard]] const VertexGraph::Arc* way_on(std::uint32_t v, const Vec3d& before) const {
        constexpr double kSame = 1 + 1e-9;
        const VertexGraph::Arc* next = nullptr;
        double straightest = 0;
        for (std::uint32_t a = graph_.first[v]; a < graph_.first[v + 1]; ++a) {
            const VertexGraph::Arc& arc = graph_.arcs[a];
            if (!(distance_[arc.to] < distance_[v]) || distance_[arc.to] + arc.cost > kSame * distance_[v]) continue;
            const double straight = dot(before, positions_[arc.to] - positions_[v]) / arc.length;
            if (next && !(straight > straightest)) continue;
            next = &arc;
            straightest = straight;
        }
        return next;
    }

    const VertexGraph& graph_;
    std::span<const Vec3d> positions_;
    std::vector<double> distance_;
};

}  // namespace

std::optional<CutGraph> limb_cut(const TriMesh& component, std::size_t most, const model::Progress& progress) {
    constexpr double kLeastDrop = 2.5;  // of a disk without limbs the second point is half as far as the first
    CutGraph cut(component);
    cut.cut_to_disk();
    FarthestPoints points(cut);
    std::vector<std::vector<std::uint32_t>> paths;
    double drop = kLeastDrop, last = 0;
    std::size_t limbs = 0;
    for (std::size_t k = 0; k <= most; ++k) {
        progress.update("cut", static_cast<double>(k) / static_cast<double>(most + 1));
        const std::uint32_t tip = points.farthest();
        const double way = points.distance(tip);
        if (!(way > 0)) break;
        if (last > drop * way) {
            drop = last / way;
            limbs = k;
        }
        last = way;
        paths.push_back(points.join(tip));
    }
    if (limbs == 0) return std::nullopt;
    for (std::size_t k = 0; k < limbs; ++k)
        for (const std::uint32_t h : paths[k]) cut.mark(h, true);
    return cut;
}

std::optional<CutSearchResult> open_limbs(const TriMesh& component, std::uint32_t m, std::uint32_t n,
                                          const model::Progress& progress) {
    constexpr std::uint32_t kSamplesToLimb = 8;
    const std::optional<CutGraph> cut = limb_cut(component, 2 * (m + n - 2) / kSamplesToLimb, progress);
    if (!cut) return std::nullopt;
    CutSearchResult out;
    out.disk = cut->open();
    out.cut_length = cut->length();
    out.rotation = candidate_rotations(out.disk, m, n, 1).front();
    return out;
}

}  // namespace dgm::bake
