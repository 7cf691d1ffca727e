// SPDX-License-Identifier: MIT
// libdgm/include/dgm/physics.h
// Gives a chart mass and material: one implicit time step of a whole organ by multigrid on the map's own strides.
//
// Link dgm::physics beside dgm::dgm. docs/physics.md has the model, its equations, sources and limits.
//
// A step minimises  m |d - dt v - dt^2 g|^2 / (2 dt^2) + membrane + bending + foundation  over displacements d,
// without penetration of obstacles and, on closed surfaces, without change of volume. It works by conjugate gradients
// on that potential; each cycle evaluates its gradient and applies V-cycles over the strides as preconditioner.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include <dgm/allocator.h>
#include <dgm/contact.h>
#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/tick.h>
#include <dgm/vec.h>

// As DGM_API in export.h, for the library dgm::physics.
#if defined(_WIN32) && defined(DGM_BUILD_PHYSICS)
#define DGM_PHYSICS_API __declspec(dllexport)
#elif defined(_WIN32) && !defined(DGM_STATIC)
#define DGM_PHYSICS_API __declspec(dllimport)
#else
#define DGM_PHYSICS_API DGM_API
#endif

namespace dgm {

namespace detail {
struct PhysicsImpl;
struct DetailImpl;
}  // namespace detail

/// What an organ is made of, SI units. The layer `deformation` scales the membrane by its stiffness, not below 1e-3.
struct Material {
    float membrane = 200;     ///< Young's modulus times thickness, N/m: 1e-6 .. 1e12
    float poisson = 0.3f;     ///< 0 .. 0.49
    float bending = 1e-3f;    ///< N m, 0 .. 1e12: stiffness against a change of mean curvature
    float foundation = 2e4f;  ///< N/m^3, 0 .. 1e12: pull of the surrounding tissue towards the rest place
    float density = 5;        ///< kg/m^2, 1e-6 .. 1e12
    float viscosity = 0;      ///< s, 0 .. 1e6: stress by a rate of strain over that by the strain
    friend bool operator==(const Material&, const Material&) = default;
};

/// Preconditioner of the conjugate gradients.
enum class Solver : std::uint8_t {
    Multigrid,  ///< V-cycles over the strides of the map: for any size and length of step
    /// Sparse factors of the second derivatives at rest, for at most 129 x 129 samples and steps of the length that the
    /// Physics is made with: one to three cycles come within 1 % of the converged step on closed bodies. After set_dt()
    /// with another length, in steps with pins and where more than one unknown in 16 is held, multigrid does the work.
    /// Takes 0.3 s and more to make, 2 to 4 KB a sample more, and 15 to 30 KB a sample while it is made.
    Factors
};

/// How a Physics is made.
struct PhysicsOptions {
    std::optional<Material> material;  ///< nullopt: the file's (layer `material`), or Material{} where it has none
    float dt = 1e-3f;                  ///< seconds a step, 1e-5 .. 10
    double metres_per_unit = 0;        ///< length of a local unit: 1e-9 .. 1e9. 0: the file's
    bool keep_volume = true;           ///< closed surfaces; without effect on open ones
    Solver solver = Solver::Multigrid;
    bool plain_loops = false;  ///< no vector instructions beyond the baseline of the platform: same bits
    Allocator allocator = {};
    std::uint64_t max_bytes = ~std::uint64_t{0};  ///< LimitExceeded if more memory is needed
};

/// A sample that is held at a place. Samples of mobility 0 (layer `contact`) are held at rest by themselves.
struct Pin {
    std::uint32_t sample = kNone;
    Vec3 position;  ///< local coordinates
};

/// Settings of a step.
struct StepOptions {
    std::uint32_t cycles = 3;             ///< conjugate gradients, 1 .. 1000
    Vec3 gravity;                         ///< m/s^2
    std::span<const Obstacle> obstacles;  ///< at most 64 together with the tools
    std::span<const Pin> pins;            ///< their class moves with them; any number
    /// Tools are spheres of this radius, local units. A grasp holds the samples within it of the sample nearest at its
    /// start, but those that another tool holds.
    float tool_radius = 0;
    /// Stiffness of a soft layer between the surface and tools that touch, N/m^3: 1 .. 1e12. The force on a tool is
    /// then the sum of what the layer presses with, and does not jump where samples come to touch. 0: contact is hard.
    float tool_layer = 0;
    /// Coulomb's coefficient between the surface and obstacles and tools, 0 .. 100. The force along the surface is at
    /// most that times what the sample was pressed with in the step before; less than that holds it in place. What
    /// moves takes the surface along: a tool, and an obstacle of the same kind at the same place in the list as in the
    /// step before. A plane goes with its `point`, and a surface with its frame, or with its skin (Obstacle::before).
    float friction = 0;
};

/// What a step did.
struct StepReport {
    double volume_error = 0;     ///< volume / rest volume - 1, of closed surfaces that keep it
    double pressure = 0;         ///< Pa, inside over outside: the multiplier of the volume
    double residual = 0;         ///< force left unbalanced over force at the start of the step; 0 where nothing acts
    double kinetic = 0;          ///< J
    double elastic = 0;          ///< J: membrane, bending, foundation
    double layers = 0;           ///< J, in the soft layer under tools
    std::uint32_t contacts = 0;  ///< unknowns that press against obstacles or tools
    std::uint32_t cycles = 0;    ///< that were run
    bool clamped = false;        ///< the step led to numbers that are not finite, and nothing has moved
};

/// Answer to a tool.
struct StepTool {
    Vec3 force;                  ///< N, on the tool: sum of the multipliers of its contact patch, and friction
    std::uint32_t contacts = 0;  ///< unknowns in the patch
};

/// What the file of a state says of its material, layer `material`.
struct StoredMaterial {
    double metres_per_unit = 0;  ///< of local coordinates; 0: the file does not say
    std::optional<Material> material;
};
[[nodiscard]] DGM_PHYSICS_API StoredMaterial stored_material(const State& state) noexcept;

/// Stencils of all strides, velocities and displacement of one state. One thread at a time, together with its state.
/// Closed and open charts of the square domain. Memory: 1.7 KB a sample from 129 x 129 on, 1.8 KB at 33 x 33, and a
/// tenth more while it is made.
class Physics {
 public:
    /// Takes the rest shape of the state as stress-free.
    /// @return BadArgument (a number out of range, half an allocator), Unsupported (no unit here or in the file, a free
    ///         domain, a surface with one side, fewer than 3 x 3 samples), LimitExceeded (memory; a material that bends
    ///         over a length beyond the body, sqrt(bending / membrane) > diagonal), OutOfMemory.
    [[nodiscard]] DGM_PHYSICS_API static Result<Physics> create(const State& state,
                                                                const PhysicsOptions& options) noexcept;
    DGM_PHYSICS_API Physics(Physics&& other) noexcept;
    DGM_PHYSICS_API Physics& operator=(Physics&& other) noexcept;
    DGM_PHYSICS_API ~Physics();
    /// Changes the length of the next steps: 1e-5 .. 10 s. O(samples), no allocation.
    /// @return BadArgument; nothing has been changed then.
    DGM_PHYSICS_API Result<void> set_dt(float seconds) noexcept;
    /// Forgets displacement and velocity. The state is not touched.
    DGM_PHYSICS_API void reset() noexcept;
    [[nodiscard]] detail::PhysicsImpl* impl() const noexcept { return impl_; }

