// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/layer_values.h
// Numbers out of a layer's bytes, for drawing.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "model/map_set.h"

namespace dgm::render {

/// A layer seen as rows x cols samples of `channels` numbers.
struct Plane {
    std::uint32_t rows = 0, cols = 0, channels = 1;
    std::vector<float> values;
    [[nodiscard]] float at(std::uint32_t i, std::uint32_t j, std::uint32_t channel = 0) const {
        return values[(std::size_t{i} * cols + j) * channels + channel];
    }
};

/// The layer as a plane of the asked element types and number of channels (1: rank 2, else rank 3).
/// @throws model::Error kBadLayerShape if type, rank or channels differ or the bytes do not fit the shape, kTooLarge if
///         a side is 0 or too large for a picture
[[nodiscard]] Plane read_plane(const model::Layer& layer, std::initializer_list<model::ElementType> types,
                               std::uint32_t channels);

/// The same, and it must have rows x cols samples.
[[nodiscard]] Plane read_plane(const model::Layer& layer, std::initializer_list<model::ElementType> types,
                               std::uint32_t channels, std::uint32_t rows, std::uint32_t cols);

/// Checks that the layer is a list [k][width] (or [k] for width 1) of `type` and gives k. @throws kBadLayerShape
[[nodiscard]] std::uint64_t list_length(const model::Layer& layer, model::ElementType type, std::uint64_t width);

}  // namespace dgm::render
