// SPDX-License-Identifier: MIT
// libdgm/src/base/double3.h
// The vector of double precision; Vec3 (dgm/vec.h) is that of single precision.
#pragma once
#include <dgm/vec.h>

#include <algorithm>

namespace dgm::detail {

struct Double3 {
    double x = 0, y = 0, z = 0;
};
[[nodiscard]] constexpr Double3 operator+(Double3 a, Double3 b) noexcept {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[nodiscard]] constexpr Double3 operator-(Double3 a, Double3 b) noexcept {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[nodiscard]] constexpr Double3 operator*(double s, Double3 a) noexcept {
    return {s * a.x, s * a.y, s * a.z};
}
[[nodiscard]] constexpr double dot(Double3 a, Double3 b) noexcept {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[nodiscard]] constexpr Double3 cross(Double3 a, Double3 b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Corners of the box around two points.
[[nodiscard]] constexpr Double3 least(Double3 a, Double3 b) noexcept {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
[[nodiscard]] constexpr Double3 greatest(Double3 a, Double3 b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
[[nodiscard]] constexpr Double3 widen(Vec3 a) noexcept {
    return {a.x, a.y, a.z};
}
[[nodiscard]] constexpr Vec3 narrow(Double3 a) noexcept {
    return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

}  // namespace dgm::detail
