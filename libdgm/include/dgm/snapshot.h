// SPDX-License-Identifier: MIT
// libdgm/include/dgm/snapshot.h
// Shapes handed from one writer to any number of readers without locks: the haptic loop publishes, the render loop
// reads, and neither waits for the other.
//
// A ring of slots, each a copy of positions and normals with a sequence number that is odd while the slot is written
// (Lamport's sequence lock; memory orders after Boehm, "Can seqlocks get along with programming language memory
// models?", 2012). The writer takes the slot published longest ago, so a reader is overtaken only if it copies for as
// long as slots - 1 publications take; it then starts again with the newest one.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/allocator.h>
#include <dgm/map_view.h>
#include <dgm/result.h>
#include <dgm/state.h>

namespace dgm {

namespace detail {
struct SnapshotImpl;
}

struct SnapshotOptions {
    std::uint32_t slots = 3;  ///< 2 .. 16
    bool normals = true;      ///< hand over normals too
    std::uint64_t max_bytes = ~std::uint64_t{0};
    Allocator allocator = {};
};

/// What read() copied.
struct SnapshotInfo {
    std::uint64_t frame = 0;  ///< counts publications from 1
    std::uint64_t tag = 0;    ///< the writer's
    std::uint32_t retries = 0;
};

/// One writer at a time calls publish(); any number of threads call read() and frame() at any time.
///
/// Memory: slots x 12 bytes a sample (24 with normals), taken at creation.
class Snapshots {
 public:
    /// For states with as many samples as this one.
    /// @return BadArgument (slots, half an allocator), LimitExceeded, OutOfMemory.
    [[nodiscard]] DGM_API static Result<Snapshots> create(const State& state,
                                                          const SnapshotOptions& options = {}) noexcept;
    DGM_API Snapshots(Snapshots&& other) noexcept;
    DGM_API Snapshots& operator=(Snapshots&& other) noexcept;
    DGM_API ~Snapshots();

    /// Copies positions and normals (as of the last State::update_normals() or tick()). Wait-free.
    /// @param tag  any number, handed to readers: a time, a tick
    /// @return the frame's number; BadArgument if the state has another number of samples. O(samples).
    DGM_API Result<std::uint64_t> publish(const State& state, std::uint64_t tag = 0) noexcept;
    /// Number of the newest frame, 0 before the first.
    [[nodiscard]] DGM_API std::uint64_t frame() const noexcept;
    /// Copies the newest frame: x of all samples, then y, then z (3 x sample_count floats each); an empty span leaves
    /// that part out. Lock-free: starts again if overtaken, at most 64 times.
    /// @return NotFound before the first publish(); BufferTooSmall; BadArgument for normals of snapshots without;
    ///         Busy if it was overtaken every time: then the memory holds parts of several frames.
    [[nodiscard]] DGM_API Result<SnapshotInfo> read(std::span<float> positions,
                                                    std::span<float> normals) const noexcept;
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    [[nodiscard]] DGM_API std::uint64_t bytes() const noexcept;

 private:
    explicit Snapshots(detail::SnapshotImpl* impl) noexcept : impl_(impl) {}
    detail::SnapshotImpl* impl_;
};

}  // namespace dgm
