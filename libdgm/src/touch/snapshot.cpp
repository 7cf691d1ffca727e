// SPDX-License-Identifier: MIT
// libdgm/src/touch/snapshot.cpp
// Sequence locks without fences, which ThreadSanitizer does not know: the writer's data stores are releases, so that a
// reader that sees one of them sees the odd sequence before it; the reader's data loads are acquires, so that the
// second look at the sequence comes after them. On x86-64 all of these are plain moves. The compilers' __atomic
// functions take plain memory, as std::atomic_ref does, which clang's C++ library does not have.
#include <dgm/snapshot.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <iterator>

#include "touch/state_impl.h"

namespace dgm {
namespace detail {

using Word = std::size_t;  ///< unit that the machine moves at once
inline constexpr std::size_t kFloats = sizeof(Word) / sizeof(float);
inline constexpr std::uint32_t kTries = 64;

struct SnapshotSlot {
    std::uint64_t sequence = 0, frame = 0, tag = 0;
    std::uint64_t unused[5] = {};  // a cache line each
};

struct SnapshotImpl {
    explicit SnapshotImpl(const Allocator& a) noexcept : allocator(a) {}
    Allocator allocator;
    std::uint32_t total = 0, slots = 0, planes = 0;
    std::size_t plane_words = 0;
    Array<SnapshotSlot> slot;
    Array<Word> words;
    /// Frame in which each cell of the state, then each band, last changed, modulo 2^32: the writer's, and a copy a
    /// slot.
    CellGrid grid;
    std::size_t cell_words = 0;
    Array<std::uint32_t> cells;
    Array<Word> slot_cells;
    const void* source = nullptr;  ///< state of the newest frame; pairs with Changes::publishers
    std::uint64_t cursor = 0;      ///< of that state
    std::atomic<std::uint64_t> newest{0};

