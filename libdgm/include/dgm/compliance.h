// SPDX-License-Identifier: MIT
// libdgm/include/dgm/compliance.h
// Lets a haptic loop feel a body whose physics is slower than the loop: the thread that steps the physics publishes how
// the body near each tool gives way, and the loop of 1 kHz solves that small contact alone.
//
// A step minimises a potential whose second derivatives are H (physics.h). Near the present shape its answer to forces
// is  d = d_ref + W (f - f_ref)  with  W = H^-1  between the samples near a tool [Duriez, Dubois, Kheddar, Andriot,
// "Realistic haptic rendering of interacting deformable objects in virtual environments", TVCG 12, 2006]. publish()
// computes columns of W by conjugate gradients, with the volume kept and all other contacts and tools as springs where
// they are. compliance_tick() solves  f >= 0, gap >= 0  for the few forces at the place where the tool is by now. So it
// answers the force that the next step would, if the tool were there. docs/haptics.md has errors, times and stability.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/physics.h>

namespace dgm {

namespace detail {
struct ComplianceImpl;
struct ReaderImpl;
}  // namespace detail

/// Sizes and limits of a Compliance.
struct ComplianceOptions {
    std::uint32_t tools = 1;     ///< 1 .. 8: tools with smaller numbers are published
    std::uint32_t columns = 16;  ///< 1 .. 32: forces on a body by a tool. More samples in touch share them in groups
    std::uint32_t cycles = 2;    ///< 1 .. 1000: conjugate gradients of a column that is known from the frame before
    std::uint32_t renewed = 4;   ///< known columns of a tool computed in a frame, oldest first; new ones all are
    std::uint64_t max_bytes = ~std::uint64_t{0};  ///< LimitExceeded if more memory is needed
    Allocator allocator = {};
};

/// What publish() did.
struct ComplianceReport {
    std::uint64_t frame = 0;     ///< counts publications from 1
    std::uint32_t columns = 0;   ///< that were computed
    std::uint32_t samples = 0;   ///< near the tools
    std::uint32_t left_out = 0;  ///< samples in touch that found no place: forces are too small then
};

/// Local compliances on their way from the thread of a Physics to the haptic loop. One thread at a time calls
/// publish(), together with state and physics; any number of readers read at any time.
/// Memory: 24 bytes a sample, column and tool, and 60 KB a tool.
class Compliance {
 public:
    /// @return BadArgument (a number out of range, half an allocator, a Physics of another size than the state),
    ///         LimitExceeded, OutOfMemory.
    [[nodiscard]] DGM_PHYSICS_API static Result<Compliance> create(const State& state, const Physics& physics,
                                                                   const ComplianceOptions& options = {}) noexcept;
    DGM_PHYSICS_API Compliance(Compliance&& other) noexcept;
    DGM_PHYSICS_API Compliance& operator=(Compliance&& other) noexcept;
    DGM_PHYSICS_API ~Compliance();

    /// Publishes how the body answers each tool in its next step. Call it after step(), with the options of the next
    /// step and the tools where they are. Positions, velocities and multipliers stay as they are, bit for bit.
    ///
    /// @param tools  of kinds and numbers as in step(); those not engaged, and those not named, are published as away
    /// @return as step(), nothing has been published then. BadArgument also: a tool's number beyond those of create(),
    ///         a Physics or state of another size. Unsupported also: a soft layer under tools, friction.
    /// Wait-free towards readers, no allocation. O(samples columns cycles).
    DGM_PHYSICS_API Result<ComplianceReport> publish(const State& state, Physics& physics, const StepOptions& options,
                                                     std::span<const ToolInput> tools) noexcept;

    [[nodiscard]] detail::ComplianceImpl* impl() const noexcept { return impl_; }

 private:
    explicit Compliance(detail::ComplianceImpl* impl) noexcept : impl_(impl) {}
    detail::ComplianceImpl* impl_;
};

/// How a reader works.
struct ReaderOptions {
    /// Ticks over which a jump of the force between two frames is spread; 0: it is not. 0 .. 1000.
    std::uint32_t fade = 0;
    /// N s/m, 0 .. 1e6: most that the tool is damped by while the body has given more energy than it got from it, as a
    /// sum over all ticks since it was engaged [Hannaford, Ryu, "Time-domain passivity control of haptic interfaces",
    /// 2002]. A slow frame makes such energy where the tool moves quickly. 0: none.
    float damper = 0;
    float tick = 1e-3f;  ///< seconds from call to call, 1e-5 .. 1
    Allocator allocator = {};
};

/// What a tick answers to a tool.
struct ComplianceAnswer {
    Vec3 force;                  ///< N, on the tool
    std::uint32_t contacts = 0;  ///< columns that press; of a grasp 1
    std::uint64_t frame = 0;     ///< by which it was answered; 0: nothing has been published
};

/// Copy of what was last published, of one haptic thread. It must not outlive its Compliance.
class ComplianceReader {
 public:
    /// @return BadArgument (half an allocator, a number out of range), OutOfMemory.
    [[nodiscard]] DGM_PHYSICS_API static Result<ComplianceReader> create(const Compliance& from,
                                                                         const ReaderOptions& options = {}) noexcept;
    DGM_PHYSICS_API ComplianceReader(ComplianceReader&& other) noexcept;
    DGM_PHYSICS_API ComplianceReader& operator=(ComplianceReader&& other) noexcept;
    DGM_PHYSICS_API ~ComplianceReader();

    [[nodiscard]] detail::ReaderImpl* impl() const noexcept { return impl_; }

 private:
    explicit ComplianceReader(detail::ReaderImpl* impl) noexcept : impl_(impl) {}
    detail::ReaderImpl* impl_;
};

/// Answers forces of tools where they are now. A tool of another kind than was published, or that was away, feels
/// nothing until the next frame.
///
/// @param answers  one for each tool
/// @return BadArgument: a coordinate that is not finite or out of range, a number beyond those of create(), too few
///         answers. Nothing has been answered then.
/// No allocation, no locks, no waiting: where the writer overtakes the reader, the frame before serves. Bounded: at
/// most 32 sweeps over columns^2 numbers a tool.
DGM_PHYSICS_API Result<void> compliance_tick(ComplianceReader& reader, std::span<const ToolInput> tools,
                                             std::span<ComplianceAnswer> answers) noexcept;

}  // namespace dgm
