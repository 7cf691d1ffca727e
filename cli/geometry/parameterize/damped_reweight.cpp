// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/damped_reweight.cpp
#include "geometry/parameterize/damped_reweight.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/mesh/half_edges.h"
#include "math/portable.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

constexpr double kLargestStretch = 1e12;  // squared; stands for faces turned over or without area
constexpr double kEnoughGain = 0.995;     // a step that lowers the energy by less is the last

/// Squared L2 stretch of each vertex, by area over its faces; and the energy, the area sum of it over the faces.
class Stretch {
 public:
    explicit Stretch(const DiskView& disk) : disk_(disk), area_(disk.positions.size(), 0.0) {
        for (const Face& f : disk.faces) {
            const std::array<Vec3d, 3> q{disk.positions[f[0]], disk.positions[f[1]], disk.positions[f[2]]};
            const auto squared = [](const Vec3d& e) { return dot(e, e); };
            faces_.push_back({face_area(q), squared(q[2] - q[1]), squared(q[0] - q[2]), squared(q[1] - q[0])});
            for (std::uint32_t v : f) area_[v] += faces_.back()[0];
            total_area_ += faces_.back()[0];
        }
    }

    double measure(std::span<const Vec2d> uv) {
        at_.assign(area_.size(), 0.0);
        double total = 0;
        for (std::size_t k = 0; k < faces_.size(); ++k) {
            const Face& f = disk_.faces[k];
            const auto& [area, l0, l1, l2] = faces_[k];
            const Vec2d d0 = uv[f[2]] - uv[f[1]], d1 = uv[f[0]] - uv[f[2]], d2 = uv[f[1]] - uv[f[0]];
            const double twice = cross(d2, uv[f[2]] - uv[f[0]]);
            // Edge form of (|S_s|^2 + |S_t|^2) / 2 [Sander 2001].
            double s = kLargestStretch;
            if (twice > 0)
                s = std::min(s, -(l0 * dot(d1, d2) + l1 * dot(d2, d0) + l2 * dot(d0, d1)) / (2 * twice * twice));
            for (std::uint32_t v : f) at_[v] += area * s;
            total += area * s;
        }
        const double mean = total / total_area_;
        for (std::size_t v = 0; v < at_.size(); ++v)
            at_[v] = area_[v] > 0 ? std::clamp(std::sqrt(at_[v] / area_[v] / mean), 1e-3, 1e3) : 1.0;
        return total;
    }

    /// Root of the last measurement, over its mean.
    [[nodiscard]] const std::vector<double>& relative() const { return at_; }

 private:
    const DiskView& disk_;
    std::vector<std::array<double, 4>> faces_;  // area, squared lengths opposite each corner
    std::vector<double> area_, at_;
    double total_area_ = 0;
};

}  // namespace

std::vector<Vec2d> damped_stretch_map(const DiskView& disk, int solves, const model::Progress& progress) {
    ConvexMapSolver solver(disk.positions.size(), disk.faces, disk.border);
    const auto edges = solver.edges();
    std::vector<double> weights = positive_cotangent_weights(disk.positions, disk.faces, edges);
    std::vector<Vec2d> uv;
    try {
        uv = solver.solve(weights, disk.border_uv);
    } catch (const model::Error&) {  // weights over many powers of ten; equal ones always have a solution
        weights.assign(weights.size(), 1.0);
        uv = solver.solve(weights, disk.border_uv);
    }
    Stretch stretch(disk);
    double energy = stretch.measure(uv), exponent = 1;
    std::vector<double> relative = stretch.relative();
    for (int k = 0; k < solves && exponent > 0.1; ++k) {
        progress.update("parameterize", static_cast<double>(k) / solves);
        std::vector<double> trial = weights, power(relative.size());
        for (std::size_t v = 0; v < power.size(); ++v) power[v] = math::pow(relative[v], -exponent);
        for (std::size_t e = 0; e < edges.size(); ++e)
            trial[e] = std::clamp(trial[e] * power[edges[e].first] * power[edges[e].second], 1e-12, 1e12);
        std::vector<Vec2d> moved;
        try {
            moved = solver.solve(trial, disk.border_uv);
        } catch (const model::Error&) {
            exponent *= 0.5;
            continue;
        }
        const double now = stretch.measure(moved);
        if (!(now < energy)) {
            exponent *= 0.5;
            continue;
        }
        const bool last = now > kEnoughGain * energy;
        energy = now;
        uv = std::move(moved);
        weights = std::move(trial);
        relative = stretch.relative();
        if (last) break;
    }
    return uv;
}

}  // namespace dgm::bake
