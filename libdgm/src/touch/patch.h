// SPDX-License-Identifier: MIT
// libdgm/src/touch/patch.h
// Footprints by distance on the surface: which samples a contact moves, and how much.
//
// A footprint depends on the rest surface, the contact and the kernel alone, and a tool at a thousand ticks a second
// stays at one sample for several of them. So it is kept as a patch, cells of 8 x 8 samples with a weight each, until
// the contact is another one.
//
// Distances come from the straight lines in space ("chords") between the contact and the samples where these are
// certain to give the distance on the surface, else from windows that run over the triangles (geodesic.cpp). Where a
// chord from the contact meets the surface at sample x under an angle of sine s to the tangent plane, its length c has
// a gradient of sqrt(1 - s^2) along the surface. So following it downhill from x leads to the contact, on a way of at
// most c / sqrt(1 - S^2), S being the largest sine along the way: the distance lies between c and that. The way cannot
// leave the searched part of the surface, and the search finds open borders that the way could meet. Within these
// bounds the length of a cubic with the chord as its base and tangent to the surface at both ends is taken, which is
// right to fourth order.
#pragma once
#include <cstdint>

#include <dgm/deform.h>

#include "base/memory.h"
#include "rows/rect_list.h"
#include "rows/rows.h"

namespace dgm::detail {

struct StateImpl;
struct TableImpl;
struct Contact;

/// All inputs that a patch depends on.
struct PatchKey {
    std::uint32_t sample = 0xFFFFFFFFu;  ///< representative
    float step = 0;
    bool exact = false;            ///< Footprint::Geodesic
    std::uint64_t kernel[2] = {};  ///< TableImpl::hash
    [[nodiscard]] bool operator==(const PatchKey&) const noexcept = default;
};

struct Patch {
    PatchKey key;
    Array<PatchCell> cells;
    Array<PatchRow> rows;  ///< those touched
    Array<float> weight;   ///< 8 a row, mobility is in it; while the patch is made 64 a cell
    std::uint32_t count = 0, row_count = 0;
    std::uint32_t samples = 0;  ///< in reach, copies counted
    bool crossed_seam = false;
    RectList moved;          ///< around the samples in reach
    RectList touched;        ///< and around those whose normals turn
    std::uint64_t used = 0;  ///< StateImpl::patch_clock when it was last asked for
    /// While the patch is made.
    [[nodiscard]] float* weights(std::uint32_t cell) noexcept { return weight.data() + std::size_t{64} * cell; }
};

/// Memory for making patches; empty between calls.
struct PatchScratch {
    Array<std::uint32_t> slot_of;      ///< cell -> its place in the patch that is being made, or kNone
    Array<std::uint8_t> flags;         ///< by cell, kCell*
    std::uint32_t rows = 0, cols = 0;  ///< of cells
    [[nodiscard]] std::uint32_t grid_cells() const noexcept { return rows * cols; }
};
inline constexpr std::uint8_t kCellSeams = 1;      ///< contains samples of weld classes
inline constexpr std::uint8_t kCellRim = 2;        ///< holds samples of an open border
inline constexpr std::uint8_t kCellFree = 4;       ///< holds samples off the surface or corners of a strip
inline constexpr std::uint8_t kCellIrregular = 8;  ///< holds samples whose normals are summed one by one

/// Cells a side of the largest press: a window of the largest reach.
[[nodiscard]] constexpr std::uint64_t press_cells(std::uint32_t max_reach) noexcept {
    return std::uint64_t{max_reach} / 4 + 3;
}
/// Takes memory for the state's patches and for the press. @return false if there is none.
[[nodiscard]] bool make_patches(StateImpl& state, bool press) noexcept;
/// The patch of a contact: one that is kept, or a new one in place of the one that was not asked for for longest.
[[nodiscard]] Patch& patch_of(StateImpl& state, const TableImpl& table, const Contact& contact) noexcept;

/// Place of a cell in the patch; a new one has no sample in reach and weights of 0.
[[nodiscard]] std::uint32_t add_cell(StateImpl& state, Patch& patch, std::uint32_t cell) noexcept;
[[nodiscard]] std::uint32_t cell_of(const StateImpl& state, std::uint32_t sample) noexcept;
/// Place of a sample among the 64 of its cell.
[[nodiscard]] std::uint32_t place_in_cell(const StateImpl& state, std::uint32_t sample) noexcept;
/// Place of row 0 .. 7 of a cell among the rows of a patch.
[[nodiscard]] inline std::uint32_t row_of(const PatchCell& cell, std::uint32_t row) noexcept {
    std::uint32_t at = cell.row;
    for (std::uint32_t k = 0; k < row; ++k) at += (cell.touched >> (8 * k) & 255) != 0 ? 1 : 0;
    return at;
}
/// Sample at a place of a cell.
[[nodiscard]] inline std::uint32_t sample_in(const PatchCell& cell, std::uint32_t place, std::uint32_t cols) noexcept {
    return cell.first + (place >> 3) * cols + (place & 7);
}
template <class Visit>
void each_bit(std::uint64_t bits, Visit visit) noexcept {
    for (; bits != 0; bits &= bits - 1) visit(static_cast<std::uint32_t>(__builtin_ctzll(bits)));
}

/// Roughness above which a way is taken to begin and end under the same angle to its chord.
inline constexpr float kSharp = 0.02f;
/// Fills an empty patch by chords. @return false where they are uncertain; the patch is empty again then.
[[nodiscard]] bool fill_by_chords(StateImpl& state, const TableImpl& table, const Contact& contact,
                                  Patch& patch) noexcept;
/// The same by windows over the triangles, anywhere.
void fill_by_front(StateImpl& state, const TableImpl& table, const Contact& contact, Patch& patch) noexcept;

/// Kernels with a direction, and stiffness: they turn the distance to a sample into its weight.
class Weigher {
 public:
    Weigher(const StateImpl& state, const TableImpl& table, const Contact& contact) noexcept;
    /// Distance alone decides, at every sample in the same way.
    [[nodiscard]] bool even() const noexcept { return even_; }
    /// At `distance` kernel steps.
    [[nodiscard]] float at(std::uint32_t sample, float distance) const noexcept;

 private:
    const StateImpl& s_;
    const TableImpl& t_;
    Vec3 contact_;
    bool even_;
    Vec3 u_{}, v_{};  ///< tangents at the contact
};

/// An elastic touch by one patch, applied to the normals at once: area vectors are linear in the displacement
/// (RingJob), so a tick at the same contact looks at no neighbours.
struct PatchPress {
    bool active = false;  ///< now = base + weight d of `patch`, and nothing else is elastic
    const Patch* patch = nullptr;
    PatchKey key;
    Vec3 d;
    std::uint64_t moved = 0;  ///< StateImpl::moved at the end of the last tick
    Array<float> plane;       ///< weights by sample, 0 between calls; read up to kPad beyond its ends
    static constexpr std::uint32_t kPad = 16;
    Array<float> forms;          ///< as RingJob
    Array<float> saved;          ///< 24 floats a row: normals of the base shape
    std::uint32_t capacity = 0;  ///< rows
};
/// One elastic contact on a surface that springs back at once, with its normals. @return false if it is another case.
[[nodiscard]] bool press_patch(StateImpl& state, const TableImpl& table, const Contact& contact,
                               DeformReport& report) noexcept;

}  // namespace dgm::detail
