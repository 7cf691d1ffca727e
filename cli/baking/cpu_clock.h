// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/cpu_clock.h
// CPU time since a moment: the measure of speed, since it hardly depends on other programs.
#pragma once
#include <ctime>

namespace dgm::bake {

class CpuClock {
 public:
    enum class Of {
        kProcess,  ///< all threads together
        kThread    ///< the calling one, where others do something else
    };
    explicit CpuClock(Of of = Of::kProcess) : of_(of) {}
    [[nodiscard]] double seconds() const { return now() - start_; }

 private:
    [[nodiscard]] double now() const {
        timespec t{};
        if (clock_gettime(of_ == Of::kThread ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID, &t) != 0) return 0;
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }
    Of of_;
    double start_ = now();
};

}  // namespace dgm::bake
