// SPDX-License-Identifier: MIT
// libdgm/src/touch/table_impl.h
// Content of a DeformTable: weights of whole offsets in rows, and a profile over distance.
#pragma once
#include <cmath>
#include <cstdint>

#include <dgm/deform.h>

#include "base/memory.h"

namespace dgm::detail {

struct TableImpl {
    explicit TableImpl(const Allocator& from) noexcept : allocator(from) {}
    Allocator allocator;
    KernelOptions options;  ///< values: the table's own copy
    Array<float> values;
    /// Kernel distance r^2 = a x^2 + b x y + c y^2 in grid steps, along the longer axis of an ellipse.
    double a = 1, b = 0, c = 1;
    double sigma = 1;              ///< exp(-r^2 / sigma); of the longer axis
    bool mirrored = true;          ///< circular and user: row |di| serves both signs; elliptic: rows 1 - b .. b - 1
    Array<float> weights, turned;  ///< turned: x and y exchanged, only if that differs
    Array<float> entries;          ///< profile at distances k * spacing
    float spacing = 1;
    /// Bounds on chords that keep the error of a weight below a share of the peak: a hundredth for exact footprints,
    /// eight hundredths for others.
    struct Tolerance {
        float share;
        float slant2 = 0;  ///< squared sine of a chord's angle to the surface
        float quiet = 0;   ///< from this distance on weights differ by no more than the share anyway, grid steps
    };
    Tolerance tolerance[2] = {{0.01f}, {0.08f}};
    std::uint64_t hash[2] = {};  ///< of all that weights depend on

    [[nodiscard]] std::uint32_t width() const noexcept { return 2 * options.reach - 1; }
    /// Weights of row di at dj = 0; dj = 1 - b .. b - 1 lie beside it. `exchange`: weights of (dj, di) instead.
    [[nodiscard]] const float* row(std::int32_t di, bool exchange = false) const noexcept {
        const std::int32_t r = mirrored ? (di < 0 ? -di : di) : di + static_cast<std::int32_t>(options.reach) - 1;
        const Array<float>& from = exchange && !mirrored ? turned : weights;
        return from.data() + static_cast<std::size_t>(r) * width() + options.reach - 1;
    }
    /// Linear between entries, 0 beyond them.
    [[nodiscard]] float profile(float distance) const noexcept {
        const float at = distance / spacing;
        const auto last = static_cast<float>(entries.size() - 1);
        if (!(at < last)) return 0;
        const auto k = static_cast<std::uint32_t>(at);
        const float share = at - static_cast<float>(k);
        return entries[k] + share * (entries[k + 1] - entries[k]);
    }
    /// At any offset in grid steps, 0 outside the window.
    [[nodiscard]] float weight(float di, float dj) const noexcept;
};

}  // namespace dgm::detail
