// SPDX-License-Identifier: MIT
// libdgm/src/file/chart_tables.h
// The layers of a chart as typed pointers, for code that reads values.
#pragma once
#include <cstdint>
#include <span>

#include <dgm/asset.h>
#include <dgm/limits.h>
#include <dgm/result.h>
#include <dgm/vec.h>

namespace dgm::detail {

/// A layer of triples or pairs in one of its stored types; both null if the chart does not have it.
struct PositionLayer {
    const float* f32 = nullptr;
    const std::uint16_t* u16 = nullptr;
    std::uint64_t file_offset = 0;
    [[nodiscard]] std::uint64_t element_offset(std::uint64_t k) const noexcept {
        return file_offset + k * 3 * (u16 != nullptr ? 2 : 4);
    }
};

/// A value of the mapped file, loaded once: the file may be overwritten between two loads, and a compiler is free to
/// load a value twice, for the check and for the use.
template <class T>
[[nodiscard]] T load_once(const T* from) noexcept {
    return *static_cast<const volatile T*>(from);
}

struct ChartTables {
    std::uint32_t rows = 0, cols = 0;
    std::uint32_t grid = 0;   ///< rows * cols
    std::uint32_t total = 0;  ///< grid + border samples
    bool free_domain = false;
    double scale[3] = {1, 1, 1};
    PositionLayer geometry, border;
    const std::uint8_t* mask = nullptr;
    const std::uint8_t* diagonals = nullptr;
    const std::int16_t* normal = nullptr;
    const std::int16_t* border_normal = nullptr;
    const std::uint8_t* reversed = nullptr;  ///< of each seam pair: the copy's faces wind against the representative's
    const float* border_uv = nullptr;
    const float* deformation = nullptr;  ///< E, F, G, stiffness of each grid sample
    const float* contact = nullptr;      ///< area, mobility of each grid sample
    std::span<const float> material;     ///< as limits.h has it
    std::span<const std::uint32_t> faces, seams;
    std::uint64_t mask_offset = 0, diagonals_offset = 0, border_uv_offset = 0, faces_offset = 0, seams_offset = 0,
                  deformation_offset = 0, contact_offset = 0, material_offset = 0;

    [[nodiscard]] bool on_surface(std::uint32_t sample) const noexcept {
        return sample >= grid || mask == nullptr || mask[sample] != 0;
    }
    /// All four corners are on the surface. i < rows - 1, j < cols - 1.
    [[nodiscard]] bool has_quad(std::uint32_t i, std::uint32_t j) const noexcept {
        if (mask == nullptr) return true;
        const std::uint8_t* m = mask + std::size_t{i} * cols + j;
        return m[0] != 0 && m[1] != 0 && m[cols] != 0 && m[cols + 1] != 0;
    }
    /// 0 or 1, whatever the file holds by now.
    [[nodiscard]] unsigned diagonal(std::uint32_t i, std::uint32_t j) const noexcept {
        return diagonals == nullptr ? 0 : diagonals[std::size_t{i} * (cols - 1) + j] & 1u;
    }
    /// Local position: scale * stored where the layer is quantised (or the grid is f32, whose scale is 1), else as
    /// stored: the f32 border of a u16 chart is not quantised.
    [[nodiscard]] Vec3 position(std::uint32_t sample) const noexcept;
    [[nodiscard]] std::uint64_t position_offset(std::uint32_t sample) const noexcept {
        return sample < grid ? geometry.element_offset(sample) : border.element_offset(sample - grid);
    }
};

/// @return BadSeamTable if `reversed` is not as long as `seams`; MissingLayer without geometry, without the mask of a
///         free domain, or without geometry or uv of its border samples.
[[nodiscard]] Result<ChartTables> read_tables(const Chart& chart) noexcept;

}  // namespace dgm::detail
