// SPDX-License-Identifier: MIT
// libdgm/web/touch_shared.h
// What the parts of a page's runtime share; touch.cpp has the rules.
#pragma once
#include <cstdint>

#include <dgm/dgm.h>

#define TOUCH_API extern "C" /* CMakeLists.txt exports the functions that start with it */

namespace touch {
inline constexpr std::uint32_t kMostTools = 4;

/// A struct of the C interface with its size set.
template <class T>
T sized() {
    T out{};
    out.struct_size = sizeof(T);
    return out;
}

extern double answers[64];
extern dgm_error error;
extern dgm_tool_input tools[kMostTools];
extern float places[];

/// An obstacle of a kind: a plane (a point of it, and its normal), a ball (middle, radius) or a capsule (both ends,
/// radius).
dgm_obstacle obstacle_of(std::uint32_t kind, const float (&p)[3], const float (&q)[3], float radius);
}  // namespace touch

struct Body;
dgm_state* state_of(const Body* body);
