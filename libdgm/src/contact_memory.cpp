// SPDX-License-Identifier: MIT
// libdgm/src/contact_memory.cpp
// Scratch of contacts, and whether a welded surface encloses a volume.
#include <algorithm>
#include <limits>

#include "contact_impl.h"

namespace dgm {
namespace detail {
namespace {

constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the contact"};

/// An edge between two points of the welded surface, lower one first; `way` +1 or -1 by the direction it was met in.
struct Edge {
    std::uint32_t a, b;
    std::int32_t way;
};

/// Directed edges of faces whose other side the grid alone does not show.
template <class F>
void each_rim_edge(const StateImpl& s, F f) noexcept {
    const ChartTables& t = s.tables;
    const auto quad = [&](std::int64_t i, std::int64_t j) {
        return i >= 0 && j >= 0 && i + 1 < t.rows && j + 1 < t.cols &&
               t.has_quad(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
    };
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i) {
        // Whole rows inside a square domain have nothing to show but at their ends.
        const bool inner = t.mask == nullptr && i > 0 && i + 2 < t.rows;
        const std::uint32_t step = inner && t.cols > 2 ? t.cols - 2 : 1;
        for (std::uint32_t j = 0; j + 1 < t.cols; j += step) {
            if (!quad(i, j)) continue;
            const std::uint32_t a = i * t.cols + j, b = a + t.cols, c = b + 1, d = a + 1;
            if (!quad(i, std::int64_t{j} - 1)) f(a, b);
            if (!quad(std::int64_t{i} + 1, j)) f(b, c);
            if (!quad(i, std::int64_t{j} + 1)) f(c, d);
            if (!quad(std::int64_t{i} - 1, j)) f(d, a);
        }
    }
    for (std::size_t k = 0; k + 2 < s.faces.size(); k += 3) {
        f(s.faces[k], s.faces[k + 1]);
        f(s.faces[k + 1], s.faces[k + 2]);
        f(s.faces[k + 2], s.faces[k]);
    }
}

bool make(ContactImpl& c, const StateImpl& s) noexcept {
    const Allocator& a = c.allocator;
    const ChartTables& t = s.tables;
    const std::size_t tiles = std::size_t{s.tile_rows} * s.tile_cols;
    c.rows = t.rows;
    c.cols = t.cols;
    c.total = t.total;
    c.plane = (std::size_t{t.total} + 1023) / 1024 * 1024 + 112;  // as the state's own
    const std::uint64_t padded = std::uint64_t{t.total} + 16;     // lanes of ContactRows
    if (!c.kind.allocate(a, padded, kQuadNone) || !c.marks.allocate(a, padded) || !c.in_class.allocate(a, padded) ||
        !c.saved.allocate(a, 3 * std::uint64_t{c.plane}) || !c.weight.allocate(a, padded) ||
        !c.square.allocate(a, t.total, std::numeric_limits<float>::infinity()) || !c.source.allocate(a, t.total) ||
        !c.queue.allocate(a, t.total) || !c.tile_bits.allocate(a, tiles) || !c.rects.allocate(a, tiles) ||
        !c.tiles.allocate(a, tiles) || !c.tile_top.allocate(a, tiles) || !c.inner.rects.allocate(a, tiles) ||
        !c.ring.rects.allocate(a, tiles) || !c.near.rects.allocate(a, tiles) ||
        !c.rim.allocate(
            a, std::min<std::uint64_t>(2 * std::uint64_t{t.total}, 16 * (std::uint64_t{t.rows} + t.cols) + 1024)))
        return false;
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < t.cols; ++j)
            if (t.has_quad(i, j)) c.kind[i * t.cols + j] = static_cast<std::uint8_t>(t.diagonal(i, j));
    for (std::uint32_t tile = 0; tile < tiles; ++tile) c.rects[tile] = s.tile_rect(tile);
    for (const std::uint32_t sample : s.class_members) c.in_class[sample] = 1;
    c.rows_of = &choose_contact_rows(s.rows_of);
    return true;
}
}  // namespace

Result<bool> find_rim(StateImpl& s) noexcept {
    const auto mark = [&](std::uint32_t first) {
        const std::uint32_t id = s.class_id(first);
        if (id == kNone) {
            if (first < s.tables.grid) s.ring[first] |= kRingRim;
            return;
        }
        for (const std::uint32_t copy : s.members(id))
            if (copy < s.tables.grid) s.ring[copy] |= kRingRim;
    };
    bool closed = s.any_sample != kNone;
    std::uint64_t count = 0;
    each_rim_edge(s, [&](std::uint32_t, std::uint32_t) { ++count; });
    Array<Edge> edges;
    if (!edges.allocate(s.allocator, count)) return kNoMemory;
    std::size_t at = 0;
    each_rim_edge(s, [&](std::uint32_t from, std::uint32_t to) {
        const std::uint32_t a = s.representative(from), b = s.representative(to);
        if (a != b) edges[at++] = a < b ? Edge{a, b, 1} : Edge{b, a, -1};
    });
    std::sort(edges.begin(), edges.begin() + at,
              [](const Edge& e, const Edge& f) { return e.a != f.a ? e.a < f.a : e.b < f.b; });
    for (std::size_t k = 0; k < at;) {
        std::int32_t balance = 0;
        const Edge first = edges[k];
        for (; k < at && edges[k].a == first.a && edges[k].b == first.b; ++k) balance += edges[k].way;
        if (balance == 0) continue;
        closed = false;
        mark(first.a);
        mark(first.b);
    }
    return closed;
}
}  // namespace detail

Result<ContactSolver> ContactSolver::create(const State& state, const Allocator& allocator,
                                            std::uint64_t max_bytes) noexcept {
    if (!detail::is_valid(allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    const detail::StateImpl& s = *state.impl();
    const std::uint64_t tiles = std::uint64_t{s.tile_rows} * s.tile_cols;
    if (std::uint64_t{s.total()} * 64 + tiles * 80 + s.faces.size() * 12 + 131072 > max_bytes)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the contact would take more memory than the limit allows"};
    detail::ContactImpl* impl = detail::create<detail::ContactImpl>(allocator, allocator);
    if (impl == nullptr) return detail::kNoMemory;
    ContactSolver solver(impl);
    if (!detail::make(*impl, s)) return detail::kNoMemory;
    impl->closed = !s.open_surface;
    return solver;
}

ContactSolver::ContactSolver(ContactSolver&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
ContactSolver& ContactSolver::operator=(ContactSolver&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
ContactSolver::~ContactSolver() {
    detail::destroy(impl_);
}
bool ContactSolver::closed() const noexcept {
    return impl_->closed;
}

double ContactSolver::volume(const State& state) const noexcept {
    const detail::StateImpl& s = *state.impl();
    if (!impl_->closed || s.tables.total != impl_->total || s.tables.cols != impl_->cols || s.tables.rows < 2) return 0;
    const detail::Double3 o = detail::widen(s.point(s.any_sample));
    const detail::QuadJob job{{0, s.tables.rows - 2, 0, s.tables.cols - 2},
                              s.tables.cols,
                              detail::StateImpl::fixed(s.now),
                              impl_->kind.data(),
                              {o.x, o.y, o.z}};
    double six = impl_->rows_of->volume(job);
    for (std::size_t k = 0; k + 2 < s.faces.size(); k += 3)
        six += detail::dot(
            detail::widen(s.point(s.faces[k])) - o,
            detail::cross(detail::widen(s.point(s.faces[k + 1])) - o, detail::widen(s.point(s.faces[k + 2])) - o));
    return six / 6;
}

}  // namespace dgm
