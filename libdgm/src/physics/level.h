// SPDX-License-Identifier: MIT
// libdgm/src/physics/level.h
// One grid of the multigrid solver: every second row and column of the finer one, seam classes as one unknown.
#pragma once
#include <cstdint>

#include "base/memory.h"
#include "physics/kernels.h"

namespace dgm::detail::physics {

/// Rows of a sparse matrix.
struct Rows {
    Array<std::uint32_t> start, col;
    [[nodiscard]] std::uint32_t count() const noexcept {
        return start.empty() ? 0 : static_cast<std::uint32_t>(start.size() - 1);
    }
};

/// Samples and unknowns of one stride. An unknown is a sample or a whole seam class; all copies of a class hold the
/// same bits in every field at all times.
struct Level {
    std::uint32_t rows = 0, cols = 0, grid = 0, dofs = 0;
    Array<std::uint32_t> dof_of;     ///< by sample
    Array<std::uint32_t> sample_of;  ///< by unknown: its first sample
    Array<std::uint32_t> copies;     ///< pairs (copy, first)

    Rows matrix;                 ///< pattern of A by unknown
    Array<double> value;         ///< A without `extra`
    Array<std::uint32_t> place;  ///< where in `stencil` each value stands
    Rows up, down;               ///< interpolation from the coarser level by fine unknown, and its transpose
    Array<float> up_weight, down_weight;
    Array<std::uint32_t> odd_up, odd_down;  ///< unknowns, here and on the coarser level, that are not between samples

    Array<float> planes;
    Field x, r, d0, d1, kept;
    float *diagonal = nullptr, *own = nullptr;
    float *extra[2] = {}, *inverse[2] = {};  ///< of both factors; inverse: of the diagonal with `extra`
    Array<float>
        stencil;  ///< kNear entries, blocked; 0 at rows of `rim`; the row of a class is the sum over its copies
    Array<std::uint32_t> rim;   ///< unknowns whose row does not fit into the stencils of their samples
    Array<std::uint32_t> late;  ///< samples of `rim`, and first samples of classes
    Rows rim_rows;              ///< columns are samples
    Array<float> rim_value, rim_now, late_now;
    double largest = 0;  ///< bound of the eigenvalues of D^-1 A

    [[nodiscard]] std::size_t count() const noexcept { return whole_blocks(grid); }
};

/// Floats before and after each plane that loops may read.
[[nodiscard]] constexpr std::size_t pad_of(std::uint32_t cols) noexcept {
    return whole_blocks(2 * std::size_t{cols} + 2 + kBlock);
}
/// Floats of one padded plane.
[[nodiscard]] constexpr std::size_t plane_size(std::uint32_t rows, std::uint32_t cols) noexcept {
    return whole_blocks(std::size_t{rows} * cols) + 2 * pad_of(cols);
}
/// Hands out padded planes of one array.
class PlaneCutter {
 public:
    PlaneCutter(Array<float>& from, std::uint32_t rows, std::uint32_t cols) noexcept
        : at_(from.data() + pad_of(cols)), step_(plane_size(rows, cols)) {}
    [[nodiscard]] float* plane() noexcept {
        float* p = at_;
        at_ += step_;
        return p;
    }
    [[nodiscard]] Field field() noexcept {
        Field f;
        for (float*& p : f.p) p = plane();
        return f;
    }

 private:
    float* at_;
    std::size_t step_;
};

inline constexpr std::uint32_t kMostLevels = 14;
inline constexpr std::uint32_t kDirect = 25;  ///< unknowns solved directly; a grid of 5 x 5 has no more

/// The matrix that is solved for, of fourth order, as a product of two of second order: scale (A + E0) M^-1 (A + E1),
/// M the masses, A level[0].value, E0 and E1 its `extra`.
enum class Factors : std::uint8_t {
    One,   ///< A + E0 alone
    Same,  ///< E0 = E1
    Two    ///< E1 = E0 + apart M
};
struct Multigrid {
    Level level[kMostLevels];
    std::uint32_t levels = 0;
    const Kernels* kernels = nullptr;
    Factors factors = Factors::One;
    int steps = 4;  ///< of the smoother, before and after
    double apart = 0, scale = 1;
    const float* mass = nullptr;               ///< plane of level[0]
    double factor[2][kDirect * kDirect] = {};  ///< Cholesky factors of the coarsest matrices
    bool sound = false;                        ///< they exist: the matrix is positive definite
};

/// Builds all coarser levels of level[0], whose samples, unknowns and matrix pattern are given. @return false: no
/// memory.
[[nodiscard]] bool build_levels(Multigrid& m, const Allocator& allocator) noexcept;
/// Unknowns of `level` from dof_of: sample_of, copies. @return false: no memory.
[[nodiscard]] bool list_unknowns(Level& level, const Allocator& allocator) noexcept;
/// Takes over level[0].value: coarse matrices P^T A P, stencils, diagonals, smoother. No allocation. O(samples).
void take_values(Multigrid& m) noexcept;
/// Takes over level[0].extra[0], a diagonal matrix that is added to A, and makes extra[1] if there are two factors. No
/// allocation.
void take_extra(Multigrid& m) noexcept;
/// Bounds the eigenvalues of D^-1 A on each level. No allocation.
void bound_eigenvalues(Multigrid& m) noexcept;
/// level[0].x is about the inverse of the product of both factors times level[0].r, one V-cycle for each inverse of a
/// factor; level[0].r is overwritten. The map from r to x is linear, symmetric and positive definite.
void run_cycle(Multigrid& m) noexcept;
/// All copies of an unknown get the value of the sample that holds it.
void share_copies(const Level& level, const Field& f) noexcept;

}  // namespace dgm::detail::physics
