// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/bench/tick_times_test.cpp
#include "bench/tick_times.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

namespace dgm::bench {
namespace {

/// Two threads on one processor: this one and one that never rests.
class CrowdedProcessor {
 public:
    CrowdedProcessor() {
        sched_getaffinity(0, sizeof all_, &all_);
        cpu_set_t one;
        CPU_ZERO(&one);
        CPU_SET(sched_getcpu(), &one);
        crowded_ = sched_setaffinity(0, sizeof one, &one) == 0;
        rival_ = std::thread([this] {
            while (!done_) ++turns_;
        });
    }
    CrowdedProcessor(const CrowdedProcessor&) = delete;
    CrowdedProcessor& operator=(const CrowdedProcessor&) = delete;
    ~CrowdedProcessor() {
        done_ = true;
        rival_.join();
        sched_setaffinity(0, sizeof all_, &all_);
    }
    [[nodiscard]] bool crowded() const { return crowded_; }

 private:
    cpu_set_t all_{};
    bool crowded_ = false;
    std::atomic<bool> done_ = false;
    std::atomic<long> turns_ = 0;
    std::thread rival_;
};

long preemptions() {
    rusage use{};
    getrusage(RUSAGE_THREAD, &use);
    return use.ru_nivcsw;
}

TEST(TickTimes, EachTurnIsSetUpAndTimedOnce) {
    std::vector<std::size_t> order;
    const TickTimes times = time_ticks(
        2, 10, [&](std::size_t k) { order.push_back(2 * k); }, [&](std::size_t k) { order.push_back(2 * k + 1); });
    std::vector<std::size_t> all(24);
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
    EXPECT_EQ(order, all);
    EXPECT_LE(times.median.value, times.p999.value);
    EXPECT_LE(times.p999.value, times.longest.value);
}

TEST(TickTimes, TurnsThatAlwaysLoseTheirProcessorHaveATime) {
    const CrowdedProcessor crowd;
    if (!crowd.crowded()) GTEST_SKIP() << "threads cannot be bound to a processor here";
    const auto start = std::chrono::steady_clock::now();
    const TickTimes times = time_ticks(0, 5, nullptr, [](std::size_t) {
        for (const long before = preemptions(); preemptions() == before;) {}
    });
    const std::chrono::duration<double, std::micro> all = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(times.preempted, 5);
    EXPECT_EQ(times.median.repetitions, 5);
    EXPECT_GT(times.median.value, 0);
    EXPECT_LT(times.longest.value, all.count()) << "the rival's share is not counted";
}

}  // namespace
}  // namespace dgm::bench
