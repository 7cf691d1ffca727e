// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/asked.h
// Numbers that whoever runs a test may ask for in the environment.
#pragma once
#include <cstdlib>

namespace dgm::test {

/// The number in a variable of the environment, or `otherwise` if there is no such variable.
inline long asked(const char* name, long otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : std::atol(text);
}

}  // namespace dgm::test
