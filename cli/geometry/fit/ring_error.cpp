// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/ring_error.cpp
#include "geometry/fit/ring_error.h"

#include <algorithm>
#include <cmath>

#include "geometry/mesh/infinity.h"
#include "geometry/mesh/triangle.h"

namespace dgm::bake {

void RingError::set_split(std::uint32_t c, const Vec3d& position, std::size_t k, unsigned diagonal, double thickness) {
    Split& split = splits_[k][diagonal];
    const CellFaces of = around_.cells.faces(cells_[k], diagonal);
    split.count = of.count;
    split.error = -1;
    split.thickness = 1;
    for (int f = 0; f < of.count; ++f) {
        std::array<Vec3d, 3>& q = split.corners[f];
        for (int v = 0; v < 3; ++v) q[v] = of.faces[f][v] == c ? position : around_.positions[of.faces[f][v]];
        split.normals[f] = cross(q[1] - q[0], q[2] - q[0]);
        const double longest = longest_edge_squared(q);
        split.thickness = std::min(split.thickness, longest > 0 ? length(split.normals[f]) / longest : 0);
    }
    if (!(split.thickness >= thickness)) split.count = 0;
    for (int f = 0; f < split.count; ++f) split.prepared[f] = PreparedTriangle(split.corners[f]);
}

/// Looks up the middles of a split's faces.
/// @return  false if the split is not possible, or one of them is more tilted than that
bool RingError::look_back(std::size_t k, unsigned diagonal, double upright) {
    Split& split = splits_[k][diagonal];
    if (split.count == 0) return false;
    if (split.error < 0) {
        const std::uint32_t start = around_.matches.middles[around_.cells.first_face(cells_[k])].hit.face;
        split.error = 0;
        split.upright = 1;
        for (int f = 0; f < split.count; ++f) {
            const auto& q = split.corners[f];
            const SurfaceHit hit = walk_to_closest(around_.source, (q[0] + q[1] + q[2]) / 3, start, &looked_);
            const double twice = length(split.normals[f]);
            const double cosine = twice > 0 ? dot(split.normals[f], around_.source.normals[hit.face]) / twice : -1;
            split.upright = std::min(split.upright, cosine);
            split.error += around_.per_area * hit.squared * twice / 2;
        }
    }
    return split.upright >= upright;
}

void RingError::set_box(std::size_t k) {
    auto& [low, high] = boxes_[k];
    low = {kInfinity, kInfinity, kInfinity};
    high = -low;
    for (const Split& split : splits_[k])
        for (int f = 0; f < split.count; ++f)
            for (const Vec3d& p : split.corners[f])
                for (int axis = 0; axis < 3; ++axis) {
                    low[axis] = std::min(low[axis], p[axis]);
                    high[axis] = std::max(high[axis], p[axis]);
                }
}

/// Squared distance that a point is at least away from a cell.
double RingError::farther_than(std::size_t k, const Vec3d& p) const {
    const auto& [low, high] = boxes_[k];
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double off = std::max({low[axis] - p[axis], p[axis] - high[axis], 0.0});
        sum += off * off;
    }
    return sum;
}

/// Distances of the points over the ring to each of its cells, split both ways. Cells that are not the nearest to a
/// point, however the others are split, may be infinitely far.
/// @return  false if even the nearest add up to the limit
bool RingError::gather(double limit) {
    squared_.clear();
    weights_.clear();
    for (std::size_t k = 0; k < cells_.size(); ++k) set_box(k);
    double least_sum = 0;
    for (std::size_t own = 0; own < cells_.size(); ++own)
        for (const std::uint32_t point : around_.points[cells_[own]]) {
            const Match& m = around_.matches.points[point];
            const std::size_t row = squared_.size();
            squared_.resize(row + 2 * cells_.size(), kInfinity);
            double least = kInfinity, sure = kInfinity;
            const auto look = [&](std::size_t k) {
                double most = 0;
                for (unsigned d = 0; d < 2; ++d) {
                    const Split& split = splits_[k][d];
                    double& here = squared_[row + 2 * k + d];
                    for (int f = 0; f < split.count; ++f)
                        here = std::min(here, split.prepared[f].squared_distance(m.position));
                    least = std::min(least, here);
                    if (split.count > 0) most = std::max(most, here);
                }
                sure = std::min(sure, most);
            };
            look(own);
            for (std::size_t k = 0; k < cells_.size(); ++k)
                if (k != own && farther_than(k, m.position) < sure) look(k);
            weights_.push_back(m.weight);
            least_sum += m.weight * least;
            if (!(least_sum < limit)) return false;
        }
    return true;
}

double RingError::total(const RingPlace& place) const {
    double sum = 0;
    for (std::size_t k = 0; k < cells_.size(); ++k) sum += splits_[k][place.diagonals[k]].error;
    const std::size_t row = 2 * cells_.size();
    for (std::size_t p = 0; p < weights_.size(); ++p) {
        double least = kInfinity;
        for (std::size_t k = 0; k < cells_.size(); ++k)
            least = std::min(least, squared_[p * row + 2 * k + place.diagonals[k]]);
        sum += weights_[p] * least;
    }
    return sum;
}

RingPlace RingError::present(std::uint32_t c, RingBounds& bounds) {
    cells_ = around_.cells.around(c);
    RingPlace out{around_.positions[c], 0, {}};
    for (std::size_t k = 0; k < cells_.size(); ++k) {
        const unsigned d = around_.cells.diagonal(cells_[k]);
        out.diagonals[k] = static_cast<std::uint8_t>(d);
        set_split(c, out.position, k, d, -1);
        splits_[k][1 - d].count = 0;
        look_back(k, d, -1);
        bounds.upright = std::min(bounds.upright, splits_[k][d].upright);
        bounds.thickness = std::min(bounds.thickness, splits_[k][d].thickness);
    }
    (void)gather(kInfinity);
    out.error = total(out);
    return out;
}

bool RingError::choose(const RingBounds& bounds, double limit, RingPlace& place) {
    constexpr int kPasses = 2;
    for (std::size_t k = 0; k < cells_.size(); ++k) {
        std::uint8_t& d = place.diagonals[k];
        if (!look_back(k, d, bounds.upright)) d ^= 1;
        if (!look_back(k, d, bounds.upright)) return false;
    }
    place.error = total(place);
    for (int pass = 0; pass < kPasses; ++pass) {
        bool any = false;
        for (std::size_t k = 0; k < cells_.size(); ++k) {
            if (!look_back(k, 1U - place.diagonals[k], bounds.upright)) continue;
            place.diagonals[k] ^= 1;
            const double now = total(place);
            any = any || now < place.error;
            if (now < place.error)
                place.error = now;
            else
                place.diagonals[k] ^= 1;
        }
        if (!any) break;
    }
    return place.error < limit;
}

bool RingError::measure(std::uint32_t c, const RingBounds& bounds, double limit, RingPlace& place) {
    cells_ = around_.cells.around(c);
    for (std::size_t k = 0; k < cells_.size(); ++k) {
        const unsigned old = around_.cells.diagonal(cells_[k]);
        for (unsigned d = 0; d < 2; ++d) {
            set_split(c, place.position, k, d, bounds.thickness);
            if (d != old && !around_.may_flip[cells_[k]]) splits_[k][d].count = 0;
        }
        if (splits_[k][0].count == 0 && splits_[k][1].count == 0) return false;
        place.diagonals[k] = static_cast<std::uint8_t>(old);
    }
    return gather(limit) && choose(bounds, limit, place);
}

}  // namespace dgm::bake
