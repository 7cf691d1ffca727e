// SPDX-License-Identifier: MIT
// libdgm/include/dgm/octahedral.h
// Decodes octahedral 2 x 16-bit unit vectors (layer `normal`).
//
// [Cigolle 2014] Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer. A Survey of Efficient Representations for
// Independent Unit Vectors. JCGT 3(2), 2014.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

namespace dgm {

/// Returns the unit vector of code (u, v). u and v are snorm, c -> max(c / 32767, -1): the point of the octahedron
/// |x| + |y| + |z| = 1 unfolded along z < 0 [Cigolle 2014], then scaled to length 1 in float.
/// Every pair of codes is valid. On the border of the square two pairs give the same direction; the encoder writes the
/// one whose other coordinate is positive, and never -32768.
[[nodiscard]] inline std::array<float, 3> decode_octahedral(std::int16_t u, std::int16_t v) noexcept {
    float x = u <= -32767 ? -1.0f : static_cast<float>(u) / 32767.0f;
    float y = v <= -32767 ? -1.0f : static_cast<float>(v) / 32767.0f;
    const float z = 1.0f - std::fabs(x) - std::fabs(y);
    const float fold = z < 0.0f ? -z : 0.0f;
    x += x >= 0.0f ? -fold : fold;
    y += y >= 0.0f ? -fold : fold;
    const float length = std::sqrt(x * x + y * y + z * z);  // at least 1/sqrt(3)
    return {x / length, y / length, z / length};
}

}  // namespace dgm
