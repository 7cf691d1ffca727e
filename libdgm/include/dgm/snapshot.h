// SPDX-License-Identifier: MIT
// libdgm/include/dgm/snapshot.h
// Hands shapes from one writer to any number of readers without locks: the haptic loop publishes, the render loop
// reads, and neither waits for the other.
//
// There is a ring of slots. Each is a copy of positions and normals, with a sequence number that is odd while the slot
// is written (Lamport's sequence lock; memory orders after Boehm, "Can seqlocks get along with programming language
// memory models?", 2012). The writer takes the slot published longest ago. So a reader is overtaken only if its copy
// takes longer than slots - 1 publications; it then starts again with the newest frame.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/allocator.h>
#include <dgm/changed.h>
#include <dgm/map_view.h>
#include <dgm/result.h>
#include <dgm/state.h>

namespace dgm {

namespace detail {
struct SnapshotImpl;
}

/// Sizes and limits of snapshots.
struct SnapshotOptions {
    std::uint32_t slots = 3;                      ///< 2 .. 16
    bool normals = true;                          ///< publish normals too
    std::uint64_t max_bytes = ~std::uint64_t{0};  ///< LimitExceeded if more memory is needed
    Allocator allocator = {};
};

/// The frame that read() copied.
struct SnapshotInfo {
    std::uint64_t frame = 0;    ///< counts publications from 1
    std::uint64_t tag = 0;      ///< the writer's number for this frame
    std::uint32_t retries = 0;  ///< how often the reader was overtaken
};

/// The frame and the ranges that read_changed() copied.
struct SnapshotChanges {
    SnapshotInfo info;
    std::size_t ranges = 0;  ///< written to the caller's list
};

/// Shapes from a writer to its readers. One writer at a time calls publish(); any number of threads call read(),
/// read_changed() and frame() at any time.
///
/// Memory: slots x 12.5 bytes a sample (24.5 with normals), taken at creation.
class Snapshots {
 public:
    /// Makes slots for states with as many rows, columns and border samples as this one.
    /// @return BadArgument (slots, half an allocator), LimitExceeded, OutOfMemory.
    [[nodiscard]] DGM_API static Result<Snapshots> create(const State& state,
                                                          const SnapshotOptions& options = {}) noexcept;
    DGM_API Snapshots(Snapshots&& other) noexcept;
    DGM_API Snapshots& operator=(Snapshots&& other) noexcept;
    DGM_API ~Snapshots();

    /// Copies positions and normals (as of the last State::update_normals() or tick()). Wait-free.
    /// @param tag  any number for the readers: a time, a tick
    /// @return the frame's number; BadArgument if the state has another number of rows, columns or border samples.
    /// O(samples).
    DGM_API Result<std::uint64_t> publish(const State& state, std::uint64_t tag = 0) noexcept;
    /// Returns the number of the newest frame, 0 before the first.
    [[nodiscard]] DGM_API std::uint64_t frame() const noexcept;
    /// Copies the newest frame: x of all samples, then y, then z (3 x sample_count floats each); an empty span leaves
    /// that part out. Lock-free: a reader that is overtaken starts again, at most 64 times.
    /// @return NotFound before the first publish(); BufferTooSmall; BadArgument for normals of snapshots without;
    ///         Busy if it was overtaken every time: then the memory contains parts of several frames.
    [[nodiscard]] DGM_API Result<SnapshotInfo> read(std::span<float> positions,
                                                    std::span<float> normals) const noexcept;
    /// Brings memory that contains an earlier frame to the newest one: `positions` and `normals` contain frame `since`.
    /// Only samples that differ between the two frames, in positions or normals, are copied, and a few around them;
    /// `ranges` lists them (changed_rows() says what a range may contain).
    ///
    /// A reader that is overtaken copies all samples when it starts again. If the frames come from more than one state,
    /// or the state is published to more than four Snapshots, all samples count as changed.
    /// @param since   the frame in the memory, from the last read; 0: none, all is copied. A frame that has not been
    ///                published yet counts as 0.
    /// @param ranges  1 is enough for a square domain, 2 for a free one; BufferTooSmall if it is less
    /// @return as read(). After Busy call with 0.
    [[nodiscard]] DGM_API Result<SnapshotChanges> read_changed(std::span<float> positions, std::span<float> normals,
                                                               std::uint64_t since,
                                                               std::span<ChangedRange> ranges) const noexcept;
    [[nodiscard]] DGM_API std::uint32_t sample_count() const noexcept;
    [[nodiscard]] DGM_API std::uint64_t bytes() const noexcept;

 private:
    explicit Snapshots(detail::SnapshotImpl* impl) noexcept : impl_(impl) {}
    detail::SnapshotImpl* impl_;
};

}  // namespace dgm
