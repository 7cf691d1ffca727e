// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/typeface.h
// The letters of pictures: DejaVu Sans, which the build takes from Debian's package and puts into the programs, so that
// a picture is the same on every machine.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace dgm::render {

/// One line of text as coverage, 0 to 255 a pixel, row by row.
struct TextMask {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> coverage;
};

/// Width in pixels of a line whose highest and lowest letters are `height` pixels apart. ASCII; others count as '?'.
[[nodiscard]] std::uint32_t text_mask_width(std::string_view text, std::uint32_t height);

/// The line itself, `height` pixels high. Thread-safe. @param height  at least 1
[[nodiscard]] TextMask text_mask(std::string_view text, std::uint32_t height);

}  // namespace dgm::render
