// SPDX-License-Identifier: MIT
// libdgm/web/heap.cpp
// Memory for modules: malloc() and its kin in a tenth of the bytes of the C library's. A page takes few blocks, large
// ones, and from one thread, so a list of what is free, in the order of addresses, is searched for the first that fits.
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace {
constexpr std::size_t kPage = 65536, kUnit = 16;

/// Stands before each block. A free block has the next one behind it, as a free list.
struct Block {
    std::size_t size;  // bytes behind this header, a multiple of kUnit
    Block* next;       // while it is free
    std::size_t unused[2];
};
static_assert(sizeof(Block) == kUnit);

Block* first_free = nullptr;

char* begin_of(Block* block) {
    return reinterpret_cast<char*>(block + 1);
}
bool adjacent(Block* a, const Block* b) {
    return begin_of(a) + a->size == reinterpret_cast<const char*>(b);
}

/// Gives a block back: neighbours become one.
void put(Block* block) {
    Block *before = nullptr, *after = first_free;
    for (; after != nullptr && after < block; after = after->next) before = after;
    block->next = after;
    if (after != nullptr && adjacent(block, after)) {
        block->size += kUnit + after->size;
        block->next = after->next;
    }
    if (before == nullptr) {
        first_free = block;
    } else if (adjacent(before, block)) {
        before->size += kUnit + block->size;
        before->next = block->next;
    } else {
        before->next = block;
    }
}

/// Makes the memory larger. False: there is no more.
bool grow(std::size_t bytes) {
    const std::size_t pages = (bytes + kUnit + kPage - 1) / kPage, at = __builtin_wasm_memory_grow(0, pages);
    if (at == SIZE_MAX) return false;
    auto* block = reinterpret_cast<Block*>(at * kPage);
    block->size = pages * kPage - kUnit;
    put(block);
    return true;
}

/// Where a block for `bytes` at `alignment` begins in `block`, its header before it; null: it does not fit. What is
/// left before it is nothing, or large enough for a header.
char* place_in(Block* block, std::size_t bytes, std::size_t alignment) {
    const auto begin = reinterpret_cast<std::uintptr_t>(begin_of(block));
    std::uintptr_t at = (begin + alignment - 1) & ~(alignment - 1);
    return at - begin <= block->size && bytes <= block->size - (at - begin) ? reinterpret_cast<char*>(at) : nullptr;
}

void* take(std::size_t bytes, std::size_t alignment) {
    if (bytes > PTRDIFF_MAX - kPage - alignment) return nullptr;
    bytes = bytes < kUnit ? kUnit : (bytes + kUnit - 1) & ~(kUnit - 1);
    for (int attempt = 0; attempt < 2; ++attempt) {
        for (Block **link = &first_free, *block = first_free; block != nullptr; link = &block->next, block = *link) {
            char* at = place_in(block, bytes, alignment);
            if (at == nullptr) continue;
            // The free block keeps what lies before; what lies behind becomes one of its own.
            char* const end = begin_of(block) + block->size;
            if (at == begin_of(block)) {
                *link = block->next;
            } else {
                block->size = static_cast<std::size_t>(at - begin_of(block)) - kUnit;
            }
            Block* taken = reinterpret_cast<Block*>(at) - 1;
            taken->size = static_cast<std::size_t>(end - at);
            if (taken->size >= bytes + 2 * kUnit) {
                auto* rest = reinterpret_cast<Block*>(at + bytes);
                rest->size = taken->size - bytes - kUnit;
                taken->size = bytes;
                put(rest);
            }
            return at;
        }
        if (!grow(bytes + alignment)) return nullptr;
    }
    return nullptr;
}
}  // namespace

extern "C" {
void* malloc(std::size_t bytes) {
    return take(bytes, kUnit);
}
void free(void* memory) {
    if (memory != nullptr) put(static_cast<Block*>(memory) - 1);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
    return take(bytes, alignment < kUnit ? kUnit : alignment);
}
void* calloc(std::size_t count, std::size_t each) {
    if (each != 0 && count > SIZE_MAX / each) return nullptr;
    void* out = take(count * each, kUnit);
    return out == nullptr ? nullptr : std::memset(out, 0, count * each);
}
void* realloc(void* memory, std::size_t bytes) {
    void* out = take(bytes, kUnit);
    if (out == nullptr || memory == nullptr) return out;
    const std::size_t had = (static_cast<Block*>(memory) - 1)->size;
    std::memcpy(out, memory, had < bytes ? had : bytes);
    free(memory);
    return out;
}
}
