// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/spatial/lazy_index_test.cpp
#include "geometry/spatial/lazy_index.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "support/meshes.h"

namespace dgm::bake {
namespace {

using model::TriMesh;

TEST(LazyIndex, IsOneForAllThreads) {
    const TriMesh ball = test::icosphere(5);
    LazyIndex lazy(ball);
    std::vector<const ClosestPointIndex*> seen(64);
    std::atomic<int> wrong = 0;
    tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t k) {
        seen[k] = &lazy.get();
        if (std::abs(seen[k]->query({2, 0, 0}).distance - 1) > 1e-3) ++wrong;
    });
    EXPECT_EQ(wrong, 0);
    for (const ClosestPointIndex* index : seen) EXPECT_EQ(index, seen[0]);
}

TEST(LazyIndex, AnswersAsBeforeOnceItWasDropped) {
    const TriMesh ball = test::icosphere(3);
    LazyIndex lazy(ball);
    const ClosestPoint before = lazy.get().query({0.3, 2, 0.1});
    lazy.drop();
    lazy.drop();
    const ClosestPoint after = lazy.get().query({0.3, 2, 0.1});
    EXPECT_EQ(after.face, before.face);
    EXPECT_EQ(after.distance, before.distance);
}

constexpr std::size_t kDeep = 1 << 16;

/// Bytes of the stack below the caller get `value`. @return one of them
[[gnu::noinline]] char fill_stack(char value) {
    std::array<volatile char, kDeep> bytes;
    for (volatile char& b : bytes) b = value;
    return bytes[kDeep / 2];
}

/// In tasks whose group lies amid those bytes.
[[gnu::noinline]] char build_deep_down(LazyIndex& index) {
    std::array<volatile char, kDeep / 2> bytes;
    for (volatile char& b : bytes) b = 1;
    tbb::parallel_for(0, 4, [&](int) { (void)index.get(); });
    return bytes[kDeep / 4];
}

TEST(LazyIndex, OutlivesTheTasksInWhichItIsBuilt) {
    // Of a group of tasks that ends by an exception TBB looks for the children among all groups that there are, by way
    // of their parents.
    const TriMesh ball = test::icosphere(4);
    LazyIndex lazy(ball);
    EXPECT_EQ(build_deep_down(lazy), 1);
    EXPECT_EQ(fill_stack(0x55), 0x55);
    const auto fail = [](int) {
        tbb::parallel_for(0, 4, [](int) {});  // a child, or it would not look
        throw std::runtime_error("asked for");
    };
    EXPECT_THROW(tbb::parallel_for(0, 4, fail), std::runtime_error);
    EXPECT_GT(lazy.get().query({2, 0, 0}).distance, 0.9);
}

}  // namespace
}  // namespace dgm::bake
