// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/progress.h
// Lets a long computation report its progress and learn that it should stop.
#pragma once
#include <atomic>
#include <functional>
#include <string_view>

#include "model/codes.h"

namespace dgm::model {

/// Passed down by reference. Thread-safe only in `cancelled`.
struct Progress {
    std::function<void(std::string_view stage, double share)>
        on_update;  ///< share of the stage done, 0..1; may be empty
    const std::atomic<bool>* cancelled = nullptr;

    /// Reports, and throws Error(kInterrupted) if the caller asked to stop. Call at least every 100 ms.
    void update(std::string_view stage, double share) const {
        if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed))
            throw Error(codes::kInterrupted, "interrupted during " + std::string(stage));
        if (on_update) on_update(stage, share);
    }
};

}  // namespace dgm::model
