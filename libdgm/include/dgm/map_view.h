// SPDX-License-Identifier: MIT
// libdgm/include/dgm/map_view.h
// Gives access to the layers of a mapped file and to the points of a state, without a copy.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/layout.h>
#include <dgm/result.h>
#include <dgm/vec.h>

namespace dgm {

namespace detail {
template <class T>
struct ElementOf;
template <>
struct ElementOf<std::uint8_t> {
    static constexpr bool matches(layout::ElementType t) { return t == layout::ElementType::kU8; }
};
template <>
struct ElementOf<std::uint16_t> {  // f16 is handed out as its bits
    static constexpr bool matches(layout::ElementType t) {
        return t == layout::ElementType::kU16 || t == layout::ElementType::kF16;
    }
};
template <>
struct ElementOf<std::uint32_t> {
    static constexpr bool matches(layout::ElementType t) { return t == layout::ElementType::kU32; }
};
template <>
struct ElementOf<std::int16_t> {
    static constexpr bool matches(layout::ElementType t) { return t == layout::ElementType::kI16; }
};
template <>
struct ElementOf<float> {
    static constexpr bool matches(layout::ElementType t) { return t == layout::ElementType::kF32; }
};
}  // namespace detail

/// One named array of a chart, row-major and contiguous, in the asset's own memory. Valid while the Asset lives.
struct LayerView {
    const char* name = "";  ///< zero-terminated, in the asset's memory
    layout::ElementType type = layout::ElementType::kU8;
    std::uint32_t rank = 0;
    std::uint32_t flags = 0;
    std::uint64_t shape[4] = {};    ///< elements in each dimension, 0 beyond `rank`
    std::uint64_t file_offset = 0;  ///< where `data` is in the file
    const std::byte* data = nullptr;
    std::size_t bytes = 0;  ///< size of `data`
    bool known = false;     ///< false: an optional layer that this version has no rules for

    /// Gives the elements as T (f16 as uint16_t bits). @return BadLayer if the stored type is another.
    template <class T>
    [[nodiscard]] Result<std::span<const T>> as() const noexcept {
        if (!detail::ElementOf<T>::matches(type))
            return Error{ErrorCode::BadLayer, file_offset, "the layer holds another element type"};
        return std::span<const T>(reinterpret_cast<const T*>(data), bytes / sizeof(T));
    }
};

/// Points of a state: one float array for each coordinate, `step` floats from one point to the next.
struct PointView {
    const float* x = nullptr;
    const float* y = nullptr;
    const float* z = nullptr;
    std::size_t count = 0;
    std::size_t step = 1;
    [[nodiscard]] Vec3 operator[](std::size_t k) const noexcept { return {x[k * step], y[k * step], z[k * step]}; }
};

}  // namespace dgm
