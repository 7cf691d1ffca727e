// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/typeface.cpp
#include "render/typeface.h"

#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb_truetype.h>

#include <algorithm>
#include <cmath>

// The font's file, byte for byte.
asm(R"(
    .section .rodata
    .balign 16
    .hidden dgm_typeface
dgm_typeface:
    .incbin ")" DGM_TYPEFACE R"("
    .previous
)");
extern "C" const unsigned char dgm_typeface[];

namespace dgm::render {
namespace {

const stbtt_fontinfo& font() {
    static const stbtt_fontinfo info = [] {
        stbtt_fontinfo out;
        stbtt_InitFont(&out, dgm_typeface, 0);
        return out;
    }();
    return info;
}

/// Calls place(character, x in pixels) for each letter. @return where the line ends
template <class Place>
double lay_out(std::string_view text, float scale, const Place& place) {
    double x = 0;
    int before = 0;
    for (const char c : text) {
        const int letter = c < ' ' || c > '~' ? '?' : static_cast<unsigned char>(c);
        int advance = 0, bearing = 0;
        stbtt_GetCodepointHMetrics(&font(), letter, &advance, &bearing);
        if (before != 0) x += double{scale} * stbtt_GetCodepointKernAdvance(&font(), before, letter);
        place(letter, x);
        x += double{scale} * advance;
        before = letter;
    }
    return x;
}

std::uint32_t whole(double width) {
    return static_cast<std::uint32_t>(std::ceil(width)) + 1;  // a slanted stroke may end beyond its advance
}

}  // namespace

std::uint32_t text_mask_width(std::string_view text, std::uint32_t height) {
    const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(height));
    return text.empty() ? 0 : whole(lay_out(text, scale, [](int, double) {}));
}

TextMask text_mask(std::string_view text, std::uint32_t height) {
    TextMask mask;
    mask.width = text_mask_width(text, height);
    mask.height = height;
    mask.coverage.resize(std::size_t{mask.width} * height);
    const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(height));
    int ascent = 0, descent = 0, gap = 0;
    stbtt_GetFontVMetrics(&font(), &ascent, &descent, &gap);
    const int baseline = static_cast<int>(std::lround(double{scale} * ascent));
    std::vector<std::uint8_t> glyph;
    lay_out(text, scale, [&](int letter, double x) {
        const auto left = static_cast<int>(std::floor(x));
        const float shift = static_cast<float>(x - left);
        int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
        stbtt_GetCodepointBitmapBoxSubpixel(&font(), letter, scale, scale, shift, 0, &x0, &y0, &x1, &y1);
        const int width = x1 - x0, rows = y1 - y0;
        if (width <= 0 || rows <= 0) return;
        glyph.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(rows), 0);
        stbtt_MakeCodepointBitmapSubpixel(&font(), glyph.data(), width, rows, width, scale, scale, shift, 0, letter);
        for (int row = 0; row < rows; ++row)
            for (int col = 0; col < width; ++col) {
                const int at_x = left + x0 + col, at_y = baseline + y0 + row;
                if (at_x < 0 || at_y < 0 || at_x >= static_cast<int>(mask.width) || at_y >= static_cast<int>(height))
                    continue;
                std::uint8_t& pixel =
                    mask.coverage[static_cast<std::size_t>(at_y) * mask.width + static_cast<std::size_t>(at_x)];
                pixel = std::max(pixel, glyph[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                              static_cast<std::size_t>(col)]);
            }
    });
    return mask;
}

}  // namespace dgm::render
