// SPDX-License-Identifier: MIT
// libdgm/src/contact/scene.h
// What a step of physics or a frame of cloth touches, and how it has moved since the one before. Each of the two
// libraries has a copy: the runtime without them need not carry it.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/tick.h>

#include "contact/contact_impl.h"

namespace dgm::detail {

/// Obstacles and tools of a step, checked.
struct Scene {
    static constexpr std::uint32_t kMost = 64;
    Shape shapes[kMost];
    std::uint32_t ids[kMost] = {};    ///< a tool's number, or kMost + the obstacle's
    std::uint64_t turns[kMost] = {};  ///< of surfaces: how often they were written
    Box boxes[kMost] = {};            ///< of surfaces, in their own frames: another one may have taken one's memory
    std::uint32_t count = 0;
};

/// Adds the ball of a tool.
void add_tool(Scene& scene, const ToolInput& tool, double radius) noexcept;
/// Adds obstacles, numbered as they come. @return as make_shape(); BadArgument: one of them is `pressed` itself
[[nodiscard]] Result<void> add_obstacles(Scene& scene, std::span<const Obstacle> obstacles,
                                         const StateImpl& pressed) noexcept;
/// Where `o` of a scene stood in the one before; null if it was not there or was another kind of body.
[[nodiscard]] const Shape* was_at(const Scene& before, const Scene& now, std::uint32_t o) noexcept;
/// The same; where it is now if it was not there.
[[nodiscard]] const Shape& last_of(const Scene& before, const Scene& now, std::uint32_t o) noexcept;
/// Whether it stands there still, in the same shape.
[[nodiscard]] bool has_stayed(const Scene& before, const Scene& now, std::uint32_t o) noexcept;
/// Whether it was there in the same shape, maybe at another place.
[[nodiscard]] bool has_kept_shape(const Scene& before, const Scene& now, std::uint32_t o) noexcept;
/// How far distances to an obstacle may change while it goes from one place to another, in the state's units: the
/// longest way of its points. Infinity for a plane that turns. Its shape is that of `now` in both, but for sides and
/// radii.
[[nodiscard]] double longest_way(const Shape& before, const Shape& now) noexcept;
/// As probe(), of a surface that is known as it was at the place where it is now, with Shape::ahead of its way still to
/// come: its samples go straight, its normals turn with the nearest triangle. Others are where they are.
[[nodiscard]] Probe probe_underway(const Shape& shape, Double3 x) noexcept;
/// The longest way of the samples of a surface that is known as it was, in the state's units: 0 for others, infinity
/// where a number is none.
[[nodiscard]] double farthest_way(const Shape& shape) noexcept;
/// The unit normal of an obstacle at a point x that was probed last; nothing (0) where it has none. Nearer to a surface
/// than its floats are exact, the way to its nearest point is noise: there it is that of the nearest triangle.
[[nodiscard]] Double3 normal_at(const Shape& shape, const Probe& there, Double3 x) noexcept;
/// How far the material of an obstacle at a point that was probed last has come, in the units of both. They are rigid:
/// a plane goes with its point and turns with its normal by the smallest angle, a sphere does not turn, what is beside
/// a capsule's axis goes as the axis there, boxes and surfaces go with their frames. 0 if both are one. A surface that
/// is known as it was is not rigid: its nearest triangle goes as its corners do.
[[nodiscard]] Double3 way_come(const Shape& before, const Shape& now, Double3 at, const Probe& there) noexcept;
/// The obstacle after a part of that way: points go straight, normals and frames turn about one axis or nearly so.
/// Half sides, radius, and the shape of a surface are those of `now`.
/// @param part  0 .. 1; from 1 on it is `now`
[[nodiscard]] Shape between(const Shape& before, const Shape& now, double part) noexcept;

}  // namespace dgm::detail
