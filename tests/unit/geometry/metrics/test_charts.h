// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/test_charts.h
// Layers made by hand.
#pragma once
#include <cstring>
#include <string>
#include <vector>

#include "model/map_set.h"

namespace dgm::test {

template <class T>
model::Layer make_layer(std::string name, model::ElementType type, std::vector<std::uint64_t> shape,
                        const std::vector<T>& values) {
    model::Layer layer;
    layer.name = std::move(name);
    layer.type = type;
    layer.shape = std::move(shape);
    layer.bytes.resize(values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(layer.bytes.data(), values.data(), layer.bytes.size());
    return layer;
}

/// Overwrites element `index` of a layer.
template <class T>
void poke(model::Layer& layer, std::size_t index, T value) {
    std::memcpy(layer.bytes.data() + index * sizeof(T), &value, sizeof(T));
}
template <class T>
T peek(const model::Layer& layer, std::size_t index) {
    T value;
    std::memcpy(&value, layer.bytes.data() + index * sizeof(T), sizeof(T));
    return value;
}

}  // namespace dgm::test
