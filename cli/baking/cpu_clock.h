// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/cpu_clock.h
// CPU time of the process since a moment, all threads together: the measure of speed, since it hardly depends on other
// programs.
#pragma once
#include <ctime>

namespace dgm::bake {

class CpuClock {
 public:
    [[nodiscard]] double seconds() const { return now() - start_; }

 private:
    static double now() {
        timespec t{};
        if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t) != 0) return 0;
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }
    double start_ = now();
};

}  // namespace dgm::bake
