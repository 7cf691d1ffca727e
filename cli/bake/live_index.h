// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/live_index.h
// The index of an HTML report while its batch still runs: there from the first finished asset on.
#pragma once
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "batch/batch_plan.h"
#include "batch/batch_runner.h"

namespace dgm::bake {

class LiveIndex {
 public:
    /// `plan` must outlive it. An empty `index`: nothing is written.
    LiveIndex(std::filesystem::path index, const BatchPlan& plan) : index_(std::move(index)), plan_(plan) {}

    /// Puts the asset into the index: at once for the first, later at most every second and for a twentieth of the
    /// time. What cannot be written is not told here: the whole report comes at the end and tells.
    void add(std::size_t asset, const AssetResult& result);

 private:
    using Clock = std::chrono::steady_clock;
    void write();

    std::filesystem::path index_;
    const BatchPlan& plan_;
    std::map<std::size_t, nlohmann::json> assets_;  ///< those that are through, in the order of the plan
    Clock::time_point next_;
};

}  // namespace dgm::bake
