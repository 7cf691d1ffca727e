// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_layout.cpp
// [sRGB] IEC 61966-2-1:1999, the transfer function between 8-bit codes and linear light.
#include "exr/exr_layout.h"
#include "model/layer_names.h"

#include <ImathConfig.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace dgm::formats {
namespace {

using layout::ElementType;

/// Names of the numbers of a sample, for layers of the format; others are c0, c1, ...
struct NamedLayer {
    std::string_view name;
    std::vector<std::string_view> components;
    bool is_table;
};

const NamedLayer* find_named(std::string_view name) {
    static const std::vector<NamedLayer> table{
        {model::layers::kGeometry, {"X", "Y", "Z"}, false},
        {model::layers::kNormal, {"oct_u", "oct_v"}, false},
        {model::layers::kDeformation, {"E", "F", "G", "stiffness"}, false},
        {model::layers::kContact, {"area", "mobility"}, false},
        {model::layers::kCollision, {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z"}, true},
        {model::layers::kSeams, {"representative", "copy"}, true},
        {model::layers::kBorderUv, {"u", "v"}, true},
        {model::layers::kBorderGeometry, {"X", "Y", "Z"}, true},
        {model::layers::kBorderNormal, {"oct_u", "oct_v"}, true},
        {model::layers::kBorderFaces, {"a", "b", "c"}, true},
    };
    for (const NamedLayer& layer : table)
        if (layer.name == name) return &layer;
    return nullptr;
}

Imf::PixelType exact_type(ElementType type) {
    if (type == ElementType::kF32) return Imf::FLOAT;
    return type == ElementType::kF16 ? Imf::HALF : Imf::UINT;
}

void name_channels(LayerImage& image, std::string_view name, ElementType type, const NamedLayer* named) {
    const std::string prefix = std::string(name) + ".";
    if (name == model::layers::kTexture && type == ElementType::kU8 && image.components == 4) {
        for (std::uint32_t c = 0; c < 4; ++c)
            image.channels.push_back({std::string(1, "RGBA"[c]), Imf::HALF, c < 3 ? Coding::kSrgb : Coding::kUnit, c});
        return;
    }
    if (named == nullptr || named->components.size() != image.components) {
        for (std::uint32_t c = 0; c < image.components; ++c)
            image.channels.push_back({image.components == 1 ? std::string(name) : prefix + "c" + std::to_string(c),
                                      exact_type(type), Coding::kExact, c});
        return;
    }
    const bool coded = name == model::layers::kGeometry && type == ElementType::kU16;
    const bool octahedral = named->components[0] == "oct_u" && type == ElementType::kI16;
    for (std::uint32_t axis = 0; (coded || octahedral) && axis < 3; ++axis)
        image.channels.push_back({prefix + "XYZ"[axis], Imf::FLOAT, coded ? Coding::kPosition : Coding::kNormal, axis});
    for (std::uint32_t c = 0; c < image.components; ++c)
        image.channels.push_back(
            {prefix + (coded ? "code_" : "") + std::string(named->components[c]), exact_type(type), Coding::kExact, c});
}

double linear_of_srgb(double s) {
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
double srgb_of_linear(double l) {
    return l <= 0.0031308 ? l * 12.92 : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
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

constexpr std::array<std::string_view, 7> kTypeNames{"", "u8", "u16", "u32", "i16", "f16", "f32"};
constexpr std::array<std::string_view, 4> kStorageNames{"grid", "part", "table", "nothing"};

template <class Number>
bool parse_number(std::string_view word, Number& value) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
}

std::vector<std::string_view> split(std::string_view text) {
    std::vector<std::string_view> out;
    while (!text.empty()) {
        const std::size_t space = std::min(text.find(' '), text.size());
        out.push_back(text.substr(0, space));
        text.remove_prefix(std::min(space + 1, text.size()));
    }
    return out;
}

template <class Number>
void append_numbers(std::string& out, const std::vector<Number>& numbers) {
    char digits[32];
    for (const Number number : numbers) {
        const auto [end, error] = std::to_chars(digits, digits + sizeof digits, number);
        (void)error;
        out.append(" ").append(digits, end);
    }
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
    const NamedLayer* named = find_named(name);
    // The last extent counts the numbers of a sample in three dimensions and more, and in the format's own tables.
    const bool grouped = shape.back() >= 1 && shape.back() <= 8 &&
                         (shape.size() >= 3 || (shape.size() == 2 && named != nullptr && named->is_table));
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
    name_channels(image, name, type, named);
    return image;
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

std::string manifest_line(const LayerEntry& entry) {
    std::string out = entry.name;
    out.append(" ").append(kTypeNames[static_cast<std::size_t>(entry.type)]);
    out.append(" ").append(kStorageNames[static_cast<std::size_t>(entry.storage)]);
    out.append(entry.required ? " required" : " optional");
    append_numbers(out, entry.shape);
    return out;
}

std::optional<LayerEntry> parse_manifest_line(std::string_view line) {
    const std::vector<std::string_view> words = split(line);
    if (words.size() < 5 || words.size() > 4 + layout::kMaxRank || words[0].empty()) return std::nullopt;
    const auto type = std::find(kTypeNames.begin() + 1, kTypeNames.end(), words[1]);
    const auto storage = std::find(kStorageNames.begin(), kStorageNames.end(), words[2]);
    if (type == kTypeNames.end() || storage == kStorageNames.end()) return std::nullopt;
    if (words[3] != "required" && words[3] != "optional") return std::nullopt;
    LayerEntry entry;
    entry.name = words[0];
    entry.type = static_cast<ElementType>(type - kTypeNames.begin());
    entry.storage = static_cast<Storage>(storage - kStorageNames.begin());
    entry.required = words[3] == "required";
    for (std::size_t k = 4; k < words.size(); ++k)
        if (!parse_number(words[k], entry.shape.emplace_back())) return std::nullopt;
    return entry;
}

std::string attribute_text(const model::AttributeValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return "text " + *text;
    std::string out;
    if (const auto* doubles = std::get_if<std::vector<double>>(&value)) {
        out = "f64";
        append_numbers(out, *doubles);
    } else {
        out = "u32";
        append_numbers(out, std::get<std::vector<std::uint32_t>>(value));
    }
    return out;
}

std::optional<model::AttributeValue> parse_attribute_text(std::string_view text) {
    if (text.starts_with("text ")) return std::string(text.substr(5));
    const std::vector<std::string_view> words = split(text);
    if (words.empty()) return std::nullopt;
    const auto parse_all = [&](auto& numbers) {
        for (std::size_t k = 1; k < words.size(); ++k)
            if (!parse_number(words[k], numbers.emplace_back())) return false;
        return true;
    };
    if (words[0] == "f64") {
        std::vector<double> numbers;
        if (parse_all(numbers)) return numbers;
    } else if (words[0] == "u32") {
        std::vector<std::uint32_t> numbers;
        if (parse_all(numbers)) return numbers;
    }
    return std::nullopt;
}

std::string hex_of(std::span<const std::uint8_t> bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string out;
    for (const std::uint8_t byte : bytes) {
        out += kDigits[byte >> 4];
        out += kDigits[byte & 15];
    }
    return out;
}

bool parse_hex(std::string_view text, std::span<std::uint8_t> bytes) {
    if (text.size() != 2 * bytes.size()) return false;
    for (std::size_t k = 0; k < bytes.size(); ++k) {
        const char* begin = text.data() + 2 * k;
        const auto [end, error] = std::from_chars(begin, begin + 2, bytes[k], 16);
        if (error != std::errc() || end != begin + 2) return false;
    }
    return true;
}

std::string part_name(std::string_view layer, std::size_t chart, std::size_t chart_count) {
    return chart_count > 1 ? "chart" + std::to_string(chart) + "." + std::string(layer) : std::string(layer);
}

}  // namespace dgm::formats
