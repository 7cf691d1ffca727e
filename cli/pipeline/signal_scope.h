// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/signal_scope.h
// Ctrl-C while workers run.
#pragma once
#include <poll.h>
#include <signal.h>

#include <array>
#include <chrono>
#include <vector>

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
    /// Until a descriptor is ready, a signal comes, or `longest` is over.
    void wait(std::vector<pollfd>& descriptors, std::chrono::nanoseconds longest) const;

 private:
    static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
    std::array<struct sigaction, kSignals.size()> old_actions_{};
    sigset_t old_mask_{};
};

}  // namespace dgm::bake
