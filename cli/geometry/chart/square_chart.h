// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/square_chart.h
// A disk on the whole square (docs/design.md section 2.4).
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/parameterize/multilevel_map.h"
#include "geometry/parameterize/parameterizer.h"
#include "geometry/parameterize/rest_shapes.h"
#include "geometry/parameterize/square_border.h"

namespace dgm::bake {

/// Lays the border, solves, checks and resamples. Every map is checked for finite values, flips and degenerate faces
/// (exact predicates) and coverage before it is used.
/// If more than a few quads fold, the map is levelled as far as the method can.
/// @throws model::Error kMapInvalid with the fault, kGridTooSmall, kInterrupted, and as lay_square_border
[[nodiscard]] SampledChart make_square_chart(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                                             const Parameterizer& method, const model::Progress& progress,
                                             BorderShares shares = BorderShares::kByLength);

/// A disk whose border is laid around an m x n grid, for the maps of several methods.
struct LaidDisk {
    std::uint32_t m, n;
    SharedDisk disk;
    SquareBorder border;
};
/// @throws model::Error as lay_square_border
[[nodiscard]] LaidDisk lay_disk(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                                BorderShares shares = BorderShares::kByLength);
/// As above, once the border is laid. The chart shares the disk.
[[nodiscard]] SampledChart make_square_chart(const LaidDisk& laid, const Parameterizer& method,
                                             const model::Progress& progress);

/// What a map by stretch is levelled to, which decides where the samples are dense.
enum class Levelling {
    kArea,        ///< equal steps everywhere
    kCurvature,   ///< more room where the surface bends (curved_rest_shapes)
    kDirections,  ///< longer steps along the direction in which it bends least (directed_rest_shapes)
};

/// The shapes that a map is levelled to; empty for kArea: those of the surface.
[[nodiscard]] std::vector<RestShape> rest_shapes_of(Levelling levelling, const DiskView& disk);

/// Levels a flip-free map in so many Newton steps. Faces sheared into slivers cost no stretch, but their samples fold;
/// the half of the energy that `epsilon` weighs levels them.
/// @param rest  one a face; empty: the shapes of the surface
/// @throws model::Error as descend_flip_free
[[nodiscard]] std::vector<Vec2d> level_map(const DiskView& disk, std::vector<Vec2d> uv, std::size_t steps,
                                           double epsilon, const model::Progress& progress,
                                           std::span<const RestShape> rest);

/// What one map by stretch leaves to the next one of the same disk with the same border.
struct StretchMemory {
    MultilevelMemory levels;
    std::optional<std::vector<Vec2d>> map;  ///< flip-free; levelled on, where no coarser level settles the map
};

/// `stretch`: multilevel_map.h, and where that crowds or has no start, stretch_map.h with so many Newton steps for an
/// ordinary map. The one with the lower stretch is taken, and levelled by a few Newton steps on an energy that counts
/// shear too. 0 steps: a trial, stretch_map.h alone.
/// @param memory  of earlier maps of the disk; one user at a time
[[nodiscard]] std::unique_ptr<Parameterizer> make_stretch_parameterizer(
    std::size_t newton_steps, Levelling levelling = Levelling::kCurvature,
    std::shared_ptr<StretchMemory> memory = nullptr);

/// The reweighted convex map [Yoshizawa 2004] alone: crowds limbs about as the named convex methods do, so a cut found
/// with it suits them too.
[[nodiscard]] std::unique_ptr<Parameterizer> make_reweighted_parameterizer();

/// @throws model::Error kMapInvalid unless every vertex is finite and every face positively oriented, by exact
/// predicate.
void check_map(const Disk& disk, const std::vector<Vec2d>& uv, std::string_view method);

}  // namespace dgm::bake
