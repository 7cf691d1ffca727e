// SPDX-License-Identifier: MIT
// libdgm/include/dgm/tick.h
// Runs one turn of the haptic loop: track, hit, force, deform, normals (paper sections 4.4 to 5.2).
//
// Tools are tracked against the permanent shape (rest plus plastic touches), not against the dent that they make.
// The paper tests N_t . N_n < 0 on the displaced surface. There a pressed sample follows the tool, N_t becomes 0, the
// hit is lost, the surface springs back, and so on from tick to tick.
//
// The force is continuous in time. As printed, d in eqs. 8-10 runs from the nearest sample to the tool. It jumps twice:
//  - when the hit begins or ends, by the part of d along the surface (up to a grid step), which is not 0 where
//    N_t . N_n is 0;
//  - when another sample becomes the nearest, by the distance of the two.
// ContactRule::Smooth takes the part of d along the normal, d = (N_t . N_n) N_n. It is 0 where the hit begins, and
// steps along the surface do not change it. Some jumps are left: the normal turns from sample to sample, the nearest
// point leaps across a fold, a poke ends sideways. In one tick d may change by twice the tool's own step; the rest of a
// jump goes into an offset that fades with `settle_time`. So for a tool moving by s in dt
//     |d(t + dt) - d(t)| <= 2 s + (1 - exp(-dt / settle_time)) |offset|,  |offset| <= sum of the jumps,
// and the force is continuous in d: its limit for short ticks is continuous on every surface.
#pragma once
#include <cstdint>
#include <limits>
#include <span>

#include <dgm/deform.h>
#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

/// How a tool touches.
enum class ToolKind : std::uint32_t {
    Touch = 0,  ///< presses and slides: the contact is the nearest sample, displaced along its normal
    Poke = 1,   ///< presses and sticks: the sample first hit follows the tool until it comes out again
    Grasp = 2,  ///< the sample nearest at the start follows the tool, in or out, until `engaged` is false
};

/// Which displacement a touching tool asks for.
enum class ContactRule : std::uint32_t {
    Smooth = 0,   ///< the depth along the normal; see the top of this file
    Printed = 1,  ///< touch as the paper prints it: d from the nearest sample to the tool, with its jumps
};

/// A tool in a tick.
struct ToolInput {
    std::uint32_t tool = 0;  ///< 0 .. StateOptions::max_tools - 1, each at most once a tick
    ToolKind kind = ToolKind::Touch;
    Vec3 position;        ///< local coordinates, within kMaxCoordinate (limits.h)
    bool engaged = true;  ///< false: a grasp lets go; a touch or poke ends
};

/// Answer to a tool.
struct ToolOutput {
    std::uint32_t sample = kNone;   ///< nearest sample of the permanent shape; exact
    float distance = 0;             ///< to that sample, local units
    bool hit = false;               ///< N_t . N_n < 0 there
    bool lost = false;              ///< the pyramid had to be searched: the window did not prove the sample nearest
    bool holding = false;           ///< in contact or grasping
    std::uint32_t contact = kNone;  ///< sample that is displaced, kNone if none is
    Vec3 displacement;              ///< d_c, at most d_max long
    Vec3 force;                     ///< eqs. 8-10
};

/// Settings of a tick.
struct TickOptions {
    float dt = 1e-3f;  ///< seconds since the last tick
    float d_max = 1;   ///< local units; > 0
    float f_max = 1;   ///< >= 0; its unit is that of the forces
    /// Where no tool is in contact, elastic displacement fades by exp(-relax_rate dt) a tick; infinity: at once.
    float relax_rate = std::numeric_limits<float>::infinity();
    float settle_time = 0.01f;               ///< seconds; 0: jumps pass at once
    float grasp_distance = 0;                ///< a grasp farther away than this has no effect; 0: four mean steps
    ContactRule rule = ContactRule::Smooth;  ///< as quick as Printed; its forces jump an eighth as far or less
    Footprint footprint = Footprint::Surface;
    DeformMode mode = DeformMode::Elastic;
    float step = 0;       ///< as Touch::step
    bool normals = true;  ///< bring State::normals() up to date (while elastic touches fade: when they are read)
};

/// Effect of a tick.
struct TickReport {
    std::uint32_t contacts = 0;  ///< tools that displace a sample
    std::uint32_t samples = 0;   ///< samples in reach of them, summed over tools
    bool crossed_seam = false;
    bool truncated = false;  ///< as DeformReport::truncated
};

/// Moves the tools, computes contacts and forces, and shapes the surface: the present shape becomes the permanent
/// shape, the rest of earlier elastic touches, and the displacement of every tool in contact. Tools that are not named
/// do not touch.
///
/// @param outputs  one for each input, or empty
/// @return BadArgument: a position, time or limit is not finite or out of range, a tool number is beyond max_tools or
///         named twice, outputs too short, or an argument that deform() rejects. Unsupported kind, rule, footprint or
///         mode. NotFound: the chart has no sample. In these cases nothing has been changed, tools included.
///         LimitExceeded as deform(): earlier tools of this call have been applied.
/// No allocation, no locks, no system calls. O(footprint): elastic displacement beyond the tools' reach fades when it
/// is read next, in one step instead of many. Displacements on seams and free borders all fade together.
[[nodiscard]] DGM_API Result<TickReport> tick(State& state, const DeformTable& table, const TickOptions& options,
                                              std::span<const ToolInput> tools, std::span<ToolOutput> outputs) noexcept;

}  // namespace dgm