 private:
    explicit Physics(detail::PhysicsImpl* impl) noexcept : impl_(impl) {}
    detail::PhysicsImpl* impl_;
};

/// Advances by one step: moves the tools, solves, answers forces and writes the present shape of the state, as an
/// elastic touch of all its samples. Normals need State::update_normals() afterwards.
///
/// @param tools    kinds as in tick(); Touch and Poke both press
/// @param answers  one for each tool, or empty
/// @return BadArgument: a number is not finite or out of range, a sample that does not exist or is pinned twice, too
///         few answers, a Physics made for a state of another size, an obstacle that resolve_contact() refuses.
///         Unsupported: kinds that are not known. LimitExceeded: more than 64 obstacles and tools, or more pairs of
///         a sample and an obstacle near it than twice the samples. Nothing has been changed then.
/// No allocation, no locks. The same bits for the same calls, with plain loops and others. O(samples).
[[nodiscard]] DGM_PHYSICS_API Result<StepReport> step(State& state, Physics& physics, const StepOptions& options = {},
                                                      std::span<const ToolInput> tools = {},
                                                      std::span<StepTool> answers = {}) noexcept;

/// A state of every stride-th row and column of `fine` and the last ones, at rest, for physics that is quicker than
/// that of all samples. Local coordinates, material, stiffness and mobility are those of `fine`; quads are cut along
/// their shorter diagonal, and at stride 1 as they are. Detail shows it on `fine`.
///
/// @param stride  1 .. ; 3 x 3 samples must be left
/// @return BadArgument (stride 0, options), Unsupported (a free domain, a surface with one side, fewer than 3 x 3
///         samples, seams of which only one side has a sample at this stride), LimitExceeded, OutOfMemory.
[[nodiscard]] DGM_PHYSICS_API Result<State> coarse_state(const State& fine, std::uint32_t stride,
                                                         const StateOptions& options = {}) noexcept;

/// How the shape of a coarse state looks on all samples of the fine one: level of detail. One thread at a time,
/// together with both states. 80 bytes a coarse sample.
class Detail {
 public:
    /// @param coarse  coarse_state(fine, stride)
    /// @return BadArgument: sizes that do not fit, half an allocator. OutOfMemory.
    [[nodiscard]] DGM_PHYSICS_API static Result<Detail> create(const State& fine, const State& coarse,
                                                               std::uint32_t stride,
                                                               const Allocator& allocator = {}) noexcept;
    DGM_PHYSICS_API Detail(Detail&& other) noexcept;
    DGM_PHYSICS_API Detail& operator=(Detail&& other) noexcept;
    DGM_PHYSICS_API ~Detail();
    /// Writes the present shape of `fine`, as an elastic touch of all its samples: that of `coarse` where both have a
    /// sample; between them the rest shape, turned and stretched with the coarse one. Normals need
    /// State::update_normals() afterwards.
    ///
    /// A rigid motion is exact but for rounding, and so is an affine map of a flat surface. Where nothing moves within
    /// two coarse steps, samples keep their rest place to the bit. Copies of a class are equal to the bit.
    /// No allocation. O(samples of fine). @return BadArgument: other states than those of create(), by their sizes.
    DGM_PHYSICS_API Result<void> show(const State& coarse, State& fine) noexcept;

 private:
    explicit Detail(detail::DetailImpl* impl) noexcept : impl_(impl) {}
    detail::DetailImpl* impl_;
};

}  // namespace dgm
