// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/trial_map.cpp
#include "geometry/cut_search/trial_map.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "geometry/chart/square_chart.h"
#include "geometry/parameterize/cell_rectangle.h"
#include "geometry/parameterize/damped_reweight.h"
#include "geometry/resample/rasterize.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

/// Squared distance of p to triangle abc [Ericson 2005, 5.1.5].
double squared_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const auto squared = [](const Vec3d& v) { return dot(v, v); };
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return squared(ap);
    const Vec3d bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return squared(bp);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return squared(ap - ab * (d1 / (d1 - d3)));
    const Vec3d cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return squared(cp);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return squared(ap - ac * (d2 / (d2 - d6)));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return squared(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    const double sum = va + vb + vc;
    if (!(sum > 0)) return std::min({squared(ap), squared(bp), squared(cp)});
    return squared(ap - ab * (vb / sum) - ac * (vc / sum));
}

class Prediction {
 public:
    Prediction(const TrialMap& map, std::vector<Vec3d> grid, std::uint32_t m, std::uint32_t n)
        : map_(map), grid_(std::move(grid)), m_(m), n_(n) {}

    [[nodiscard]] double rms() const {
        const TriMesh& mesh = map_.disk.mesh;
        double sum = 0, total = 0;
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            const Face& t = mesh.faces[f];
            const auto q = mesh.corners(f);
            const double area = face_area(q);
            const Vec2d centre = (map_.uv[t[0]] + map_.uv[t[1]] + map_.uv[t[2]]) * (1.0 / 3);
            // Degree-2 rule of the triangle: its centre weighs 9/12, each corner 1/12.
            sum += area * (0.75 * off((q[0] + q[1] + q[2]) / 3, centre));
            for (int k = 0; k < 3; ++k) sum += area / 12 * off(q[static_cast<std::size_t>(k)], map_.uv[t[k]]);
            total += area;
        }
        return total > 0 ? std::sqrt(sum / total) : 0;
    }

 private:
    /// Squared distance to the quad at (u, v), split along its shorter diagonal.
    [[nodiscard]] double off(const Vec3d& p, Vec2d at) const {
        const auto cell = [](double x, std::uint32_t count) {
            return static_cast<std::size_t>(std::clamp(x * (count - 1), 0.0, count - 2.0));
        };
        const std::size_t s = cell(at.x, m_) * n_ + cell(at.y, n_);
        const Vec3d &a = grid_[s], &b = grid_[s + n_], &c = grid_[s + n_ + 1], &d = grid_[s + 1];
        if (dot(b - d, b - d) < dot(a - c, a - c))
            return std::min(squared_distance(p, a, b, d), squared_distance(p, b, c, d));
        return std::min(squared_distance(p, a, b, c), squared_distance(p, a, c, d));
    }

    const TrialMap& map_;
    std::vector<Vec3d> grid_;
    std::uint32_t m_, n_;
};

}  // namespace

TrialMap make_trial_map(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                        const MultilevelOptions& options, const model::Progress& progress, BorderShares shares) {
    TrialMap map;
    const SquareBorder border = lay_square_border(disk, m, n, rotation, shares);
    const DiskView view{disk.mesh.positions, disk.mesh.faces, border.vertices, border.uv, (m - 1.0) / (n - 1.0)};
    const CellRectangle cells(view);
    std::optional<std::vector<Vec2d>> uv = multilevel_stretch_map(cells.view(), options, progress);
    map.uv = cells.to_square(uv ? std::move(*uv) : damped_stretch_map(cells.view(), 12, progress));
    check_map(disk, map.uv, "stretch");
    const SampleGrid grid = rasterize(disk.mesh.faces, map.uv, m, n);
    if (grid.missing > 0)
        throw model::Error(model::codes::kMapInvalid,
                           "stretch: " + std::to_string(grid.missing) + " grid points are covered by no face");
    std::vector<Vec3d> positions(grid.samples.size());
    for (std::size_t s = 0; s < positions.size(); ++s) positions[s] = position_at(disk.mesh, grid.samples[s]);
    for (const BorderSample& s : border.samples) positions[s.index] = position_at(disk.mesh, s.at);
    map.disk = std::move(disk);
    map.rms = Prediction(map, std::move(positions), m, n).rms();
    return map;
}

}  // namespace dgm::bake
