// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/same_places.cpp
#include "geometry/metrics/same_places.h"

#include <bit>
#include <cstddef>
#include <limits>

namespace dgm::bake {
namespace {

using model::Vec3d;

std::uint64_t hash_of(const Vec3d& p) {
    std::uint64_t out = 0;
    for (int k = 0; k < 3; ++k) {
        out ^= std::bit_cast<std::uint64_t>(p[k] + 0.0);  // -0 is 0
        out *= 0x9e3779b97f4a7c15u;
        out ^= out >> 32;
    }
    return out;
}

}  // namespace

std::vector<std::uint32_t> first_at_same_place(std::span<const Vec3d> points) {
    constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
    const std::size_t places = std::bit_ceil(2 * points.size() + 1);
    std::vector<std::uint32_t> table(places, kFree), out(points.size());
    for (std::uint32_t k = 0; k < points.size(); ++k) {
        std::size_t at = hash_of(points[k]) & (places - 1);
        while (table[at] != kFree && !(points[table[at]] == points[k])) at = (at + 1) & (places - 1);
        if (table[at] == kFree) table[at] = k;
        out[k] = table[at];
    }
    return out;
}

}  // namespace dgm::bake
