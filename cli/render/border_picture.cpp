// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/border_picture.cpp
#include "render/border_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "math/portable.h"
#include "model/codes.h"
#include "model/element.h"
#include "model/octahedral.h"
#include "render/canvas.h"
#include "render/colour.h"
#include "render/layer_values.h"

namespace dgm::render {
namespace {
using formats::Image;
using model::Chart;
using model::element_value;
using model::ElementType;
using model::Layer;
using model::Rgba8;
using model::Vec2d;
using model::Vec3d;

constexpr Rgba8 kSurface{250, 250, 249, 255};

/// Pixel positions (x = v, y = u) of the extra samples of a free domain; none in a square domain.
std::vector<Vec2d> border_pixels(const Chart& chart) {
    std::vector<Vec2d> pixels;
    const Layer* layer = chart.find("border_uv");
    if (layer == nullptr) return pixels;
    const std::uint64_t count = list_length(*layer, ElementType::kF32, 2);
    for (std::uint64_t b = 0; b < count; ++b) {
        const double u = element_value(*layer, 2 * b), v = element_value(*layer, 2 * b + 1);
        if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1))
            throw model::Error(model::codes::kBadLayerShape, fmt::format("border sample {} lies outside the square", b),
                               "border_uv");
        pixels.push_back({v * (chart.cols - 1), u * (chart.rows - 1)});
    }
    return pixels;
}

Image surface_image(const Chart& chart) {
    Image image = blank(chart.cols, chart.rows, kSurface);
    if (const Layer* layer = chart.find("mask")) {
        const Plane mask = read_plane(*layer, {ElementType::kU8}, 1, chart.rows, chart.cols);
        for (std::size_t s = 0; s < mask.values.size(); ++s)
            if (mask.values[s] == 0) image.pixels[s] = kOffSurface;
    }
    return image;
}

/// Angle about the middle of the square as 0..1, so that neighbours along a border have neighbouring colours.
double turn(const Chart& chart, Vec2d pixel) {
    const double x = 2 * pixel.x / (chart.cols - 1) - 1, y = 2 * pixel.y / (chart.rows - 1) - 1;
    return math::atan2(y, x) / (2 * math::acos(-1.0)) + 0.5;
}

double dot_radius(const Chart& chart) {
    return std::max(0.0, std::max(chart.rows, chart.cols) / 90.0 - 0.5);
}

void fill_triangle(Image& image, const Vec2d (&p)[3], Rgba8 colour) {
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    if (area == 0) return;
    const auto range = [](double a, double b, double c, std::uint32_t side) {
        const double low = std::floor(std::min({a, b, c})), high = std::ceil(std::max({a, b, c}));
        return std::pair(static_cast<std::int64_t>(std::clamp(low, 0.0, side - 1.0)),
                         static_cast<std::int64_t>(std::clamp(high, 0.0, side - 1.0)));
    };
    const auto [x0, x1] = range(p[0].x, p[1].x, p[2].x, image.width);
    const auto [y0, y1] = range(p[0].y, p[1].y, p[2].y, image.height);
    for (std::int64_t y = y0; y <= y1; ++y)
        for (std::int64_t x = x0; x <= x1; ++x) {
            const Vec2d q{static_cast<double>(x), static_cast<double>(y)};
            const double a = cross(p[1] - p[0], q - p[0]) / area, b = cross(p[2] - p[1], q - p[1]) / area,
                         c = cross(p[0] - p[2], q - p[2]) / area;
            if (a >= 0 && b >= 0 && c >= 0) fill_rectangle(image, x, y, 1, 1, colour);
        }
}

/// Where sample `index` of the grid or, beyond it, of the border stands in the picture.
Vec2d sample_pixel(const Chart& chart, const std::vector<Vec2d>& border, std::uint64_t index) {
    const std::uint64_t grid = std::uint64_t{chart.rows} * chart.cols;
    if (index < grid) return {static_cast<double>(index % chart.cols), static_cast<double>(index / chart.cols)};
    return border[index - grid];
}

std::uint64_t sample_count(const Chart& chart, const std::vector<Vec2d>& border) {
    return std::uint64_t{chart.rows} * chart.cols + border.size();
}
}  // namespace

