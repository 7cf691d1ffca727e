// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/interrupt.h
#pragma once

namespace dgm::bench {

/// From now on stop_if_interrupted() receives SIGINT, SIGTERM and SIGHUP, so that temporary files are removed. (While
/// bakes run, run_batch receives them.)
void listen_for_interrupts();

/// @throws model::Error kInterrupted once such a signal has come
void stop_if_interrupted();

}  // namespace dgm::bench
