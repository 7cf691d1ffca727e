// SPDX-License-Identifier: MIT
// libdgm/src/physics/physics_impl.h
// Memory of a Physics. Lengths are metres, forces newtons; fields hold the same bits at all copies of a class.
#pragma once
#include <dgm/physics.h>

#include "base/double3.h"
#include "contact/scene.h"
#include "physics/factor.h"
#include "physics/level.h"
#include "touch/state_impl.h"

namespace dgm::detail {

namespace physics {

inline constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the physics"};
inline constexpr float kFlat = 0.5f;  ///< see model.cpp
#ifdef DGM_NO_FRICTION                // pages: as small as can be
inline constexpr bool kFriction = false;
#else
inline constexpr bool kFriction = true;
#endif

[[nodiscard]] inline Double3 point(const Field& f, std::size_t k) noexcept {
    return {f.p[0][k], f.p[1][k], f.p[2][k]};
}

/// A sample and the obstacle it may touch; sorted by obstacle, then sample.
struct Touching {
    std::uint32_t sample = kNone, obstacle = kNone;
    Double3 normal;         ///< out of the obstacle
    double gap = 0;         ///< without displacement in this step, metres
    double stiffness = 0;   ///< N/m
    double multiplier = 0;  ///< at the start of the step, N; >= 0
    double force = 0;       ///< now
    bool met = false;       ///< had a force at some time in this step
    bool moves = true;      ///< the obstacle is not as in the step before
    bool slides = false;    ///< friction is `hold`, and part of `inertial`
    double blunt = 0;       ///< soft layer: depth at which all of the sample's cell is in touch, metres; 0: hard
    float most = 0;         ///< of the force of friction, N: the coefficient times what the step before pressed with
    Vec3 slid = {};         ///< way along the obstacle that friction has yet to take back, metres
    Vec3 hold = {};         ///< friction at the start of the step, N, on the sample; after it, at its end
    [[nodiscard]] bool soft() const noexcept { return blunt > 0; }
    [[nodiscard]] bool rubs() const noexcept { return kFriction && most > 0; }
    /// Whether friction is part of the potential of contacts.
    [[nodiscard]] bool sticks() const noexcept { return rubs() && !slides; }
    /// The part along the obstacle.
    [[nodiscard]] Double3 flat(Double3 v) const noexcept { return v - dot(normal, v) * normal; }
};

/// Force of a contact, its growth by depth, and its energy.
struct Press {
    double force = 0, stiffness = 0, energy = 0;
};
[[nodiscard]] Press press_of(const Touching& t, double gap) noexcept;

/// Friction of a contact.
struct Rub {
    Double3 force;         ///< N, on the sample
    Double3 along;         ///< way along the obstacle, metres
    double energy = 0;     ///< J
    double stiffness = 0;  ///< N/m; where it slides, across the force alone
    bool slides = false;
};
/// @param way  of the sample in this step, metres
[[nodiscard]] Rub rub_of(const Touching& t, Double3 way) noexcept;

[[nodiscard]] inline bool is_tool(const Touching& t) noexcept {
    return t.obstacle < Scene::kMost;
}

/// Samples a side of the tiles that look at obstacles.
inline constexpr std::uint32_t kTile = 8;

/// Box of a tile, local units.
struct Tile {
    Double3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    [[nodiscard]] Double3 centre() const noexcept { return 0.5 * (low + high); }
    /// Of a ball around it.
    [[nodiscard]] double radius() const noexcept {
        const Double3 half = 0.5 * (high - low);
        return std::sqrt(dot(half, half));
    }
    [[nodiscard]] Box box() const noexcept {
        return {{static_cast<float>(low.x), static_cast<float>(low.y), static_cast<float>(low.z)},
                {static_cast<float>(high.x), static_cast<float>(high.y), static_cast<float>(high.z)}};
    }
};

/// A surface that tiles have seen.
struct SurfaceSeen {
    std::uint32_t obstacle = kNone;
    double way = 0;  ///< that it has gone since it was first seen, at most; local units
};

/// How a sample sees an obstacle.
struct Sight {
    Probe there;                           ///< where it is near
    std::uint64_t triangle = kNoTriangle;  ///< of a surface, that was found
    bool near = false;                     ///< may touch in this step
};

/// Place of a sample relative to the tool that grasps it.
struct Grasped {
    std::uint32_t sample, tool;
    Double3 offset;      ///< metres
    Double3 aim;         ///< displacement that the tool asks for in this step
    double stiffness;    ///< N/m
    Double3 multiplier;  ///< N
    Double3 force;       ///< now, on the sample
};

/// A quad's triangles are (a, b, third) and (first, c, d); see kernels_impl.h.
struct Triangle {
    std::uint32_t corner[3];  ///< samples
    std::size_t quad;
    int which;  ///< 0 or 1
};

}  // namespace physics

struct PhysicsImpl {
    explicit PhysicsImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    PhysicsOptions options;
    Material material;  ///< of the options, or the file
    std::uint32_t rows = 0, cols = 0, total = 0;
    double scale = 1;  ///< metres per local unit
    bool closed = false;
    physics::Multigrid solver;
    physics::Factor factor;       ///< preconditioner instead of the multigrid, in steps of its length
    float shear = 0, dilate = 0;  ///< Lame's constants times thickness, N/m
    double rest_volume = 0;       ///< m^3

