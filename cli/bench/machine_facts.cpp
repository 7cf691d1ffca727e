// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/machine_facts.cpp
#include "bench/machine_facts.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string_view>
#include <thread>

#include "tool/version.h"

namespace dgm::bench {
namespace {

unsigned cores() {
    return std::max(1U, std::thread::hardware_concurrency());
}

std::string processor() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("model name")) return line.substr(std::min(line.find(':') + 2, line.size()));
    return "unknown";
}

std::string fact(const Pairs& pairs, std::string_view key) {
    for (const auto& [k, value] : pairs)
        if (k == key) return value;
    return {};
}

}  // namespace

double load_per_core() {
    double load = 0;
    return getloadavg(&load, 1) == 1 ? load / cores() : std::numeric_limits<double>::quiet_NaN();
}

Pairs machine_facts() {
    utsname system{};
    uname(&system);
    const double pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
    const double gib = pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1U << 30U);
    return {{"processor", processor()},
            {"cores", std::to_string(cores())},
            {"memory", fmt::format("{:.1f} GiB", gib)},
            {"system", fmt::format("{} {} {}", system.sysname, system.release, system.machine)},
            {"compiler", DGM_COMPILER},
            {"build", DGM_BUILD},
            {"version", tool::build_version()},
            {"load_per_core_at_start", fmt::format("{:.2f}", load_per_core())}};
}

bool same_hardware(const Pairs& a, const Pairs& b) {
    for (const char* key : {"processor", "cores", "compiler", "build"})
        if (fact(a, key) != fact(b, key)) return false;
    return true;
}

}  // namespace dgm::bench
