// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_loop.cpp
#include "baking/component/component_loop.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <vector>

namespace dgm::bake {

void for_each_component(std::size_t count, const model::Progress& progress,
                        const std::function<void(std::size_t, const model::Progress&)>& work) {
    std::mutex mutex;
    std::vector<double> shares(count, 0.0);
    double sum = 0;
    std::vector<std::exception_ptr> failures(count);
    std::atomic<std::size_t> lowest_failure{count};

    const auto run = [&](std::size_t k) {
        if (k > lowest_failure.load(std::memory_order_relaxed)) return;
        model::Progress part;
        part.cancelled = progress.cancelled;
        part.on_update = [&, k](std::string_view stage, double share) {
            const std::lock_guard lock(mutex);
            const double risen = std::max(shares[k], share);
            sum += risen - shares[k];
            shares[k] = risen;
            progress.update(stage, sum / static_cast<double>(count));
        };
        try {
            // A thread that waits within one component must not start another one on top of it.
            tbb::this_task_arena::isolate([&] { work(k, part); });
            const std::lock_guard lock(mutex);
            sum += 1 - shares[k];
            shares[k] = 1;
        } catch (...) {
            failures[k] = std::current_exception();
            std::size_t lowest = lowest_failure.load(std::memory_order_relaxed);
            while (k < lowest && !lowest_failure.compare_exchange_weak(lowest, k, std::memory_order_relaxed)) {}
        }
    };
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t k = range.begin(); k != range.end(); ++k) run(k);
        },
        tbb::simple_partitioner());
    if (lowest_failure < count) std::rethrow_exception(failures[lowest_failure]);
}

}  // namespace dgm::bake