    Array<float> planes;
    physics::Field rest, moved;     ///< centred; displacement as the loops see it
    physics::Field delta, before;   ///< of this step
    physics::Field inertial;        ///< where mass would go without forces
    physics::Field velocity;        ///< m/s
    physics::Field target;          ///< displacement that the foundation pulls to
    physics::Field smooth;          ///< gradient of the potential without contacts and grasps
    physics::Field gradient, area;  ///< of all of it; twice the area vectors around a sample
    physics::Field push;            ///< `area` of which the constraint of volume is made, 0 where held
    physics::Field curvature, moment, twist, corner[4], face[2];
    physics::Field swell;  ///< A^-1 of the gradient of the volume
    physics::Field way, fresh, last, smooth_before;
    physics::Field rest_normal;
    float *energy = nullptr, *bent = nullptr, *other = nullptr, *modulus = nullptr, *height = nullptr;
    float *mass = nullptr, *anchor = nullptr, *free = nullptr;  ///< kg, N/m of the foundation, 1 or 0: held
    float* is_quad = nullptr;                   ///< 1 at samples with a quad (i, j), 0 at the last row and column
    float* weight = nullptr;                    ///< kg: M of the solver's product of factors
    float *firm = nullptr, *pressed = nullptr;  ///< N/m: diagonal of the matrix; stiffness of grasps and contacts
    float* grip = nullptr;                      ///< N/m: stiffness of a grasp or contact
    float* give = nullptr;                      ///< m/N: 1 / (firm + pressed), 0 at copies
    float* stretch[6] = {};                     ///< at the end of the step before; null without viscosity
    Array<float> quads, near, near_turned;      ///< see kernels.h
    Array<double> at[3];                        ///< displacement from rest
    Array<double> laplace, membrane;            ///< Laplacian, and times stiffness, by solver.level[0].matrix
    Array<double> membrane_firm, other_firm;    ///< diagonals of membrane (times 1 + viscosity / dt) and the rest
    Array<std::uint32_t> next_copy;             ///< of the class of a sample, or kNone
    Array<std::uint32_t> followers;             ///< pairs (unknown without a triangle, sample that it follows)
    Array<physics::Touching> touching[2];       ///< as `scene`: of this step and of the one before
    Scene scene[2];
    static constexpr std::uint32_t kSurfaces = 4;  ///< obstacles with memory for searches: further ones have none
    Array<NearTiles> near_tiles;                   ///< by surface
    Array<physics::Tile> tiles;                    ///< before the step
    Array<Surroundings> tiles_seen;                ///< by surface and tile: of its middle
    physics::SurfaceSeen surface_seen[kSurfaces];  ///< that `tiles_seen` is of
    Array<physics::Sight> sights;                  ///< of a row of tiles
    std::uint32_t touching_count = 0, touching_now = 0;
    Array<physics::Grasped> grasped;
    std::uint32_t grasped_count = 0;
    float hold = 0;             ///< entry of `extra` that stands for a held sample on coarser levels
    bool driven = false;        ///< a pin moves in this step
    bool few_held = true;       ///< no pins, and few samples are pressed or grasped
    std::uint64_t holding = 0;  ///< bit by tool number
    double elastic = 0;         ///< at the end of the step before, J
    double pressure = 0;
    Array<std::uint8_t> pinned;  ///< by unknown, while a step runs: 1 by a pin, 2 by a pin where it was held anyway
    double layer = 0;            ///< of tools in this step, N/m^3; 0: hard
    double unsure = 0;           ///< of `elastic`: at most about so much below what evaluate() would find
    double energy_before = 0;    ///< kinetic and elastic, at the start of the step
    double elastic_before = 0;   ///< J, at the start of the step
    double at_rest = 0;          ///< inertial part of the potential without displacement in this step
    double friction = 0;         ///< coefficient in this step

