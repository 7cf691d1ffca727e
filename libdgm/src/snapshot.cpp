// SPDX-License-Identifier: MIT
// libdgm/src/snapshot.cpp
// Sequence locks without fences, which ThreadSanitizer does not know: the writer's data stores are releases, so that
// whoever sees one of them sees the odd sequence before it; the reader's data loads are acquires, so that the second
// look at the sequence comes after them. On x86-64 all of these are plain moves. The compilers' __atomic functions take
// plain memory, as std::atomic_ref does, which clang's C++ library does not have.
#include <dgm/snapshot.h>

#include <atomic>
#include <cstring>

#include "state_impl.h"

namespace dgm {
namespace detail {

using Word = std::size_t;  ///< what the machine moves at once
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
    std::atomic<std::uint64_t> newest{0};

    [[nodiscard]] Word* plane(std::uint32_t s, std::uint32_t p) noexcept {
        return words.data() + (std::size_t{s} * planes + p) * plane_words;
    }
};
}  // namespace detail

namespace {
using detail::kFloats;
using detail::SnapshotImpl;
using detail::SnapshotSlot;
using detail::Word;

constexpr Error kNoMemory{ErrorCode::OutOfMemory, kNoOffset, "no memory for the snapshots"};

template <class T>
T load_acquire(const T& from) noexcept {
    return __atomic_load_n(&from, __ATOMIC_ACQUIRE);
}
template <class T>
void store_release(T& to, T value) noexcept {
    __atomic_store_n(&to, value, __ATOMIC_RELEASE);
}

void store_plane(Word* to, const float* from, std::size_t count) noexcept {
    const std::size_t whole = count / kFloats;
    for (std::size_t k = 0; k < whole; ++k) {
        Word w;
        std::memcpy(&w, from + k * kFloats, sizeof w);
        store_release(to[k], w);
    }
    if (whole * kFloats == count) return;
    Word w = 0;
    std::memcpy(&w, from + whole * kFloats, (count - whole * kFloats) * sizeof(float));
    store_release(to[whole], w);
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

bool try_read(SnapshotImpl& s, std::span<float> positions, std::span<float> normals, SnapshotInfo& info) noexcept {
    const std::uint64_t newest = s.newest.load(std::memory_order_acquire);
    const auto at = static_cast<std::uint32_t>((newest - 1) % s.slots);
    SnapshotSlot& slot = s.slot[at];
    const std::uint64_t before = load_acquire(slot.sequence);
    if (before % 2 != 0) return false;
    info.frame = load_acquire(slot.frame);
    info.tag = load_acquire(slot.tag);
    for (std::uint32_t p = 0; p < 3; ++p) {
        if (!positions.empty()) load_plane(s.plane(at, p), positions.data() + std::size_t{p} * s.total, s.total);
        if (!normals.empty()) load_plane(s.plane(at, 3 + p), normals.data() + std::size_t{p} * s.total, s.total);
    }
    return __atomic_load_n(&slot.sequence, __ATOMIC_RELAXED) == before;
}
}  // namespace

Result<Snapshots> Snapshots::create(const State& state, const SnapshotOptions& options) noexcept {
    if (!detail::is_valid(options.allocator))
        return Error{ErrorCode::BadArgument, kNoOffset, "the allocator is half empty"};
    if (options.slots < 2 || options.slots > 16)
        return Error{ErrorCode::BadArgument, kNoOffset, "the number of slots is not in 2..16"};
    const std::uint32_t total = state.sample_count(), planes = options.normals ? 6 : 3;
    const std::uint64_t words = (std::uint64_t{total} + kFloats - 1) / kFloats;
    const std::uint64_t bytes = words * sizeof(Word) * planes * options.slots;
    if (bytes + options.slots * sizeof(SnapshotSlot) + sizeof(SnapshotImpl) > options.max_bytes)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the snapshots would take more memory than the limit allows"};
    SnapshotImpl* impl = detail::create<SnapshotImpl>(options.allocator, options.allocator);
    if (impl == nullptr) return kNoMemory;
    Snapshots made(impl);
    impl->total = total;
    impl->slots = options.slots;
    impl->planes = planes;
    impl->plane_words = static_cast<std::size_t>(words);
    if (!impl->slot.allocate(options.allocator, options.slots) ||
        !impl->words.allocate(options.allocator, words * planes * options.slots))
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
    if (state.sample_count() != s.total)
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
    store_release(slot.sequence, sequence + 2);
    s.newest.store(frame, std::memory_order_release);
    return frame;
}

std::uint64_t Snapshots::frame() const noexcept {
    return impl_->newest.load(std::memory_order_acquire);
}

Result<SnapshotInfo> Snapshots::read(std::span<float> positions, std::span<float> normals) const noexcept {
    SnapshotImpl& s = *impl_;
    if (frame() == 0) return Error{ErrorCode::NotFound, kNoOffset, "nothing has been published yet"};
    const std::size_t needed = 3 * std::size_t{s.total};
    if ((!positions.empty() && positions.size() < needed) || (!normals.empty() && normals.size() < needed))
        return Error{ErrorCode::BufferTooSmall, kNoOffset, "the memory for the snapshot is too small"};
    if (!normals.empty() && s.planes < 6)
        return Error{ErrorCode::BadArgument, kNoOffset, "the snapshots hold no normals"};
    SnapshotInfo info;
    for (; info.retries < detail::kTries; ++info.retries)
        if (try_read(s, positions, normals, info)) return info;
    return Error{ErrorCode::Busy, kNoOffset, "the writer overtook the reader again and again"};
}

std::uint32_t Snapshots::sample_count() const noexcept {
    return impl_->total;
}
std::uint64_t Snapshots::bytes() const noexcept {
    return impl_->words.size() * sizeof(Word) + impl_->slots * sizeof(SnapshotSlot) + sizeof(SnapshotImpl);
}

}  // namespace dgm
