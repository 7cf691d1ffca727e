// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/minutes.h
// How progress tells times.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>

namespace dgm::tool {

/// Minutes and whole seconds, as in 2:07. @param seconds  not negative
[[nodiscard]] inline std::string minutes(double seconds) {
    const long long whole = std::llround(seconds);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace dgm::tool
