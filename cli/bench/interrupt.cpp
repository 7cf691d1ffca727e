// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/interrupt.cpp
#include "bench/interrupt.h"

#include <signal.h>

#include "model/codes.h"

namespace dgm::bench {
namespace {

volatile sig_atomic_t g_interrupted = 0;

}  // namespace

void listen_for_interrupts() {
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) signal(number, [](int) { g_interrupted = 1; });
}

void stop_if_interrupted() {
    if (g_interrupted != 0) throw model::Error(model::codes::kInterrupted, "the sweep was interrupted");
}

}  // namespace dgm::bench
