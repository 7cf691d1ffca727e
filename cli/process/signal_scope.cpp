// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/signal_scope.cpp
#include "process/signal_scope.h"

#include <poll.h>

#include <algorithm>
#include <chrono>

namespace dgm::bake {
namespace {
volatile sig_atomic_t g_stop_requested = 0;
}  // namespace

SignalScope::SignalScope() {
    g_stop_requested = 0;
    sigset_t blocked;
    sigemptyset(&blocked);
    struct sigaction action {};
    action.sa_handler = [](int) { g_stop_requested = 1; };
    for (std::size_t k = 0; k < kSignals.size(); ++k) {
        sigaddset(&blocked, kSignals[k]);
        sigaction(kSignals[k], &action, &old_actions_[k]);
    }
    sigprocmask(SIG_BLOCK, &blocked, &old_mask_);
}

SignalScope::~SignalScope() {
    for (std::size_t k = 0; k < kSignals.size(); ++k) sigaction(kSignals[k], &old_actions_[k], nullptr);
    sigprocmask(SIG_SETMASK, &old_mask_, nullptr);
}

bool SignalScope::stop_requested() const {
    return g_stop_requested != 0;
}

void SignalScope::wait(const std::vector<const ChildProcess*>& workers, bool more_to_do) const {
    constexpr std::chrono::nanoseconds kTick = std::chrono::milliseconds(200), kEndTick = std::chrono::milliseconds(2);
    std::vector<pollfd> descriptors;
    std::chrono::nanoseconds longest = workers.empty() || more_to_do ? std::chrono::nanoseconds{0} : kTick;
    for (const ChildProcess* worker : workers) {
        if (worker->messages() >= 0) descriptors.push_back({worker->messages(), POLLIN, 0});
        if (worker->errors() >= 0) descriptors.push_back({worker->errors(), POLLIN, 0});
        if (worker->messages() < 0 && worker->errors() < 0) longest = std::min(longest, kEndTick);
    }
    const timespec timeout{static_cast<time_t>(longest.count() / 1'000'000'000), longest.count() % 1'000'000'000};
    ppoll(descriptors.data(), descriptors.size(), &timeout, &old_mask_);
}

}  // namespace dgm::bake
