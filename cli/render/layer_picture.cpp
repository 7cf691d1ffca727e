// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/layer_picture.cpp
#include "render/layer_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <dgm/grid.h>

#include "model/codes.h"
#include "model/element.h"
#include "model/octahedral.h"
#include "render/border_picture.h"
#include "render/canvas.h"
#include "render/colour.h"
#include "render/layer_values.h"
#include "render/percentile.h"

namespace dgm::render {
namespace {
using formats::Image;
using model::Chart;
using model::element_value;
using model::ElementType;
using model::Layer;
using model::Rgba8;

constexpr ElementType kF32 = ElementType::kF32;

/// Which samples are on the surface; all of them without a mask.
class OnSurface {
 public:
    explicit OnSurface(const Chart& chart) {
        if (const Layer* mask = chart.find("mask"))
            mask_ = read_plane(*mask, {ElementType::kU8}, 1, chart.rows, chart.cols);
    }
    bool operator()(std::uint32_t i, std::uint32_t j) const { return mask_.values.empty() || mask_.at(i, j) != 0; }

 private:
    Plane mask_;
};

template <class Colour>
Image paint(std::uint32_t rows, std::uint32_t cols, Colour colour) {
    Image image = blank(cols, rows);
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < cols; ++j) image.pixels[std::size_t{i} * cols + j] = colour(i, j);
    return image;
}

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
    void add(double x) {
        if (std::isfinite(x)) {
            low = std::min(low, x);
            high = std::max(high, x);
        }
    }
    [[nodiscard]] bool empty() const { return low > high; }
    [[nodiscard]] double share(double x) const {
        if (std::isnan(x)) return x;
        return high > low ? (x - low) / (high - low) : 0.5;
    }
    [[nodiscard]] double reach() const { return empty() ? 0 : std::max(std::abs(low), std::abs(high)); }
    [[nodiscard]] std::string text() const {
        return empty() ? "no values" : fmt::format("{:.3g} .. {:.3g}", low, high);
    }
};

Range range_of(const Plane& plane, std::uint32_t channel, const OnSurface& on_surface) {
    Range range;
    for (std::uint32_t i = 0; i < plane.rows; ++i)
        for (std::uint32_t j = 0; j < plane.cols; ++j)
            if (on_surface(i, j)) range.add(plane.at(i, j, channel));
    return range;
}

Image sequential(const Plane& plane, std::uint32_t channel, const OnSurface& on_surface) {
    const Range range = range_of(plane, channel, on_surface);
    return paint(plane.rows, plane.cols, [&](std::uint32_t i, std::uint32_t j) {
        return on_surface(i, j) ? sequential_colour(range.share(plane.at(i, j, channel))) : kOffSurface;
    });
}

Image diverging(const Plane& plane, std::uint32_t channel, double reach,
                const std::function<bool(std::uint32_t, std::uint32_t)>& shown) {
    return paint(plane.rows, plane.cols, [&](std::uint32_t i, std::uint32_t j) {
        return shown(i, j) ? diverging_colour(reach > 0 ? plane.at(i, j, channel) / reach : 0 * plane.at(i, j, channel))
                           : kOffSurface;
    });
}

Image tiles(const std::vector<Image>& parts, std::uint32_t columns) {
    const std::uint32_t w = parts[0].width, h = parts[0].height;
    const auto lines = static_cast<std::uint32_t>((parts.size() + columns - 1) / columns);
    Image sheet =
        blank(columns * w + (columns - 1) * kTileGap, lines * h + (lines - 1) * kTileGap, {255, 255, 255, 255});
    for (std::uint32_t k = 0; k < parts.size(); ++k)
        paste(sheet, parts[k], (k % columns) * (w + kTileGap), (k / columns) * (h + kTileGap));
    return sheet;
}

LayerPicture geometry(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {kF32, ElementType::kU16}, 3, chart.rows, chart.cols);
    const OnSurface on_surface(chart);
    const auto image = paint(chart.rows, chart.cols, [&](std::uint32_t i, std::uint32_t j) {
        if (!on_surface(i, j)) return kOffSurface;
        model::Vec3d p;
        for (int k = 0; k < 3; ++k) {
            const auto axis = static_cast<std::size_t>(k);
            p[k] = chart.offset[axis] + chart.scale[axis] * plane.at(i, j, static_cast<std::uint32_t>(k));
        }
        return position_colour(chart, p);
    });
    return {image, "x y z as red green blue"};
}

