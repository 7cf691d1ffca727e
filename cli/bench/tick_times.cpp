// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/tick_times.cpp
#include "bench/tick_times.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "baking/cpu_clock.h"
#include "bench/interrupt.h"

namespace dgm::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kBlocks = 5;

/// Times the thread was taken off the processor.
long preemptions() {
    rusage use{};
    getrusage(RUSAGE_THREAD, &use);
    return use.ru_nivcsw;
}

}  // namespace

TickTimes time_ticks(std::size_t warm_up, std::size_t ticks, const std::function<void(std::size_t)>& set_up,
                     const std::function<void(std::size_t)>& turn) {
    TickTimes out;
    std::vector<double> median, p99, p999;
    double longest = 0;
    for (std::size_t k = 0; k < warm_up; ++k) {
        if (set_up) set_up(k);
        turn(k);
    }
    for (std::size_t block = 0, k = warm_up; block < kBlocks; ++block) {
        stop_if_interrupted();
        std::vector<double> times, interrupted;
        for (const std::size_t end = warm_up + (block + 1) * ticks / kBlocks; k < end; ++k) {
            if (set_up) set_up(k);
            const long switches = preemptions();
            const bake::CpuClock computed(bake::CpuClock::Of::kThread);
            const auto start = Clock::now();
            turn(k);
            const double took = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
            if (preemptions() == switches)
                times.push_back(took);
            else
                interrupted.push_back(1e6 * computed.seconds());
        }
        out.preempted += interrupted.size();
        if (times.empty()) times = std::move(interrupted);
        if (times.empty()) continue;
        median.push_back(quantile(times, 0.5));
        p99.push_back(quantile(times, 0.99));
        p999.push_back(quantile(times, 0.999));
        longest = std::max(longest, *std::max_element(times.begin(), times.end()));
    }
    out.median = summarize(median);
    out.p99 = summarize(p99);
    out.p999 = summarize(p999);
    out.longest = {longest, longest, longest, 1, false};
    return out;
}

}  // namespace dgm::bench
