// SPDX-License-Identifier: MIT
// libdgm/src/touch/state.cpp
#include <dgm/state.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <dgm/deform.h>

#include "touch/state_impl.h"

namespace dgm {
namespace detail {
namespace {

std::uint64_t walk_capacity(std::uint64_t total, std::uint64_t max_reach) noexcept {
    // A window of (2b - 1)^2 steps holds more samples than that where several sheets meet at one seam node, each copy
    // bringing at most half a turn: eight sheets are nodes of 16 cut paths.
    const std::uint64_t side = 2 * max_reach - 1;
    return std::min<std::uint64_t>(total, 8 * side * side);
}

bool make_scratch(StateImpl& s, std::uint32_t max_tools) noexcept {
    const Allocator& a = s.allocator;
    const std::uint64_t capacity = walk_capacity(s.total(), s.max_reach);
    if (s.tables.free_domain) {
        if (!s.walk.slot_of.allocate(a, s.total(), kNone) || !s.walk.nodes.allocate(a, capacity) ||
            !s.walk.heap.allocate(a, capacity) || !s.walk.visited.allocate(a, capacity))
            return false;
    }
    FootprintScratch& f = s.footprint;
    if (!f.key.allocate(a, s.total(), std::numeric_limits<float>::infinity()) || !f.weight.allocate(a, s.total()) ||
        !f.samples.allocate(a, s.total()) || !f.classes.allocate(a, s.class_count) ||
        !f.class_seen.allocate(a, s.class_count))
        return false;
    if (!make_geodesics(s)) return false;
    return s.tools.allocate(a, max_tools);
}

std::uint32_t patches_for(const StateOptions& o) noexcept {
    return o.max_tools == 0 ? 1 : StateImpl::kMostPatches;
}

/// Upper bound of the memory of create(), for StateOptions::max_bytes.
std::uint64_t bytes_needed(const ChartTables& t, const StateOptions& o) noexcept {
    const std::uint64_t walk = t.free_domain ? walk_capacity(t.total, o.max_reach) * (sizeof(WalkNode) + 8) : 0;
    const std::uint64_t tiles = (std::uint64_t{tile_count(t.rows - 1)} * tile_count(t.cols - 1));
    const std::uint64_t cells =
        ((std::uint64_t{t.rows} + 7) / 8) * ((std::uint64_t{t.cols} + 7) / 8) + (t.total - t.grid) / 8 + 1;
    const std::uint64_t side = press_cells(o.max_reach);
    const std::uint64_t patches =
        cells * (5 + patches_for(o) * (sizeof(PatchCell) + 8 * sizeof(PatchRow) + kCellSamples * sizeof(float))) +
        (o.max_tools == 0 ? 0 : std::min(cells, side * side) * kCellSamples * 9 * sizeof(float));
    // Footprints: key, weight and list of samples; fading: time, displacement and two lists of tiles.
    return surface_bytes(t) + patches + std::uint64_t{t.total} * (12 + kGeodesicSample) + walk + tiles * 20 +
           o.max_tools * sizeof(ToolSlot) + sizeof(StateImpl) +
           geodesic_bytes(t.rows, t.cols, t.faces.size(), o.max_reach) + 8192;
}

/// Where the permanent shape, which the present one is, is not the rest shape: rows between their first and last such
/// sample.
RectList unlike_rest(const StateImpl& s) noexcept {
    RectList moved;
    const auto unlike = [&](std::uint32_t k) {
        const Vec3 a = StateImpl::at(s.base, k), b = StateImpl::at(s.rest, k);
        return std::memcmp(&a, &b, sizeof a) != 0;
    };
    for (std::uint32_t i = 0; i < s.tables.rows; ++i) {
        Rect row{i, i, 0, s.tables.cols - 1};
        const std::uint32_t first = i * s.tables.cols;
        while (row.j0 < s.tables.cols && !unlike(first + row.j0)) ++row.j0;
        if (row.j0 == s.tables.cols) continue;
        while (!unlike(first + row.j1)) --row.j1;
        moved.add(row);
    }
    for (std::uint32_t k = s.tables.grid; k < s.total(); ++k)
        if (unlike(k)) moved.add_border(k);
    return moved;
}

Result<void> fill(StateImpl& s, const ChartTables& tables, const StateOptions& options) noexcept {
    if (bytes_needed(tables, options) > options.max_bytes) return over_max_bytes();
    s.max_reach = options.max_reach;
    if (auto r = fill_surface(s, tables, options.plain_loops); !r) return r;
    s.patch_count = patches_for(options);
    if (!make_fading(s) || !make_scratch(s, options.max_tools) || !make_patches(s, options.max_tools != 0))
        return kNoStateMemory;
    return {};
}
}  // namespace

Result<State> create_state(const ChartTables& tables, const StateOptions& options) noexcept {
    if (!is_valid(options.allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (options.max_reach < 1 || options.max_reach > kMaxReach)
        return Error{ErrorCode::BadArgument, kNoOffset, "max_reach is not in 1..1024"};
    if (options.max_tools > 64) return Error{ErrorCode::BadArgument, kNoOffset, "max_tools is beyond 64"};
    StateImpl* impl = create<StateImpl>(options.allocator, options.allocator);
    if (impl == nullptr) return kNoStateMemory;
    State state(impl);
    if (auto r = fill(*impl, tables, options); !r) return r.error();
    return state;
}
}  // namespace detail

Result<State> State::create(const Chart& chart, const StateOptions& options) noexcept {
    auto found = detail::read_tables(chart);
    if (!found) return found.error();
    return detail::create_state(found.value(), options);
}

State::State(State&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
State& State::operator=(State&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
State::~State() {
    detail::destroy(impl_);
}

std::uint32_t State::rows() const noexcept {
    return impl_->tables.rows;
}
std::uint32_t State::cols() const noexcept {
    return impl_->tables.cols;
}
std::uint32_t State::sample_count() const noexcept {
    return impl_->total();
}
detail::StateImpl* State::settled() const noexcept {
    detail::settle(*impl_);
    return impl_;
}
PointView State::positions() const noexcept {
    const detail::StateImpl& s = *settled();
    return {s.now.x, s.now.y, s.now.z, s.total(), 1};
}
PointView State::rest_positions() const noexcept {
    return {impl_->rest.x, impl_->rest.y, impl_->rest.z, impl_->total(), 1};
}
PointView State::normals() const noexcept {
    const detail::StateImpl& s = *settled();
    return {s.normal.x, s.normal.y, s.normal.z, s.total(), 1};
}
void State::update_normals() noexcept {
    detail::update_normals(*settled());
}
float State::mean_step() const noexcept {
    return impl_->mean_step;
}
const char* State::loops() const noexcept {
    return impl_->rows_of->name;
}
bool State::on_surface(std::uint32_t sample) const noexcept {
    return impl_->usable(sample);
}
std::uint32_t State::class_count() const noexcept {
    return impl_->class_count;
}
std::uint32_t State::class_of(std::uint32_t sample) const noexcept {
    return sample < impl_->total() ? impl_->class_id(sample) : kNone;
}
std::span<const std::uint32_t> State::class_members(std::uint32_t id) const noexcept {
    return id < impl_->class_count ? impl_->members(id) : std::span<const std::uint32_t>{};
}
Vec3 State::normal(std::uint32_t sample) const noexcept {
    const detail::StateImpl& s = *settled();
    return detail::sample_normal(s, detail::StateImpl::fixed(s.now), sample);
}

void State::release() noexcept {
    detail::release_elastic(*settled());
}

Result<void> State::relax(float dt, float rate) noexcept {
    if (!(dt >= 0) || !std::isfinite(dt) || !(rate >= 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "the time step or the rate is negative or not a number"};
    if (std::isinf(rate))
        release();
    else
        detail::relax_elastic(*impl_, double{rate} * dt);
    return {};
}

void State::reset() noexcept {
    detail::StateImpl& s = *settled();
    detail::release_elastic(s);
    const detail::RectList moved = detail::unlike_rest(s);
    if (moved.empty()) return;
    std::memcpy(s.base.x, s.rest.x, 3 * s.plane * sizeof(float));
    std::memcpy(s.now.x, s.rest.x, 3 * s.plane * sizeof(float));
    s.touch(moved, true);
}

}  // namespace dgm
