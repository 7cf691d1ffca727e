// SPDX-License-Identifier: MIT
// libdgm/include/dgm/state.h
// Creates the deformable copy of a chart: rest, permanent and present shape, weld classes, search pyramid, scratch
// memory.
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

class State;
struct StateOptions;
namespace detail {
struct ChartTables;
struct StateImpl;
[[nodiscard]] DGM_API Result<State> create_state(const ChartTables& tables, const StateOptions& options) noexcept;
}  // namespace detail

/// Index that stands for no sample or no class.
inline constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// Sizes and limits of a state.
struct StateOptions {
    std::uint32_t max_reach = 65;  ///< largest kernel reach b and tracking window a + 1 that will be used: 1 .. 1024
    std::uint64_t max_bytes = ~std::uint64_t{0};  ///< LimitExceeded if more memory is needed
    Allocator allocator = {};
    bool metric = false;  ///< @deprecated without effect
    /// Number of different tools in tick(), at most 64. 0 for states that tick() never gets: they need a seventh less
    /// memory.
    std::uint32_t max_tools = 4;
    bool plain_loops = false;  ///< use no vector instructions beyond the baseline of the platform
};

/// Memory of a state, and work that is due.
struct StateUsage {
    std::uint64_t bytes = 0;  ///< taken from the allocator, all at creation
    std::uint32_t samples = 0;
    std::uint32_t active_samples = 0;  ///< present shape may differ from the permanent one: release() visits these
    std::uint32_t dirty_samples = 0;   ///< moved since update_normals()
};

/// A chart's shape that tools can touch. Independent of the Asset once created.
///
/// Memory: about 130 bytes a sample, all taken at creation; no later call allocates. One thread at a time. Copies of a
/// weld class have the same bits at all times; on a surface with one side (layer `reversed`) reversed copies have the
/// opposite normal, to the bit.
class State {
 public:
    /// Decodes the geometry, and stiffness and mobility if there are such layers, and checks the chart's values as
    /// validate_chart() does.
    /// @return MissingLayer without geometry, an error of validate_chart(), LimitExceeded, OutOfMemory, BadArgument.
    [[nodiscard]] DGM_API static Result<State> create(const Chart& chart, const StateOptions& options = {}) noexcept;
    DGM_API State(State&& other) noexcept;
    DGM_API State& operator=(State&& other) noexcept;
    DGM_API ~State();

    [[nodiscard]] DGM_API std::uint32_t rows() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t cols() const noexcept;
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    /// Present shape and rest shape, local coordinates, samples in the order of Chart::sample_count(). The memory stays
    /// in place. The call brings faded displacements up to date, so call again after tick() or relax().
    [[nodiscard]] DGM_API PointView positions() const noexcept;
    [[nodiscard]] DGM_API PointView rest_positions() const noexcept;
    [[nodiscard]] DGM_API bool on_surface(std::uint32_t sample) const noexcept;

    [[nodiscard]] DGM_API std::uint32_t class_count() const noexcept;
    /// Weld class of a sample, or kNone.
    [[nodiscard]] DGM_API std::uint32_t class_of(std::uint32_t sample) const noexcept;
    /// All samples of a class, ascending; the first is the representative. Empty if there is no such class.
    [[nodiscard]] DGM_API std::span<const std::uint32_t> class_members(std::uint32_t id) const noexcept;

    /// Area-weighted unit normal of the present shape over the triangles around a sample, across seams; 0 where there
    /// is no area or no sample.
    [[nodiscard]] DGM_API Vec3 normal(std::uint32_t sample) const noexcept;
    /// Normals of all samples, as of the last update_normals() or tick(); call again after these.
    [[nodiscard]] DGM_API PointView normals() const noexcept;
    /// Brings normals() up to date where the shape was touched since. O(touched samples).
    DGM_API void update_normals() noexcept;
    /// Square root of the mean area of a rest quad: the typical length of a grid step. At least 1e-15, and 1 for a
    /// surface without area.
    [[nodiscard]] DGM_API float mean_step() const noexcept;
    [[nodiscard]] DGM_API StateUsage usage() const noexcept;
    /// Instruction set in use: "plain" or "avx2" (which uses AVX-512 for the normals of uniform diagonals if it can).
    [[nodiscard]] DGM_API const char* loops() const noexcept;

    /// Ends every elastic touch: the present shape becomes the permanent one where it was touched. O(touched samples).
    DGM_API void release() noexcept;
    /// Lets elastic touches fade: multiplies the elastic displacement of every sample by exp(-rate * dt). Displacements
    /// below 1e-6 mean steps are set to zero. rate in 1/s, infinity is release(); dt in s.
    /// @return BadArgument if either is negative or NaN, or dt is infinite; nothing has been changed then.
    DGM_API Result<void> relax(float dt, float rate) noexcept;
    /// Returns to the rest shape and ends plastic deformation too. O(samples).
    DGM_API void reset() noexcept;

    /// For the library's own functions: impl() is up to date, unsettled() is as tick() left it.
    [[nodiscard]] detail::StateImpl* impl() noexcept { return settled(); }
    [[nodiscard]] const detail::StateImpl* impl() const noexcept { return settled(); }
    [[nodiscard]] detail::StateImpl* unsettled() noexcept { return impl_; }

 private:
    [[nodiscard]] DGM_API detail::StateImpl* settled() const noexcept;
    explicit State(detail::StateImpl* impl) noexcept : impl_(impl) {}
    friend Result<State> detail::create_state(const detail::ChartTables& tables, const StateOptions& options) noexcept;
    detail::StateImpl* impl_;
};

}  // namespace dgm
