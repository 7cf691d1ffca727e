// SPDX-License-Identifier: MIT
// libdgm/src/rows/rows.h
// The inner loops of a tick, built once per instruction set and chosen when a state is made.
//
// Moving samples gives the same bits in all variants: only single correctly rounded operations, more of them at a time.
// So seam copies agree whichever lane computed them. Normals may be fused (a b + c rounded once) where the processor
// can: they differ between variants by less than kNormalTolerance a component, and within one variant a sample's normal
// does not depend on the rectangle it was computed in.
#pragma once
#include <cstdint>

#include "base/inline.h"

// Loops for AVX2 and AVX-512 come with the library. GCC's own code for Windows keeps such vectors at places of the
// stack that are not aligned as its instructions require (GCC bug 54412), and crashes. An assembler that makes every
// vector move an unaligned one mends that: -Wa,-muse-unaligned-vector-move. A build that uses it defines
// DGM_UNALIGNED_MOVES, as our CMakeLists.txt does; without it, GCC on Windows gets the plain loops.
#if (defined(__x86_64__) || defined(__i386__)) && \
    (!defined(_WIN32) || defined(__clang__) || defined(DGM_UNALIGNED_MOVES))
#define DGM_HAS_AVX 1
#else
#define DGM_HAS_AVX 0
#endif

namespace dgm::detail {

/// Largest difference of a normal between variants, where the ring's corners are not sharper than 1e-3 of a full turn.
inline constexpr float kNormalTolerance = 4e-6f;

/// Samples of rows i0..i1, columns j0..j1 of the grid, ends included; empty if i0 > i1.
struct Rect {
    std::uint32_t i0 = 1, i1 = 0, j0 = 1, j1 = 0;
    [[nodiscard]] bool empty() const noexcept { return i0 > i1 || j0 > j1; }
    [[nodiscard]] std::uint32_t width() const noexcept { return j1 - j0 + 1; }
    [[nodiscard]] std::uint32_t height() const noexcept { return i1 - i0 + 1; }
    [[nodiscard]] bool holds(const Rect& r) const noexcept {
        return i0 <= r.i0 && r.i1 <= i1 && j0 <= r.j0 && r.j1 <= j1;
    }
    [[nodiscard]] bool meets(const Rect& r) const noexcept {
        return i0 <= r.i1 && r.i0 <= i1 && j0 <= r.j1 && r.j0 <= j1;
    }
    [[nodiscard]] bool has(std::uint32_t i, std::uint32_t j) const noexcept {
        return i0 <= i && i <= i1 && j0 <= j && j <= j1;
    }
    [[nodiscard]] bool operator==(const Rect&) const noexcept = default;
};

/// Grid samples as three planes: sample (i, j) of coordinate a at a[i * cols + j].
struct ConstPlanes {
    const float *x, *y, *z;
};
struct Planes {
    float *x, *y, *z;
};

/// to = from + (w * mobility) * d. Weights of row i start at weights + place(i) * weight_step, where
/// place(i) = i - i0, or |i - centre| if `mirrored`.
struct MoveJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes from;
    Planes to;
    const float* weights;
    std::uint32_t weight_step;
    bool mirrored;
    std::uint32_t centre;
    const float* mobility;  ///< plane of the grid, or null: 1
    float d[3];
};

/// now = base + factor (now - base), and base where no component differs by more than `still`. Where rounding would
/// hold a sample back for ever less than kStuck of its coordinate away, it goes one step of the floats on.
struct RelaxJob {
    Rect rect;
    std::uint32_t cols;
    Planes now;
    ConstPlanes base;
    float factor, still;
};
inline constexpr float kStuck = 0x1p-14f;

/// Unit normals of samples whose eight neighbours exist and are on the surface: area vector of the ring polygon,
/// 2A = sum of q_k x q_(k+1), as cross products of the diagonals of quadrangles.
struct NormalJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes at;
    Planes out;
    const std::uint8_t* ring;  ///< bit k: corner k is in the ring; null: corners 0 and 2 (all diagonals 0)
    float scale;               ///< power of two that brings area vectors near 1
};

struct NearestJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes at;
    float tool[3];
};

/// Boxes along axes of the caller's choice, over places from `centre` on: flat ones, along the surface, bound best.
struct BoxFrame {
    float centre[3];
    float axis[3][3];  ///< unit vectors, square to each other
};
/// Quads (i, j) of `rect`, at most 8 by 8, all with four corners in the grid.
struct QuadBoxesJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes at;
    BoxFrame frame;
};
/// Lows and highs of boxes along each axis in turn, in six planes `stride` apart; `count` is a multiple of eight, and
/// the lows of those that are none are infinite.
struct BoxesNearJob {
    const float* boxes;
    std::uint32_t stride, count;
    float low[3], high[3];  ///< of the box asked for, or a point twice
    float square;           ///< of the reach, finite, rounding allowed for by the caller
};

/// Nearer placements of a row win: key = A x^2 + B x y + C y^2 at (x + k dx, y + k dy), k = 0 .. count - 1.
struct MergeJob {
    float* key;
    float* weight;
    const float* weights;
    std::uint32_t count;
    float a, b, c;
    float x, y, dx, dy;
};