LayerPicture normal(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {ElementType::kI16}, 2, chart.rows, chart.cols);
    const OnSurface on_surface(chart);
    const auto image = paint(chart.rows, chart.cols, [&](std::uint32_t i, std::uint32_t j) {
        if (!on_surface(i, j)) return kOffSurface;
        return normal_colour(model::decode_octahedral(
            {static_cast<std::int16_t>(plane.at(i, j, 0)), static_cast<std::int16_t>(plane.at(i, j, 1))}));
    });
    return {image, "x y z as red green blue"};
}

LayerPicture texture(const Chart&, const Layer& layer) {
    const Plane plane = read_plane(layer, {ElementType::kU8}, 4);
    const auto image = paint(plane.rows, plane.cols, [&](std::uint32_t i, std::uint32_t j) {
        const auto byte = [&](std::uint32_t c) { return static_cast<std::uint8_t>(plane.at(i, j, c)); };
        return Rgba8{byte(0), byte(1), byte(2), byte(3)};
    });
    return {image, "sRGB"};
}

LayerPicture bump(const Chart&, const Layer& layer) {
    const Plane plane = read_plane(layer, {ElementType::kF16}, 1);
    constexpr double kShown = 0.99;  // a spike where the grid cuts a corner would leave all else white
    Range range;
    std::vector<double> heights;
    heights.reserve(plane.values.size());
    for (const float h : plane.values) {
        range.add(h);
        if (std::isfinite(h)) heights.push_back(std::abs(h));
    }
    const double most = percentile(std::move(heights), kShown), reach = most > 0 ? most : range.reach();
    return {diverging(plane, 0, reach, [](std::uint32_t, std::uint32_t) { return true; }),
            range.text() + (reach < range.reach() ? fmt::format(", colours end at {:.2g}", reach) : std::string())};
}

/// Boxes of the pyramid's leaves, by the attribute `levels` (first row: the leaf tiles).
LayerPicture collision(const Chart& chart, const Layer& layer) {
    const std::uint64_t nodes = list_length(layer, kF32, 6);
    const std::uint32_t rows = tile_count(chart.rows - 1), cols = tile_count(chart.cols - 1);
    if (std::uint64_t{rows} * cols > nodes)
        throw model::Error(model::codes::kBadLayerShape,
                           fmt::format("{} boxes, but {} x {} leaf tiles", nodes, rows, cols), layer.name);
    std::vector<double> sizes(std::size_t{rows} * cols);
    Range range;
    for (std::size_t t = 0; t < sizes.size(); ++t) {
        model::Vec3d low, high;
        for (int k = 0; k < 3; ++k) {
            low[k] = element_value(layer, 6 * t + static_cast<std::size_t>(k));
            high[k] = element_value(layer, 6 * t + 3 + static_cast<std::size_t>(k));
        }
        const bool has_surface = low.x <= high.x && low.y <= high.y && low.z <= high.z;
        sizes[t] = has_surface ? length(high - low) : -1;
        if (has_surface) range.add(sizes[t]);
    }
    // A quad's colour is that of its tile; the last row and column of samples belong to the last tile.
    const auto image = paint(chart.rows, chart.cols, [&](std::uint32_t i, std::uint32_t j) {
        const std::uint32_t row = std::min(i / kTileQuads, rows - 1), col = std::min(j / kTileQuads, cols - 1);
        const double size = sizes[std::size_t{row} * cols + col];
        return size < 0 ? kOffSurface : sequential_colour(range.share(size));
    });
    return {image, fmt::format("{} x {} leaf boxes, {}", rows, cols, range.text())};
}

LayerPicture cover(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {kF32}, 1, chart.rows, chart.cols);
    const OnSurface on_surface(chart);
    return {sequential(plane, 0, on_surface), range_of(plane, 0, on_surface).text()};
}

LayerPicture deformation(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {kF32}, 4, chart.rows, chart.cols);
    const OnSurface on_surface(chart);
    const double reach = range_of(plane, 1, on_surface).reach();
    const Image sheet = tiles({sequential(plane, 0, on_surface), diverging(plane, 1, reach, on_surface),
                               sequential(plane, 2, on_surface), sequential(plane, 3, on_surface)},
                              2);
    return {sheet, fmt::format("E, F / G, stiffness {}", range_of(plane, 3, on_surface).text())};
}

