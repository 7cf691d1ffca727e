// SPDX-License-Identifier: MIT
// libdgm/include/dgm/contact.h
// Presses a shape against an obstacle (paper section 6): samples beyond it are projected back, and the volume that this
// removes comes out again as a bulge around the contact.
//
// There are three departures from the paper.
//  - Height. Eq. 11 bulges every sample of a ring by exp(-s^2 / sigma) D along its normal, where D is the sum of all
//    displacements: a length times a number of samples. That bulge grows with the resolution and keeps no volume.
//    Bulge::Exact scales the same bulge to the height beta at which the volume of the welded triangles is that before
//    the contact. beta comes first from the volume's gradient, then from the volume along the bulge, which is a cubic
//    in beta.
//  - Obstacle. Bulged samples that would end up beyond the obstacle are put back on it. The last steps to beta
//    therefore measure the volume.
//  - Distance. s is measured on the surface from the rim of the contact, which lies between samples. So nothing jumps
//    while the rim crosses them.
#pragma once
#include <cstdint>
#include <limits>
#include <span>

#include <dgm/allocator.h>
#include <dgm/deform.h>
#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

namespace detail {
struct ContactImpl;
}

/// Shape of an obstacle.
enum class ObstacleKind : std::uint32_t {
    Plane = 0,    ///< half space: a point p with (p - point) . normal < 0 is beyond it
    Sphere = 1,   ///< around `point`
    Capsule = 2,  ///< all points nearer than `radius` to the segment from `point` to `end`
    Box = 3,      ///< |axis . (p - point)| < half on each axis
    Surface = 4,  ///< the present shape of another state, searched through its own pyramid
};

/// A body to press against, in local coordinates of the state that is pressed. No coordinate, radius, half side or
/// reach is beyond kMaxCoordinate (limits.h).
struct Obstacle {
    ObstacleKind kind = ObstacleKind::Plane;
    /// Plane: a point of it. Sphere, box: the centre. Capsule: one end. Surface: the origin of its local frame.
    Vec3 point = {};
    Vec3 normal{0, 0, 1};                             ///< plane: towards the free side, of any length
    Vec3 end = {};                                    ///< capsule: the other end
    float radius = 0;                                 ///< sphere, capsule: > 0
    Vec3 half = {};                                   ///< box: half its sides, > 0
    float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< box, surface: own frame to the state's, rows first
    State* surface = nullptr;                         ///< only its pyramid is written: it is brought up to date
    /// Surface: samples farther behind it than this are taken to be on its other side. 0: no limit for a closed
    /// surface, four of its mean steps for an open one.
    float reach = 0;
    /// Surface, in a step of physics or a frame of cloth: where its samples were in the one before, as a copy of
    /// State::positions() from then. Friction goes with a skin that bends and stretches, then, and the substeps of
    /// cloth meet its samples on their way; without, friction goes with the frame alone. Read during the call, where
    /// the surface was written since the step before and its frame was there.
    PointView before = {};
};

/// How the surface around a contact bulges.
enum class Bulge : std::uint32_t {
    Exact = 0,  ///< volume kept
    Paper = 1,  ///< eq. 11 as printed
    None = 2,
};

/// Row of the paper's table of R and sigma by D.
struct RingSize {
    float total = 0;  ///< the row applies to D up to this; the last row to any D
    float reach = 0;  ///< R, local units, 1e-15 .. 1e18
    float sigma = 0;  ///< local units squared, 1e-30 .. 1e36
};

/// Settings of a contact.
struct ContactOptions {
    float max_depth = std::numeric_limits<float>::infinity();  ///< dS_max: farthest that a single sample may move
    float max_total = std::numeric_limits<float>::infinity();  ///< dT_max: farthest that all may move, summed
    Bulge bulge = Bulge::Exact;  ///< Exact takes 1 to 1.5 times as long as Paper, whose error is many times the volume
    /// At most 16 rows, ascending `total`. Empty: R is half the radius of a disk as large as the contact, but at least
    /// two mean steps, and sigma is R^2 / 4.
    std::span<const RingSize> rings = {};
    DeformMode mode = DeformMode::Elastic;
    /// Open surfaces: how often the displacement is averaged with that of the neighbours in the ring; 0 .. 64.
    std::uint32_t smoothing = 8;
};

