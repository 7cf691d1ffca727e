// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/memory_test.cpp
// The caller's allocator: asked for everything, given everything back, and allowed to say no at any time.
#include <gtest/gtest.h>

#include <dgm/deform.h>
#include <dgm/validate.h>

#include <cstdlib>
#include <map>

#include "opened.h"

namespace dgm::test {
namespace {

struct Counting {
    std::map<void*, std::size_t> live;
    int calls = 0, allowed = 1 << 30;
    bool mismatch = false;
    Allocator allocator() {
        return {this,
                [](void* user, std::size_t bytes, std::size_t alignment) -> void* {
                    auto* self = static_cast<Counting*>(user);
                    if (self->calls++ >= self->allowed) return nullptr;
                    void* memory = nullptr;
                    if (posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) != 0) return nullptr;
                    self->live[memory] = bytes;
                    return memory;
                },
                [](void* user, void* memory, std::size_t bytes) {
                    auto* self = static_cast<Counting*>(user);
                    self->mismatch |= self->live.count(memory) == 0 || self->live[memory] != bytes;
                    self->live.erase(memory);
                    std::free(memory);
                }};
    }
};

/// Everything that takes memory, in one go.
Error use_all(const Bytes& bytes, const Allocator& allocator) {
    OpenOptions open;
    open.allocator = allocator;
    auto asset = Asset::open_memory(bytes, open);
    if (!asset) return asset.error();
    const Chart chart = asset.value().chart(0).value();
    if (auto r = validate_chart(chart, allocator); !r) return r.error();
    StateOptions options;
    options.allocator = allocator;
    auto state = State::create(chart, options);
    if (!state) return state.error();
    auto table = DeformTable::create({}, allocator);
    return table ? Error{} : table.error();
}

TEST(Memory, EveryFailedAllocationIsOutOfMemoryAndLeavesNothing) {
    const Bytes bytes = build({free_chart(12, 10, sheet, {{121, 125}, {122, 126}})}).bytes;
    Counting all;
    ASSERT_EQ(use_all(bytes, all.allocator()).code, ErrorCode::Ok);
    EXPECT_TRUE(all.live.empty());
    EXPECT_FALSE(all.mismatch);
    ASSERT_GT(all.calls, 20);
    for (int allowed = 0; allowed < all.calls; ++allowed) {
        Counting some;
        some.allowed = allowed;
        EXPECT_EQ(use_all(bytes, some.allocator()).code, ErrorCode::OutOfMemory) << allowed;
        EXPECT_TRUE(some.live.empty()) << allowed;
        EXPECT_FALSE(some.mismatch);
    }
}

TEST(Memory, HalfAnAllocatorIsRefused) {
    const Bytes bytes = build({grid_chart(3, 3, sheet)}).bytes;
    Counting counting;
    Allocator half = counting.allocator();
    half.release = nullptr;
    EXPECT_EQ(use_all(bytes, half).code, ErrorCode::BadArgument);
    EXPECT_EQ(counting.calls, 0);
}

TEST(Memory, MaxBytesIsAnUpperBound) {
    const Opened opened(build({free_chart(40, 50, sheet)}));
    struct Sum {
        std::size_t now = 0, peak = 0;
    } sum;
    StateOptions options;
    options.allocator = {&sum,
                         [](void* user, std::size_t bytes, std::size_t alignment) -> void* {
                             auto* s = static_cast<Sum*>(user);
                             s->now += bytes;
                             s->peak = std::max(s->peak, s->now);
                             void* memory = nullptr;
                             return posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) == 0 ? memory
                                                                                                            : nullptr;
                         },
                         [](void* user, void* memory, std::size_t bytes) {
                             static_cast<Sum*>(user)->now -= bytes;
                             std::free(memory);
                         }};
    std::uint64_t low = 0, high = 1 << 24;  // the smallest limit that is accepted
    while (high - low > 1) {
        options.max_bytes = (low + high) / 2;
        (State::create(opened.chart(), options).ok() ? high : low) = options.max_bytes;
    }
    sum = {};
    options.max_bytes = high;
    ASSERT_TRUE(State::create(opened.chart(), options).ok());
    EXPECT_LE(sum.peak, high);
    EXPECT_EQ(sum.now, 0u);
}

}  // namespace
}  // namespace dgm::test
