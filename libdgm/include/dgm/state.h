// SPDX-License-Identifier: MIT
// libdgm/include/dgm/state.h
// The deformable copy of a chart: rest shape, permanent shape, present shape, seam classes, search pyramid, scratch.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/allocator.h>
#include <dgm/asset.h>
#include <dgm/limits.h>
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
    bool metric = false;  ///< @deprecated without effect
    /// Tools that tick() tells apart; at most 64. 0 for states that are never given to tick(): a seventh of the memory
    /// less.
    std::uint32_t max_tools = 4;
    bool plain_loops = false;  ///< do without the processor's vector instructions beyond the baseline
};

/// What a state costs.
struct StateUsage {
    std::uint64_t bytes = 0;  ///< taken from the allocator, all at creation
    std::uint32_t samples = 0;
    std::uint32_t active_samples = 0;  ///< present shape may differ from the permanent one: what release() looks at
    std::uint32_t dirty_samples = 0;   ///< moved since update_normals()
};

/// Shape of one chart that tools can touch. Independent of the Asset once created.
///
/// Memory: about 130 bytes a sample, all taken at creation; no later call allocates. One thread at a time. Copies of a
/// seam class hold the same bits at all times.
class State {
 public:
    /// Decodes the geometry, and stiffness and mobility if there are such layers, and checks the chart's values
    /// (validate_chart).
    /// @return MissingLayer without geometry, what validate_chart answers, LimitExceeded, OutOfMemory, BadArgument.
    [[nodiscard]] DGM_API static Result<State> create(const Chart& chart, const StateOptions& options = {}) noexcept;
    DGM_API State(State&& other) noexcept;
    DGM_API State& operator=(State&& other) noexcept;
    DGM_API ~State();

    [[nodiscard]] DGM_API std::uint32_t rows() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t cols() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    /// Present shape and rest shape, local coordinates, samples in the order of Chart::sample_count(). The memory stays
    /// in place; what fades is brought up to date when the view is asked for, so ask again after tick() or relax().
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
    /// The same for all samples, as of the last update_normals() or tick(); ask again after these.
    [[nodiscard]] DGM_API PointView normals() const noexcept;
    /// Brings normals() up to date where the shape was touched since. O(touched samples).
    DGM_API void update_normals() noexcept;
    /// Square root of the mean area of a rest quad: the length of a grid step, on the whole; at least 1e-15, and 1
    /// where there is no area.
    [[nodiscard]] DGM_API float mean_step() const noexcept;
    [[nodiscard]] DGM_API StateUsage usage() const noexcept;
    /// Instruction set in use: "plain" or "avx2" (with AVX-512 for the normals of uniform diagonals where there is it).
    [[nodiscard]] DGM_API const char* loops() const noexcept;

    /// Ends every elastic touch: the present shape becomes the permanent one where it was touched. O(touched samples).
    DGM_API void release() noexcept;
    /// Lets elastic touches fade: the elastic displacement of every sample is multiplied by exp(-rate * dt). What is
    /// left of it below 1e-6 mean steps goes at once, so that work ends. rate in 1/s, infinity is release(); dt in s.
    /// @return BadArgument if either is negative or NaN, or dt is infinite; nothing has been changed then.
    DGM_API Result<void> relax(float dt, float rate) noexcept;
    /// Back to rest, plastic deformation included. O(samples).
    DGM_API void reset() noexcept;

    /// For the library's own functions: up to date, or as tick() left it.
    [[nodiscard]] detail::StateImpl* impl() noexcept { return settled(); }
    [[nodiscard]] const detail::StateImpl* impl() const noexcept { return settled(); }
    [[nodiscard]] detail::StateImpl* unsettled() noexcept { return impl_; }

 private:
    [[nodiscard]] DGM_API detail::StateImpl* settled() const noexcept;
    explicit State(detail::StateImpl* impl) noexcept : impl_(impl) {}
    detail::StateImpl* impl_;
};

}  // namespace dgm
