// SPDX-License-Identifier: MIT
// libdgm/include/dgm/allocator.h
// Lets the caller provide the memory of each object of the runtime.
#pragma once
#include <cstddef>

namespace dgm {

/// Two functions and a context. If both functions are null, the C library's heap is used.
///
/// `allocate` returns at least `bytes` bytes aligned to `alignment` (a power of two, at most 64), or null: the call
/// that needs the memory then returns OutOfMemory and leaves nothing behind. `release` takes back what `allocate`
/// returned, with the same `bytes`. Both are called only while objects are created and destroyed, never in per-tick
/// calls.
struct Allocator {
    void* user = nullptr;  ///< passed to both functions; must stay valid until the object is destroyed
    void* (*allocate)(void* user, std::size_t bytes, std::size_t alignment) = nullptr;
    void (*release)(void* user, void* memory, std::size_t bytes) = nullptr;
};

}  // namespace dgm
