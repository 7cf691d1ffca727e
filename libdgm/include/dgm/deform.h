// SPDX-License-Identifier: MIT
// libdgm/include/dgm/deform.h
// Deforms a state around a contact, paper eq. 7:
//     d(P_ij) = d_c * exp(-((i - i_c)^2 + (j - j_c)^2) / sigma),  |i - i_c|, |j - j_c| < b.
//
// "The paper" in these headers is Liu, Prakash and Srinivasan, "Interactive deformable geometry maps", The Visual
// Computer 23 (2007) 119-131.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/allocator.h>
#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

namespace detail {
struct TableImpl;
}

/// How the weight of a touch falls with the distance from the contact.
enum class KernelShape : std::uint32_t {
    Circular = 0,  ///< eq. 7
    Elliptic = 1,  ///< exp(-(x / radius_a)^2 - (y / radius_b)^2), with axes rotated by `angle`
    User = 2,      ///< `values`: weights at equally spaced distances 0 .. b, linear between them, 0 beyond b
};

/// How the kernel ends at b.
enum class KernelEnd : std::uint32_t {
    /// Eq. 7 as printed: a square window, with a step of at most exp(-b^2 / sigma) * |d_c| at its rim.
    Printed = 0,
    /// Value and slope are 0 at distance b, and the weight is 0 beyond. With r = distance / sqrt(sigma) and
    /// R = b / sqrt(sigma) it is
    ///     (exp(-r^2) - exp(-R^2) (1 + R^2 - r^2)) / (1 - exp(-R^2) (1 + R^2)),
    /// which differs from eq. 7 by at most (1 + R^2) exp(-R^2) inside the disk of radius b.
    Compact = 1,
};

/// The kernel of eq. 7.
struct KernelOptions {
    KernelShape shape = KernelShape::Circular;
    KernelEnd end = KernelEnd::Printed;  ///< as the paper; Compact takes no longer and differs by 0.3 % of the depth
    /// Squared grid steps, 1e-6 .. 1e12 (limits.h): 2 std^2 in eq. 7 (the paper says std). With b = 11, 16 leaves 5e-4
    /// of the depth at the rim.
    float sigma = 16;
    std::uint32_t reach = 11;  ///< b of eq. 7: samples with |di| < b and |dj| < b move; 1 .. kMaxReach
    /// Elliptic: distances in grid steps at which the weight is 1/e along both axes (a circle of radius r is
    /// sigma = r^2), and the angle of axis a in radians, from the row direction (+i) towards the column direction (+j).
    /// Radii lie in 1e-3 .. 1e6; the longer one is at most 1e4 times the shorter one. The compact end is 0 on the
    /// ellipse of these proportions that touches distance b.
    float radius_a = 4, radius_b = 4, angle = 0;
    /// User: 2 .. 65536 finite weights in [-1, 1]; copied. `end` and `sigma` have no effect on them.
    std::span<const float> values = {};
};

/// Largest reach of a kernel, grid steps.
inline constexpr std::uint32_t kMaxReach = 1024;

/// The kernel's values for one (sigma, b, shape), computed once. Immutable: any number of threads and states share it.
class DeformTable {
 public:
    /// @return BadArgument (sigma, a radius, their ratio, reach or values out of range, angle not finite),
    ///         Unsupported shape or end, OutOfMemory.
    [[nodiscard]] DGM_API static Result<DeformTable> create(const KernelOptions& options,
                                                            const Allocator& allocator = {}) noexcept;
    DGM_API DeformTable(DeformTable&& other) noexcept;
    DGM_API DeformTable& operator=(DeformTable&& other) noexcept;
    DGM_API ~DeformTable();

    /// Returns the weight at an offset in grid steps, 0 outside the window. Whole offsets read the table; others
    /// (border samples of a free domain) evaluate the formula.
    [[nodiscard]] DGM_API float weight(float di, float dj) const noexcept;
    /// Largest difference between weight() and the kernel in exact arithmetic.
    [[nodiscard]] DGM_API float error_bound() const noexcept;
    /// Returns the weight at a distance in grid steps, by linear interpolation in the table that footprints by distance
    /// and painted stiffness read. For an elliptic kernel the distance is along its longer axis.
    [[nodiscard]] DGM_API float profile(float distance) const noexcept;
    /// Largest difference between profile() and the kernel: h^2 / 4 for entries h apart in units of sqrt(sigma), plus
    /// rounding.
    [[nodiscard]] DGM_API float profile_error_bound() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t reach() const noexcept;

