// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/option_text.h
// Reads sizes, bytes and lengths as users write them, alike on the command line and in scene files. `name` is the
// purpose of the value, and begins the message of every refusal; all throw model::Error kUsage.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "baking/bake_options.h"

namespace dgm::bake {

/// "MxN", or "M" for MxM; each side from `least` to `most`.
[[nodiscard]] GridSize parse_size(std::string_view name, const std::string& text, std::uint32_t least,
                                  std::uint32_t most);

/// "512MiB", "2G", "800000000": decimal units end in B alone (MB), the others are powers of 1024. At most 1e18.
[[nodiscard]] std::uint64_t parse_bytes(std::string_view name, const std::string& text, std::string_view example);

struct Quantity {
    double value = 0;       ///< finite, > 0
    std::string_view unit;  ///< one of those allowed; empty: none was written
};

/// "0.05%", "0.05 %", "1.5px", "0.2"
[[nodiscard]] Quantity parse_quantity(std::string_view name, const std::string& text,
                                      std::initializer_list<std::string_view> units, std::string_view example);

}  // namespace dgm::bake
