// SPDX-License-Identifier: MIT
// libdgm/include/dgm/state.h
// The deformable copy of a chart: rest shape, permanent shape, present shape, seam classes, search pyramid, scratch.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/allocator.h>
#include <dgm/asset.h>
#include <dgm/map_view.h>
#include <dgm/result.h>

namespace dgm {

namespace detail {
struct StateImpl;
}

/// "No sample": what class and sample indices hold when there is none.
inline constexpr std::uint32_t kNone = 0xFFFFFFFFu;

struct StateOptions {
    std::uint32_t max_reach = 65;  ///< largest kernel reach b and tracking window a + 1 this state will be asked for
    std::uint64_t max_bytes = ~std::uint64_t{0};  ///< refuse to take more memory than this
    Allocator allocator = {};
};

/// Shape of one chart that tools can touch. Independent of the Asset once created.
///
/// Memory: about 48 bytes a sample, all taken at creation; no later call allocates. One thread at a time.
/// Copies of a seam class hold the same bits at all times.
class State {
 public:
    /// Decodes the geometry and checks the chart's values (validate_chart).
    /// @return MissingLayer without geometry, what validate_chart answers, LimitExceeded, OutOfMemory, BadArgument.
    [[nodiscard]] DGM_API static Result<State> create(const Chart& chart, const StateOptions& options = {}) noexcept;
    DGM_API State(State&& other) noexcept;
    DGM_API State& operator=(State&& other) noexcept;
    DGM_API ~State();

    [[nodiscard]] DGM_API std::uint32_t rows() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t cols() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    /// Present shape and rest shape, local coordinates, samples in the order of Chart::sample_count().
    [[nodiscard]] DGM_API PointView positions() const noexcept;
    [[nodiscard]] DGM_API PointView rest_positions() const noexcept;
    [[nodiscard]] DGM_API bool on_surface(std::uint32_t sample) const noexcept;

    [[nodiscard]] DGM_API std::uint32_t class_count() const noexcept;
    /// Seam class of a sample, or kNone.
    [[nodiscard]] DGM_API std::uint32_t class_of(std::uint32_t sample) const noexcept;
    /// All samples of a class, ascending; the first is the representative. Empty if there is no such class.
    [[nodiscard]] DGM_API std::span<const std::uint32_t> class_members(std::uint32_t id) const noexcept;

    /// Area-weighted unit normal of the present shape over the welded ring; 0 where there is no area or no sample.
    [[nodiscard]] DGM_API Vec3 normal(std::uint32_t sample) const noexcept;

    /// Ends every elastic touch: the present shape becomes the permanent one where it was touched. O(touched tiles).
    DGM_API void release() noexcept;
    /// Back to rest, plastic deformation included. O(samples).
    DGM_API void reset() noexcept;

    /// For the library's own functions.
    [[nodiscard]] detail::StateImpl* impl() noexcept { return impl_; }
    [[nodiscard]] const detail::StateImpl* impl() const noexcept { return impl_; }

 private:
    explicit State(detail::StateImpl* impl) noexcept : impl_(impl) {}
    detail::StateImpl* impl_;
};

}  // namespace dgm