    [[nodiscard]] const detail::TableImpl* impl() const noexcept { return impl_; }

 private:
    explicit DeformTable(detail::TableImpl* impl) noexcept : impl_(impl) {}
    detail::TableImpl* impl_;
};

/// Which samples a touch moves, and how much: the distance that replaces that of eq. 7.
enum class Footprint : std::uint32_t {
    /// The default: distance along the rest surface, across seams and never to a near sheet; cut at distance b.
    /// Straight lines give the distance as far as the weights are certain to be within 6 % of the peak; beyond that, a
    /// front runs over the triangles. The footprint of a contact is kept while the tool stays there.
    Surface = 0,
    Metric = 1,    ///< @deprecated the same as Surface, whatever StateOptions::metric
    Geodesic = 2,  ///< the same, with weights within 1 % of the peak
    /// Eq. 7 as printed: distance in grid steps. It is right only where the map is isometric up to scale. At a seam the
    /// mate's grid is laid beside this one as if steps were equally long on both sides, and samples count that no
    /// straight line through that piece of seam reaches. A touch there can move samples 20 half radii away, and tear
    /// the shape.
    Grid = 3,
};

/// How long a touch or a contact lasts.
enum class DeformMode : std::uint32_t {
    Elastic = 0,  ///< adds to the present shape until State::release()
    Plastic = 1,  ///< adds to the permanent shape too
};

/// One touch of a tool.
struct Touch {
    std::uint32_t sample = 0;  ///< the contact (i_c, j_c) as a sample index; any copy of a weld class will do
    Vec3 displacement;         ///< d_c, local units: into the surface pushes, out of it pulls; within kMaxCoordinate
    float d_max = 0;           ///< |d_c| is shortened to this; > 0
    Footprint footprint = Footprint::Surface;
    DeformMode mode = DeformMode::Elastic;
    /// All footprints but Grid: local length that counts as one grid step of the kernel, 1e-15 .. 1e15.
    /// 0: State::mean_step().
    float step = 0;
};

/// Effect of a touch.
struct DeformReport {
    std::uint32_t samples = 0;  ///< samples in reach; seam copies count
    Vec3 displacement;          ///< d_c after it was shortened to d_max
    bool crossed_seam = false;
    /// Grid alone: the footprint was cut short by more windings around cut nodes than kMaxFrames.
    bool truncated = false;
};

/// Footprint::Grid: a window is unfolded into at most this many placed copies of the chart.
inline constexpr std::uint32_t kMaxFrames = 128;

/// Applies eq. 7 around a contact sample.
///
/// A seam is no border: distances continue beyond it, every copy of a weld class gets one weight and is written with
/// the same bits. Footprint::Grid unfolds the mate's grid next to this one: outward here is inward there, and one step
/// along the seam is one step on either side. A sample with several places in the window takes the nearest one, and a
/// class takes the weight of its nearest copy. Away from seams that is eq. 7 exactly. At the border of a free domain
/// the unfolding is a walk from sample to sample in order of distance, and each sample is placed where it is first met.
///
/// The footprints of the last two contacts are kept: another touch at one of them, by a kernel of the same values, only
/// writes. A new contact looks once at the samples around it where straight lines give their distances; where the
/// surface is strongly curved it takes some ten times as long.
///
/// Two layers count if the chart has them: painted stiffness k (0 .. 1, `deformation`) of a sample makes its sigma
/// k * sigma, and mobility (0 .. 1, `contact`) multiplies its displacement.
///
/// Touches add up. For a tool that presses elastically, call state.release() (or relax()) first in each tick and then
/// deform() once for each contact, or use tick(). Normals need State::update_normals() afterwards.
///
/// @return BadArgument: sample not on the surface, d_c beyond kMaxCoordinate, d_max not finite or <= 0, table.reach()
///         beyond StateOptions::max_reach, step out of range. LimitExceeded: Footprint::Grid, more samples in reach
///         than the state's scratch memory has room for (many sheets around one seam node). Unsupported footprint or
///         mode. On every error nothing has been changed.
/// No allocation, no locks. O(b^2).
[[nodiscard]] DGM_API Result<DeformReport> deform(State& state, const DeformTable& table, const Touch& touch) noexcept;

}  // namespace dgm
