// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/physics_map.h
// A baked map as a body with material, for benchmarks of dgm::physics.
#pragma once
#include <dgm/asset.h>
#include <dgm/physics.h>
#include <dgm/reconstruct.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

namespace dgm::bench {

[[noreturn]] inline void give_up(const std::string& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    std::exit(2);
}
template <class T>
T value_of(Result<T> result) {
    if (!result) give_up(result.error().message);
    return std::move(result).value();
}
inline double length(Vec3 v) {
    return std::sqrt(double{v.x} * double{v.x} + double{v.y} * double{v.y} + double{v.z} * double{v.z});
}

/// The first chart of a map. Where its file names no unit, the body has a diagonal of 0.15 m.
class PhysicsMap {
 public:
    explicit PhysicsMap(const std::string& file) : file_(file), asset_(value_of(Asset::open(file.c_str()))) {
        const State s = state();
        const PointView rest = s.rest_positions();
        Vec3 low = rest[0], high = rest[0];
        for (std::uint32_t k = 0; k < rest.count; ++k) {
            low = {std::min(low.x, rest[k].x), std::min(low.y, rest[k].y), std::min(low.z, rest[k].z)};
            high = {std::max(high.x, rest[k].x), std::max(high.y, rest[k].y), std::max(high.z, rest[k].z)};
            if (rest[k].z > rest[top_].z) top_ = k;
        }
        diagonal_ = length(high - low);
        metres_ = stored_material(s).metres_per_unit;
        if (metres_ == 0) metres_ = 0.15 / diagonal_;
    }
    [[nodiscard]] State state() const { return value_of(State::create(value_of(asset_.chart(0)))); }
    [[nodiscard]] const std::string& file() const { return file_; }
    [[nodiscard]] double metres() const { return metres_; }      ///< per local unit
    [[nodiscard]] double diagonal() const { return diagonal_; }  ///< local units
    [[nodiscard]] std::uint32_t top() const { return top_; }     ///< the highest sample

 private:
    std::string file_;
    Asset asset_;
    double diagonal_ = 0, metres_ = 0;
    std::uint32_t top_ = 0;
};

}  // namespace dgm::bench
