// SPDX-License-Identifier: MIT
// libdgm/src/base/memory.cpp
#include "base/memory.h"

#include <cstdlib>
#if defined(_WIN32)
#include <malloc.h>
#endif

namespace dgm::detail {
namespace {
#if defined(_WIN32)  // has no aligned_alloc, and free() does not know memory of _aligned_malloc
void* take(std::size_t bytes, std::size_t alignment) noexcept {
    return ::_aligned_malloc(bytes, alignment);
}
void give_back(void* memory) noexcept {
    ::_aligned_free(memory);
}
#else
void* take(std::size_t bytes, std::size_t alignment) noexcept {
    return std::aligned_alloc(alignment, bytes);
}
void give_back(void* memory) noexcept {
    std::free(memory);
}
#endif
}  // namespace

bool is_valid(const Allocator& allocator) noexcept {
    return (allocator.allocate == nullptr) == (allocator.release == nullptr);
}

void* allocate(const Allocator& allocator, std::size_t bytes, std::size_t alignment) noexcept {
    if (allocator.allocate != nullptr) return allocator.allocate(allocator.user, bytes, alignment);
    if (alignment < sizeof(void*)) alignment = sizeof(void*);
    const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;  // as aligned_alloc requires
    return rounded < bytes ? nullptr : take(rounded, alignment);
}

void release(const Allocator& allocator, void* memory, std::size_t bytes) noexcept {
    if (allocator.release != nullptr)
        allocator.release(allocator.user, memory, bytes);
    else
        give_back(memory);
}

}  // namespace dgm::detail
