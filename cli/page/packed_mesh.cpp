// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/packed_mesh.cpp
#include "page/packed_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "page/grid_codes.h"

namespace dgm::page {
namespace {
constexpr double kCodes = 65535;

/// Bytes of numbers, all lowest ones first.
template <class T>
void append_planes(const std::vector<T>& numbers, std::vector<std::byte>& out) {
    for (std::size_t shift = 0; shift < 8 * sizeof(T); shift += 8)
        for (const T number : numbers) out.push_back(static_cast<std::byte>(number >> shift & 0xff));
}

}  // namespace

PackedMesh packed_mesh(std::span<const model::Vec3d> positions, std::span<const model::Face> faces) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    model::Vec3d low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    for (const model::Vec3d& p : positions)
        for (int k = 0; k < 3 && is_finite(p); ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
    PackedMesh out;
    if (is_finite(low)) out.low = low;
    const double extent = is_finite(low) ? std::max({high.x - low.x, high.y - low.y, high.z - low.z}) : 0;
    if (extent > 0 && std::isfinite(extent)) out.step = extent / kCodes;

    std::vector<std::uint16_t> places;
    std::array<std::uint16_t, 3> last{};
    for (const model::Vec3d& p : positions)
        for (int k = 0; k < 3; ++k) {
            const double place = is_finite(p) ? std::round((p[k] - out.low[k]) / out.step) : 0;
            const auto code = static_cast<std::uint16_t>(std::clamp(place, 0.0, kCodes));
            std::uint16_t& before = last[static_cast<std::size_t>(k)];
            places.push_back(sign_last(static_cast<std::uint16_t>(code - before)));
            before = code;
        }
    append_planes(places, out.bytes);
    std::vector<std::uint32_t> indices;
    std::uint32_t before = 0;
    for (const model::Face& f : faces)
        for (const std::uint32_t v : f) indices.push_back(sign_last(v - before)), before = v;
    append_planes(indices, out.bytes);
    return out;
}

}  // namespace dgm::page
