// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/layer_values.cpp
#include "render/layer_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "image/image.h"
#include "model/codes.h"

namespace dgm::render {
namespace {
using model::ElementType;
using model::Layer;

static_assert(std::endian::native == std::endian::little, "layers are read as they are stored");

template <class T>
T load(const Layer& layer, std::size_t index) {
    T value;
    std::memcpy(&value, layer.bytes.data() + index * sizeof(T), sizeof(T));
    return value;
}

double from_half(std::uint16_t bits) {
    const int exponent = (bits >> 10) & 31;
    const double fraction = bits & 1023;
    const double magnitude = exponent == 0    ? std::ldexp(fraction, -24)
                             : exponent == 31 ? (fraction == 0 ? std::numeric_limits<double>::infinity()
                                                               : std::numeric_limits<double>::quiet_NaN())
                                              : std::ldexp(1024 + fraction, exponent - 25);
    return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

[[noreturn]] void bad_shape(const Layer& layer) {
    throw model::Error(model::codes::kBadLayerShape,
                       fmt::format("{} {} with {} bytes does not suit this layer", type_name(layer.type),
                                   shape_text(layer.shape), layer.bytes.size()),
                       layer.name);
}

void check_bytes(const Layer& layer) {
    std::uint64_t bytes = layout::element_size(layer.type);
    for (const std::uint64_t side : layer.shape)
        if (__builtin_mul_overflow(bytes, side, &bytes)) bad_shape(layer);
    if (bytes == 0 || bytes != layer.bytes.size()) bad_shape(layer);
}
}  // namespace

const char* type_name(ElementType type) {
    switch (type) {
        case ElementType::kU8:
            return "u8";
        case ElementType::kU16:
            return "u16";
        case ElementType::kU32:
            return "u32";
        case ElementType::kI16:
            return "i16";
        case ElementType::kF16:
            return "f16";
        case ElementType::kF32:
            return "f32";
    }
    return "unknown";
}

std::string shape_text(const std::vector<std::uint64_t>& shape) {
    return fmt::format("{}", fmt::join(shape, " x "));
}

double element_value(const Layer& layer, std::size_t index) {
    switch (layer.type) {
        case ElementType::kU8:
            return load<std::uint8_t>(layer, index);
        case ElementType::kU16:
            return load<std::uint16_t>(layer, index);
        case ElementType::kU32:
            return load<std::uint32_t>(layer, index);
        case ElementType::kI16:
            return load<std::int16_t>(layer, index);
        case ElementType::kF16:
            return from_half(load<std::uint16_t>(layer, index));
        case ElementType::kF32:
            return load<float>(layer, index);
    }
    return 0;
}

Plane read_plane(const Layer& layer, std::initializer_list<ElementType> types, std::uint32_t channels) {
    const std::size_t rank = channels == 1 ? 2 : 3;
    const bool has_type = std::find(types.begin(), types.end(), layer.type) != types.end();
    if (!has_type || layer.shape.size() != rank || (rank == 3 && layer.shape[2] != channels)) bad_shape(layer);
    check_bytes(layer);
    if (std::max(layer.shape[0], layer.shape[1]) > formats::kMaxImageSide)
        throw model::Error(model::codes::kTooLarge, shape_text(layer.shape) + " samples do not fit a picture",
                           layer.name);
    Plane plane{static_cast<std::uint32_t>(layer.shape[0]), static_cast<std::uint32_t>(layer.shape[1]), channels, {}};
    plane.values.resize(layer.bytes.size() / layout::element_size(layer.type));
    for (std::size_t k = 0; k < plane.values.size(); ++k) plane.values[k] = static_cast<float>(element_value(layer, k));
    return plane;
}

Plane read_plane(const Layer& layer, std::initializer_list<ElementType> types, std::uint32_t channels,
                 std::uint32_t rows, std::uint32_t cols) {
    Plane plane = read_plane(layer, types, channels);
    if (plane.rows != rows || plane.cols != cols) bad_shape(layer);
    return plane;
}

std::uint64_t list_length(const Layer& layer, ElementType type, std::uint64_t width) {
    const std::size_t rank = width == 1 ? 1 : 2;
    if (layer.type != type || layer.shape.size() != rank || (rank == 2 && layer.shape[1] != width)) bad_shape(layer);
    if (layer.shape[0] == 0 && layer.bytes.empty()) return 0;
    check_bytes(layer);
    return layer.shape[0];
}

}  // namespace dgm::render
