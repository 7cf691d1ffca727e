// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/parameterizer.h
// Interface and promises of a parameterization method. dgm_cgal and dgm_geometry implement it; the pipeline introduces
// the two.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "model/progress.h"
#include "model/vec.h"

namespace dgm::bake {

using model::Face;
using model::Vec2d;
using model::Vec3d;

/// A topological disk, already cut, oriented and free of degenerate faces. Positions are in the normalised frame
/// (centred, bounding-box diagonal 1); every vertex is used by a face.
struct DiskView {
    std::span<const Vec3d> positions;
    std::span<const Face> faces;
    std::span<const std::uint32_t> border;  ///< the one border cycle, surface on its left, each vertex once
    std::span<const Vec2d> border_uv;  ///< fixed-border methods: one point per entry of `border`, counter-clockwise
                                       ///  on the boundary of the unit square; empty for free-border methods
    double aspect = 1;  ///< fixed-border methods: cells of the grid along u : along v; > 0. Stretch counts in cells.
};

class Parameterizer {
 public:
    virtual ~Parameterizer() = default;
    [[nodiscard]] virtual std::string_view name() const = 0;
    /// True if the method needs `border_uv` and keeps it to the bit.
    [[nodiscard]] virtual bool fixed_border() const = 0;
    /// One (u, v) per vertex. Fixed-border results lie in the unit square; free-border results in any frame, positively
    /// oriented. Finite always; flips are for the caller to count with exact predicates.
    /// @throws model::Error kMapInvalid if the solver fails, kInterrupted
    [[nodiscard]] virtual std::vector<Vec2d> solve(const DiskView& disk, const model::Progress& progress) const = 0;
    /// The map `uv` of `solve` with less shear and more stretch, `step` = 0, 1, ... ever more so; nothing if the method
    /// has no further step. For maps that are so sheared that quads of the grid fold over on the surface.
    [[nodiscard]] virtual std::optional<std::vector<Vec2d>> level(const DiskView&, const std::vector<Vec2d>& /*uv*/,
                                                                  std::size_t /*step*/, const model::Progress&) const {
        return std::nullopt;
    }
};

}  // namespace dgm::bake
