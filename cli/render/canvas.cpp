// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/canvas.cpp
#include "render/canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "math/portable.h"
#include "model/codes.h"
#include "render/colour.h"
#include "render/typeface.h"

namespace dgm::render {
namespace {
using formats::Image;
using model::Rgba8;

constexpr std::uint32_t kLine = 11;  ///< pixels a line is high at scale 1, of which one above its place

Rgba8& pixel(Image& image, std::uint32_t x, std::uint32_t y) {
    return image.pixels[std::size_t{y} * image.width + x];
}

Rgba8 over(Rgba8 top, Rgba8 below) {
    if (top.a == 255) return top;
    const float alpha = static_cast<float>(top.a) / 255;
    return encoded(mix(linear(below), linear(top), alpha));
}

/// Source range [first, last) of each of `to` cells over `from` pixels, none empty.
std::pair<std::uint32_t, std::uint32_t> cell(std::uint32_t k, std::uint32_t from, std::uint32_t to) {
    const auto first = static_cast<std::uint32_t>(std::uint64_t{k} * from / to);
    const auto last = static_cast<std::uint32_t>((std::uint64_t{k} + 1) * from / to);
    return {first, std::max(last, first + 1)};
}
}  // namespace

Image blank(std::uint32_t width, std::uint32_t height, Rgba8 colour) {
    if (width == 0 || height == 0 || width > formats::kMaxImageSide || height > formats::kMaxImageSide)
        throw model::Error(model::codes::kTooLarge,
                           fmt::format("a picture of {} x {} pixels; each side must be 1 to {}", width, height,
                                       formats::kMaxImageSide))
            .with_hint("ask for another --size, or for one --chart");
    return {width, height, std::vector<Rgba8>(std::size_t{width} * height, colour)};
}

void paste(Image& image, const Image& top, std::int64_t x, std::int64_t y) {
    for (std::int64_t v = std::max<std::int64_t>(0, -y); v < std::min<std::int64_t>(top.height, image.height - y); ++v)
        for (std::int64_t u = std::max<std::int64_t>(0, -x); u < std::min<std::int64_t>(top.width, image.width - x);
             ++u) {
            Rgba8& below = pixel(image, static_cast<std::uint32_t>(x + u), static_cast<std::uint32_t>(y + v));
            below = over(top.at(static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v)), below);
        }
}

void fill_rectangle(Image& image, std::int64_t x, std::int64_t y, std::int64_t width, std::int64_t height,
                    Rgba8 colour) {
    for (std::int64_t v = std::max<std::int64_t>(0, y); v < std::min<std::int64_t>(image.height, y + height); ++v)
        for (std::int64_t u = std::max<std::int64_t>(0, x); u < std::min<std::int64_t>(image.width, x + width); ++u)
            pixel(image, static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v)) = colour;
}

void fill_disc(Image& image, double x, double y, double radius, Rgba8 colour) {
    const auto clamp_to = [](double v, std::uint32_t side) {
        return static_cast<std::int64_t>(std::clamp(v, 0.0, side - 1.0));
    };
    for (std::int64_t v = clamp_to(std::floor(y - radius), image.height);
         v <= clamp_to(std::ceil(y + radius), image.height); ++v)
        for (std::int64_t u = clamp_to(std::floor(x - radius), image.width);
             u <= clamp_to(std::ceil(x + radius), image.width); ++u)
            if (math::hypot(static_cast<double>(u) - x, static_cast<double>(v) - y) <= radius)
                pixel(image, static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v)) = colour;
}

Image fitted(const Image& image, std::uint32_t width, std::uint32_t height) {
    const std::uint32_t enlarge = std::min(width / image.width, height / image.height);
    if (enlarge >= 1) {
        Image out = blank(image.width * enlarge, image.height * enlarge);
        for (std::uint32_t y = 0; y < out.height; ++y)
            for (std::uint32_t x = 0; x < out.width; ++x) pixel(out, x, y) = image.at(x / enlarge, y / enlarge);
        return out;
    }
    const double scale = std::min(width / double{1.0 * image.width}, height / double{1.0 * image.height});
    Image out = blank(std::max(1u, static_cast<std::uint32_t>(image.width * scale)),
                      std::max(1u, static_cast<std::uint32_t>(image.height * scale)));
    for (std::uint32_t y = 0; y < out.height; ++y)
        for (std::uint32_t x = 0; x < out.width; ++x) {
            const auto [x0, x1] = cell(x, image.width, out.width);
            const auto [y0, y1] = cell(y, image.height, out.height);
            Rgb sum;
            float alpha = 0;
            for (std::uint32_t v = y0; v < y1; ++v)
                for (std::uint32_t u = x0; u < x1; ++u) {
                    const Rgba8 c = image.at(u, v);
                    sum += linear(c) * static_cast<float>(c.a);
                    alpha += static_cast<float>(c.a);
                }
            Rgba8 mean = alpha > 0 ? encoded(sum * (1 / alpha)) : Rgba8{0, 0, 0, 0};
            mean.a = static_cast<std::uint8_t>(std::lround(alpha / static_cast<float>((x1 - x0) * (y1 - y0))));
            pixel(out, x, y) = mean;
        }
    return out;
}

void draw_text(Image& image, std::int64_t x, std::int64_t y, std::string_view text, std::uint32_t scale, Rgba8 colour) {
    const TextMask mask = text_mask(text, kLine * scale);
    for (std::uint32_t row = 0; row < mask.height; ++row)
        for (std::uint32_t col = 0; col < mask.width; ++col) {
            const std::int64_t at_x = x + col, at_y = y + row - scale;
            if (at_x < 0 || at_y < 0 || at_x >= image.width || at_y >= image.height) continue;
            const unsigned covered = mask.coverage[std::size_t{row} * mask.width + col];
            if (covered == 0) continue;
            Rgba8 ink = colour;
            ink.a = static_cast<std::uint8_t>(colour.a * covered / 255);
            Rgba8& below = pixel(image, static_cast<std::uint32_t>(at_x), static_cast<std::uint32_t>(at_y));
            below = over(ink, below);
        }
}

std::uint32_t text_width(std::string_view text, std::uint32_t scale) {
    return text_mask_width(text, kLine * scale);
}

void draw_text_centred(Image& image, std::int64_t middle_x, std::int64_t y, std::string_view text, std::uint32_t scale,
                       Rgba8 colour) {
    draw_text(image, middle_x - text_width(text, scale) / 2, y, text, scale, colour);
}

void draw_legend(Image& image, std::int64_t x, std::int64_t y, std::uint32_t width, std::uint32_t height, double low,
                 double high, bool open_end, std::uint32_t scale) {
    for (std::uint32_t k = 0; k < width; ++k)
        fill_rectangle(image, x + k, y, 1, height, sequential_colour(width > 1 ? k / (width - 1.0) : 0));
    const std::int64_t below = y + height + 2 * scale;
    const std::string top = fmt::format("{}{:.2g}", open_end ? ">=" : "", high);
    const std::string bottom = fmt::format("{:.2g}", low), middle = fmt::format("{:.2g}", 0.5 * (low + high));
    draw_text(image, x, below, bottom, scale);
    // The middle only where it stands clear of both ends.
    if (text_width(middle, scale) + 2 * std::max(text_width(bottom, scale), text_width(top, scale)) + 8 * scale < width)
        draw_text_centred(image, x + width / 2, below, middle, scale);
    draw_text(image, x + width - text_width(top, scale), below, top, scale);
}

}  // namespace dgm::render