    [[nodiscard]] Word* plane(std::uint32_t s, std::uint32_t p) noexcept {
        return words.data() + (std::size_t{s} * planes + p) * plane_words;
    }
    [[nodiscard]] static std::uint64_t stamps(const CellGrid& grid) noexcept { return grid.cells() + grid.bands(); }
    [[nodiscard]] Word* cells_of(std::uint32_t s) noexcept { return slot_cells.data() + s * cell_words; }
};
}  // namespace detail

namespace {
using detail::kFloats;
using detail::SnapshotImpl;
using detail::SnapshotSlot;
using detail::Word;

constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the snapshots"};
constexpr Error kBusy{ErrorCode::Busy, kNoOffset, "the writer overtook the reader again and again"};

template <class T>
T load_acquire(const T& from) noexcept {
    return __atomic_load_n(&from, __ATOMIC_ACQUIRE);
}
template <class T>
void store_release(T& to, T value) noexcept {
    __atomic_store_n(&to, value, __ATOMIC_RELEASE);
}

/// `from`: floats or numbers of 32 bits.
void store_plane(Word* to, const void* memory, std::size_t count) noexcept {
    const auto* from = static_cast<const std::byte*>(memory);
    const std::size_t whole = count / kFloats;
    for (std::size_t k = 0; k < whole; ++k) {
        Word w;
        std::memcpy(&w, from + k * sizeof w, sizeof w);
        store_release(to[k], w);
    }
    if (whole * kFloats == count) return;
    Word w = 0;
    std::memcpy(&w, from + whole * sizeof w, (count - whole * kFloats) * sizeof(float));
    store_release(to[whole], w);
}
/// Element k of a plane of floats or numbers of 32 bits.
template <class T>
T load_one(Word* from, std::size_t k) noexcept {
    const Word w = load_acquire(from[k / kFloats]);
    T values[kFloats];
    std::memcpy(values, &w, sizeof w);
    return values[k % kFloats];
}
void load_plane(Word* from, float* to, std::size_t count) noexcept {
    const std::size_t whole = count / kFloats;
    for (std::size_t k = 0; k < whole; ++k) {
        const Word w = load_acquire(from[k]);
        std::memcpy(to + k * kFloats, &w, sizeof w);
    }
    if (whole * kFloats == count) return;
    const Word w = load_acquire(from[whole]);
    std::memcpy(to + whole * kFloats, &w, (count - whole * kFloats) * sizeof(float));
}

/// Samples first .. first + count - 1 of a plane, to their places in `to`.
void load_range(Word* from, float* to, std::size_t first, std::size_t count) noexcept {
    const std::size_t end = first + count;
    for (; first < end && first % kFloats != 0; ++first) to[first] = load_one<float>(from, first);
    const std::size_t whole = (end - first) / kFloats;
    load_plane(from + first / kFloats, to + first, whole * kFloats);
    for (first += whole * kFloats; first < end; ++first) to[first] = load_one<float>(from, first);
}

/// Lets a reader copy from the newest frame: copy(slot, frame) copies it. @return false if it was overtaken.
template <class Copy>
bool try_read(SnapshotImpl& s, SnapshotInfo& info, Copy copy) noexcept {
    const std::uint64_t newest = s.newest.load(std::memory_order_acquire);
    const auto at = static_cast<std::uint32_t>((newest - 1) % s.slots);
    SnapshotSlot& slot = s.slot[at];
    const std::uint64_t before = load_acquire(slot.sequence);
    if (before % 2 != 0) return false;
    info.frame = load_acquire(slot.frame);
    info.tag = load_acquire(slot.tag);
    copy(at, info.frame);
    return __atomic_load_n(&slot.sequence, __ATOMIC_RELAXED) == before;
}

Result<void> check_read(const SnapshotImpl& s, std::span<float> positions, std::span<float> normals) noexcept {
    if (s.newest.load(std::memory_order_acquire) == 0)
        return Error{ErrorCode::NotFound, kNoOffset, "nothing has been published yet"};
    const std::size_t needed = 3 * std::size_t{s.total};
    if ((!positions.empty() && positions.size() < needed) || (!normals.empty() && normals.size() < needed))
        return Error{ErrorCode::BufferTooSmall, kNoOffset, "the memory for the snapshot is too small"};
    if (!normals.empty() && s.planes < 6)
        return Error{ErrorCode::BadArgument, kNoOffset, "the snapshots hold no normals"};
    return {};
}

/// Stamps the cells that changed since the frame before. A state is known again by a sign on both sides: its address
/// alone may have been another's.
void stamp_cells(SnapshotImpl& s, const detail::StateImpl& from, std::uint64_t frame) noexcept {
    detail::Changes& changes = from.changes;
    changes.bring_up();
    const void* const* known = std::find(changes.publishers, std::end(changes.publishers), &s);
    const auto stamp = static_cast<std::uint32_t>(frame);
    if (s.source != &from || known == std::end(changes.publishers)) {
        if (known == std::end(changes.publishers))
            changes.publishers[changes.next_publisher++ % detail::Changes::kPublishers] = &s;
        s.source = &from;
        std::fill(s.cells.begin(), s.cells.end(), stamp);
    } else {
        const std::uint32_t across = s.grid.across();
        const auto fill = [&](std::size_t first, std::size_t count) {
            std::fill_n(s.cells.data() + first, count, stamp);
        };
        changes.each_run(
            s.cursor,
            [&](std::uint32_t row, std::uint32_t first, std::uint32_t last) {
                fill(std::size_t{row} * across + first, last - first + 1);
                s.cells[s.grid.cells() + row / detail::kBandRows] = stamp;
            },
            [&](std::uint32_t first, std::uint32_t last) {
                fill(std::size_t{s.grid.rows} * across + first, last - first + 1);
            });
    }
    s.cursor = changes.epoch;
}

/// Copies cells of a slot that changed after frame `since`, and names them.
void copy_changed(SnapshotImpl& s, std::uint32_t at, std::uint64_t frame, std::uint64_t since,
                  std::span<float> positions, std::span<float> normals, detail::RangeWriter& writer) noexcept {
    Word* stamps = s.cells_of(at);
    const bool all = since == 0 || since > frame;
    const std::uint64_t age = frame - since;  // stamps wrap to younger ones: more is copied then, never less
    const auto copy = [&](std::size_t first, std::size_t count) {
        for (std::uint32_t p = 0; p < 3; ++p) {
            if (!positions.empty())
                load_range(s.plane(at, p), positions.data() + std::size_t{p} * s.total, first, count);
            if (!normals.empty())
                load_range(s.plane(at, 3 + p), normals.data() + std::size_t{p} * s.total, first, count);
        }
    };
    const std::uint32_t across = s.grid.across(), cols = s.grid.cols, border = s.grid.border_cells();
    const auto changed = [&](std::size_t cell) {
        return all || static_cast<std::uint32_t>(frame) - load_one<std::uint32_t>(stamps, cell) < age;
    };
    for (std::uint32_t i = 0; i < s.grid.rows; ++i) {
        if (i % detail::kBandRows == 0 && !changed(s.grid.cells() + i / detail::kBandRows)) {
            i += detail::kBandRows - 1;
            continue;
        }
        detail::each_run_of(
            0, across, [&](std::uint32_t c) { return changed(std::size_t{i} * across + c); },
            [&](std::uint32_t first, std::uint32_t last) {
                const std::uint32_t j = first * detail::kRunSamples;
                copy(std::size_t{i} * cols + j, std::min((last + 1) * detail::kRunSamples, cols) - j);
                writer.add_row(i, first, last);
            });
    }
    detail::each_run_of(
        0, border, [&](std::uint32_t c) { return changed(std::size_t{s.grid.rows} * across + c); },
        [&](std::uint32_t first, std::uint32_t last) {
            const std::uint32_t b = first * detail::kRunSamples;
            copy(s.grid.grid() + b, std::min((last + 1) * detail::kRunSamples, s.grid.border) - b);
            writer.add_border(first, last);
        });
}
}  // namespace

Result<Snapshots> Snapshots::create(const State& state, const SnapshotOptions& options) noexcept {
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (options.slots < 2 || options.slots > 16)
        return Error{ErrorCode::BadArgument, kNoOffset, "the number of slots is not in 2..16"};
    const std::uint32_t total = state.sample_count(), planes = options.normals ? 6 : 3;
    const std::uint64_t words = (std::uint64_t{total} + kFloats - 1) / kFloats;
    const detail::CellGrid grid = state.impl()->changes.grid;
    const std::uint64_t cell_words = (SnapshotImpl::stamps(grid) + kFloats - 1) / kFloats;
    const std::uint64_t bytes = (words * planes + cell_words) * sizeof(Word) * options.slots +
                                SnapshotImpl::stamps(grid) * sizeof(std::uint32_t);
    if (bytes + options.slots * sizeof(SnapshotSlot) + sizeof(SnapshotImpl) > options.max_bytes)
        return detail::over_max_bytes();
    SnapshotImpl* impl = detail::create<SnapshotImpl>(options.allocator, options.allocator);
    if (impl == nullptr) return kNoMemory;
    Snapshots made(impl);
    impl->total = total;
    impl->slots = options.slots;
    impl->planes = planes;
    impl->plane_words = static_cast<std::size_t>(words);
    impl->grid = grid;
    impl->cell_words = static_cast<std::size_t>(cell_words);
    if (!impl->slot.allocate(options.allocator, options.slots) ||
        !impl->words.allocate(options.allocator, words * planes * options.slots) ||
        !impl->cells.allocate(options.allocator, SnapshotImpl::stamps(grid)) ||
        !impl->slot_cells.allocate(options.allocator, cell_words * options.slots))
        return kNoMemory;
    return made;
}

Snapshots::Snapshots(Snapshots&& other) noexcept : impl_(std::exchange(other.impl_, nullptr)) {}
Snapshots& Snapshots::operator=(Snapshots&& other) noexcept {
    std::swap(impl_, other.impl_);
    return *this;
}
Snapshots::~Snapshots() {
    detail::destroy(impl_);
}

Result<std::uint64_t> Snapshots::publish(const State& state, std::uint64_t tag) noexcept {
    SnapshotImpl& s = *impl_;
    if (!(state.impl()->changes.grid == s.grid))
        return Error{ErrorCode::BadArgument, kNoOffset, "the snapshots were made for a state of another size"};
    const std::uint64_t frame = s.newest.load(std::memory_order_relaxed) + 1;
    const auto at = static_cast<std::uint32_t>((frame - 1) % s.slots);
    SnapshotSlot& slot = s.slot[at];
    const std::uint64_t sequence = __atomic_load_n(&slot.sequence, __ATOMIC_RELAXED);
    __atomic_store_n(&slot.sequence, sequence + 1, __ATOMIC_RELAXED);
    store_release(slot.frame, frame);
    store_release(slot.tag, tag);
    const detail::StateImpl& from = *state.impl();
    const float* planes[6] = {from.now.x, from.now.y, from.now.z, from.normal.x, from.normal.y, from.normal.z};
    for (std::uint32_t p = 0; p < s.planes; ++p) store_plane(s.plane(at, p), planes[p], s.total);
    stamp_cells(s, from, frame);
    store_plane(s.cells_of(at), s.cells.data(), s.cells.size());
    store_release(slot.sequence, sequence + 2);
    s.newest.store(frame, std::memory_order_release);
    return frame;
}

std::uint64_t Snapshots::frame() const noexcept {
    return impl_->newest.load(std::memory_order_acquire);
}

Result<SnapshotInfo> Snapshots::read(std::span<float> positions, std::span<float> normals) const noexcept {
    SnapshotImpl& s = *impl_;
    if (auto r = check_read(s, positions, normals); !r) return r.error();
    const auto copy = [&](std::uint32_t at, std::uint64_t) {
        for (std::uint32_t p = 0; p < 3; ++p) {
            if (!positions.empty()) load_plane(s.plane(at, p), positions.data() + std::size_t{p} * s.total, s.total);
            if (!normals.empty()) load_plane(s.plane(at, 3 + p), normals.data() + std::size_t{p} * s.total, s.total);
        }
    };
    SnapshotInfo info;
    for (; info.retries < detail::kTries; ++info.retries)
        if (try_read(s, info, copy)) return info;
    return kBusy;
}

Result<SnapshotChanges> Snapshots::read_changed(std::span<float> positions, std::span<float> normals,
                                                std::uint64_t since, std::span<ChangedRange> ranges) const noexcept {
    SnapshotImpl& s = *impl_;
    if (auto r = check_read(s, positions, normals); !r) return r.error();
    if (ranges.size() < (s.grid.border != 0 ? 2u : 1u))
        return Error{ErrorCode::BufferTooSmall, kNoOffset, "there is no room for the ranges"};
    SnapshotChanges done;
    for (; done.info.retries < detail::kTries; ++done.info.retries) {
        detail::RangeWriter writer(s.grid, ranges);
        writer.reserve(s.grid.border != 0 ? 1 : 0);
        const bool whole = try_read(s, done.info, [&](std::uint32_t at, std::uint64_t frame) {
            copy_changed(s, at, frame, since, positions, normals, writer);
        });
        done.ranges = writer.count();
        if (whole) return done;
        since = 0;  // copied values may be of a frame to come
    }
    return kBusy;
}

std::uint32_t Snapshots::sample_count() const noexcept {
    return impl_->total;
}
std::uint64_t Snapshots::bytes() const noexcept {
    return (impl_->words.size() + impl_->slot_cells.size()) * sizeof(Word) +
           impl_->cells.size() * sizeof(std::uint32_t) + impl_->slots * sizeof(SnapshotSlot) + sizeof(SnapshotImpl);
}

}  // namespace dgm
