// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/remap.h
// Maps a chart anew, with more samples where a fit has left more error than elsewhere.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/chart/square_chart.h"
#include "model/progress.h"

namespace dgm::bake {

/// Where a fit has left error.
struct ErrorField {
    std::vector<double> of_faces;  ///< mean squared distance over each face of the disk, over that of all; empty: none
    double worst_share = 0;        ///< of the squared error, in the twentieth of the grid's cells that have most of it
};

/// Measures points spread by area against all faces of the grid, and evens the result out over neighbouring cells.
/// Parallel, with the same bits for any number of threads.
/// @throws model::Error kInternal if the index of the grid's faces cannot be built
[[nodiscard]] ErrorField error_field(const SampledChart& fitted);

/// What the faces would like to be in the map, before the error that is left weighs them.
enum class RemapShape {
    kLevelled,  ///< what the map was levelled to (square_chart.h)
    kOwn,       ///< what they are in the map
};

/// A map by stretch is levelled to an error that is foretold from curvature. Once a fit has shown where error is left,
/// the map can be levelled to that: faces of more error than the mean weigh more in the energy, and get more room. The
/// border stays, so seams, masks and strips of free charts do too. Where facets of the source are larger than the
/// grid's faces, most of the error sits at a few places whose edges have too few samples, and the gain is large.
class Remap {
 public:
    /// @param mapped     before its fit
    /// @param levelling  of its map, not kArea; nothing: it was levelled to nothing else, and kLevelled is not to be
    ///                   asked for
    Remap(SampledChart mapped, std::optional<Levelling> levelling);

    /// The map that was accepted last, levelled to the error that its fit has left; not fitted.
    /// @return  nothing if there is no such error, or the result rounds to a map that is not sound
    /// @throws model::Error kInterrupted
    [[nodiscard]] std::optional<SampledChart> propose(const ErrorField& left, RemapShape shape,
                                                      const model::Progress& progress);
    /// The next proposals start from the last one.
    void accept();
    [[nodiscard]] bool may_be_levelled() const { return levelling_.has_value(); }

 private:
    [[nodiscard]] std::optional<std::vector<Vec2d>> levelled(const std::vector<double>& weights, RemapShape shape,
                                                             const model::Progress& progress) const;

    SampledChart mapped_;
    std::optional<Levelling> levelling_;
    std::vector<std::uint32_t> border_;
    std::vector<Vec2d> border_uv_;
    std::vector<double> weights_;  // per face of the disk, of the levelling
    std::optional<SampledChart> proposed_;
    std::vector<double> proposed_weights_;
};

}  // namespace dgm::bake
