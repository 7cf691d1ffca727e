// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/vec.h
// Small double-precision vectors of the offline side. The runtime has its own, in float.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

namespace dgm::model {

struct Vec2d {
    double x = 0, y = 0;
    friend constexpr Vec2d operator+(Vec2d a, Vec2d b) { return {a.x + b.x, a.y + b.y}; }
    friend constexpr Vec2d operator-(Vec2d a, Vec2d b) { return {a.x - b.x, a.y - b.y}; }
    friend constexpr Vec2d operator*(Vec2d a, double s) { return {a.x * s, a.y * s}; }
    friend constexpr Vec2d operator*(double s, Vec2d a) { return a * s; }
    friend constexpr bool operator==(const Vec2d&, const Vec2d&) = default;
};

struct Vec3d {
    double x = 0, y = 0, z = 0;
    constexpr double operator[](int k) const { return k == 0 ? x : k == 1 ? y : z; }
    constexpr double& operator[](int k) { return k == 0 ? x : k == 1 ? y : z; }
    friend constexpr Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr Vec3d operator-(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr Vec3d operator-(const Vec3d& a) { return {-a.x, -a.y, -a.z}; }
    friend constexpr Vec3d operator*(const Vec3d& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
    friend constexpr Vec3d operator*(double s, const Vec3d& a) { return a * s; }
    friend constexpr Vec3d operator/(const Vec3d& a, double s) { return {a.x / s, a.y / s, a.z / s}; }
    constexpr Vec3d& operator+=(const Vec3d& b) { return *this = *this + b; }
    constexpr Vec3d& operator-=(const Vec3d& b) { return *this = *this - b; }
    constexpr Vec3d& operator*=(double s) { return *this = *this * s; }
    friend constexpr bool operator==(const Vec3d&, const Vec3d&) = default;
};

constexpr double dot(Vec2d a, Vec2d b) {
    return a.x * b.x + a.y * b.y;
}
constexpr double cross(Vec2d a, Vec2d b) {
    return a.x * b.y - a.y * b.x;
}
inline double length(Vec2d a) {
    return std::sqrt(dot(a, a));
}
constexpr double dot(const Vec3d& a, const Vec3d& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3d cross(const Vec3d& a, const Vec3d& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vec3d& a) {
    return std::sqrt(dot(a, a));
}
/// Unit vector along `a`, or `fallback` where `a` has no direction (zero or not finite).
inline Vec3d normalized(const Vec3d& a, const Vec3d& fallback = {0, 0, 1}) {
    const double l = length(a);
    return l > 0 && std::isfinite(l) ? a / l : fallback;
}
inline bool is_finite(const Vec3d& a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// Corner vertex indices of a triangle, counter-clockwise seen from outside.
using Face = std::array<std::uint32_t, 3>;

}  // namespace dgm::model
