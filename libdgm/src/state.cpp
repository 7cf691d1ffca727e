// SPDX-License-Identifier: MIT
// libdgm/src/state.cpp
#include <dgm/state.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <dgm/deform.h>

#include "state_impl.h"
#include "validate_impl.h"

namespace dgm {
namespace detail {
namespace {

constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the state"};

template <class T>
bool copy_in(Array<T>& to, const T* from, std::size_t count, const Allocator& allocator) noexcept {
    if (from == nullptr || count == 0) return true;
    if (!to.allocate(allocator, count)) return false;
    std::memcpy(to.data(), from, count * sizeof(T));
    return true;
}

/// The state keeps its own copy of every table that per-tick code indexes with: the file may change under us.
bool copy_tables(StateImpl& s, const ChartTables& t) noexcept {
    const Allocator& a = s.allocator;
    const std::size_t border = t.total - t.grid;
    if (!copy_in(s.mask, t.mask, t.grid, a) ||
        !copy_in(s.diagonals, t.diagonals, std::size_t{t.rows - 1} * (t.cols - 1), a) ||
        !copy_in(s.faces, t.faces.data(), t.faces.size(), a) || !copy_in(s.border_uv, t.border_uv, 2 * border, a))
        return false;
    s.tables = t;
    s.tables.geometry = s.tables.border = {};
    s.tables.normal = s.tables.border_normal = nullptr;
    s.tables.mask = s.mask.data();
    s.tables.diagonals = s.diagonals.data();
    s.tables.border_uv = s.border_uv.data();
    s.tables.faces = {s.faces.data(), s.faces.size()};
    return true;
}

bool copy_positions(StateImpl& s, const ChartTables& t) noexcept {
    const std::uint64_t floats = 3 * std::uint64_t{t.total};
    if (!s.rest.allocate(s.allocator, floats) || !s.base.allocate(s.allocator, floats) ||
        !s.now.allocate(s.allocator, floats))
        return false;
    const std::size_t n = t.total;
    for (std::uint32_t k = 0; k < t.total; ++k) {
        Vec3 p = t.position(k);
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            p = {};  // off the surface: checked before
        s.rest[k] = p.x;
        s.rest[n + k] = p.y;
        s.rest[2 * n + k] = p.z;
    }
    std::memcpy(s.base.data(), s.rest.data(), s.rest.size() * sizeof(float));
    std::memcpy(s.now.data(), s.rest.data(), s.rest.size() * sizeof(float));
    return true;
}

/// Border faces of each sample, as offsets into one list.
bool index_faces(StateImpl& s) noexcept {
    if (s.faces.empty()) return true;
    if (!s.face_start.allocate(s.allocator, std::uint64_t{s.total()} + 2) ||
        !s.face_of.allocate(s.allocator, s.faces.size()))
        return false;
    for (const std::uint32_t v : s.faces) ++s.face_start[v + 2];
    for (std::size_t v = 2; v < s.face_start.size(); ++v) s.face_start[v] += s.face_start[v - 1];
    for (std::size_t k = 0; k < s.faces.size(); ++k)
        s.face_of[s.face_start[s.faces[k] + 1]++] = static_cast<std::uint32_t>(k / 3);
    return true;
}

bool make_scratch(StateImpl& s) noexcept {
    // A window of (2b - 1)^2 steps holds more samples than that where several sheets meet at one seam node, each copy
    // bringing at most half a turn: eight sheets are nodes of 16 cut paths.
    const std::uint64_t side = 2 * std::uint64_t{s.max_reach} - 1;
    const std::uint64_t capacity = std::min<std::uint64_t>(s.total(), 8 * side * side);
    if (s.classes_or_border()) {
        if (!s.walk.slot_of.allocate(s.allocator, s.total(), kNone) || !s.walk.nodes.allocate(s.allocator, capacity) ||
            !s.walk.heap.allocate(s.allocator, capacity) || !s.walk.visited.allocate(s.allocator, capacity))
            return false;
    }
    return s.walk.class_node.allocate(s.allocator, s.class_count, kNone) &&
           s.walk.classes.allocate(s.allocator, s.class_count);
}

/// Upper bound of what create() takes, for StateOptions::max_bytes.
std::uint64_t bytes_needed(const ChartTables& t, std::uint32_t max_reach) noexcept {
    const std::uint64_t side = 2 * std::uint64_t{max_reach} - 1;
    const std::uint64_t walk = std::min<std::uint64_t>(t.total, 8 * side * side) * (sizeof(WalkNode) + 8);
    const std::uint64_t tiles = (std::uint64_t{tile_count(t.rows - 1)} * tile_count(t.cols - 1));
    return std::uint64_t{t.total} * (36 + 4 + 4 + 4 + 2) + walk + tiles * 2 * (sizeof(Box) + 16) + t.faces.size() * 40 +
           t.seams.size() * 80 + (t.rows + t.cols) * std::uint64_t{128} + 4096;
}

Result<void> fill(StateImpl& s, const Chart& chart, const StateOptions& options) noexcept {
    auto found = read_tables(chart);
    if (!found) return found.error();
    const ChartTables& t = found.value();
    if (bytes_needed(t, options.max_reach) > options.max_bytes)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the state would take more memory than the limit allows"};
    s.max_reach = options.max_reach;
    // Tables first, values after: what is checked is what is kept.
    ChartTables own = t;
    if (!copy_tables(s, t)) return kNoMemory;
    own.mask = s.tables.mask;
    own.diagonals = s.tables.diagonals;
    own.border_uv = s.tables.border_uv;
    own.faces = s.tables.faces;
    Array<std::uint32_t> seams;
    if (!copy_in(seams, t.seams.data(), t.seams.size(), s.allocator)) return kNoMemory;
    own.seams = s.tables.seams = {seams.data(), seams.size()};
    if (auto r = check_values(own, s.allocator); !r) return r;
    if (!copy_positions(s, own) || !index_faces(s)) return kNoMemory;
    if (auto r = build_classes(s); !r) return r;
    if (auto r = build_links(s); !r) return r;
    s.tables.seams = {};
    if (auto r = build_pyramid(s); !r) return r;
    return make_scratch(s) ? Result<void>{} : Result<void>{kNoMemory};
}
}  // namespace
}  // namespace detail

Result<State> State::create(const Chart& chart, const StateOptions& options) noexcept {
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (options.max_reach < 1 || options.max_reach > kMaxReach)
        return Error{ErrorCode::BadArgument, kNoOffset, "max_reach is not in 1..1024"};
    detail::StateImpl* impl = detail::create<detail::StateImpl>(options.allocator, options.allocator);
    if (impl == nullptr) return detail::kNoMemory;
    State state(impl);
    if (auto r = detail::fill(*impl, chart, options); !r) return r.error();
    return state;
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
PointView State::positions() const noexcept {
    const std::size_t n = impl_->total();
    return {impl_->now.data(), impl_->now.data() + n, impl_->now.data() + 2 * n, n, 1};
}
PointView State::rest_positions() const noexcept {
    const std::size_t n = impl_->total();
    return {impl_->rest.data(), impl_->rest.data() + n, impl_->rest.data() + 2 * n, n, 1};
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
    return impl_->usable(sample) ? detail::ring_normal(*impl_, sample) : Vec3{};
}

void State::release() noexcept {
    detail::StateImpl& s = *impl_;
    const std::size_t n = s.total();
    const std::uint32_t count = s.elastic_count;
    s.elastic_count = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t tile = s.elastic_tiles[k], ti = tile / s.tile_cols, tj = tile % s.tile_cols;
        const std::uint32_t i1 = std::min(ti * kTileQuads + kTileQuads + 1, s.tables.rows);
        const std::uint32_t j0 = tj * kTileQuads, j1 = std::min(j0 + kTileQuads + 1, s.tables.cols);
        for (std::size_t plane = 0; plane < 3 * n; plane += n) {
            for (std::uint32_t i = ti * kTileQuads; i < i1; ++i) {
                const std::size_t at = plane + std::size_t{i} * s.tables.cols;
                std::copy(s.base.data() + at + j0, s.base.data() + at + j1, s.now.data() + at + j0);
            }
            for (std::uint32_t b = s.tile_border_start[tile]; b < s.tile_border_start[tile + 1]; ++b)
                s.now[plane + s.tile_border[b]] = s.base[plane + s.tile_border[b]];
        }
        s.tile_flags[tile] &= static_cast<std::uint8_t>(~detail::kTileElastic);
        s.touch_tile(tile, false);
    }
}

void State::reset() noexcept {
    detail::StateImpl& s = *impl_;
    std::memcpy(s.base.data(), s.rest.data(), s.rest.size() * sizeof(float));
    std::memcpy(s.now.data(), s.rest.data(), s.rest.size() * sizeof(float));
    for (std::uint8_t& flags : s.tile_flags) flags &= static_cast<std::uint8_t>(~detail::kTileElastic);
    s.elastic_count = 0;
    s.touch_all();
}

}  // namespace dgm
