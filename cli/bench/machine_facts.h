// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/machine_facts.h
#pragma once
#include "bench/table.h"

namespace dgm::bench {

/// Processor, cores, memory, system, compiler, build, version, and the load when the run began. No host name.
[[nodiscard]] Pairs machine_facts();

/// True if times of the two may be compared: equal processor, cores, compiler and build.
[[nodiscard]] bool same_hardware(const Pairs& a, const Pairs& b);

/// Mean number of other runnable threads in the last minute, a core; NaN if the system does not report it.
[[nodiscard]] double load_per_core();

}  // namespace dgm::bench
