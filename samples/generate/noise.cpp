// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/noise.cpp
// [Worley 1996] Worley. A cellular texture basis function. SIGGRAPH 1996.
#include "noise.h"

#include <algorithm>
#include <cmath>

namespace dgm::samples {
namespace {
using model::Vec3d;

std::uint32_t mix(std::uint32_t h) {
    h ^= h >> 16;
    h *= 0x7feb352dU;
    h ^= h >> 15;
    h *= 0x846ca68bU;
    return h ^ (h >> 16);
}

double fade(double t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}
double lerp(double a, double b, double t) {
    return a + (b - a) * t;
}
std::int64_t wrap(std::int64_t i, int period) {
    return ((i % period) + period) % period;
}
}  // namespace

double hash01(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
    std::uint32_t h = mix(seed + 0x9e3779b9U);
    h = mix(h ^ static_cast<std::uint32_t>(x));
    h = mix(h ^ (static_cast<std::uint32_t>(y) * 3U + 1U));
    h = mix(h ^ (static_cast<std::uint32_t>(z) * 5U + 2U));
    return h / 4294967296.0;
}

double noise3(const Vec3d& p, std::uint32_t seed) {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy),
               iz = static_cast<std::int64_t>(fz);
    const double u = fade(p.x - fx), v = fade(p.y - fy), w = fade(p.z - fz);
    const auto row = [&](int dy, int dz) {
        return lerp(hash01(ix, iy + dy, iz + dz, seed), hash01(ix + 1, iy + dy, iz + dz, seed), u);
    };
    return 2 * lerp(lerp(row(0, 0), row(1, 0), v), lerp(row(0, 1), row(1, 1), v), w) - 1;
}

double fractal3(const Vec3d& p, int octaves, std::uint32_t seed) {
    double sum = 0, weight = 1, total = 0, frequency = 1;
    for (int k = 0; k < octaves; ++k) {
        sum += weight * noise3(p * frequency, seed + static_cast<std::uint32_t>(k));
        total += weight;
        weight *= 0.5;
        frequency *= 2;
    }
    return total > 0 ? sum / total : 0;
}

double tiled_noise2(double x, double y, int period_x, int period_y, std::uint32_t seed) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const double u = fade(x - fx), v = fade(y - fy);
    const auto at = [&](int dx, int dy) { return hash01(wrap(ix + dx, period_x), wrap(iy + dy, period_y), 0, seed); };
    return 2 * lerp(lerp(at(0, 0), at(1, 0), u), lerp(at(0, 1), at(1, 1), u), v) - 1;
}

Cells cells3(const Vec3d& p, std::uint32_t seed) {
    const auto ix = static_cast<std::int64_t>(std::floor(p.x)), iy = static_cast<std::int64_t>(std::floor(p.y)),
               iz = static_cast<std::int64_t>(std::floor(p.z));
    Cells out{8, 8, 0};
    for (std::int64_t z = iz - 1; z <= iz + 1; ++z)
        for (std::int64_t y = iy - 1; y <= iy + 1; ++y)
            for (std::int64_t x = ix - 1; x <= ix + 1; ++x) {
                const Vec3d q{static_cast<double>(x) + hash01(x, y, z, seed),
                              static_cast<double>(y) + hash01(x, y, z, seed + 1),
                              static_cast<double>(z) + hash01(x, y, z, seed + 2)};
                const double d = length(p - q);
                if (d < out.nearest) {
                    out = {d, out.nearest, hash01(x, y, z, seed + 3)};
                } else {
                    out.second = std::min(out.second, d);
                }
            }
    return out;
}

double smooth_step(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

}  // namespace dgm::samples
