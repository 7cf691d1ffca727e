// SPDX-License-Identifier: MIT
// libdgm/src/state.cpp
#include <dgm/state.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <dgm/deform.h>

#include "contact_impl.h"
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
    s.tables.deformation = s.tables.contact = nullptr;
    s.tables.mask = s.mask.data();
    s.tables.diagonals = s.diagonals.data();
    s.tables.border_uv = s.border_uv.data();
    s.tables.faces = {s.faces.data(), s.faces.size()};
    return true;
}

/// Floats from one plane to the next: 448 bytes beyond a multiple of 4096, so that the planes are spread over the
/// page and rows of one plane end on a cache line of their own.
std::uint64_t plane_floats(std::uint64_t total) noexcept {
    return (total + 1023) / 1024 * 1024 + 112;
}

/// Checked before, but where the file has been overwritten since: what is kept is bounded whatever it holds.
bool copy_positions(StateImpl& s, const ChartTables& t) noexcept {
    s.plane = static_cast<std::size_t>(plane_floats(t.total));
    if (!s.planes.allocate(s.allocator, 16 * std::uint64_t{s.plane})) return false;
    std::size_t next = 0;
    for (Planes* p : {&s.rest, &s.base, &s.now, &s.normal, &s.rest_normal}) {
        p->x = s.planes.data() + next;
        p->y = p->x + s.plane;
        p->z = p->y + s.plane;
        next += 3 * s.plane;
    }
    s.rough = s.planes.data() + next;
    for (std::uint32_t k = 0; k < t.total; ++k) {
        Vec3 p = t.position(k);
        if (!is_place(p)) p = {};  // off the surface
        s.rest.x[k] = p.x;
        s.rest.y[k] = p.y;
        s.rest.z[k] = p.z;
    }
    return true;
}

