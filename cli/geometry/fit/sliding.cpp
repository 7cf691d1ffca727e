// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/sliding.cpp
#include "geometry/fit/sliding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "geometry/fit/pieces.h"
#include "geometry/mesh/infinity.h"

namespace dgm::bake {
namespace {

// Chosen by measurement on organs and busts: how far a sample may slide, and how thin and how tilted a face may become
// on the way.
constexpr double kMaxSlide = 0.4;     // tangential step a round, of the shortest edge at the sample
constexpr double kThinnest = 0.02;    // twice the area over the longest edge squared, or its earlier value
constexpr double kShrink = 0.1;       // area after a round over the area before
constexpr double kUpright = 0.3;      // cosine to the source below, or its earlier value ...
constexpr double kUprightLoss = 0.1;  // ... less this a round, while it is positive
constexpr double kCornerUpright = 0.6, kCornerThinnest = 0.1;  // of faces whose sample goes to a corner of the border

}  // namespace

Sliding::Step Sliding::clamped(std::span<const Vec3d> step, std::vector<double> ways) const {
    const LinkedSurface& grid = grid_.surface;
    const std::size_t count = grid.positions.size();
    Step out;
    std::vector<char> moves(count, 0);
    for (std::size_t c = 0; c < count; ++c) moves[c] = step[c] != Vec3d{} || (c < ways.size() && ways[c] != 0);
    for (std::uint32_t f = 0; f < grid.faces.size(); ++f)
        if (const Face& v = grid.faces[f]; moves[v[0]] || moves[v[1]] || moves[v[2]]) out.faces.push_back(f);
    std::vector<Vec3d> normal(count, Vec3d{});
    for (const std::uint32_t f : out.faces) {
        const auto q = grid.corners(f);
        const Vec3d n = cross(q[1] - q[0], q[2] - q[0]);
        for (const std::uint32_t c : grid.faces[f]) grid_.add_facing(normal[c], n, c);
    }
    std::vector<double> edge(count, kInfinity);  // the shortest, squared
    for (const auto& [a, b] : grid_.edges) {
        if (!moves[a] && !moves[b]) continue;
        const Vec3d along = grid.positions[b] - grid.positions[a];
        const double squared = dot(along, along);
        edge[a] = std::min(edge[a], squared);
        edge[b] = std::min(edge[b], squared);
    }
    out.along.resize(count);
    out.across.resize(count);
    for (std::size_t c = 0; c < count; ++c) {
        if (!moves[c] || fixed_[c]) continue;
        const Vec3d n = normalized(normal[c], Vec3d{});
        out.across[c] = n * dot(step[c], n);
        out.along[c] = step[c] - out.across[c];
        const double l = length(out.along[c]), limit = kMaxSlide * std::sqrt(edge[c]);
        if (l > limit) out.along[c] *= limit / l;
    }
    out.ways = std::move(ways);
    for (std::uint32_t c = 0; c < out.ways.size(); ++c) {
        double& way = out.ways[c];
        if (rails_.freedom()[c] != Freedom::kSlides) way = 0;
        if (way != 0) way = std::clamp(way, -rails_.reach(c), rails_.reach(c));
    }
    return out;
}

void Sliding::take(std::span<const Vec3d> whole_step, std::vector<double> whole_ways) {
    constexpr int kPasses = 12, kWholePass = 5, kStopPass = 9;
    const Step step = clamped(whole_step, std::move(whole_ways));
    LinkedSurface& grid = grid_.surface;
    const std::size_t count = grid.positions.size();
    std::vector<double> slide(count, 1.0), whole(count, 1.0);
    const std::vector<Vec3d> start = grid.positions;
    const auto way = [&](std::uint32_t c) { return step.ways[c] * slide[c] * whole[c]; };
    const auto put = [&](std::uint32_t c) {
        if (!step.ways.empty() && way(c) != 0)
            grid.positions[c] = rails_.place_after(c, way(c));
        else
            grid.positions[c] = start[c] + (step.across[c] + step.along[c] * slide[c]) * whole[c];
    };
    for (std::uint32_t c = 0; c < count; ++c) put(c);
    std::vector<char> bad(count, 1), changed(count), refused(step.faces.size());
    for (int pass = 0; pass < kPasses; ++pass) {
        changed.swap(bad);
        std::fill(bad.begin(), bad.end(), 0);
        each_in_pieces(step.faces.size(), [&](std::size_t k) {
            const std::uint32_t f = step.faces[k];
            const Face& v = grid.faces[f];
            refused[k] = (changed[v[0]] || changed[v[1]] || changed[v[2]]) &&
                         !allows(f, {start[v[0]], start[v[1]], start[v[2]]}, grid.corners(f));
        });
        bool any = false;
        for (std::size_t k = 0; k < refused.size(); ++k) {
            if (!refused[k]) continue;
            any = true;
            for (const std::uint32_t c : grid.faces[step.faces[k]]) bad[c] = 1;
        }
        if (!any) break;
        for (std::uint32_t c = 0; c < count; ++c) {
            if (!bad[c]) continue;
            slide[c] *= 0.5;
            if (pass >= kWholePass) whole[c] *= 0.25;
            if (pass >= kStopPass) whole[c] = 0;
            put(c);
        }
    }
    std::vector<std::pair<std::uint32_t, double>> gone;
    for (std::uint32_t c = 0; c < step.ways.size(); ++c)
        if (way(c) != 0) gone.emplace_back(c, way(c));
    if (!gone.empty()) rails_.slide(gone);
    each_in_pieces(step.faces.size(), [&](std::size_t k) { grid.update_normal(step.faces[k]); });
}

bool Sliding::allows(std::uint32_t f, const std::array<Vec3d, 3>& was, const std::array<Vec3d, 3>& now) const {
    const Vec3d n0 = cross(was[1] - was[0], was[2] - was[0]), n1 = cross(now[1] - now[0], now[2] - now[0]);
    const double before = length(n0), after = length(n1);
    if (!(after > kShrink * before)) return false;
    const double thin = after / longest_edge_squared(now);
    if (thin < kThinnest && thin < before / longest_edge_squared(was)) return false;
    Vec3d below = upward_[matches_.middles[f].hit.face];
    if (dot(n1, below) >= kUpright * after) return true;
    // Over a fold the middle's closest wall is a matter of chance; the walls under the corners are not.
    for (const std::uint32_t c : grid_.surface.faces[f]) below += upward_[matches_.classes[c].hit.face];
    below = normalized(below, Vec3d{});
    const double start = before > 0 ? dot(n0, below) / before : 0;
    return dot(n1, below) >= std::min({kUpright, start, std::max(0.0, start - kUprightLoss)}) * after;
}

bool Sliding::occupy_corners() {
    if (rails_.empty()) return false;
    LinkedSurface& grid = grid_.surface;
    const std::vector<double> ways = rails_.ways_to_corners();
    const WeldedGrid::Rings rings = grid_.rings();
    // Quality of a face: its cosine to the source below, if it is not thin.
    const auto worst = [&](std::uint32_t c) {
        double least = 1;
        for (std::uint32_t k = rings.first[c]; k < rings.first[c + 1]; ++k) {
            const std::uint32_t f = rings.faces[k];
            const auto q = grid.corners(f);
            const Vec3d n = cross(q[1] - q[0], q[2] - q[0]);
            const double l = length(n);
            if (!(l > kCornerThinnest * longest_edge_squared(q))) return -1.0;
            least = std::min(least, dot(n, upward_[matches_.middles[f].hit.face]) / l);
        }
        return least;
    };
    std::vector<std::pair<std::uint32_t, double>> gone;
    for (std::uint32_t c = 0; c < ways.size(); ++c) {
        if (ways[c] == 0) continue;
        const Vec3d old = grid.positions[c];
        const double before = worst(c);
        grid.positions[c] = rails_.place_after(c, ways[c]);
        if (worst(c) >= std::min(kCornerUpright, before))
            gone.emplace_back(c, ways[c]);
        else
            grid.positions[c] = old;
    }
    if (gone.empty()) return false;
    rails_.slide(gone);
    grid.update_normals();
    return true;
}

}  // namespace dgm::bake
