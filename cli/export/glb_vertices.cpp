// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/glb_vertices.cpp
#include "export/glb_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/codes.h"

namespace dgm::exporter {
namespace {
using model::Vec2d;
using model::Vec3d;

constexpr double kLargestU16 = 65535, kLargestI8 = 127;

std::array<float, 3> floats(const Vec3d& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

std::int8_t signed_share(double c) {
    return static_cast<std::int8_t>(std::lround(std::clamp(c, -1.0, 1.0) * kLargestI8));
}
std::uint16_t share(double c) {
    return static_cast<std::uint16_t>(std::lround(std::clamp(c, 0.0, 1.0) * kLargestU16));
}

/// The entries of `used`, in their order, as `convert` stores them.
template <class Out, class In, class Convert>
std::vector<Out> gathered(std::span<const std::uint32_t> used, const std::vector<In>& values, Convert convert) {
    std::vector<Out> out;
    out.reserve(used.size());
    for (const std::uint32_t v : used) out.push_back(convert(values[v]));
    return out;
}

/// The bounds of what is stored, as numbers of JSON. A float goes as double: its shortest text need not be the same
/// number to a reader that computes in double.
template <class Number>
void set_bounds(GlbBuffer::Json& accessor, const std::vector<std::array<Number, 3>>& values) {
    std::array<double, 3> low{}, high{};
    for (std::size_t c = 0; c < 3; ++c) {
        low[c] = high[c] = values[0][c];
        for (const std::array<Number, 3>& p : values) {
            low[c] = std::min<double>(low[c], p[c]);
            high[c] = std::max<double>(high[c], p[c]);
        }
    }
    accessor["min"] = low, accessor["max"] = high;
}
}  // namespace

std::size_t GlbVertices::add_positions(GlbFrame& frame) {
    const auto positions = gathered<std::array<float, 3>>(used_, mesh_.positions, floats);
    for (const std::array<float, 3>& p : positions)
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
            throw model::Error(model::codes::kNotFinite, "a vertex is not finite in single precision", "geometry");
    if (!quantize_) {
        const std::size_t accessor = buffer_.add_vertices(positions, kFloat);
        set_bounds(buffer_.accessor(accessor), positions);
        return accessor;
    }
    Vec3d low = mesh_.positions[used_[0]], high = low;
    for (const std::uint32_t v : used_)
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], mesh_.positions[v][c]);
            high[c] = std::max(high[c], mesh_.positions[v][c]);
        }
    // One scale for all axes: another would bend normals.
    const double longest = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    const double side = longest > 0 ? longest : 1;
    const auto codes = gathered<std::array<std::uint16_t, 3>>(used_, mesh_.positions, [&](const Vec3d& p) {
        return std::array{share((p.x - low.x) / side), share((p.y - low.y) / side), share((p.z - low.z) / side)};
    });
    frame.translation += low * frame.scale;
    frame.scale *= side;
    const std::size_t accessor = buffer_.add_vertices(codes, kUnsignedShort);
    set_bounds(buffer_.accessor(accessor), codes);
    return accessor;
}

std::size_t GlbVertices::add_normals() {
    if (!quantize_) return buffer_.add_vertices(gathered<std::array<float, 3>>(used_, mesh_.normals, floats), kFloat);
    return buffer_.add_vertices(gathered<std::array<std::int8_t, 3>>(
                                    used_, mesh_.normals,
                                    [](const Vec3d& n) {
                                        return std::array{signed_share(n.x), signed_share(n.y), signed_share(n.z)};
                                    }),
                                kByte);
}

std::size_t GlbVertices::add_tangents(const std::vector<Vec3d>& tangents) {
    if (!quantize_)
        return buffer_.add_vertices(gathered<std::array<float, 4>>(used_, tangents,
                                                                   [](const Vec3d& t) {
                                                                       const auto [x, y, z] = floats(t);
                                                                       return std::array{x, y, z, 1.0f};
                                                                   }),
                                    kFloat);
    return buffer_.add_vertices(
        gathered<std::array<std::int8_t, 4>>(
            used_, tangents,
            [](const Vec3d& t) {
                return std::array{signed_share(t.x), signed_share(t.y), signed_share(t.z), signed_share(1)};
            }),
        kByte);
}

std::size_t GlbVertices::add_uvs(std::uint32_t across, std::uint32_t down) {
    if (!quantize_)
        return buffer_.add_vertices(
            gathered<std::array<float, 2>>(used_, mesh_.uvs,
                                           [&](const Vec2d& uv) {
                                               const Vec2d at = place_in_picture(uv, across, down);
                                               return std::array{static_cast<float>(at.x), static_cast<float>(at.y)};
                                           }),
            kFloat);
    return buffer_.add_vertices(gathered<std::array<std::uint16_t, 2>>(used_, mesh_.uvs,
                                                                       [&](const Vec2d& uv) {
                                                                           const Vec2d at =
                                                                               place_in_picture(uv, across, down);
                                                                           return std::array{share(at.x), share(at.y)};
                                                                       }),
                                kUnsignedShort);
}

}  // namespace dgm::exporter
