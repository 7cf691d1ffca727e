// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/multilevel_map.h
// The stretch-minimal map of a large disk, found on a small one and refined.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

struct MultilevelOptions {
    std::size_t coarsest_faces = 1000;  ///< beside two faces for each border vertex
    std::size_t newton_steps = 25;      ///< on the coarsest level, at most
    int coarsest_sweeps = 100;          ///< of vertex relaxation after them
    int sweeps = 30;                    ///< of vertex relaxation on every finer level
    /// Power of the squared stretch that is summed by area. 1 is the L2 norm of [Sander 2001]. The error of a piecewise
    /// linear surface grows with the square of the step, its square with the fourth power: 2. On the corpus' heads,
    /// animals and organs at 257 a side, 2 reconstructs 0.1 to 1.6 dB better than 1.
    double power = 2;
    /// Maps the coarsest level, flip-free; the border stays on the levels above where this puts it. Empty: reweighting
    /// and Newton steps, with the border on `border_uv`.
    std::function<std::optional<std::vector<Vec2d>>(const DiskView&)> map_coarsest = {};
    /// Moves the map of the finest level of at most `finish_faces` faces (the coarsest, if none is that small) on its
    /// way up, flip-free; the levels above it follow with `sweeps_after` sweeps. Empty: nothing.
    std::function<std::vector<Vec2d>(const DiskView&, std::vector<Vec2d>)> finish = {};
    std::size_t finish_faces = 60'000;
    int sweeps_after = 4;
};

/// What the maps of one disk have in common up to where `finish` changes them: the levels, and the map of the one that
/// it moves. For maps with the same options but for `finish` and `sweeps_after`; one at a time. Another disk or
/// border begins anew.
class MultilevelMemory {
 public:
    MultilevelMemory();
    ~MultilevelMemory();
    MultilevelMemory(const MultilevelMemory&) = delete;
    MultilevelMemory& operator=(const MultilevelMemory&) = delete;

    struct Settled;
    std::unique_ptr<Settled> settled;
};

/// Simplifies the disk level by level with its border untouched (simplify.h), maps the coarsest level by reweighting
/// and projected Newton (slim.h), then puts the vertices back, each inside the kernel of its ring in the map, and
/// relaxes them one at a time by Newton steps on the stretch of their ring [Hormann, Labsik, Greiner 1999; Sander
/// 2001]. No step turns a face over. A sweep cannot move long waves, but the coarser levels have moved them already, so
/// the cost is linear in the number of faces.
///
/// @param disk  with a fixed border
/// @param memory  of earlier maps of this disk, if it is given; they and this one come out as without it
/// @return  one point per vertex, flip-free by the exact predicate; nothing if the coarsest level has no flip-free
/// start
/// @throws model::Error kInterrupted
/// Deterministic, single-threaded.
[[nodiscard]] std::optional<std::vector<Vec2d>> multilevel_stretch_map(const DiskView& disk,
                                                                       const MultilevelOptions& options,
                                                                       const model::Progress& progress,
                                                                       MultilevelMemory* memory = nullptr);

}  // namespace dgm::bake
