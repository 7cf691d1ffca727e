// SPDX-License-Identifier: MIT
// libdgm/include/dgm/cloth.h
// Gives a chart the mass and material of cloth: it hangs, folds, falls on things and rubs against them.
//
// Link dgm::cloth beside dgm::dgm. docs/cloth.md has the model, its equations, sources and limits.
//
// Each substep is an implicit one: it lowers  m |d - h v - h^2 g|^2 / (2 h^2) + membrane + bending + contacts  by one
// step of Newton's method or more, whose matrix multigrid solves on the map's own strides. Where nothing moves, forces
// balance exactly, whatever the number of cycles.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include <dgm/allocator.h>
#include <dgm/contact.h>
#include <dgm/physics.h>
#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/tick.h>
#include <dgm/vec.h>

// As DGM_API in export.h, for the library dgm::cloth.
#if defined(_WIN32) && defined(DGM_BUILD_CLOTH)
#define DGM_CLOTH_API __declspec(dllexport)
#elif defined(_WIN32) && !defined(DGM_STATIC)
#define DGM_CLOTH_API __declspec(dllimport)
#else
#define DGM_CLOTH_API DGM_API
#endif

namespace dgm {

namespace detail {
struct ClothImpl;
}

/// What a cloth is made of, SI units. Warp threads lead along columns of the map (from row to row), weft across them.
/// The layer `deformation` scales warp, weft, cross and shear by its stiffness, not below 1e-3.
struct Fabric {
    float warp = 2000;      ///< N/m, Young's modulus times thickness: 1e-3 .. 1e9
    float weft = 2000;      ///< N/m, 1e-3 .. 1e9
    float cross = 0;        ///< N/m, stress along one by strain along the other: at most 0.95 sqrt(warp weft)
    float shear = 400;      ///< N/m, 1e-6 .. 1e9
    float bending = 1e-5f;  ///< N m, 0 .. 1e9: stiffness against a change of mean curvature
    float density = 0.2f;   ///< kg/m^2, 1e-6 .. 1e6
    float damping = 0.5f;   ///< 1/s, 0 .. 1e6: air takes so much of the velocity
    friend bool operator==(const Fabric&, const Fabric&) = default;
};

/// What the layer `material` of the file says (`dgm-bake --material denim`), the same in all directions:
/// warp = weft = membrane / (1 - nu^2), cross = nu warp, shear = (1 - nu) warp / 2. Damping is that of a Fabric.
/// Empty: it names none.
[[nodiscard]] DGM_CLOTH_API std::optional<Fabric> stored_fabric(const State& state) noexcept;

/// How a Cloth is made.
struct ClothOptions {
    Fabric fabric;
    double metres_per_unit = 0;  ///< length of a local unit: 1e-9 .. 1e9. 0: the file's
    /// Metres. Samples stay half of it away from obstacles, and all of it from other parts of the cloth if that is
    /// asked for. 0 .. the mean grid step; 0 without self-contact is allowed.
    float thickness = 1e-3f;
    bool self_contact = false;  ///< layers of the cloth keep apart
    bool plain_loops = false;   ///< no vector instructions beyond the baseline of the platform: same bits
    Allocator allocator = {};
    std::uint64_t max_bytes = ~std::uint64_t{0};  ///< LimitExceeded if more memory is needed
};

/// Settings of a frame.
struct ClothStep {
    float dt = 1.0f / 60;        ///< seconds, 1e-5 .. 10
    std::uint32_t substeps = 2;  ///< 1 .. 100; tools and obstacles go a part of their way in each
    std::uint32_t cycles = 1;    ///< of conjugate gradients in a substep, 1 .. 100
    std::uint32_t levels = 0;    ///< strides that are used, for measurements. 0: all
    Vec3 gravity;                ///< m/s^2
    /// Coulomb's coefficient, 0 .. 100. What moves takes cloth along, as StepOptions::friction says (physics.h).
    float friction = 0.3f;
    std::span<const Obstacle> obstacles;  ///< at most 64 together with the tools
    std::span<const Pin> pins;            ///< their class moves with them; any number
    /// Tools are spheres of this radius, local units. A grasp holds the samples within it of the sample nearest at its
    /// start.
    float tool_radius = 0;
};

/// What a frame did.
struct ClothReport {
    double kinetic = 0;          ///< J
    double elastic = 0;          ///< J: membrane and bending
    double potential = 0;        ///< J, of gravity, by the place at rest
    double residual = 0;         ///< of the last substep: force left unbalanced over force at its start
    std::uint32_t contacts = 0;  ///< unknowns that press against obstacles or tools
    std::uint32_t touches = 0;   ///< pairs of a sample and a triangle of the cloth itself that were kept apart
    bool clamped = false;        ///< the frame led to numbers that are not finite, and nothing has moved
};

/// Stencils of all strides, velocities and place of one cloth. One thread at a time, together with its state. Charts of
/// the square domain without mask; seams are sewn. Memory: 0.6 to 0.9 KB a sample.
class Cloth {
 public:
    /// Takes the rest shape of the state as free of stress.
    /// @return BadArgument (a number out of range, half an allocator), Unsupported (no unit here or in the file, a free
    ///         domain, a surface with one side, fewer than 3 x 3 samples), LimitExceeded (memory), OutOfMemory.
    [[nodiscard]] DGM_CLOTH_API static Result<Cloth> create(const State& state, const ClothOptions& options) noexcept;
    DGM_CLOTH_API Cloth(Cloth&& other) noexcept;
    DGM_CLOTH_API Cloth& operator=(Cloth&& other) noexcept;
    DGM_CLOTH_API ~Cloth();
    /// Takes the present shape of the state as its place, without velocity: where it is laid out before it is let go,
    /// or after State::reset() its rest shape.
    /// @return BadArgument: a state of another size. Nothing has been changed then.
    DGM_CLOTH_API Result<void> take_shape(const State& state) noexcept;
    [[nodiscard]] detail::ClothImpl* impl() const noexcept { return impl_; }

 private:
    explicit Cloth(detail::ClothImpl* impl) noexcept : impl_(impl) {}
    detail::ClothImpl* impl_;
};

/// Advances by one frame and writes the present shape of the state, as an elastic touch of all its samples. Normals
/// need State::update_normals() afterwards.
///
/// @param tools    kinds as in tick(); Touch and Poke both press
/// @param answers  one for each tool, or empty; forces are the mean over the frame
/// @return BadArgument: a number is not finite or out of range, a sample that does not exist or is pinned twice, too
///         few answers, a Cloth made for a state of another size, an obstacle that resolve_contact() refuses.
///         Unsupported: kinds that are not known. LimitExceeded: more than 64 obstacles and tools. Nothing has been
///         changed then.
/// No allocation, no locks. The same bits for the same calls, with plain loops and others. O(samples).
[[nodiscard]] DGM_CLOTH_API Result<ClothReport> step(State& state, Cloth& cloth, const ClothStep& options = {},
                                                     std::span<const ToolInput> tools = {},
                                                     std::span<StepTool> answers = {}) noexcept;

}  // namespace dgm
