// SPDX-License-Identifier: MIT
// libdgm/include/dgm/allocator.h
// Where the runtime takes its memory from: the caller decides, per object.
#pragma once
#include <cstddef>

namespace dgm {

/// Pair of functions and a context. Both null: the C library's heap.
///
/// `allocate` returns at least `bytes` bytes aligned to `alignment` (a power of two, at most 64), or null: the call
/// that asked then answers OutOfMemory and leaves nothing behind. `release` gets what `allocate` returned, with the
/// same `bytes`. Called only while objects are created and destroyed, never in per-tick calls.
struct Allocator {
    void* user = nullptr;
    void* (*allocate)(void* user, std::size_t bytes, std::size_t alignment) = nullptr;
    void (*release)(void* user, void* memory, std::size_t bytes) = nullptr;
};

}  // namespace dgm
