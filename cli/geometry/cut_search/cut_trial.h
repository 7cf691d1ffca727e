// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_trial.h
// Maps a component along a cut and measures the result.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/cut/cut_graph.h"
#include "geometry/cut_search/cut_search.h"
#include "geometry/mesh/infinity.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/parameterizer.h"
#include "geometry/spatial/lazy_index.h"
#include "model/codes.h"

namespace dgm::bake {

struct Trial {
    double rms = kInfinity;
    std::uint32_t rotation = 0;
    Disk split;             ///< as the border layout split it
    std::vector<Vec2d> uv;  ///< empty if the map failed
};

/// Tries cuts of one component on one grid, by prediction (trial_map.h) or, if `options.measured`, by a bake that is
/// measured. Counts the trials and keeps the first failure's reason.
class CutTrials {
 public:
    /// All must outlive the object.
    CutTrials(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress);

    /// One map and one measurement of a cut. Its error is infinite if the map failed.
    /// @param rotation  nothing: the first candidate
    /// @throws model::Error kInterrupted
    Trial attempt(Disk disk, std::optional<std::uint32_t> rotation, BorderShares shares = BorderShares::kByLength);

    /// @throws model::Error `failure` itself if it is kInterrupted
    void note(const model::Error& failure);
    [[nodiscard]] const std::optional<model::Error>& failure() const { return failure_; }
    [[nodiscard]] int count() const { return count_; }

 private:
    [[nodiscard]] Trial predicted(Disk disk, std::uint32_t rotation, BorderShares shares) const;
    [[nodiscard]] Trial measured(Disk disk, std::uint32_t rotation, BorderShares shares);

    const TriMesh& component_;
    const CutSearchOptions& options_;
    const model::Progress& progress_;
    std::unique_ptr<Parameterizer> method_;
    LazyIndex index_;  ///< of the component
    Topology topology_;
    std::optional<model::Error> failure_;
    int count_ = 0;
};

}  // namespace dgm::bake
