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
    kExact,     ///< the element itself; integers as UINT (signed ones by their 16 bits)
    kSrgb,      ///< scene-linear half of an 8-bit sRGB code
    kUnit,      ///< half of an 8-bit 0..1 value
    kPosition,  ///< for people: scale * code; not read back
    kNormal,    ///< for people: the decoded normal; not read back
};

struct Channel {
    std::string name;  ///< as in the file: "normal.X"
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

/// Where the bytes of a layer are.
enum class Storage { kGrid, kPart, kTable, kNothing };

/// One line of the attribute dgmLayers.
struct LayerEntry {
    std::string name;
    layout::ElementType type = layout::ElementType::kF32;
    std::vector<std::uint64_t> shape;
    bool required = false;
    Storage storage = Storage::kPart;
};
[[nodiscard]] std::string manifest_line(const LayerEntry& entry);
/// Nothing if the text is not what manifest_line writes.
[[nodiscard]] std::optional<LayerEntry> parse_manifest_line(std::string_view line);

[[nodiscard]] std::string attribute_text(const model::AttributeValue& value);
[[nodiscard]] std::optional<model::AttributeValue> parse_attribute_text(std::string_view text);

[[nodiscard]] std::string hex_of(std::span<const std::uint8_t> bytes);
[[nodiscard]] bool parse_hex(std::string_view text, std::span<std::uint8_t> bytes);

/// Name of the part that holds the grid-sized layers of a chart, or one layer.
[[nodiscard]] std::string part_name(std::string_view layer, std::size_t chart, std::size_t chart_count);
inline constexpr std::string_view kGridPart = "grid";

}  // namespace dgm::formats