/// Copies hold the bits of their representative, as in the file that was checked.
void weld_positions(StateImpl& s) noexcept {
    for (std::uint32_t id = 0; id < s.class_count; ++id)
        for (const std::uint32_t copy : s.members(id)) {
            const Vec3 p = StateImpl::at(s.rest, s.members(id)[0]);
            s.rest.x[copy] = p.x;
            s.rest.y[copy] = p.y;
            s.rest.z[copy] = p.z;
        }
    std::memcpy(s.base.x, s.rest.x, 3 * s.plane * sizeof(float));
    std::memcpy(s.now.x, s.rest.x, 3 * s.plane * sizeof(float));
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

/// Upper bound of what create() takes, for StateOptions::max_bytes.
std::uint64_t bytes_needed(const ChartTables& t, const StateOptions& o) noexcept {
    const std::uint64_t walk = t.free_domain ? walk_capacity(t.total, o.max_reach) * (sizeof(WalkNode) + 8) : 0;
    const std::uint64_t tiles = (std::uint64_t{tile_count(t.rows - 1)} * tile_count(t.cols - 1));
    const std::uint64_t shape = 16 * plane_floats(t.total) * sizeof(float);
    const std::uint64_t cells =
        ((std::uint64_t{t.rows} + 7) / 8) * ((std::uint64_t{t.cols} + 7) / 8) + (t.total - t.grid) / 8 + 1;
    const std::uint64_t side = press_cells(o.max_reach);
    const std::uint64_t patches =
        cells * (5 + patches_for(o) * (sizeof(PatchCell) + 8 * sizeof(PatchRow) + kCellSamples * sizeof(float))) +
        (o.max_tools == 0 ? 0 : std::min(cells, side * side) * kCellSamples * 9 * sizeof(float));
    // Per sample: mask, diagonals, ring, footprint (key, weight, list), geodesic, classes,
    // slots.
    return shape + patches + std::uint64_t{t.total} * (3 + 12 + kGeodesicSample + 8 + 8 + 4) + walk +
           tiles * (4 * sizeof(Box) + 52 + 9 * 8) + 2 * (std::uint64_t{t.rows} + t.cols) * 8 + (t.total - t.grid) +
           t.faces.size() * 40 + t.seams.size() * 80 + (t.rows + t.cols) * std::uint64_t{128} +
           o.max_tools * sizeof(ToolSlot) + sizeof(StateImpl) +
           geodesic_bytes(t.rows, t.cols, t.faces.size(), o.max_reach) + 8192;
}

/// The last element of a layer [m][n][width]; nothing is kept if all are 1.
Result<void> copy_share(StateImpl& s, const float* layer, std::uint64_t offset, std::size_t width,
                        Array<float>& to) noexcept {
    if (layer == nullptr) return {};
    if (!to.allocate(s.allocator, s.tables.grid, 1.0f)) return kNoMemory;
    bool all_one = true;
    for (std::size_t k = 0; k < s.tables.grid; ++k) {
        if (!s.tables.on_surface(static_cast<std::uint32_t>(k))) continue;
        const std::size_t at = width * k + width - 1;
        const float v = load_once(layer + at);
        if (!is_behaviour(3, v))
            return Error{ErrorCode::BadValue, offset + 4 * at, "stiffness or mobility is not in 0..1"};
        to[k] = v;
        all_one = all_one && v == 1;
    }
    if (all_one) to = Array<float>{};
    return {};
}

/// Copies of a class take what their representative holds.
void weld_share(const StateImpl& s, Array<float>& values) noexcept {
    if (values.empty()) return;
    for (std::uint32_t id = 0; id < s.class_count; ++id) {
        const auto members = s.members(id);
        const float v = members[0] < s.tables.grid ? values[members[0]] : 1;
        for (const std::uint32_t copy : members)
            if (copy < s.tables.grid) values[copy] = v;
    }
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

Result<void> copy_behaviour(StateImpl& s, const ChartTables& t) noexcept {
    if (auto r = copy_share(s, t.deformation, t.deformation_offset, 4, s.stiffness); !r) return r;
    if (auto r = copy_share(s, t.contact, t.contact_offset, 2, s.mobility); !r) return r;
    weld_share(s, s.stiffness);
    weld_share(s, s.mobility);
    return {};
}

Result<void> fill(StateImpl& s, const Chart& chart, const StateOptions& options) noexcept {
    auto found = read_tables(chart);
    if (!found) return found.error();
    const ChartTables& t = found.value();
    if (bytes_needed(t, options) > options.max_bytes)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the state would take more memory than the limit allows"};
    s.max_reach = options.max_reach;
    s.rows_of = &choose_rows(options.plain_loops);
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
    weld_positions(s);
    if (auto r = build_links(s); !r) return r;
    s.tables.seams = {};
    if (auto r = copy_behaviour(s, own); !r) return r;
    if (auto r = build_rings(s); !r) return r;
    if (auto r = build_pyramid(s); !r) return r;
    // Distances depend on the rest normals: the same bits whatever the processor.
    const NormalLoops quickest = std::exchange(s.normals_of, kPlainRows.normals);
    update_normals(s);
    std::memcpy(s.rest_normal.x, s.normal.x, 3 * s.plane * sizeof(float));
    s.normals_of = quickest;
    s.touch_all();
    update_normals(s);
    measure_roughness(s);
    s.elastic.clear();
    s.changes.bring_up();  // all that, before any reader's first look
    for (std::uint32_t k = 0; k < s.total() && s.any_sample == kNone; ++k)
        if (s.usable(k)) s.any_sample = k;
    auto closed = find_rim(s);
    if (!closed) return closed.error();
    s.open_surface = !closed.value();
    s.patch_count = patches_for(options);
    return make_scratch(s, options.max_tools) && make_patches(s, options.max_tools != 0) ? Result<void>{}
                                                                                         : Result<void>{kNoMemory};
}
}  // namespace
}  // namespace detail

Result<State> State::create(const Chart& chart, const StateOptions& options) noexcept {
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (options.max_reach < 1 || options.max_reach > kMaxReach)
        return Error{ErrorCode::BadArgument, kNoOffset, "max_reach is not in 1..1024"};
    if (options.max_tools > 64) return Error{ErrorCode::BadArgument, kNoOffset, "max_tools is beyond 64"};
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