    [[nodiscard]] physics::Level& fine() noexcept { return solver.level[0]; }
    [[nodiscard]] const physics::Level& fine() const noexcept { return solver.level[0]; }
    /// Whether the factors are the preconditioner of this step: they know nothing of pins and contacts.
    [[nodiscard]] bool factored() const noexcept { return physics::kFactors && factor.dt == options.dt && few_held; }
    [[nodiscard]] physics::Quads on() const noexcept {
        return {fine().count(), static_cast<std::ptrdiff_t>(cols), quads.data(), other, rest, moved};
    }
};

namespace physics {

/// Planes, unknowns, rest shape, stencils and matrices of a state's rest shape. @return OutOfMemory, LimitExceeded.
[[nodiscard]] Result<void> build_model(PhysicsImpl& p, const StateImpl& s) noexcept;
/// Values of all matrices for options.dt.
void take_step_length(PhysicsImpl& p) noexcept;

/// What a step refuses: BadArgument, Unsupported, LimitExceeded.
[[nodiscard]] Result<void> check_tools(const StepOptions& o, std::span<const ToolInput> tools,
                                       std::size_t answers) noexcept;
[[nodiscard]] Result<void> check_step(const PhysicsImpl& p, const StateImpl& s, const StepOptions& o) noexcept;
/// Marks pinned unknowns. @return false, and nothing is marked: one is pinned twice.
[[nodiscard]] bool mark_pins(PhysicsImpl& p, std::span<const Pin> pins) noexcept;
/// Samples of marked pins are not free until they are released.
void hold_pins(PhysicsImpl& p, std::span<const Pin> pins) noexcept;
void release_pins(PhysicsImpl& p, std::span<const Pin> pins) noexcept;

/// Parts of the potential whose minimum is the implicit step, J.
struct Potential {
    double elastic = 0;   ///< membrane, bending, foundation
    double inertial = 0;  ///< 1/2 m |delta - inertial|^2 / dt^2
    double contact = 0;
    [[nodiscard]] double sum() const noexcept { return elastic + inertial + contact; }
};
/// Potential without contacts and grasps at `delta`, and its gradient `smooth`; also `area`.
[[nodiscard]] Potential evaluate(PhysicsImpl& p) noexcept;
/// gradient = smooth + that of contacts and grasps at `delta`. @return their potential
double press(PhysicsImpl& p) noexcept;
/// First and second derivative of the potential of contacts and grasps at delta + step way.
struct Slope {
    double first = 0, second = 0;
};
[[nodiscard]] Slope pressed_slope(const PhysicsImpl& p, const Field& way, double step) noexcept;
/// Lists the samples that may touch what is in the scene beside `touching_now`, with the multipliers that they had, and
/// makes that scene the present one. @return false, and nothing is changed: there are too many.
[[nodiscard]] bool find_touching(PhysicsImpl& p, const StateImpl& s) noexcept;
/// Puts the friction of samples that their mass alone keeps sliding into `inertial`, where it needs no search.
void let_slide(PhysicsImpl& p) noexcept;
/// Begins and ends grasps, and aims those that hold. A sample that a tool holds is not taken by another.
void move_grasps(PhysicsImpl& p, const StateImpl& s, std::span<const ToolInput> tools, float radius) noexcept;
/// Stiffness of pins, grasps and contacts on the diagonal.
void take_holds(PhysicsImpl& p) noexcept;
/// What acts on a body in a step.
enum class Outside : std::uint8_t {
    Nothing,
    Obstacles,  ///< those that are as in the step before: they do no work
    AtRest,     ///< tools, too
    Moving
};
[[nodiscard]] Outside outside(const PhysicsImpl& p) noexcept;
/// Multipliers for the next step, after one whose way is in `before`.
void keep_multipliers(PhysicsImpl& p) noexcept;
/// How a body that nothing outside holds moves as a whole.
struct Drift {
    double mass = 0, mean[3] = {};  ///< mean by mass; 0 if the body is held, or has a foundation
    double energy = 0;              ///< mass |mean|^2 / 2
};
/// Whether samples are held, or a foundation holds them all.
[[nodiscard]] bool is_held(const PhysicsImpl& p) noexcept;
[[nodiscard]] Drift drift_of(const PhysicsImpl& p, const Field& of) noexcept;
/// Moves a body that nothing holds as a whole to where it lowers inertia and contacts, whose potential is `contact`.
/// `before` is where it was. @return what inertia gains, J
[[nodiscard]] double move_whole(PhysicsImpl& p, double contact) noexcept;
/// Minimises the potential from `delta` on. @return false: nothing lower was found, or numbers overflowed.
[[nodiscard]] bool minimise(PhysicsImpl& p, std::uint32_t cycles, StepReport& report) noexcept;

/// Volume of rest + at + delta + step * way, m^3.
[[nodiscard]] double volume_of(const PhysicsImpl& p, const Field& delta, double step, const Field* way) noexcept;
/// to_class = sum over its copies.
void sum_classes(const PhysicsImpl& p, const Field& f) noexcept;

}  // namespace physics
}  // namespace dgm::detail