Rgba8 position_colour(const Chart& chart, const Vec3d& position) {
    std::uint8_t channel[3];
    for (int k = 0; k < 3; ++k) {
        const double low = chart.bbox[static_cast<std::size_t>(k)], high = chart.bbox[static_cast<std::size_t>(k) + 3];
        const double share = high > low ? (position[k] - low) / (high - low) : 0.5;
        channel[k] = std::isnan(share) ? 0 : static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
    }
    return {channel[0], channel[1], channel[2], 255};
}

Rgba8 normal_colour(const Vec3d& n) {
    const auto channel = [](double c) {
        return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::clamp(c, -1.0, 1.0)));
    };
    return {channel(n.x), channel(n.y), channel(n.z), 255};
}

LayerPicture seam_picture(const Chart& chart, const Layer& seams) {
    const std::uint64_t pairs = list_length(seams, ElementType::kU32, 2);
    const std::vector<Vec2d> border = border_pixels(chart);
    const std::uint64_t samples = sample_count(chart, border);
    std::map<std::uint64_t, std::set<std::uint64_t>> classes;
    for (std::uint64_t k = 0; k < pairs; ++k) {
        const auto representative = static_cast<std::uint64_t>(element_value(seams, 2 * k));
        const auto copy = static_cast<std::uint64_t>(element_value(seams, 2 * k + 1));
        if (representative >= samples || copy >= samples)
            throw model::Error(model::codes::kBadSeamTable,
                               fmt::format("pair {} names sample {} of {}", k, std::max(representative, copy), samples),
                               "seams");
        classes[representative].insert({representative, copy});
    }
    Image image = surface_image(chart);
    for (const auto& [representative, members] : classes) {
        const Rgba8 colour = cyclic_colour(turn(chart, sample_pixel(chart, border, representative)));
        for (const std::uint64_t member : members) {
            const Vec2d p = sample_pixel(chart, border, member);
            fill_disc(image, std::round(p.x), std::round(p.y), dot_radius(chart), colour);
        }
    }
    return {image, fmt::format("{} pairs, {} classes", pairs, classes.size())};
}

LayerPicture border_picture(const Chart& chart, const Layer& layer) {
    const std::vector<Vec2d> border = border_pixels(chart);
    const std::uint64_t samples = sample_count(chart, border);
    Image image = surface_image(chart);
    std::uint64_t faces = 0;
    if (const Layer* strip = chart.find("border_faces")) {
        faces = list_length(*strip, ElementType::kU32, 3);
        for (std::uint64_t f = 0; f < faces; ++f) {
            Vec2d p[3];
            for (std::uint64_t k = 0; k < 3; ++k) {
                const auto index = static_cast<std::uint64_t>(element_value(*strip, 3 * f + k));
                if (index >= samples)
                    throw model::Error(model::codes::kBadLayerShape,
                                       fmt::format("face {} names sample {} of {}", f, index, samples), "border_faces");
                p[k] = sample_pixel(chart, border, index);
            }
            fill_triangle(image, p, f % 2 == 0 ? Rgba8{150, 190, 196, 255} : Rgba8{184, 212, 208, 255});
        }
    }
    const bool positions = layer.name == "border_geometry", normals = layer.name == "border_normal";
    if ((positions && list_length(layer, layer.type, 3) != border.size()) ||
        (normals && list_length(layer, ElementType::kI16, 2) != border.size()) ||
        (positions && layer.type != ElementType::kF32 && layer.type != ElementType::kU16))
        throw model::Error(model::codes::kBadLayerShape, "it does not fit border_uv", layer.name);
    for (std::size_t b = 0; b < border.size(); ++b) {
        Rgba8 colour = kInk;
        if (positions) {
            const Layer* grid = chart.find("geometry");
            const bool scaled = grid == nullptr || grid->type == layer.type;
            Vec3d p;
            for (int k = 0; k < 3; ++k) {
                const auto axis = static_cast<std::size_t>(k);
                p[k] = chart.offset[axis] + (scaled ? chart.scale[axis] : 1.0) * element_value(layer, 3 * b + axis);
            }
            colour = position_colour(chart, p);
        } else if (normals) {
            colour =
                normal_colour(model::decode_octahedral({static_cast<std::int16_t>(element_value(layer, 2 * b)),
                                                        static_cast<std::int16_t>(element_value(layer, 2 * b + 1))}));
        }
        fill_disc(image, std::round(border[b].x), std::round(border[b].y), 0.5 * dot_radius(chart), colour);
    }
    return {image, fmt::format("{} samples, {} faces", border.size(), faces)};
}

}  // namespace dgm::render
