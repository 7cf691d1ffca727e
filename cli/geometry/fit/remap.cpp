// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/remap.cpp
#include "geometry/fit/remap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include "geometry/fit/pieces.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/triangle.h"
#include "geometry/parameterize/cell_rectangle.h"
#include "geometry/parameterize/rest_shapes.h"
#include "geometry/parameterize/slim.h"
#include "geometry/resample/rasterize.h"
#include "geometry/spatial/closest_point.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr std::size_t kPointsPerSample = 8;
constexpr double kNeighbours = 0.5;  // weight of a cell beside another, in each direction
constexpr double kWorst = 0.05;      // of the cells
constexpr double kRounding = 1e-12;  // normalised units

/// How strongly the error weighs, and the descent after it. Of three to six exponents and as many weights of the term
/// against shear, tried on eleven meshes, these gained most; a wrong one still gained half.
struct Strength {
    double power, epsilon;
};
constexpr Strength kLevelledStrength{0.4, 1}, kOwnStrength{0.6, 0.1};
constexpr double kLeastWeight = 0.2, kMostWeight = 30;                 // of one step
constexpr std::size_t kSteps = 8, kStepsOfDense = 4, kDense = 25'000;  // of the descent; the latter from so many faces

/// The cell of the grid that holds each face of a chart's surface: its quad, or the one below the middle of a triangle
/// of the strip.
std::vector<std::size_t> cells_of_faces(const SampledChart& chart) {
    std::vector<std::size_t> out;
    for (std::uint32_t i = 0; i + 1 < chart.m; ++i)
        for (std::uint32_t j = 0; j + 1 < chart.n; ++j)
            if (chart.has_quad(i, j)) out.insert(out.end(), 2, std::size_t{i} * (chart.n - 1) + j);
    const double rows = chart.m - 1.0, cols = chart.n - 1.0;
    const auto in_cells = [&](std::uint32_t sample) -> Vec2d {
        if (sample < chart.grid_count())
            return {static_cast<double>(sample / chart.n), static_cast<double>(sample % chart.n)};
        const Vec2d& uv = chart.border_uv[sample - chart.grid_count()];
        return {uv.x * rows, uv.y * cols};
    };
    for (const Face& f : chart.strip) {
        const Vec2d middle = (in_cells(f[0]) + in_cells(f[1]) + in_cells(f[2])) * (1.0 / 3);
        const auto i = static_cast<std::size_t>(std::clamp(middle.x, 0.0, rows - 1));
        const auto j = static_cast<std::size_t>(std::clamp(middle.y, 0.0, cols - 1));
        out.push_back(i * (chart.n - 1) + j);
    }
    return out;
}

struct Sum {
    double of = 0, weight = 0;
};

/// Weighted means of each cell of a grid and those beside it.
std::vector<double> even_out(const std::vector<Sum>& cells, std::ptrdiff_t rows, std::ptrdiff_t cols) {
    std::vector<double> out(cells.size());
    for (std::ptrdiff_t i = 0; i < rows; ++i)
        for (std::ptrdiff_t j = 0; j < cols; ++j) {
            Sum sum;
            for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - 1); a <= std::min(rows - 1, i + 1); ++a)
                for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - 1); b <= std::min(cols - 1, j + 1); ++b) {
                    const double w = (a == i ? 1 : kNeighbours) * (b == j ? 1 : kNeighbours);
                    sum.of += w * cells[a * cols + b].of;
                    sum.weight += w * cells[a * cols + b].weight;
                }
            out[i * cols + j] = sum.weight > 0 ? sum.of / sum.weight : 0;
        }
    return out;
}

double share_of_worst(const std::vector<Sum>& cells) {
    std::vector<double> sums;
    sums.reserve(cells.size());
    double all = 0;
    for (const Sum& cell : cells) {
        sums.push_back(cell.of);
        all += cell.of;
    }
    const auto worst = static_cast<std::ptrdiff_t>(std::ceil(kWorst * static_cast<double>(sums.size())));
    std::nth_element(sums.begin(), sums.begin() + worst - 1, sums.end(), std::greater<>());
    double most = 0;
    for (std::ptrdiff_t k = 0; k < worst; ++k) most += sums[k];
    return all > 0 ? most / all : 0;
}

/// Points spread by area, and the middle of each face that has none of them.
std::vector<SurfaceSample> points_on(const TriMesh& mesh, std::size_t count) {
    std::vector<SurfaceSample> out = spread_by_area(mesh, count);
    std::vector<char> has_one(mesh.faces.size(), 0);
    for (const SurfaceSample& s : out) has_one[s.face] = 1;
    for (std::uint32_t f = 0; f < has_one.size(); ++f)
        if (!has_one[f]) out.push_back({f, {1.0 / 3, 1.0 / 3, 1.0 / 3}});
    return out;
}

/// In units in which the mean over all area is 1; empty if there is no error but for rounding.
std::vector<double> over_mean(std::vector<double> errors, const TriMesh& mesh) {
    double sum = 0, area = 0;
    for (std::size_t f = 0; f < errors.size(); ++f) {
        const double own = face_area(mesh.corners(f));
        sum += own * errors[f];
        area += own;
    }
    if (!(sum > kRounding * kRounding * area) || !std::isfinite(sum)) return {};
    for (double& e : errors) e *= area / sum;
    return errors;
}

}  // namespace

