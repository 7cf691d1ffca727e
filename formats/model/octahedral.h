// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/octahedral.h
// Octahedral unit vectors of the layer `normal`: the encoder, and the runtime's decoder in the baker's types.
//
// [Cigolle 2014], as libdgm/include/dgm/octahedral.h.
#pragma once
#include <dgm/octahedral.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "model/vec.h"

namespace dgm::model {

using OctahedralCode = std::array<std::int16_t, 2>;

/// Exactly the vector that the runtime decodes, each float widened.
[[nodiscard]] inline Vec3d decode_octahedral(const OctahedralCode& code) {
    const std::array<float, 3> n = dgm::decode_octahedral(code[0], code[1]);
    return {n[0], n[1], n[2]};
}

/// Canonical code nearest to the direction of `n`, which need not be of length 1; (0, 0), that is +z, where `n` is zero
/// or not finite. encode(decode(c)) == c for every canonical c, and decode(encode(decode(c))) == decode(c) up to float
/// rounding for every c.
[[nodiscard]] inline OctahedralCode encode_octahedral(const Vec3d& n) {
    const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    if (!is_finite(n) || !(largest > 0)) return {0, 0};
    const Vec3d q{n.x / largest, n.y / largest, n.z / largest};  // so that the sum below cannot overflow or vanish
    const double sum = std::abs(q.x) + std::abs(q.y) + std::abs(q.z);
    double x = q.x / sum, y = q.y / sum;
    if (q.z < 0) {
        const double folded_x = (1 - std::abs(y)) * (x >= 0 ? 1 : -1);
        y = (1 - std::abs(x)) * (y >= 0 ? 1 : -1);
        x = folded_x;
    }
    long u = std::lround(x * 32767.0), v = std::lround(y * 32767.0);
    // Border points (1, v) and (1, -v) are one direction; so are (u, 1) and (-u, 1).
    if (std::labs(u) == 32767) v = std::labs(v);
    if (std::labs(v) == 32767) u = std::labs(u);
    return {static_cast<std::int16_t>(u), static_cast<std::int16_t>(v)};
}

}  // namespace dgm::model
