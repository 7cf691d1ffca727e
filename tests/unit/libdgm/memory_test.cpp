// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/memory_test.cpp
// The caller's allocator: it provides all memory, gets all of it back, and may fail at any time.
#include <gtest/gtest.h>

#include <dgm/contact.h>
#include <dgm/deform.h>
#include <dgm/dgm.h>
#include <dgm/snapshot.h>
#include <dgm/validate.h>

#include <cstdlib>
#include <map>

#include "opened.h"
#include "platform.h"

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
                    void* memory = take_aligned(bytes, alignment);
                    if (memory != nullptr) self->live[memory] = bytes;
                    return memory;
                },
                [](void* user, void* memory, std::size_t bytes) {
                    auto* self = static_cast<Counting*>(user);
                    self->mismatch |= self->live.count(memory) == 0 || self->live[memory] != bytes;
                    self->live.erase(memory);
                    give_aligned(memory);
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
    auto solver = ContactSolver::create(state.value(), allocator);
    if (!solver) return solver.error();
    SnapshotOptions snapshot;
    snapshot.allocator = allocator;
    auto snapshots = Snapshots::create(state.value(), snapshot);
    if (!snapshots) return snapshots.error();
    auto table = DeformTable::create({}, allocator);
    return table ? Error{} : table.error();
}

/// The same through the C interface. On an error no handle may be left in the caller's variable.
dgm_code use_all_in_c(const Bytes& bytes, const dgm_allocator& allocator) {
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    dgm_table* table = nullptr;
    dgm_contact_solver* solver = nullptr;
    dgm_snapshots* snapshots = nullptr;
    dgm_error error{};
    error.struct_size = sizeof error;
    dgm_kernel_options kernel{};
    kernel.struct_size = sizeof kernel;
    kernel.sigma = 16;
    kernel.reach = 11;
    dgm_code code = dgm_asset_open_memory(bytes.data(), bytes.size(), nullptr, &allocator, &asset, &error);
    if (code == DGM_OK) code = dgm_chart_validate(asset, 0, &allocator, &error);
    if (code == DGM_OK) code = dgm_state_create(asset, 0, nullptr, &allocator, &state, &error);
    if (code == DGM_OK) code = dgm_table_create(&kernel, &allocator, &table, &error);
    if (code == DGM_OK) code = dgm_contact_solver_create(state, &allocator, &solver, &error);
    if (code == DGM_OK) code = dgm_snapshots_create(state, nullptr, &allocator, &snapshots, &error);
    EXPECT_EQ(error.code, static_cast<std::uint32_t>(code));
    EXPECT_EQ(snapshots != nullptr, code == DGM_OK);
    EXPECT_FALSE(asset == nullptr && state != nullptr);
    EXPECT_FALSE(state == nullptr && (table != nullptr || solver != nullptr));
    dgm_snapshots_destroy(snapshots);
    dgm_contact_solver_destroy(solver);
    dgm_table_destroy(table);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
    return code;
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

TEST(Memory, EveryFailedAllocationOfTheCInterfaceIsOutOfMemory) {
    const Bytes bytes = build({free_chart(12, 10, sheet, {{121, 125}, {122, 126}})}).bytes;
    const auto in_c = [](Counting& counting) {
        const Allocator same = counting.allocator();
        dgm_allocator out{};
        out.struct_size = sizeof out;
        out.user = same.user;
        out.allocate = same.allocate;
        out.release = same.release;
        return out;
    };
    Counting all;
    ASSERT_EQ(use_all_in_c(bytes, in_c(all)), DGM_OK);
    EXPECT_TRUE(all.live.empty());
    ASSERT_GT(all.calls, 25);
    for (int allowed = 0; allowed < all.calls; ++allowed) {
        Counting some;
        some.allowed = allowed;
        EXPECT_EQ(use_all_in_c(bytes, in_c(some)), DGM_OUT_OF_MEMORY) << allowed;
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
                             return take_aligned(bytes, alignment);
                         },
                         [](void* user, void* memory, std::size_t bytes) {
                             static_cast<Sum*>(user)->now -= bytes;
                             give_aligned(memory);
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