ErrorField error_field(const SampledChart& fitted) {
    const TriMesh surface = fitted.surface();
    const ClosestPointIndex index(surface.positions, surface.faces);
    const TriMesh& mesh = fitted.disk->mesh;
    const std::vector<SurfaceSample> points = points_on(mesh, kPointsPerSample * fitted.grid_count());
    const std::vector<std::size_t> cell_of_face = cells_of_faces(fitted);
    std::vector<std::size_t> cell_of(points.size());
    std::vector<double> squared(points.size());
    in_pieces(points.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::uint32_t hint = ClosestPointIndex::kNoFace;
        for (std::size_t k = begin; k < end; ++k) {
            const ClosestPoint hit = index.query(position_at(mesh, points[k]), hint);
            hint = hit.face;
            cell_of[k] = cell_of_face[hit.face];
            squared[k] = hit.distance * hit.distance;
        }
    });
    std::vector<Sum> cells(std::size_t{fitted.m - 1} * (fitted.n - 1));
    for (std::size_t k = 0; k < points.size(); ++k) {
        cells[cell_of[k]].of += squared[k];
        cells[cell_of[k]].weight += 1;
    }
    const std::vector<double> evened = even_out(cells, fitted.m - 1, fitted.n - 1);
    std::vector<double> errors(mesh.faces.size(), 0), counts(mesh.faces.size(), 0);
    for (std::size_t k = 0; k < points.size(); ++k) {
        errors[points[k].face] += evened[cell_of[k]];
        counts[points[k].face] += 1;
    }
    for (std::size_t f = 0; f < errors.size(); ++f) errors[f] /= counts[f];
    return {over_mean(std::move(errors), mesh), share_of_worst(cells)};
}

Remap::Remap(SampledChart mapped, std::optional<Levelling> levelling)
    : mapped_(std::move(mapped)), levelling_(levelling), weights_(mapped_.disk->mesh.faces.size(), 1.0) {
    for (const std::uint32_t h : mapped_.disk->border()) {
        border_.push_back(origin(mapped_.disk->mesh.faces, h));
        border_uv_.push_back(mapped_.uv[border_.back()]);
    }
}

/// @return  nothing where rounding turns faces of next to no area
std::optional<std::vector<Vec2d>> Remap::levelled(const std::vector<double>& weights, RemapShape shape,
                                                  const model::Progress& progress) const {
    const TriMesh& mesh = mapped_.disk->mesh;
    const DiskView square{mesh.positions, mesh.faces, border_, border_uv_, (mapped_.m - 1.0) / (mapped_.n - 1.0)};
    const CellRectangle cells(square);
    std::vector<Vec2d> uv = cells.from_square(mapped_.uv);
    if (count_not_positive(mesh.faces, uv) > 0) return std::nullopt;
    std::vector<RestShape> rest;
    if (shape == RemapShape::kOwn) {
        std::vector<Vec3d> flat;
        flat.reserve(uv.size());
        for (const Vec2d& p : uv) flat.push_back({p.x, p.y, 0});
        DiskView plane = cells.view();
        plane.positions = flat;
        rest = rest_shapes(plane);
    } else {
        rest = rest_shapes_of(*levelling_, cells.view());
    }
    for (std::size_t f = 0; f < rest.size(); ++f) rest[f].area *= weights[f];
    const std::size_t steps = mesh.faces.size() < kDense ? kSteps : kStepsOfDense;
    const double epsilon = (shape == RemapShape::kOwn ? kOwnStrength : kLevelledStrength).epsilon;
    uv = cells.to_square(level_map(cells.view(), std::move(uv), steps, epsilon, progress, rest));
    if (count_not_positive(mesh.faces, uv) > 0) return std::nullopt;
    return uv;
}

std::optional<SampledChart> Remap::propose(const ErrorField& left, RemapShape shape, const model::Progress& progress) {
    proposed_.reset();
    if (left.of_faces.empty()) return std::nullopt;
    const auto weighed = [&](double power) {
        std::vector<double> out;
        out.reserve(left.of_faces.size());
        for (const double error : left.of_faces)
            out.push_back(std::clamp(math::pow(error, power), kLeastWeight, kMostWeight));
        return out;
    };
    proposed_weights_ = weighed(kLevelledStrength.power);
    for (std::size_t f = 0; f < weights_.size(); ++f) proposed_weights_[f] *= weights_[f];
    std::optional<std::vector<Vec2d>> uv =
        levelled(shape == RemapShape::kOwn ? weighed(kOwnStrength.power) : proposed_weights_, shape, progress);
    if (!uv) return std::nullopt;
    SampledChart out = mapped_;
    out.uv = std::move(*uv);
    const SampleGrid fine = rasterize(out.disk->mesh.faces, out.uv, 2 * out.m - 1, 2 * out.n - 1);
    const std::vector<SurfaceSample> samples = coarsen(fine, out.m, out.n);
    for (std::uint32_t i = 0; i < out.m; ++i)
        for (std::uint32_t j = 0; j < out.n; ++j) {
            const std::size_t s = std::size_t{i} * out.n + j;
            // Those on the square's border stay as the seams have them.
            const bool stays = out.mask.empty() && (i == 0 || j == 0 || i + 1 == out.m || j + 1 == out.n);
            if (stays || !out.on_surface(s)) continue;
            if (samples[s].face == kNone) return std::nullopt;
            out.samples[s] = samples[s];
        }
    place_samples(out);
    choose_diagonals(out, fine);
    proposed_ = out;
    return out;
}

void Remap::accept() {
    mapped_ = std::move(*proposed_);
    weights_ = std::move(proposed_weights_);
    proposed_.reset();
}

}  // namespace dgm::bake
