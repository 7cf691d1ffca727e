// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/platform.h
// Marks the tests of the runtime that cannot run everywhere. docs/platforms.md lists them with the reasons.
#pragma once
#include <cstddef>
#include <cstdlib>
#if defined(_WIN32)
#include <malloc.h>
#endif

#if defined(__wasm__)
#define DGM_TEST_THREADS 0  // Debian's libc++ for WebAssembly has none
#define DGM_TEST_FILES 0    // the runtime maps none there
#else
#define DGM_TEST_THREADS 1
#define DGM_TEST_FILES 1
#endif
#if defined(__linux__)
#define DGM_TEST_PAGES 1  // mincore() lists the pages of a file that are in memory
#else
#define DGM_TEST_PAGES 0
#endif

namespace dgm::test {

/// Memory for the allocators of tests, or null; given back by give_aligned().
inline void* take_aligned(std::size_t bytes, std::size_t alignment) {
    if (alignment < sizeof(void*)) alignment = sizeof(void*);
#if defined(_WIN32)
    return ::_aligned_malloc(bytes, alignment);
#else
    return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
#endif
}
inline void give_aligned(void* memory) {
#if defined(_WIN32)
    ::_aligned_free(memory);
#else
    std::free(memory);
#endif
}

}  // namespace dgm::test
