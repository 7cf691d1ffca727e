// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/signal_scope.h
// Ctrl-C while workers run.
#pragma once
#include <signal.h>

#include <array>
#include <vector>

#include "process/child_process.h"

namespace dgm::bake {

/// Turns SIGINT, SIGTERM and SIGHUP into a flag while it lives; their handlers are restored at the end. They stay
/// blocked but inside wait(), so none is missed. One at a time, on the thread that waits.
class SignalScope {
 public:
    SignalScope();
    SignalScope(const SignalScope&) = delete;
    SignalScope& operator=(const SignalScope&) = delete;
    ~SignalScope();
    [[nodiscard]] bool stop_requested() const;
    /// Until a worker has sent something, a signal comes, or it is time to look at clocks and at workers that have
    /// closed both their pipes: their end follows within milliseconds, and no descriptor signals it. Not at all if
    /// `more_to_do` or there is no worker.
    void wait(const std::vector<const ChildProcess*>& workers, bool more_to_do) const;

 private:
    static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
    std::array<struct sigaction, kSignals.size()> old_actions_{};
    sigset_t old_mask_{};
};

}  // namespace dgm::bake
