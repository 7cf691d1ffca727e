// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit.h
// Moving the samples of a chart so that the piecewise-linear grid surface lies closest to its source.
//
// Samples taken on a curved patch leave all the error on one side of it. The fit minimises the squared distance of both
// surfaces by Gauss-Newton steps whose rows are the distances to tangent planes [Chen, Medioni 1992]: nothing holds a
// sample along the surface but a small damping, so the grid gathers and aligns its edges where the error is.
#pragma once
#include <cstddef>
#include <cstdint>

#include "geometry/chart/sampled_chart.h"
#include "model/progress.h"

namespace dgm::bake {

struct FitOptions {
    int rounds = 3;                ///< matches, one least-squares step, diagonals
    int worst_rounds = 0;          ///< further rounds that weigh points by their error, to lower the maximum
    double worst_price_db = 0.2;   ///< loss of PSNR that those may cause
    bool split_quads = true;       ///< choose diagonals by the error
    bool on_lattice = false;       ///< leave the grid's samples on the places that u16 positions have
    std::uint64_t most_looks = 0;  ///< faces that walks may look at before the fit ends; 0: most_looks_of()
    double points_per_sample = 8;  ///< source points a grid sample, but 24 where that makes 200,000 at most
};

/// `l2`: a few rounds, for the mean error. `best`: more of them, then rounds for the largest error.
[[nodiscard]] FitOptions l2_fit();
[[nodiscard]] FitOptions best_fit();
/// Counted work, so that a fit ends alike everywhere: some times what ordinary charts take.
[[nodiscard]] std::uint64_t most_looks_of(std::size_t samples);

struct FitReport {
    double start_rms = 0, rms = 0;  ///< symmetric, normalised units, over the points of the fit
    double start_hausdorff = 0, hausdorff = 0;
    int rounds = 0;            ///< rounds whose result was kept
    std::size_t inverted = 0;  ///< faces against the source (metrics/turned_faces.h)
    std::uint64_t looked = 0;  ///< faces that walks have looked at
    bool ended_early = false;  ///< at the bound of its work, with the best state so far
};

/// Fits `chart.positions` and `chart.diagonals`; the copies of a class move as one unknown, samples on the source's
/// real border slide along it and stay on its corners (border_rails.h), and a step is shortened where it would invert a
/// triangle. Faces that are inverted at the start are repaired first, the remaining ones at the end; the best state is
/// kept. `chart.samples` are moved to the closest points of the source, for the layers that are read there.
/// Deterministic, whatever the number of threads.
FitReport fit_chart(SampledChart& chart, const FitOptions& options, const model::Progress& progress);

/// The error after a few rounds for the mean, without repairs, to compare charts of one component by: what they will
/// have after fit_chart() differs alike. Normalised units, over the points of the fit.
[[nodiscard]] double trial_fit_rms(SampledChart chart, const model::Progress& progress);

}  // namespace dgm::bake