LayerPicture contact(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {kF32}, 2, chart.rows, chart.cols);
    const OnSurface on_surface(chart);
    const auto mobility = paint(chart.rows, chart.cols, [&](std::uint32_t i, std::uint32_t j) {
        if (!on_surface(i, j)) return kOffSurface;
        const auto grey = static_cast<std::uint8_t>(std::lround(255 * std::clamp(plane.at(i, j, 1), 0.0f, 1.0f)));
        return Rgba8{grey, grey, grey, 255};
    });
    return {tiles({sequential(plane, 0, on_surface), mobility}, 2),
            fmt::format("area {}, mobility", range_of(plane, 0, on_surface).text())};
}

LayerPicture diagonals(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {ElementType::kU8}, 1, chart.rows - 1, chart.cols - 1);
    const auto ones = std::count(plane.values.begin(), plane.values.end(), 1.0f);
    const auto image = paint(plane.rows, plane.cols,
                             [&](std::uint32_t i, std::uint32_t j) { return sequential_colour(plane.at(i, j)); });
    return {image, fmt::format("{} of {} are 1", ones, plane.values.size())};
}

LayerPicture mask(const Chart& chart, const Layer& layer) {
    const Plane plane = read_plane(layer, {ElementType::kU8}, 1, chart.rows, chart.cols);
    const auto on = std::count_if(plane.values.begin(), plane.values.end(), [](float v) { return v != 0; });
    const auto image = paint(plane.rows, plane.cols, [&](std::uint32_t i, std::uint32_t j) {
        return plane.at(i, j) != 0 ? Rgba8{255, 255, 255, 255} : Rgba8{0, 0, 0, 255};
    });
    return {image, fmt::format("{:.1f} % on the surface",
                               100.0 * static_cast<double>(on) / static_cast<double>(plane.values.size()))};
}

/// The seams that the layer is about.
LayerPicture reversed(const Chart& chart, const Layer& layer) {
    const Layer* seams = chart.find("seams");
    if (seams == nullptr) throw model::Error(model::codes::kMissingLayer, "there is no layer \"seams\" to draw");
    LayerPicture out = seam_picture(chart, *seams);
    const auto count =
        std::count_if(layer.bytes.begin(), layer.bytes.end(), [](std::byte b) { return b != std::byte{}; });
    out.note += fmt::format(", {} copies reversed", count);
    return out;
}

using Painter = LayerPicture (*)(const Chart&, const Layer&);
const std::map<std::string_view, Painter>& painters() {
    static const std::map<std::string_view, Painter> table{
        {"geometry", geometry},
        {"normal", normal},
        {"texture", texture},
        {"bump", bump},
        {"collision", collision},
        {"cover", cover},
        {"contact", contact},
        {"deformation", deformation},
        {"diagonals", diagonals},
        {"mask", mask},
        {"seams", seam_picture},
        {"reversed", reversed},
        {"border_uv", border_picture},
        {"border_geometry", border_picture},
        {"border_normal", border_picture},
        {"border_faces", border_picture},
    };
    return table;
}
}  // namespace

LayerPicture layer_picture(const Chart& chart, std::string_view name) {
    const Layer* layer = chart.find(name);
    const auto painter = painters().find(name);
    if (layer == nullptr) {
        std::string have;
        for (const Layer& l : chart.layers) have.append(have.empty() ? "" : ", ").append(l.name);
        throw model::Error(model::codes::kMissingLayer,
                           fmt::format("there is no layer \"{}\"; the chart has {}", name, have));
    }
    if (painter == painters().end())
        throw model::Error(model::codes::kUnsupported, fmt::format("no picture is defined for layer \"{}\"", name));
    if (chart.rows < 2 || chart.cols < 2 || std::max(chart.rows, chart.cols) > formats::kMaxImageSide)
        throw model::Error(model::codes::kTooLarge,
                           fmt::format("a grid of {} x {} samples cannot be drawn", chart.rows, chart.cols));
    return painter->second(chart, *layer);
}

}  // namespace dgm::render
