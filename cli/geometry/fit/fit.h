// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit.h
// Moving the samples of a chart so that the piecewise-linear grid surface lies closest to its source.
//
// Samples taken on a curved patch leave all the error on one side of it. The fit minimises the squared distance of both
// surfaces by Gauss-Newton steps whose rows are the distances to tangent planes [Chen, Medioni 1992]: nothing holds a
// sample along the surface but a small damping, so the grid gathers and aligns its edges where the error is.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/fit/fit_work.h"
#include "model/progress.h"

namespace dgm::bake {

/// How firmly samples are held. Loose ones go where the error is least and win nearly everywhere; where facets of the
/// source are larger than the grid's, they may leave an edge that firm ones keep to.
struct Hold {
    double damping;       ///< of a step, by a sample's own weight
    double corner_share;  ///< of the weight of the grid's faces, on their corners in all; the rest is on the middles
    double grid_share;    ///< weight of the grid's points in all, against the source's
};

/// A quarter on the corners is right for squares of linear distances, and more draws the grid to the surface there,
/// away from where it is nearest. The grid's points are few and weigh little: the source's see all of both surfaces.
/// A tenth of the damping gains 0.1 dB more, and doubles the largest error of some.
inline constexpr Hold kLoose{1e-4, 0.25, 0.2};
inline constexpr Hold kFirm{1e-3, 0.5, 1};

struct FitOptions {
    Hold hold = kLoose;
    int rounds = 3;                ///< matches, one least-squares step, diagonals
    int worst_rounds = 0;          ///< further rounds that weigh points by their error, to lower the maximum
    double worst_price_db = 0.2;   ///< loss of PSNR that those may cause
    int snaps = 0;                 ///< times that samples go to the source's edges, between rounds (edge_snap.h)
    bool split_quads = true;       ///< choose diagonals by the error
    bool guarded = false;          ///< repair first, and undo each round where it inverts faces
    bool on_lattice = false;       ///< leave the grid's samples on the places that u16 positions have
    std::uint64_t most_looks = 0;  ///< faces that walks may look at before the fit ends; 0: most_looks_of()
    std::size_t patch_effort = kPatchEffort;  ///< of a repair of inverted faces, and of each attempt of the last resort
    std::uint64_t trial_samples = kTrialSamples;  ///< where the chart is compared with what it was
    double points_per_sample = 8;  ///< source points a grid sample, but 24 where that makes points_of_small at most
    std::size_t points_of_small = kPointsOfSmall;
    double points_of_dense = 0;  ///< the same as points_per_sample where a large grid has a dense source, if more
};

/// `l2`: a few rounds, for the mean error. `best`: more of them, then rounds for the largest error. Both put samples on
/// edges of the source.
[[nodiscard]] FitOptions l2_fit();
[[nodiscard]] FitOptions best_fit();
/// The same with samples that are held firmly, in fewer rounds.
[[nodiscard]] FitOptions firm(FitOptions options);
/// The same with rounds that invert no face.
[[nodiscard]] FitOptions guarded(FitOptions options);
/// Counted work, so that a fit ends alike everywhere: some times what ordinary charts take.
[[nodiscard]] std::uint64_t most_looks_of(std::size_t samples);

struct FitReport {
    double start_rms = 0, rms = 0;  ///< symmetric, normalised units, over the points of the fit
    double start_hausdorff = 0, hausdorff = 0;
    int rounds = 0;            ///< rounds whose result was kept
    std::size_t inverted = 0;  ///< faces against the source (metrics/turned_faces.h)
    std::uint64_t looked = 0;  ///< faces that walks have looked at
    bool was_exact = false;    ///< nothing was left to fit, but for rounding
    bool ended_early = false;  ///< at the bound of its work, with the best state so far
};

/// What a fit changes of a chart: a small part of it where the source is dense.
struct Placement {
    std::vector<Vec3d> positions;
    std::vector<std::uint8_t> diagonals;
    std::vector<SurfaceSample> samples;
    std::optional<Lattice> lattice;
};

/// A chart after a few rounds for the mean, without repairs: charts of one component are compared by its error, since
/// what they will have after fit_chart() differs alike.
struct TrialFit {
    Placement placement;
    double start_rms = 0, rms = 0;  ///< normalised units, over the points of the trial
    double first_rms = 0;           ///< after the first round
};

/// @param chart  fitted in its place, and as before afterwards
[[nodiscard]] TrialFit trial_fit(SampledChart& chart, const model::Progress& progress);

/// The chart takes the samples of a placement.
void take_placement(SampledChart& chart, Placement from);

/// A chart and its trial fit, if there is one already.
struct TrialOf {
    SampledChart& chart;
    std::optional<TrialFit>& fit;
};

/// Makes the trial fits of two charts of one component that lack one. A chart whose error is more than `clearly` times
/// the other one's after the first round gets no further rounds.
void fit_trials(const std::array<TrialOf, 2>& trials, double clearly, const model::Progress& progress);

/// Fits `chart.positions` and `chart.diagonals`; the copies of a class move as one unknown, samples on the source's
/// real border slide along it and stay on its corners (border_rails.h), and a step is shortened where it would invert a
/// triangle. Faces that are inverted at the start are repaired first, the remaining ones at the end; the best state is
/// kept. `chart.samples` are moved to the closest points of the source, for the layers that are read there.
/// Deterministic, whatever the number of threads.
/// @param begun  a trial of this chart, to go on from; null: from the chart itself
FitReport fit_chart(SampledChart& chart, const FitOptions& options, const model::Progress& progress,
                    const TrialFit* begun = nullptr);

}  // namespace dgm::bake
