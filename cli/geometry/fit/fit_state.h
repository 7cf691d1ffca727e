// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit_state.h
// Holds a chart while it is fitted: both surfaces, the matches between them, and the best state so far.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/fit/border_rails.h"
#include "geometry/fit/fit.h"
#include "geometry/fit/fit_rows.h"
#include "geometry/fit/inverted_faces.h"
#include "geometry/fit/matches.h"
#include "geometry/fit/normal_equations.h"
#include "geometry/fit/region.h"
#include "geometry/fit/sliding.h"
#include "geometry/fit/welded_grid.h"

namespace dgm::bake {

/// The parts of a fit, in the order in which each needs those above. The grid moves, `matches` follow when they are
/// updated, and `kept` is the state to go back to. Parts refer to each other, so the object stays where it is.
struct FitState {
    /// A state of the grid with its error.
    struct Kept {
        double rms = 0, largest = 0;
        std::vector<Vec3d> positions;
        std::vector<std::uint8_t> diagonals;
        std::vector<double> places;  // of the rails' stops
    };

    /// @param fitted  must outlive the object; its diagonals follow the grid's, its positions do not
    FitState(SampledChart& fitted, const FitOptions& options);
    FitState(const FitState&) = delete;
    FitState& operator=(const FitState&) = delete;

    /// True once the walks have looked at as many faces as they may: what runs ends with the best state so far.
    [[nodiscard]] bool is_spent() const { return matches.looked() >= most_looks; }
    /// Largest distance of a match, or from the source's border to the grid's.
    [[nodiscard]] double largest() const;

    void keep();
    /// The grid lies as kept. The matches do not follow.
    void restore();
    /// Keeps an earlier state instead, restores it and updates the matches.
    void go_back_to(const Kept& before);
    /// Reads the chart's diagonals again.
    void relink();

    /// Updates the matches, edges too, and settles the farthest of them.
    void look_up_farthest();
    /// One least-squares step, as far as the faces allow. Where the rows say nothing, along the surface above all,
    /// samples go on as in the step before [Polyak 1964; Nesterov 1983]; not if `worst_only`. Only `region` moves.
    void step(bool worst_only, const Region& region = {});
    /// The next step begins at rest.
    void rest() { came_from_.clear(); }
    /// Chooses the diagonals anew, by the error; the matches have to be up to date.
    void split_quads();
    /// Splits the quads of inverted faces the other way.
    /// @param measured  by the measure of inverted faces, not by normals
    /// @return  true if one is split the other way; the matches are up to date then
    bool flip_quads(std::span<const std::uint32_t> faces, bool measured);

    /// Corners of faces that a round has inverted go back to where they were before it.
    /// @param fresh_now  returns those faces, as the grid lies now
    /// @param went_back  per class: set where one did, if it is not empty
    /// @return  true if no such face is left
    template <class Fresh>
    bool take_back(const std::vector<Vec3d>& before, const Fresh& fresh_now, std::span<char> went_back = {}) {
        constexpr int kPasses = 3;
        for (int pass = 0;; ++pass) {
            const std::vector<std::uint32_t> fresh = fresh_now();
            if (fresh.empty()) return true;
            if (pass == kPasses) return false;
            move_back(fresh, before, went_back);
        }
    }

    SampledChart& chart;
    std::uint64_t most_looks;
    bool holds_largest;  // with the middles of the edges: what is done besides the mean may hardly raise it
    double damping;
    double points_a_sample;  // of the source
    bool has_dense_points;   // more than usual: FitOptions::points_of_dense
    LinkedSurface source;
    WeldedGrid grid;
    Matches matches;
    std::vector<char> fixed;  // per class: on the source's border
    BorderRails rails;
    std::vector<Vec3d> upward;  // per face of the source: its normal at the scale of the grid
    Sliding sliding;
    InvertedFaces inverted;
    FitRows rows;
    NormalEquations equations;  // of the last step
    Kept kept;

 private:
    void move_back(std::span<const std::uint32_t> faces, const std::vector<Vec3d>& before, std::span<char> went_back);

    std::vector<Vec3d> came_from_;  // per class: where it was before the last step; empty: at rest
    int steps_ = 0;                 // since then
};

inline constexpr int kCgIterations = 40;
/// Cosine to the source below which faces are repaired at the end.
inline constexpr double kEndUpright = 0.02;

/// Members of the first of two ascending lists that the second lacks.
[[nodiscard]] std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& all,
                                                 const std::vector<std::uint32_t>& known);

}  // namespace dgm::bake
