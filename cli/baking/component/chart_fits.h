// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/chart_fits.h
// The fits of one chart, of which the best is kept.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "baking/bake_options.h"
#include "baking/component/candidates.h"
#include "geometry/fit/fit.h"
#include "geometry/fit/remap.h"
#include "model/progress.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

/// Vertices of a source that is worth a copy and further fits.
inline constexpr std::size_t kMostFitted = 200'000;

/// Faces that fits of one chart may have looked at before another map of it is fitted for fewer inverted faces alone:
/// some 25 s of a processor.
inline constexpr std::uint64_t kMostLooked = 150'000'000;

/// Moves the samples of a chart closest to their source. If faces are inverted after the first fit, or it has gained
/// little of what there was to gain, there is also one with samples that are held firmly, then, if faces are inverted
/// still, one in rounds that invert none; kept is the one with the fewest inverted faces, of those with the lowest
/// error. One that leaves error at few places, and any of `best`, is made again of a map with more samples there
/// (remap.h). Each step is offered by a may_...() that says whether it is worth its time, in this order.
class ChartFits {
 public:
    /// All but `trial_samples` must outlive the object.
    ChartFits(const model::TriMesh& component, ComponentResult& mapped, const BakeOptions& options,
              const FitOptions& fit, std::uint64_t trial_samples)
        : component_(component), mapped_(mapped), options_(options), fit_(fit), trial_samples_(trial_samples) {}

    void fit(const model::Progress& progress);

    [[nodiscard]] bool may_gain() const;
    void fit_firmly(const model::Progress& progress);

    [[nodiscard]] bool may_gain_guarded() const;
    void fit_guarded(const model::Progress& progress);

    [[nodiscard]] bool may_remap() const;
    void remap(const model::Progress& progress);

    /// All of this for the chart that came next; it is taken if it is the better one.
    [[nodiscard]] bool may_lose() const;
    void fit_runner_up(const model::Progress& progress);

    /// What fit() offers of the first three.
    void fit_further(const model::Progress& progress);

    [[nodiscard]] std::size_t inverted() const { return report_.inverted; }
    /// Faces that the fits so far have looked at.
    [[nodiscard]] std::uint64_t looked() const { return looked_; }
    [[nodiscard]] std::size_t samples() const { return mapped_.chart.grid_count(); }

 private:
    [[nodiscard]] double facets() const;
    [[nodiscard]] double price_of(std::size_t inverted) const;
    [[nodiscard]] SurfaceError error_of(const SampledChart& chart) const;
    [[nodiscard]] const SurfaceError& measured();
    [[nodiscard]] Candidate* chosen() const;
    [[nodiscard]] std::optional<Levelling> levelling() const;
    void keep(SampledChart&& chart, const FitReport& report, const SurfaceError& error);
    [[nodiscard]] bool fit_remapped(SampledChart& chart, const model::Progress& progress);
    bool fit_again(const FitOptions& options, const model::Progress& progress);

    const model::TriMesh& component_;
    ComponentResult& mapped_;
    const BakeOptions& options_;
    const FitOptions& fit_;
    std::uint64_t trial_samples_;
    std::optional<SampledChart> start_;  // mapped, not fitted
    FitReport report_;                   // of the fit that is kept
    std::uint64_t looked_ = 0;
    std::optional<SurfaceError> error_;  // of it, once measured
    bool held_firmly_ = false;           // in it
};

/// All of them, one after the other.
/// @return  inverted faces
std::size_t fit_component(const model::TriMesh& component, ComponentResult& mapped, const BakeOptions& options,
                          const FitOptions& fit, std::uint64_t trial_samples, const model::Progress& progress);

}  // namespace dgm::bake
