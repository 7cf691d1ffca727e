// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/normal_equations.h
// The damped least-squares step of a point-to-surface fit, over the classes of a chart.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "geometry/fit/welded_grid.h"

namespace dgm::bake {

/// Freedom of a class: it moves anywhere, nowhere, or along its rail.
enum class Freedom : char { kFree, kHeld, kSlides };

/// Sums rows "the surface point at b on this face should move by n . gap along n" into 3x3 blocks per class and per
/// edge: a step of conjugate gradients then costs one pass over the edges, however many points there are. Sums run in
/// the order of the calls: the same bits every time.
class NormalEquations {
 public:
    explicit NormalEquations(const WeldedGrid& grid);
    /// No rows; the grid may have been linked anew.
    void clear();

    void add(std::uint32_t face, const std::array<double, 3>& b, const Vec3d& gap, const Vec3d& normal, double weight);
    /// The same at the middle of a face, and at a class itself.
    void add_at_middle(std::uint32_t face, const Vec3d& gap, const Vec3d& normal, double weight);
    void add_at_class(std::uint32_t c, const Vec3d& gap, const Vec3d& normal, double weight);
    /// The same along the face's own normal: most rows, of which only these sums per face are kept until close().
    /// @param distance  normal . gap
    void add_along_normal(std::uint32_t face, const std::array<double, 3>& b, double distance, double weight) {
        FaceSums& sums = along_normal_[face];
        for (std::size_t k = 0; k < 3; ++k) {
            const double share = weight * b[k];
            sums.own[k] += share * b[k];
            sums.pair[k] += share * b[(k + 1) % 3];
            sums.pull[k] += share * distance;
        }
    }
    /// The same as add(), but kept until close().
    void add_later(std::uint32_t face, const std::array<double, 3>& b, const Vec3d& gap, const Vec3d& normal,
                   double weight) {
        later_.push_back({face, b, gap, normal, weight});
    }
    /// Takes the sums per face and the rows that were kept into the blocks, after the last of them. One thread may add
    /// those while another one calls add().
    void close();

    /// Minimises the rows + damping * (own diagonal) * |step|^2 by conjugate gradients with 3x3 block Jacobi
    /// preconditioning; classes that are held stay 0, those that slide go along their unit vector in `rails` (which may
    /// be empty if none does).
    /// @param onward  per class: the step that is free of damping, which counts from there; empty: none
    [[nodiscard]] std::vector<Vec3d> solve(std::span<const Freedom> freedom, std::span<const Vec3d> rails,
                                           double damping, int iterations, std::span<const Vec3d> onward = {}) const;

    /// Puts classes on a lattice where the rows suffer least: each goes to its nearest point; those marked kFree then
    /// take one of the 27 points around it, the one with the smallest sum while all others are held, in passes over all
    /// classes until none gains. A row asks for no more than its normal, so of 27 points one is nearly in the plane.
    /// @param on_lattice  per class; the others stay as they are, and the rows count with them so
    /// @param spoilt      how many faces around a class its present position spoils: asked for classes marked `tight`
    ///                    alone, and weighs more than the sum
    void snap(std::vector<Vec3d>& positions, const Lattice& lattice, std::span<const Freedom> freedom,
              std::span<const char> on_lattice, std::span<const char> tight,
              const std::function<int(std::uint32_t)>& spoilt) const;

 private:
    using Block = std::array<double, 6>;  // symmetric: xx, xy, xz, yy, yz, zz

    /// Of a face, per corner: its weight squared, with that of the next corner, and times the distance.
    struct FaceSums {
        std::array<double, 3> own{}, pair{}, pull{};
    };

    struct Row {
        std::uint32_t face;
        std::array<double, 3> b;
        Vec3d gap, normal;
        double weight;
    };

    /// Adds m times the sums to the blocks of a face, and `pull` times its distances to the right side.
    void take(std::size_t face, const FaceSums& sums, const Block& m, const Vec3d& pull);

    const WeldedGrid& grid_;
    std::vector<FaceSums> along_normal_;
    std::vector<Row> later_;
    std::vector<Block> diagonal_, off_;
    std::vector<Vec3d> right_;
};

}  // namespace dgm::bake
