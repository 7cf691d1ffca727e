// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/asset_pictures.cpp
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "math/portable.h"
#include "model/codes.h"
#include "model/element.h"
#include "render/canvas.h"
#include "render/layer_picture.h"
#include "report/asset_sections.h"
#include "report/html.h"

namespace dgm::report {
namespace {
using formats::Image;

constexpr std::uint32_t kMapSide = 260;
constexpr std::size_t kChartsShown = 6;  // pictures of more charts than these would make the page heavy
constexpr std::size_t kMostPngBytes = 24'000;

std::string figure(const std::string& uri, std::string_view title, std::string_view note) {
    return fmt::format("<figure><img src=\"{}\" alt=\"{}\"><figcaption><b>{}</b> {}</figcaption></figure>\n", uri,
                       escaped(title), escaped(title), escaped(note));
}

/// The colour scale of a quantity with the words at its ends and in its middle.
std::string legend(Quantity quantity, const std::array<std::string, 3>& words) {
    Image bar = render::blank(128, 1);
    for (std::uint32_t x = 0; x < bar.width; ++x)
        bar.pixels[x] = render::quantity_colour(quantity, x / (bar.width - 1.0));
    return fmt::format(
        "<div class=\"legend\"><img src=\"{}\" alt=\"\"><div><span>{}</span><span>{}</span><span>{}"
        "</span></div></div>",
        picture_uri(bar, kMostPngBytes), escaped(words[0]), escaped(words[1]), escaped(words[2]));
}

std::array<std::string, 3> legend_words(Quantity quantity, const Scales& scales, double diagonal) {
    if (quantity == Quantity::kDistance)
        return {"inside " + length_text(scales.distance, diagonal), "0",
                "outside " + length_text(scales.distance, diagonal)};
    if (quantity == Quantity::kArea)
        return {fmt::format("1/{:.2g} of the mean", math::pow(2, scales.area)), "1",
                fmt::format("{:.2g} times", math::pow(2, scales.area))};
    return {"1 (none)", fmt::format("{:.2g}", math::pow(2, scales.angle / 2)),
            fmt::format("{:.2g}", math::pow(2, scales.angle))};
}

std::size_t shown_charts(const BakedAsset& baked) {
    return std::min(kChartsShown, baked.maps.charts.size());
}

std::string chart_heading(const BakedAsset& baked, std::size_t k) {
    return baked.maps.charts.size() == 1 ? std::string() : fmt::format("<h3>Chart {}</h3>\n", k);
}

std::string left_out(const BakedAsset& baked) {
    if (shown_charts(baked) == baked.maps.charts.size()) return {};
    return fmt::format(
        "<p class=\"small\">Pictures of the first {} of {} charts; dgm-export --sheet makes all of "
        "them.</p>\n",
        shown_charts(baked), baked.maps.charts.size());
}

std::string distortion_section(const BakedAsset& baked) {
    constexpr std::array kRows{std::pair(Quantity::kDistance, "distance to the source"),
                               std::pair(Quantity::kArea, "area of a grid cell"),
                               std::pair(Quantity::kAngle, "angle distortion")};
    std::string out = "<section><h2>Error and distortion in the map</h2>\n";
    for (std::size_t k = 0; k < shown_charts(baked); ++k) {
        out += chart_heading(baked, k) + "<div class=\"pictures\">\n";
        for (const auto& [quantity, title] : kRows) {
            const Image picture = render::grid_picture(baked.maps.charts[k], baked.values[k], quantity, baked.scales);
            out += fmt::format("<figure><img src=\"{}\" alt=\"{}\"><figcaption><b>{}</b> {}</figcaption></figure>\n",
                               picture_uri(render::fitted(picture, kMapSide, kMapSide), kMostPngBytes), title, title,
                               legend(quantity, legend_words(quantity, baked.scales, baked.diagonal())));
        }
        out += "</div>\n";
    }
    out +=
        "<p class=\"small\">Row u runs down, column v to the right. Red cells cover more of the surface than "
        "the mean, blue ones less. Angle distortion is the quasi-conformal dilatation: 1 keeps every angle, 2 "
        "draws a circle out to twice its width.</p>\n";
    return out + left_out(baked) + "</section>\n";
}

std::string layers_section(const BakedAsset& baked) {
    std::string out = "<section><h2>Layers</h2>\n";
    for (std::size_t k = 0; k < shown_charts(baked); ++k) {
        const model::Chart& chart = baked.maps.charts[k];
        out += chart_heading(baked, k) + "<div class=\"pictures\">\n";
        for (const model::Layer& layer : chart.layers) {
            const std::string shape =
                fmt::format("{} {}", model::shape_text(layer.shape), model::type_name(layer.type));
            try {
                const render::LayerPicture picture = render::layer_picture(chart, layer.name);
                out += figure(picture_uri(render::fitted(picture.image, kMapSide, kMapSide), kMostPngBytes), layer.name,
                              shape + ". " + picture.note);
            } catch (const model::Error& error) {
                if (&error.code() != &model::codes::kUnsupported) throw;
                out += fmt::format("<p class=\"small\">{}: {}, no picture</p>\n", escaped(layer.name), shape);
            }
        }
        out += "</div>\n";
    }
    return out + "</section>\n";
}
}  // namespace

std::string picture_sections(const BakedAsset& baked) {
    return distortion_section(baked) + layers_section(baked);
}

}  // namespace dgm::report
