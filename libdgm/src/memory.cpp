// SPDX-License-Identifier: MIT
// libdgm/src/memory.cpp
#include "memory.h"

#include <cstdlib>

namespace dgm::detail {

bool is_valid(const Allocator& allocator) noexcept {
    return (allocator.allocate == nullptr) == (allocator.release == nullptr);
}

void* allocate(const Allocator& allocator, std::size_t bytes, std::size_t alignment) noexcept {
    if (allocator.allocate != nullptr) return allocator.allocate(allocator.user, bytes, alignment);
    const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;  // what aligned_alloc asks for
    return rounded < bytes ? nullptr
                           : std::aligned_alloc(alignment < sizeof(void*) ? sizeof(void*) : alignment, rounded);
}

void release(const Allocator& allocator, void* memory, std::size_t bytes) noexcept {
    if (allocator.release != nullptr)
        allocator.release(allocator.user, memory, bytes);
    else
        std::free(memory);
}

}  // namespace dgm::detail
