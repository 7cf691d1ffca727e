// SPDX-License-Identifier: MIT
// libdgm/include/dgm/contact.h
// A shape against an obstacle, paper section 6: samples beyond it are projected back, and the volume they take with
// them comes out again as a bulge around the contact.
//
// Three departures from the paper. It bulges every sample of a ring by exp(-s^2 / sigma) D along its normal, D being
// the sum of all displacements (eq. 11): a length times a number of samples, so that the bulge grows with the
// resolution and keeps no volume. Bulge::Exact gives the same bulge the height beta at which the volume of the welded
// triangles is that before the contact: beta from the volume's gradient, then from the cubic it is along the bulge,
// then, since bulged samples that would end up beyond the obstacle are put back on it, from the volume measured. And s
// is measured on the surface from the rim of the contact, which lies between samples, so that nothing jumps while the
// rim crosses them.
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

enum class ObstacleKind : std::uint32_t {
    Plane = 0,    ///< half space: beyond is where (p - point) . normal < 0
    Sphere = 1,   ///< around `point`
    Capsule = 2,  ///< all that is nearer than `radius` to the segment from `point` to `end`
    Box = 3,      ///< |axis . (p - point)| < half on each axis
    Surface = 4,  ///< the present shape of another state, searched through its own pyramid
};

/// All coordinates are local ones of the state that is pressed against it, and none, nor a radius, half side or reach,
/// is beyond kMaxCoordinate (limits.h).
struct Obstacle {
    ObstacleKind kind = ObstacleKind::Plane;
    Vec3 point = {};       ///< plane: a point of it. Sphere, box: centre. Capsule: one end. Surface:
                           ///< where the origin of its local frame lies
    Vec3 normal{0, 0, 1};  ///< plane: towards the free side, of any length
    Vec3 end = {};         ///< capsule: the other end
    float radius = 0;      ///< sphere, capsule: > 0
    Vec3 half = {};        ///< box: half its sides, > 0
    float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< box, surface: own frame to the state's, rows first
    State* surface = nullptr;                         ///< not written but for its pyramid, which is brought up to date
    /// Surface: samples farther behind it than this are taken to be on its other side. 0: no limit for a closed one,
    /// four of its mean steps for an open one.
    float reach = 0;
};

enum class Bulge : std::uint32_t {
    Exact = 0,  ///< volume kept
    Paper = 1,  ///< eq. 11 as printed
    None = 2,
};

/// Row of the paper's table of R and sigma by D.
struct RingSize {
    float total = 0;  ///< for D up to this (the last row: for any D)
    float reach = 0;  ///< R, local units, 1e-15 .. 1e18
    float sigma = 0;  ///< local units squared, 1e-30 .. 1e36
};

struct ContactOptions {
    float max_depth = std::numeric_limits<float>::infinity();  ///< dS_max: most a single sample may be moved
    float max_total = std::numeric_limits<float>::infinity();  ///< dT_max: most they all may be, summed
    Bulge bulge = Bulge::Exact;  ///< 1 to 1.5 times the time of Paper, which is off by many times the volume taken
    /// At most 16, ascending `total`. Empty: R is half the radius of a disk as large as the contact (but two mean steps
    /// at least), sigma = R^2 / 4.
    std::span<const RingSize> rings = {};
    DeformMode mode = DeformMode::Elastic;
    /// Open surfaces: how often the displacement is averaged with that of the neighbours in the ring; 0 .. 64.
    std::uint32_t smoothing = 8;
};

enum class ContactStatus : std::uint32_t {
    Clear = 0,     ///< nothing is beyond the obstacle
    Contact = 1,   ///< projected, and bulged if that was asked for
    Restored = 2,  ///< a limit was exceeded: the shape is as it was before the call, bit for bit
    Open = 3,      ///< the surface has a border, hence no volume: projected and smoothed
};

struct ContactReport {
    ContactStatus status = ContactStatus::Clear;
    bool volume_kept = false;              ///< |volume_error| <= 1e-6; never on an open surface
    bool sunk = false;                     ///< samples that may not move (mobility) are still beyond the obstacle
    std::uint32_t samples = 0;             ///< in contact (Phi), each seam class once, as in the two sums below
    float deepest = 0;                     ///< largest |d_ij|
    float total = 0;                       ///< D, sum of |d_ij|
    std::uint32_t ring = 0;                ///< bulged samples (Psi), copies counted
    float ring_reach = 0, ring_sigma = 0;  ///< R and sigma in use
    float beta = 0;                        ///< height of the bulge at the rim
    std::uint32_t passes = 0;              ///< bulged volumes worked out or measured
    double removed = 0;                    ///< volume the projection took; positive for outward normals
    double volume_error = 0;       ///< volume gained by the call / removed, measured on the triangles within 1e-8
    double first_order_error = 0;  ///< the same for beta by the gradient alone, before clamping
    double paper_error = 0;        ///< and for eq. 11 as printed
};

/// Scratch memory for contacts of one state (about 40 bytes a sample and 50 KB), and what of its surface never changes.
class ContactSolver {
 public:
    /// @return OutOfMemory, LimitExceeded beyond `max_bytes`, BadArgument (half an allocator).
    [[nodiscard]] DGM_API static Result<ContactSolver> create(const State& state, const Allocator& allocator = {},
                                                              std::uint64_t max_bytes = ~std::uint64_t{0}) noexcept;
    DGM_API ContactSolver(ContactSolver&& other) noexcept;
    DGM_API ContactSolver& operator=(ContactSolver&& other) noexcept;
    DGM_API ~ContactSolver();
    /// Every edge of the welded surface has two sides: it encloses a volume.
    [[nodiscard]] DGM_API bool closed() const noexcept;
    /// Volume of the present shape by its welded triangles; 0 if it is open. O(samples).
    [[nodiscard]] DGM_API double volume(const State& state) const noexcept;
    [[nodiscard]] detail::ContactImpl* impl() const noexcept { return impl_; }

 private:
    explicit ContactSolver(detail::ContactImpl* impl) noexcept : impl_(impl) {}
    detail::ContactImpl* impl_;
};

/// Puts the present shape out of an obstacle. Copies of a seam class stay equal; mobility (layer `contact`) scales what
/// a sample moves. Elastic contacts end with State::release(), as touches do; plastic ones are permanent. Normals
/// follow at State::update_normals().
///
/// A step beyond the obstacle of less than 2e-7 of the largest coordinate is none: a shape that rests is left alone.
/// @return BadArgument: an obstacle, limit or ring that is not finite (limits may be infinite) or out of range, a
///         rotation that is none, a surface that is the state itself, a solver made for another state. Unsupported
///         kind, bulge or mode. NotFound: the obstacle is a surface without triangles. On an error nothing has been
///         changed.
/// No allocation, no locks. O(samples in contact and ring), for surfaces times a search of their pyramid.
[[nodiscard]] DGM_API Result<ContactReport> resolve_contact(State& state, const ContactSolver& solver,
                                                            const Obstacle& obstacle,
                                                            const ContactOptions& options = {}) noexcept;

/// Distance of a point from an obstacle, negative beyond it, and the nearest point of its border.
struct ObstacleDistance {
    float distance = 0;
    Vec3 nearest;
};
/// @return as resolve_contact(). To a Surface: exact distance to its triangles.
[[nodiscard]] DGM_API Result<ObstacleDistance> obstacle_distance(const Obstacle& obstacle, Vec3 point) noexcept;

}  // namespace dgm
