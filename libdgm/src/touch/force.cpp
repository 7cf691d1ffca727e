// SPDX-License-Identifier: MIT
// libdgm/src/touch/force.cpp
#include <dgm/force.h>

#include <algorithm>
#include <cmath>

namespace dgm {

Result<Vec3> contact_force(Vec3 d, float d_max, float f_max) noexcept {
    if (!std::isfinite(d.x) || !std::isfinite(d.y) || !std::isfinite(d.z))
        return Error{ErrorCode::BadArgument, kNoOffset, "the displacement is not finite"};
    if (!std::isfinite(d_max) || !(d_max > 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "d_max is not a positive number"};
    if (!std::isfinite(f_max) || !(f_max >= 0))
        return Error{ErrorCode::BadArgument, kNoOffset, "f_max is not a number from 0"};
    const auto axis = [&](float v) {
        const double r = std::clamp(double{v} / d_max, -1.0, 1.0);
        return static_cast<float>(-(r * r * r) * f_max);
    };
    return Vec3{axis(d.x), axis(d.y), axis(d.z)};
}

}  // namespace dgm
