// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/sliding.h
// Moves samples without inverting, flattening or shrinking the faces around them.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/fit/border_rails.h"
#include "geometry/fit/matches.h"

namespace dgm::bake {

/// Moves the classes of a grid, each step as far as its faces allow. Deterministic, single-threaded.
class Sliding {
 public:
    /// All must outlive the object.
    /// @param upward  per face of the source: its normal at the scale of the grid
    /// @param fixed  per class: on the source's border, moves along it alone
    Sliding(WeldedGrid& grid, const Matches& matches, BorderRails& rails, std::span<const Vec3d> upward,
            std::span<const char> fixed)
        : grid_(grid), matches_(matches), rails_(rails), upward_(upward), fixed_(fixed) {}

    /// Applies a step, and `ways` along the border for classes that slide there: its tangential part is clamped, then
    /// halved (and at last the whole step) at the corners of faces that it would turn or flatten.
    /// @param step  per class
    /// @param ways  per class, or empty
    void take(std::span<const Vec3d> step, std::vector<double> ways);

    /// Samples of the border go to its corners that have none, where the faces around them stay sound.
    /// @return  true if one moved
    bool occupy_corners();

 private:
    struct Step {
        std::vector<Vec3d> across, along;  // per class: along the normal of the grid, in its plane
        std::vector<double> ways;          // per class, or empty
        std::vector<std::uint32_t> faces;  // that move: few where most classes are held
    };
    [[nodiscard]] Step clamped(std::span<const Vec3d> step, std::vector<double> ways) const;
    /// True if a face may go from `was` to `now`: not much smaller, thinner or more tilted against the source below it.
    [[nodiscard]] bool allows(std::uint32_t face, const std::array<Vec3d, 3>& was,
                              const std::array<Vec3d, 3>& now) const;

    WeldedGrid& grid_;
    const Matches& matches_;
    BorderRails& rails_;
    std::span<const Vec3d> upward_;
    std::span<const char> fixed_;
};

}  // namespace dgm::bake
