// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/attribute_stream.h
// Attributes of layers in a byte stream.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "model/map_set.h"
#include "process/byte_stream.h"

namespace dgm::bake {

using Attributes = std::map<std::string, model::AttributeValue>;

inline void put_attributes(ByteWriter& out, const Attributes& attributes) {
    out.put(std::uint64_t{attributes.size()});
    for (const auto& [name, value] : attributes) {
        out.put(name);
        out.put(static_cast<std::uint8_t>(value.index()));
        if (const auto* text = std::get_if<std::string>(&value)) out.put(*text);
        if (const auto* doubles = std::get_if<std::vector<double>>(&value)) out.put_all(*doubles);
        if (const auto* words = std::get_if<std::vector<std::uint32_t>>(&value)) out.put_all(*words);
    }
}

inline Attributes get_attributes(ByteReader& in) {
    Attributes out;
    in.get_each([&] {
        std::string name = in.text();
        const auto kind = in.get<std::uint8_t>();
        if (kind == 0) {
            out.emplace(std::move(name), in.text());
        } else if (kind == 1) {
            std::vector<double> doubles;
            in.get_all(doubles);
            out.emplace(std::move(name), std::move(doubles));
        } else {
            std::vector<std::uint32_t> words;
            in.get_all(words);
            out.emplace(std::move(name), std::move(words));
        }
    });
    return out;
}

}  // namespace dgm::bake