/// A block of 8 x 8 samples of the grid, or fewer at its end; or 8 border samples of a free domain, one row.
struct PatchCell {
    std::uint32_t first;  ///< sample in its first row and column
    std::uint32_t cell;   ///< number of the cell
    std::uint8_t width, height;
    std::uint64_t reach;    ///< bit 8 r + c: sample (r, c) of the cell is in reach
    std::uint64_t touched;  ///< in reach, or beside a sample that is: its normal changes
    std::uint32_t row;      ///< place of its first touched row among all
};
inline constexpr std::uint32_t kCellSamples = 64;

/// Up to 8 samples side by side.
struct PatchRow {
    std::uint32_t first;
    std::uint8_t width;
    std::uint8_t keep;  ///< bit k: a press leaves the normal of sample k as it was
};

/// Straight lines from a contact to the samples of a cell.
struct ChordJob {
    PatchCell cell;
    std::uint32_t cols;
    ConstPlanes at, normal;    ///< rest shape
    const float* rough;        ///< as StateImpl::rough
    float centre[3], axis[3];  ///< the contact and its normal
    float reach2;              ///< squared
    bool sharp;                ///< the contact lies on a crease or tip: its normal does not bound the way's beginning
    float slant2;              ///< squared sine of the angle between line and surface that is certain enough
};
struct ChordResult {
    std::uint64_t reach;
    float doubtful;  ///< square of the shortest line in reach that is too slanted; infinite if none is
    bool steep;      ///< a line is so slanted that the samples in reach are uncertain
};
inline constexpr float kSteep = 0.6f;    ///< sine: the way along the surface is at most 1.25 lines long
inline constexpr float kTurned = 0.25f;  ///< cosine of the largest angle between the normals at both ends

/// Weights of squared distances: entries k * spacing apart over distance * per_step, linear between them.
struct ProfileJob {
    std::uint64_t reach;
    const float* entries;
    std::uint32_t last;
    float per_step, spacing, end;  ///< 0 from distance `end` on
};

/// Twice the area vector of the ring of each sample, and its gain by a displacement d times the weights: area(base + w
/// d) = area(base) + d x slope. Samples on the border of the grid, and beyond it, are left out.
struct RingJob {
    const PatchRow* rows;
    std::uint32_t count, first, last, cols;  ///< rows that start at samples first .. last - 1 are done
    ConstPlanes at;
    const float* weight;       ///< plane
    const std::uint8_t* ring;  ///< bits as in NormalJob
    float scale;
    float* forms;  ///< kFormFloats a row: x, y and z of eight areas, then of eight slopes
};
inline constexpr std::uint32_t kFormFloats = 48;

/// to = from + w d. In place, or not.
struct PatchJob {
    const PatchRow* rows;
    std::uint32_t count;
    ConstPlanes from;
    Planes to;
    const float* weight;  ///< eight a row
    float d[3];
};
/// The same, and the normals.
struct PressJob {
    PatchJob move;
    Planes normal;
    const float* forms;
    const float* saved;  ///< kSavedFloats a row: x, y and z of eight normals to be kept
};
inline constexpr std::uint32_t kSavedFloats = 24;

struct RowKernels {
    const char* name;
    void (*move)(const MoveJob& job) noexcept;
    /// @return the largest component of the displacement that is left, 0 if every sample is at rest.
    float (*relax)(const RelaxJob& job) noexcept;
    /// @return false if a normal was left at 0 because its area vector is out of the range of float arithmetic.
    bool (*normals)(const NormalJob& job) noexcept;
    /// Offers every sample of a full rectangle to (d2, sample): nearer ones, of equally near ones the lowest index.
    void (*nearest)(const NearestJob& job, float& d2, std::uint32_t& sample) noexcept;
    /// Grows low/high by the samples of a full rectangle.
    void (*bounds)(ConstPlanes at, const Rect& rect, std::uint32_t cols, float* low, float* high) noexcept;
    void (*merge)(const MergeJob& job) noexcept;
    /// Box of quad (i, j), counted from the rectangle's corner, at 8 i + j of planes of 64; lows and highs of all along
    /// each axis into `whole`.
    void (*quad_boxes)(const QuadBoxesJob& job, float* boxes, float* whole) noexcept;
    /// Bit k: box k is no farther than the reach.
    std::uint64_t (*boxes_near)(const BoxesNearJob& job) noexcept;
    /// Squares of distances, in front of the certificate that patch.h explains, into d2[64]. The same bits in all
    /// variants.
    ChordResult (*chords)(const ChordJob& job, float* d2) noexcept;
    /// Squared distances in, weights out, in place; 0 for samples out of reach. The same bits in all variants.
    void (*profile)(const ProfileJob& job, float* values) noexcept;
    void (*rings)(const RingJob& job) noexcept;
    /// The same bits in all variants.
    void (*move_patch)(const PatchJob& job) noexcept;
    /// @return false if a normal is uncertain: little is left of an area vector, or it is out of the range of floats.
    bool (*press)(const PressJob& job) noexcept;
};

/// The plain loops: the compiler's code for four lanes on any target.
extern const RowKernels kPlainRows;
/// The fastest loops this processor runs; `plain` forces kPlainRows.
[[nodiscard]] const RowKernels& choose_rows(bool plain) noexcept;
/// The fastest normals beside `rows` for jobs with this ring and scale.
using NormalLoops = bool (*)(const NormalJob& job) noexcept;
[[nodiscard]] NormalLoops choose_normals(const RowKernels& rows, const std::uint8_t* ring, float scale) noexcept;

}  // namespace dgm::detail
