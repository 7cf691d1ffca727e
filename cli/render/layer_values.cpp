// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/layer_values.cpp
#include "render/layer_values.h"

#include <fmt/format.h>

#include <algorithm>

#include "image/image.h"
#include "model/codes.h"
#include "model/element.h"

namespace dgm::render {
namespace {
using model::element_value;
using model::ElementType;
using model::Layer;

[[noreturn]] void bad_shape(const Layer& layer) {
    throw model::Error(model::codes::kBadLayerShape,
                       fmt::format("{} {} with {} bytes does not suit this layer", model::type_name(layer.type),
                                   model::shape_text(layer.shape), layer.bytes.size()),
                       layer.name);
}

void check_bytes(const Layer& layer) {
    std::uint64_t bytes = layout::element_size(layer.type);
    for (const std::uint64_t side : layer.shape)
        if (__builtin_mul_overflow(bytes, side, &bytes)) bad_shape(layer);
    if (bytes == 0 || bytes != layer.bytes.size()) bad_shape(layer);
}
}  // namespace

Plane read_plane(const Layer& layer, std::initializer_list<ElementType> types, std::uint32_t channels) {
    const std::size_t rank = channels == 1 ? 2 : 3;
    const bool has_type = std::find(types.begin(), types.end(), layer.type) != types.end();
    if (!has_type || layer.shape.size() != rank || (rank == 3 && layer.shape[2] != channels)) bad_shape(layer);
    check_bytes(layer);
    if (std::max(layer.shape[0], layer.shape[1]) > formats::kMaxImageSide)
        throw model::Error(model::codes::kTooLarge, model::shape_text(layer.shape) + " samples do not fit a picture",
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
