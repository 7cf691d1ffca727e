// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/element.h
// Numbers out of a layer's bytes, and how types and shapes are spelled.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "model/half.h"
#include "model/map_set.h"

namespace dgm::model {

static_assert(std::endian::native == std::endian::little, "layers are read as they are stored");

/// Element `index` as it is stored, of a layer whose type and size have been checked.
template <class T>
[[nodiscard]] inline T element(const Layer& layer, std::size_t index) {
    T value;
    std::memcpy(&value, layer.bytes.data() + index * sizeof(T), sizeof(T));
    return value;
}

/// Element `index` as a number, whatever its type; f16 as IEEE 754 binary16. The size must have been checked.
[[nodiscard]] inline double element_value(const Layer& layer, std::size_t index) {
    switch (layer.type) {
        case ElementType::kU8:
            return element<std::uint8_t>(layer, index);
        case ElementType::kU16:
            return element<std::uint16_t>(layer, index);
        case ElementType::kU32:
            return element<std::uint32_t>(layer, index);
        case ElementType::kI16:
            return element<std::int16_t>(layer, index);
        case ElementType::kF16:
            return static_cast<double>(half_value(element<std::uint16_t>(layer, index)));
        case ElementType::kF32:
            return static_cast<double>(element<float>(layer, index));
    }
    return 0;
}

/// "f32", "u8", ...
[[nodiscard]] inline const char* type_name(ElementType type) {
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

/// "257 x 257 x 3"
[[nodiscard]] inline std::string shape_text(std::span<const std::uint64_t> shape) {
    std::string out;
    for (const std::uint64_t extent : shape) out += (out.empty() ? "" : " x ") + std::to_string(extent);
    return out;
}

}  // namespace dgm::model
