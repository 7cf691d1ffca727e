// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/chart_pictures.cpp
#include "export/chart_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "export/tangent_space.h"
#include "render/chart_surface.h"

namespace dgm::exporter {
namespace {
using formats::Image;
using model::Rgba8;
using model::Vec3d;

/// The texels that one texel of the result is made of, and their shares.
struct Tap {
    std::uint32_t first = 0;
    std::vector<double> weights;
};

/// A line of `from` texels with `to` texels; the middles of both ends stay.
std::vector<Tap> taps(std::uint32_t from, std::uint32_t to) {
    const double step = to > 1 ? (from - 1.0) / (to - 1.0) : 0;
    const double reach = std::max(1.0, step);
    std::vector<Tap> out(to);
    for (std::uint32_t k = 0; k < to; ++k) {
        const double at = to > 1 ? k * step : 0.5 * (from - 1.0);
        const double low = std::max(0.0, std::floor(at - reach) + 1), high = std::min(from - 1.0, at + reach);
        out[k].first = static_cast<std::uint32_t>(low);
        double sum = 0;
        for (double x = low; x <= high; ++x) {
            out[k].weights.push_back(std::max(0.0, 1 - std::abs(x - at) / reach));
            sum += out[k].weights.back();
        }
        for (double& weight : out[k].weights) weight /= sum;
    }
    return out;
}

using Texel = std::array<double, 4>;

void add(Texel& sum, const Texel& texel, double weight) {
    for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * texel[c];
}

Rgba8 rounded(const Texel& texel, Texels texels) {
    Texel out = texel;
    if (texels == Texels::kNormals) {
        const Vec3d n = normalized(Vec3d{texel[0] / 127.5 - 1, texel[1] / 127.5 - 1, texel[2] / 127.5 - 1}, {0, 0, 1});
        out = {128 + 127.5 * n.x - 0.5, 128 + 127.5 * n.y - 0.5, 128 + 127.5 * n.z - 0.5, texel[3]};
    }
    const auto code = [](double c) {
        return static_cast<std::uint8_t>(std::clamp(std::floor(c + 0.5 + 1e-6), 0.0, 255.0));
    };
    return {code(out[0]), code(out[1]), code(out[2]), code(out[3])};
}

Image with_powers_of_two(const Image& picture, Texels texels) {
    return resized(picture, nearest_power_of_two(picture.width), nearest_power_of_two(picture.height), texels);
}
}  // namespace

ChartPictures chart_pictures(const model::Chart& chart, const bake::Reconstruction& surface, const ChartMesh& mesh,
                             bool power_of_two) {
    ChartPictures out;
    out.colour = render::texture_picture(chart);
    if (chart.find("bump") != nullptr && !mesh.normals.empty() && !mesh.uvs.empty()) {
        out.tangents = vertex_tangents(mesh);
        out.normal_map = tangent_normal_map(chart, surface, mesh, out.tangents);
        if (!out.normal_map) out.tangents.clear();
    }
    if (!power_of_two) return out;
    if (!out.colour.pixels.empty()) out.colour = with_powers_of_two(out.colour, Texels::kColour);
    if (out.normal_map) out.normal_map = with_powers_of_two(*out.normal_map, Texels::kNormals);
    return out;
}

void share_size(ChartPictures& pictures) {
    if (pictures.colour.pixels.empty() || !pictures.normal_map) return;
    const std::uint32_t width = std::max(pictures.colour.width, pictures.normal_map->width);
    const std::uint32_t height = std::max(pictures.colour.height, pictures.normal_map->height);
    pictures.colour = resized(pictures.colour, width, height, Texels::kColour);
    pictures.normal_map = resized(*pictures.normal_map, width, height, Texels::kNormals);
}

std::uint32_t nearest_power_of_two(std::uint32_t side) {
    std::uint32_t low = 1;
    while (low < formats::kMaxImageSide && 2 * low <= side) low *= 2;
    // side / low against 2 low / side
    const bool up = std::uint64_t{side} * side >= 2 * std::uint64_t{low} * low;
    return up ? std::min(2 * low, formats::kMaxImageSide) : low;
}

Image resized(const Image& picture, std::uint32_t width, std::uint32_t height, Texels texels) {
    if (picture.width == width && picture.height == height) return picture;
    const std::vector<Tap> across = taps(picture.width, width), down = taps(picture.height, height);
    Image out{width, height, std::vector<Rgba8>(std::size_t{width} * height)};
    std::vector<Texel> row(picture.width);
    for (std::uint32_t y = 0; y < height; ++y) {
        std::fill(row.begin(), row.end(), Texel{});
        for (std::uint32_t k = 0; k < down[y].weights.size(); ++k)
            for (std::uint32_t x = 0; x < picture.width; ++x) {
                const Rgba8& p = picture.at(x, down[y].first + k);
                add(row[x], {1.0 * p.r, 1.0 * p.g, 1.0 * p.b, 1.0 * p.a}, down[y].weights[k]);
            }
        for (std::uint32_t x = 0; x < width; ++x) {
            Texel sum{};
            for (std::size_t k = 0; k < across[x].weights.size(); ++k)
                add(sum, row[across[x].first + k], across[x].weights[k]);
            out.pixels[std::size_t{y} * width + x] = rounded(sum, texels);
        }
    }
    return out;
}

}  // namespace dgm::exporter
