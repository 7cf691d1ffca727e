// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit.h
// Moving the samples of a chart so that the piecewise-linear grid surface lies closest to its source.
//
// Samples taken on a curved patch leave all the error on one side of it. The plain fit minimises the squared distance of
// source points to the grid surface; the tangent fit lets samples slide along the surface, so that the grid gathers where
// the error is: the point-to-plane metric of [Chen, Medioni 1992] beside a small point-to-point share.
#pragma once
#include <cstdint>

#include "geometry/chart/sampled_chart.h"
#include "model/progress.h"

namespace dgm::bake {

struct FitOptions {
    int rounds = 3;                  ///< closest points, one least-squares step, diagonals
    double point_share = 1;          ///< 1: plain fit; 0.01: samples slide along the surface
    bool two_way = false;            ///< also grid points to the source; shapes with limbs need it
    double points_per_sample = 5;    ///< source points a grid sample; all vertices of the source beside them
    double max_slide = 0.2;          ///< largest tangential step a round, of the shortest edge at the sample
    bool split_quads = true;         ///< choose diagonals by the error
    int worst_rounds = 0;            ///< further rounds that weigh points by their error, to lower the maximum
    double worst_price_db = 0.2;     ///< what those may cost in PSNR
};

/// `l2` of methods: three plain rounds. `best`: ten tangent rounds both ways, then eight on the worst places.
[[nodiscard]] FitOptions l2_fit();
[[nodiscard]] FitOptions best_fit();

struct FitReport {
    double start_rms = 0, rms = 0;              ///< symmetric, normalised units, by quick_error
    double start_hausdorff = 0, hausdorff = 0;
    int rounds = 0;                             ///< rounds whose result was kept
};

/// Fits `chart.positions` and `chart.diagonals`; the copies of a class move as one unknown, samples on the source's real
/// border stay where they are, and a step is shortened where it would turn a triangle against the source. Faces that
/// the start turns against the source are mended first; from there on the state with the least measured error is kept.
/// `chart.samples` are moved to the closest points of the source, for the layers that are read there.
/// Deterministic, whatever the number of threads.
FitReport fit_chart(const TriMesh& component, SampledChart& chart, const FitOptions& options, const model::Progress& progress);

/// For each point of a rows x cols grid over the square, the closest point of the source (as a face of chart.disk) to the
/// chart's surface there: what a rasterization is for an unfitted chart. face is kNone off the surface.
[[nodiscard]] SampleGrid closest_samples(const SampledChart& chart, std::uint32_t rows, std::uint32_t cols);

}  // namespace dgm::bake