/// Outcome of a contact.
enum class ContactStatus : std::uint32_t {
    Clear = 0,     ///< nothing is beyond the obstacle
    Contact = 1,   ///< projected, and bulged if the options ask for it
    Restored = 2,  ///< a limit was exceeded: the shape is as it was before the call, bit for bit
    Open = 3,      ///< the surface has a border or one side, hence no volume: projected and smoothed
};

/// Effect of a contact.
struct ContactReport {
    ContactStatus status = ContactStatus::Clear;
    bool volume_kept = false;              ///< |volume_error| <= 1e-6; never on an open surface
    bool sunk = false;                     ///< samples that may not move (mobility) are still beyond the obstacle
    std::uint32_t samples = 0;             ///< in contact (Phi); a weld class counts once, as in the two sums below
    float deepest = 0;                     ///< largest |d_ij|
    float total = 0;                       ///< D, sum of |d_ij|
    std::uint32_t ring = 0;                ///< bulged samples (Psi); seam copies count
    float ring_reach = 0, ring_sigma = 0;  ///< R and sigma in use
    float beta = 0;                        ///< height of the bulge at the rim
    std::uint32_t passes = 0;              ///< bulged volumes that were computed or measured
    double removed = 0;                    ///< volume that the projection removed; positive for outward normals
    double volume_error = 0;       ///< volume gained by the call / removed, measured on the triangles within 1e-8
    double first_order_error = 0;  ///< the same for beta by the gradient alone, before clamping
    double paper_error = 0;        ///< the same for eq. 11 as printed
};

/// Scratch memory for contacts of one state (about 40 bytes a sample and 50 KB), and the constants of its surface.
class ContactSolver {
 public:
    /// @return OutOfMemory, LimitExceeded beyond `max_bytes`, BadArgument (half an allocator).
    [[nodiscard]] DGM_API static Result<ContactSolver> create(const State& state, const Allocator& allocator = {},
                                                              std::uint64_t max_bytes = ~std::uint64_t{0}) noexcept;
    DGM_API ContactSolver(ContactSolver&& other) noexcept;
    DGM_API ContactSolver& operator=(ContactSolver&& other) noexcept;
    DGM_API ~ContactSolver();
    /// Says whether every edge of the welded surface has two faces that wind alike, so that it encloses a volume.
    [[nodiscard]] DGM_API bool closed() const noexcept;
    /// Volume of the present shape by its welded triangles; 0 if it is open or has one side. O(samples).
    [[nodiscard]] DGM_API double volume(const State& state) const noexcept;
    /// The same, but refuses by name. @return Unsupported if the surface has one side or a border (the message says
    ///         which), BadArgument if the solver was made for a state of another size.
    [[nodiscard]] DGM_API Result<double> enclosed_volume(const State& state) const noexcept;
    [[nodiscard]] detail::ContactImpl* impl() const noexcept { return impl_; }

 private:
    explicit ContactSolver(detail::ContactImpl* impl) noexcept : impl_(impl) {}
    detail::ContactImpl* impl_;
};

/// Moves the present shape out of an obstacle. Seam copies stay equal; mobility (layer `contact`) scales the
/// displacement of a sample. Elastic contacts end with State::release(), as touches do; plastic ones are permanent.
/// Normals need State::update_normals() afterwards.
///
/// A depth below 2e-7 of the largest coordinate counts as none, so that a shape at rest stays unchanged.
/// @return BadArgument: an obstacle, limit or ring that is not finite (limits may be infinite) or out of range, a
///         matrix that is no rotation, a surface that is the state itself, a solver made for another state.
///         Unsupported kind, bulge or mode. NotFound: the obstacle is a surface without triangles. On an error nothing
///         has been changed.
/// No allocation, no locks. O(samples in contact and ring), for surfaces times a search of their pyramid.
[[nodiscard]] DGM_API Result<ContactReport> resolve_contact(State& state, const ContactSolver& solver,
                                                            const Obstacle& obstacle,
                                                            const ContactOptions& options = {}) noexcept;

/// Distance of a point from an obstacle, negative beyond it, and the nearest point of its border.
struct ObstacleDistance {
    float distance = 0;
    Vec3 nearest;
};
/// Measures the distance; to a Surface it is exact for the triangles. @return as resolve_contact().
[[nodiscard]] DGM_API Result<ObstacleDistance> obstacle_distance(const Obstacle& obstacle, Vec3 point) noexcept;

}  // namespace dgm
