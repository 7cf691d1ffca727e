// SPDX-License-Identifier: MIT
// libdgm/src/base/memory.cpp
#include "base/memory.h"

#include <cstdlib>
#include <limits>
#if defined(_WIN32)
#include <malloc.h>
#endif

namespace dgm::detail {
namespace {
#if defined(_WIN32)  // has no aligned_alloc, and free() does not know memory of _aligned_malloc
void* take_aligned(std::size_t bytes, std::size_t alignment) noexcept {
    return ::_aligned_malloc(bytes, alignment);
}
void free_taken(void* memory) noexcept {
    ::_aligned_free(memory);
}
#else
void* take_aligned(std::size_t bytes, std::size_t alignment) noexcept {
    return std::aligned_alloc(alignment, bytes);
}
void free_taken(void* memory) noexcept {
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
    return rounded < bytes ? nullptr : take_aligned(rounded, alignment);
}

void release(const Allocator& allocator, void* memory, std::size_t bytes) noexcept {
    if (allocator.release != nullptr)
        allocator.release(allocator.user, memory, bytes);
    else
        free_taken(memory);
}

bool ArrayMemory::take(const Allocator& from, std::uint64_t count, std::size_t each) noexcept {
    if (count == 0) return true;
    if (count > std::numeric_limits<std::size_t>::max() / 2 / each) return false;
    void* const memory = allocate(from, static_cast<std::size_t>(count) * each, kMaxAlignment);
    if (memory == nullptr) return false;
    allocator = from;
    data = memory;
    size = static_cast<std::size_t>(count);
    return true;
}

void ArrayMemory::give_back(std::size_t each) noexcept {
    if (data != nullptr) release(allocator, data, size * each);
}

}  // namespace dgm::detail
