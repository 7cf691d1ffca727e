// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/repeat.cpp
#include "bench/repeat.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <numeric>
#include <string>
#include <utility>

#include "model/codes.h"

namespace dgm::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBlocks = 5;
constexpr double kBlockSeconds = 0.01;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

std::vector<std::vector<bake::AssetResult>> bake_all(const std::vector<BakeTask>& tasks, const BakeRepeats& repeats,
                                                     const std::filesystem::path& folder,
                                                     const std::function<void(double)>& on_share,
                                                     const std::function<void(std::size_t)>& on_task) {
    std::vector<std::size_t> order(tasks.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return tasks[a].work > tasks[b].work; });
    bake::BatchPlan plan;
    plan.folder = folder;
    std::vector<std::size_t> task_of;  // each planned bake's
    double work = 0;
    for (const std::size_t task : order)
        for (unsigned k = 0; k < tasks[task].repetitions; ++k) {
            const std::string name = std::to_string(plan.assets.size()) + ".dgm";
            plan.assets.push_back({tasks[task].source, folder / name, {}, std::nullopt, name, tasks[task].options});
            task_of.push_back(task);
            work += tasks[task].work;
        }
    bake::BatchOptions batch;
    batch.force = true;
    batch.jobs = repeats.jobs;
    batch.threads = repeats.threads;
    batch.time_limit_seconds = repeats.time_limit_seconds;
    batch.memory_bytes = repeats.memory_bytes;
    double done = 0;
    bake::BatchObserver observer;
    observer.on_start = [&](std::size_t k) {
        if (on_task) on_task(task_of[k]);
    };
    observer.on_end = [&](std::size_t k, const bake::AssetResult&) {
        done += tasks[task_of[k]].work;
        on_share(done / work);
        std::error_code ignored;
        if (k > 0 && task_of[k - 1] == task_of[k]) std::filesystem::remove(plan.assets[k].dgm, ignored);
    };
    observer.on_tick = [&] { on_share(done / work); };
    std::vector<bake::AssetResult> results = bake::run_batch(plan, batch, observer);
    std::vector<std::vector<bake::AssetResult>> out(tasks.size());
    for (std::size_t k = 0; k < results.size(); ++k) {
        if (results[k].outcome == bake::Outcome::kInterrupted || results[k].outcome == bake::Outcome::kNotStarted)
            throw model::Error(model::codes::kInterrupted, "the sweep was interrupted");
        out[task_of[k]].push_back(std::move(results[k]));
    }
    return out;
}

std::vector<bake::AssetResult> bake_repeatedly(const std::vector<std::filesystem::path>& sources,
                                               const bake::BakeOptions& options, const BakeRepeats& repeats,
                                               const std::filesystem::path& folder,
                                               const std::function<void(double)>& on_share) {
    std::vector<BakeTask> tasks;
    tasks.reserve(sources.size());
    for (const std::filesystem::path& source : sources) tasks.push_back({source, options, repeats.repetitions});
    std::vector<bake::AssetResult> out;
    for (std::vector<bake::AssetResult>& results : bake_all(tasks, repeats, folder, on_share))
        std::move(results.begin(), results.end(), std::back_inserter(out));
    return out;
}

Figure figure_of(const std::vector<bake::AssetResult>& results,
                 const std::function<double(const bake::AssetResult&)>& quantity) {
    std::vector<double> values;
    for (const bake::AssetResult& r : results)
        if (r.outcome == bake::Outcome::kBaked) values.push_back(quantity(r));
    return summarize(values);
}

Figure time_of_call(const std::function<void()>& body) {
    const auto warm = Clock::now();
    body();
    const double once = std::max(seconds_since(warm), 1e-9);
    const int calls = static_cast<int>(std::clamp(kBlockSeconds / once, 1.0, 1e6));
    std::vector<double> means;
    for (int block = 0; block < kBlocks; ++block) {
        const auto start = Clock::now();
        for (int k = 0; k < calls; ++k) body();
        means.push_back(seconds_since(start) / calls);
    }
    return summarize(means);
}

}  // namespace dgm::bench
