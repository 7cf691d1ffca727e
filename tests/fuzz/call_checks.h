// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/call_checks.h
// Laws that a state obeys after every call, whatever the call was.
#pragma once
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <dgm/state.h>

namespace dgm::test {

/// Says which promise was broken, then aborts.
inline void promise(bool kept, const char* what) {
    if (kept) return;
    std::fprintf(stderr, "broken promise: %s\n", what);
    std::abort();
}

/// Prints each call on stderr if the variable DGM_FUZZ_SAY is set: read it when a program broke a promise.
inline bool is_saying() {
    static const bool saying = std::getenv("DGM_FUZZ_SAY") != nullptr;
    return saying;
}
#define DGM_SAY(...) (is_saying() ? static_cast<void>(std::fprintf(stderr, __VA_ARGS__)) : static_cast<void>(0))

using Shape = std::vector<Vec3>;

inline Shape shape_of(const PointView& points) {
    Shape all(points.count);
    for (std::size_t k = 0; k < points.count; ++k) all[k] = points[k];
    return all;
}
inline bool same_bits(const Shape& a, const Shape& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0);
}
inline bool is_finite(Vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline double length(Vec3 v) {
    return std::sqrt(double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z);
}

/// Points are finite, and copies of a class hold the same bits.
/// @param or_opposite  copies whose faces wind against the representative's have the opposite, as normals do
inline void check_points(const State& state, const PointView& points, const char* torn, const char* infinite,
                         bool or_opposite = false) {
    for (std::size_t k = 0; k < points.count; ++k) promise(is_finite(points[k]), infinite);
    for (std::uint32_t id = 0; id < state.class_count(); ++id) {
        const auto members = state.class_members(id);
        const Vec3 first = points[members[0]];
        for (const std::uint32_t copy : members) {
            const Vec3 p = points[copy];
            const bool is_same = std::memcmp(&p, &first, sizeof p) == 0 ||
                                 (or_opposite && p.x == -first.x && p.y == -first.y && p.z == -first.z);
            if (!is_same)
                DGM_SAY("class %u: sample %u at %a %a %a, sample %u at %a %a %a\n", id, members[0], first.x, first.y,
                        first.z, copy, p.x, p.y, p.z);
            promise(is_same, torn);
            promise(state.class_of(copy) == id, "a member of a class is not in it");
        }
    }
}
inline void check_state(const State& state) {
    check_points(state, state.positions(), "copies of a weld class are apart", "a position is not finite");
}
inline void check_normals(const State& state) {
    const PointView normals = state.normals();
    check_points(state, normals, "normals of copies differ", "a normal is not finite", true);
    for (std::size_t k = 0; k < normals.count; ++k) {
        const double l = length(normals[k]);
        promise(l == 0 || std::fabs(l - 1) < 1e-3, "a normal is neither 0 nor a unit vector");
    }
}

}  // namespace dgm::test
