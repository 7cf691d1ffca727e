// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_layout.cpp
// [sRGB] IEC 61966-2-1:1999, the transfer function between 8-bit codes and linear light.
#include "exr/exr_layout.h"

#include <ImathConfig.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "math/portable.h"
#include "model/half.h"
#include "model/layer_names.h"

namespace dgm::formats {
namespace {

using layout::ElementType;

/// Names of the numbers of a sample, behind the layer's: `-area.V` is the channel V of the pass `contact-area`.
/// Programs read passes of one channel, RGB(A) and XYZ(W); other letters and words they refuse (SPEC.md section 5).
struct NamedLayer {
    std::string_view name;
    std::vector<std::string_view> components;
};

const NamedLayer* find_named(std::string_view name, std::uint32_t components, ElementType type) {
    static const std::vector<NamedLayer> table{
        {model::layers::kGeometry, {".X", ".Y", ".Z"}},
        {model::layers::kNormal, {"-code.U", "-code.V"}},
        {model::layers::kDeformation, {".X", ".Y", ".Z", "-stiffness.V"}},
        {model::layers::kContact, {"-area.V", "-mobility.V"}},
        {model::layers::kCollision, {"-min.X", "-min.Y", "-min.Z", "-max.X", "-max.Y", "-max.Z"}},
        {model::layers::kBorderUv, {".U", ".V"}},
        {model::layers::kBorderGeometry, {".X", ".Y", ".Z"}},
        {model::layers::kBorderNormal, {"-code.U", "-code.V"}},
    };
    if (type == ElementType::kU32) return nullptr;  // two channels each: names of their own
    for (const NamedLayer& layer : table)
        if (layer.name == name && layer.components.size() == components) return &layer;
    return nullptr;
}

bool is_table_of_ours(std::string_view name) {
    constexpr std::array<std::string_view, 6> kTables{model::layers::kCollision,    model::layers::kSeams,
                                                      model::layers::kBorderUv,     model::layers::kBorderGeometry,
                                                      model::layers::kBorderNormal, model::layers::kBorderFaces};
    return std::find(kTables.begin(), kTables.end(), name) != kTables.end();
}

/// FLOAT holds every element but u32; halves stay halves where no other layer shares the part, since some programs want
/// one type for all channels of a part.
Imf::PixelType pixel_type(ElementType type, bool in_grid) {
    return type == ElementType::kF16 && !in_grid ? Imf::HALF : Imf::FLOAT;
}

void name_channels(LayerImage& image, std::string_view name, ElementType type, bool in_grid) {
    const std::string layer(name);
    if (name == model::layers::kTexture && type == ElementType::kU8 && image.components == 4) {
        for (std::uint32_t c = 0; c < 4; ++c)
            image.channels.push_back(
                {layer + "." + "RGBA"[c], in_grid ? Imf::FLOAT : Imf::HALF, c < 3 ? Coding::kSrgb : Coding::kUnit, c});
        return;
    }
    const NamedLayer* named = find_named(name, image.components, type);
    const bool coded = name == model::layers::kGeometry && type == ElementType::kU16 && named != nullptr;
    const bool octahedral = name == model::layers::kNormal && type == ElementType::kI16 && named != nullptr;
    for (std::uint32_t axis = 0; (coded || octahedral) && axis < 3; ++axis)
        image.channels.push_back(
            {layer + "." + "XYZ"[axis], Imf::FLOAT, coded ? Coding::kPosition : Coding::kNormal, axis});
    for (std::uint32_t c = 0; c < image.components; ++c) {
        const std::string number = image.components == 1 ? layer : layer + "-c" + std::to_string(c);
        if (type == ElementType::kU32) {
            image.channels.push_back({number + ".X", Imf::FLOAT, Coding::kLowHalf, c});
            image.channels.push_back({number + ".Y", Imf::FLOAT, Coding::kHighHalf, c});
        } else {
            const std::string of_ours = named == nullptr ? "" : layer + (coded ? "-code" : "");
            image.channels.push_back({named == nullptr ? number + ".V" : of_ours + std::string(named->components[c]),
                                      pixel_type(type, in_grid), Coding::kExact, c});
        }
    }
}

double linear_of_srgb(double s) {
    return s <= 0.04045 ? s / 12.92 : math::pow((s + 0.055) / 1.055, 2.4);
}
double srgb_of_linear(double l) {
    return l <= 0.0031308 ? l * 12.92 : 1.055 * math::pow(l, 1 / 2.4) - 0.055;
}

float float_of_half(std::uint16_t bits) {
    half h;
    h.setBits(bits);
    return static_cast<float>(h);
}

std::uint8_t code_of(double unit) {
    return std::isnan(unit) ? std::uint8_t{0}
                            : static_cast<std::uint8_t>(std::lround(std::clamp(unit, 0.0, 1.0) * 255));
}

}  // namespace

std::optional<std::uint64_t> exr_layer_bytes(ElementType type, std::span<const std::uint64_t> shape) {
    std::uint64_t bytes = layout::element_size(type), bound = bytes;
    if (bytes == 0 || shape.empty() || shape.size() > layout::kMaxRank) return std::nullopt;
    for (const std::uint64_t extent : shape) {
        if (__builtin_mul_overflow(bound, std::max<std::uint64_t>(extent, 1), &bound)) return std::nullopt;
        bytes *= extent;
    }
    return bytes;
}

LayerImage image_of_layer(std::string_view name, ElementType type, std::span<const std::uint64_t> shape, bool in_grid) {
    LayerImage image;
    // The last extent counts the numbers of a sample in three dimensions and more, and in the format's own tables.
    const bool grouped =
        shape.back() >= 1 && shape.back() <= 8 && (shape.size() >= 3 || (shape.size() == 2 && is_table_of_ours(name)));
    if (grouped) {
        image.components = static_cast<std::uint32_t>(shape.back());
        shape = shape.first(shape.size() - 1);
    }
    image.is_table = shape.size() == 1;
    image.pixels = 1;
    for (const std::uint64_t extent : shape) image.pixels *= extent;
    image.row = shape.size() == 1 ? 0 : shape.back();
    if (image.row == 0 || image.row > kMaxExrWidth || image.pixels / image.row > kMaxExrHeight)
        image.row =
            std::max<std::uint64_t>(1, std::min<std::uint64_t>(image.pixels, image.pixels > 1'000'000 ? 8192 : 1024));
    const std::uint64_t height = (image.pixels + image.row - 1) / image.row;
    const std::uint64_t margin = in_grid && name == model::layers::kDiagonals && shape.size() == 2 ? 1 : 0;
    image.width = static_cast<std::uint32_t>(image.row + margin);
    image.height = static_cast<std::uint32_t>(std::min(height, kMaxExrHeight) + margin);
    if (height > kMaxExrHeight) image.pixels = 0;  // 2^37 samples: no memory holds such a layer
    name_channels(image, name, type, in_grid);
    return image;
}

void use_root_names(LayerImage& image, std::string_view layer) {
    const auto letter_of = [&](const Channel& channel) -> char {
        const std::size_t prefix = layer.size() + 1;
        if (channel.name.size() != prefix + 1 || channel.name[prefix - 1] != '.') return 0;
        if (image.channels.size() == 1) return 'Y';
        const char letter = channel.name[prefix];
        if (layer == model::layers::kTexture) return letter;
        return layer == model::layers::kGeometry ? "RGB"[letter - 'X'] : '\0';
    };
    for (Channel& channel : image.channels)
        if (const char letter = letter_of(channel); letter != 0) channel.name = std::string(1, letter);
}

bool fits_grid(const LayerImage& image, std::uint32_t rows, std::uint32_t cols) {
    return !image.is_table && image.width == cols && image.height == rows && image.pixels > 0;
}

std::uint16_t half_of_srgb(std::uint8_t code) {
    static const auto table = [] {
        std::array<std::uint16_t, 256> out{};
        for (std::size_t k = 0; k < out.size(); ++k)
            out[k] = half(static_cast<float>(linear_of_srgb(static_cast<double>(k) / 255))).bits();
        return out;
    }();
    return table[code];
}
std::uint8_t srgb_of_half(std::uint16_t bits) {
    static const auto table = [] {
        std::vector<std::uint8_t> out(65536);
        for (std::size_t k = 0; k < out.size(); ++k) {
            const double linear = float_of_half(static_cast<std::uint16_t>(k));
            out[k] = linear > 0 ? code_of(srgb_of_linear(std::min(linear, 1.0))) : std::uint8_t{0};
        }
        return out;
    }();
    return table[bits];
}
std::uint16_t half_of_unit(std::uint8_t code) {
    return half(static_cast<float>(code) / 255.0f).bits();
}
std::uint8_t unit_of_half(std::uint16_t bits) {
    return code_of(float_of_half(bits));
}

std::uint32_t float_bits_of_half(std::uint16_t half_bits) {
    if ((half_bits & 0x7C00) == 0x7C00)  // infinite or not a number: processors change the bits of some of the latter
        return std::uint32_t{half_bits & 0x8000u} << 16 | 0x7F800000u | std::uint32_t{half_bits & 0x3FFu} << 13;
    const float value = model::half_value(half_bits);
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}
std::uint16_t half_bits_of_float(std::uint32_t float_bits) {
    if ((float_bits & 0x7F800000u) == 0x7F800000u) {
        const std::uint32_t fraction = float_bits & 0x7FFFFFu;
        const std::uint32_t kept = fraction >> 13 | (fraction != 0 && fraction >> 13 == 0 ? 1u : 0u);
        return static_cast<std::uint16_t>((float_bits >> 16 & 0x8000u) | 0x7C00u | kept);
    }
    float value = 0;
    std::memcpy(&value, &float_bits, sizeof value);
    return model::half_bits(value);
}

}  // namespace dgm::formats
