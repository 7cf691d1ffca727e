// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/canvas.h
// Putting pictures together: paper, paste, text, legends.
#pragma once
#include <cstdint>
#include <string_view>

#include "image/image.h"

namespace dgm::render {

inline constexpr model::Rgba8 kPaper{246, 246, 244, 255};
inline constexpr model::Rgba8 kInk{58, 60, 66, 255};

/// @throws model::Error kTooLarge if a side is 0 or beyond formats::kMaxImageSide
[[nodiscard]] formats::Image blank(std::uint32_t width, std::uint32_t height, model::Rgba8 colour = kPaper);

/// Lays `top` over `image` with its upper left corner at (x, y); parts outside are cut off. Alpha is blended.
void paste(formats::Image& image, const formats::Image& top, std::int64_t x, std::int64_t y);
void fill_rectangle(formats::Image& image, std::int64_t x, std::int64_t y, std::int64_t width, std::int64_t height,
                    model::Rgba8 colour);
void fill_disc(formats::Image& image, double x, double y, double radius, model::Rgba8 colour);

/// The picture in at most width x height pixels, same aspect: enlarged by a whole number without blurring, or reduced
/// by averaging in linear light.
[[nodiscard]] formats::Image fitted(const formats::Image& image, std::uint32_t width, std::uint32_t height);

/// One line of ASCII text (typeface.h); other characters show as '?'. Letters
/// are between y and y + 9 * `scale`, their accents and tails a little beyond.
void draw_text(formats::Image& image, std::int64_t x, std::int64_t y, std::string_view text, std::uint32_t scale,
               model::Rgba8 colour = kInk);
[[nodiscard]] std::uint32_t text_width(std::string_view text, std::uint32_t scale);
void draw_text_centred(formats::Image& image, std::int64_t middle_x, std::int64_t y, std::string_view text,
                       std::uint32_t scale, model::Rgba8 colour = kInk);

/// A horizontal bar of sequential_colour with the numbers of its two ends and its middle below; `open_end` marks the
/// upper end as "and more". Uses `width` x (height + 10 * scale) pixels.
void draw_legend(formats::Image& image, std::int64_t x, std::int64_t y, std::uint32_t width, std::uint32_t height,
                 double low, double high, bool open_end, std::uint32_t scale);

}  // namespace dgm::render
