// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_log.cpp
#include "baking/stage_log.h"

namespace dgm::bake {
namespace {

/// One rising share from steps whose number is not known beforehand (start, descent, other candidates). Each step
/// counts from 0 to 1, and gets half of the share that is left.
class OpenSteps {
 public:
    double operator()(double share) {
        if (share < last_) left_ /= 2;
        last_ = share;
        return 1 - left_ + left_ / 2 * share;
    }

 private:
    double last_ = 0, left_ = 1;
};

}  // namespace

model::Progress part_of(const model::Progress& whole, std::string stage, std::size_t k, std::size_t count) {
    model::Progress out;
    out.cancelled = whole.cancelled;
    out.on_update = [&whole, stage = std::move(stage), k, count, steps = OpenSteps()](std::string_view inner,
                                                                                      double share) mutable {
        const bool cut = inner == "cut", counted = cut || stage != "map";
        whole.update(cut ? "cut" : stage,
                     (static_cast<double>(k) + (counted ? share : steps(share))) / static_cast<double>(count));
    };
    return out;
}

model::Progress StageLog::progress() const {
    model::Progress out;
    out.cancelled = progress_.cancelled;
    out.on_update = [this](std::string_view stage, double share) {
        progress_.update(trial_ + std::string(stage), share);
    };
    return out;
}

void StageLog::record(const std::string& shown, double seconds, double cpu_seconds) {
    if (times_.empty() || times_.back().stage != shown) times_.push_back({shown, 0, 0});
    times_.back().seconds += seconds;
    times_.back().cpu_seconds += cpu_seconds;
}

}  // namespace dgm::bake
