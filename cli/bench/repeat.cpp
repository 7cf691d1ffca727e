// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/repeat.cpp
#include "bench/repeat.h"

#include <algorithm>
#include <chrono>
#include <string>

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

std::vector<bake::AssetResult> bake_repeatedly(const std::vector<std::filesystem::path>& sources,
                                               const bake::BakeOptions& options, const BakeRepeats& repeats,
                                               const std::filesystem::path& folder,
                                               const std::function<void(double)>& on_share) {
    bake::BatchPlan plan;
    plan.folder = folder;
    for (const std::filesystem::path& source : sources)
        for (unsigned k = 0; k < repeats.repetitions; ++k) {
            const std::string name = std::to_string(plan.assets.size()) + ".dgm";
            plan.assets.push_back({source, folder / name, {}, std::nullopt, name, options});
        }
    bake::BatchOptions batch;
    batch.force = true;
    batch.jobs = repeats.jobs;
    batch.threads = repeats.threads;
    batch.time_limit_seconds = repeats.time_limit_seconds;
    batch.memory_bytes = repeats.memory_bytes;
    std::size_t ended = 0;
    bake::BatchObserver observer;
    observer.on_end = [&](std::size_t) {
        ++ended;
        on_share(static_cast<double>(ended) / static_cast<double>(plan.assets.size()));
    };
    observer.on_tick = [&] { on_share(static_cast<double>(ended) / static_cast<double>(plan.assets.size())); };
    std::vector<bake::AssetResult> results = bake::run_batch(plan, batch, observer);
    for (const bake::AssetResult& r : results)
        if (r.outcome == bake::Outcome::kInterrupted || r.outcome == bake::Outcome::kNotStarted)
            throw model::Error(model::codes::kInterrupted, "the sweep was interrupted");
    return results;
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
