// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_memory.cpp
// Scratch memory for contacts, and the volume that a surface encloses.
#include <algorithm>
#include <limits>

#include "contact/contact_impl.h"

namespace dgm {
namespace detail {
namespace {

constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the contact"};

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

}  // namespace detail

Result<ContactSolver> ContactSolver::create(const State& state, const Allocator& allocator,
                                            std::uint64_t max_bytes) noexcept {
    if (!detail::is_valid(allocator)) return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    const detail::StateImpl& s = *state.impl();
    const std::uint64_t tiles = std::uint64_t{s.tile_rows} * s.tile_cols;
    if (std::uint64_t{s.total()} * 64 + tiles * 80 + s.faces.size() * 12 + 131072 > max_bytes)
        return detail::over_max_bytes();
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

Result<double> ContactSolver::enclosed_volume(const State& state) const noexcept {
    const detail::StateImpl& s = *state.impl();
    if (s.open_surface)
        return Error{ErrorCode::Unsupported, kNoOffset,
                     s.reversed.empty() ? "the surface has a border, so it encloses no volume"
                                        : "the surface has one side, so it encloses no volume"};
    if (!impl_->closed || s.tables.total != impl_->total || s.tables.cols != impl_->cols)
        return Error{ErrorCode::BadArgument, kNoOffset, "the solver was made for another state"};
    return volume(state);
}

}  // namespace dgm
