// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_layout.h
// How a layer lies in an EXR part: shared by writer and reader, so that they cannot disagree.
#pragma once
#include <ImfPixelType.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/map_set.h"

namespace dgm::formats {

/// Meaning of a channel's numbers.
enum class Coding {
    kExact,     ///< the element's value, to the bit
    kLowHalf,   ///< the lower 16 bits of a u32, as a number
    kHighHalf,  ///< the upper ones
    kSrgb,      ///< scene-linear half of an 8-bit sRGB code
    kUnit,      ///< half of an 8-bit 0..1 value
    kPosition,  ///< for people: scale * code; not read back
    kNormal,    ///< for people: the decoded normal; not read back
};

struct Channel {
    std::string name;  ///< as in the file: "normal.X"; one letter behind the last dot
    Imf::PixelType type = Imf::FLOAT;
    Coding coding = Coding::kExact;
    std::uint32_t component = 0;  ///< which number of an element group, or axis, it is
    [[nodiscard]] bool is_read() const { return coding != Coding::kPosition && coding != Coding::kNormal; }
};

/// Pixel k of a layer, holding `components` elements, is at x = k % row, y = k / row.
struct LayerImage {
    std::uint64_t pixels = 0, row = 0;
    std::uint32_t width = 0, height = 0;  ///< of the part; pixels beyond the layer's are 0
    std::uint32_t components = 1;
    bool is_table = false;  ///< a list rather than a picture
    std::vector<Channel> channels;
};

inline constexpr std::uint64_t kMaxExrWidth = 65536, kMaxExrHeight = std::uint64_t{1} << 24;

/// @param in_grid  the layer shares a part of rows x cols pixels: one with the quads' extents gets a margin of zeros
[[nodiscard]] LayerImage image_of_layer(std::string_view name, layout::ElementType type,
                                        std::span<const std::uint64_t> shape, bool in_grid);
/// Names without the layer, for what a program shall show first of a file: `R G B` for positions, `R G B A` for a
/// texture, `Y` for a single channel. Channels of codes keep their names.
void use_root_names(LayerImage& image, std::string_view layer);
/// True if the layer can share the part of a chart's grid.
[[nodiscard]] bool fits_grid(const LayerImage& in_grid_image, std::uint32_t rows, std::uint32_t cols);

/// Product of shape and element size; nothing on overflow, wrong rank or type.
[[nodiscard]] std::optional<std::uint64_t> exr_layer_bytes(layout::ElementType type,
                                                           std::span<const std::uint64_t> shape);

/// Bits of the half that stands for an sRGB code, and the code nearest to a half; exact inverses on all 256 codes.
[[nodiscard]] std::uint16_t half_of_srgb(std::uint8_t code);
[[nodiscard]] std::uint8_t srgb_of_half(std::uint16_t bits);
[[nodiscard]] std::uint16_t half_of_unit(std::uint8_t code);
[[nodiscard]] std::uint8_t unit_of_half(std::uint16_t bits);

/// An f16 as float and back, to the bit, whatever kind of not-a-number it is; other floats are rounded to nearest even.
[[nodiscard]] std::uint32_t float_bits_of_half(std::uint16_t half_bits);
[[nodiscard]] std::uint16_t half_bits_of_float(std::uint32_t float_bits);

}  // namespace dgm::formats
