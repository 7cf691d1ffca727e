// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_text.h
// Header attributes as text: other programs keep strings when they save a file again, and drop what they do not know.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/map_set.h"

namespace dgm::formats {

/// One line of the attribute dgmChart<k>.layers.
struct LayerEntry {
    std::string name;
    layout::ElementType type = layout::ElementType::kF32;
    std::vector<std::uint64_t> shape;
    bool required = false;
};
[[nodiscard]] std::string manifest_line(const LayerEntry& entry);
/// Nothing if the text is not what manifest_line writes.
[[nodiscard]] std::optional<LayerEntry> parse_manifest_line(std::string_view line);

[[nodiscard]] std::string attribute_text(const model::AttributeValue& value);
[[nodiscard]] std::optional<model::AttributeValue> parse_attribute_text(std::string_view text);

[[nodiscard]] std::string hex_of(std::span<const std::uint8_t> bytes);
[[nodiscard]] bool parse_hex(std::string_view text, std::span<std::uint8_t> bytes);

/// Base 64 of RFC 4648 section 4, padded, without line breaks.
[[nodiscard]] std::string base64_of(std::span<const std::byte> bytes);
/// Nothing unless the text is what base64_of writes.
[[nodiscard]] std::optional<std::vector<std::byte>> parse_base64(std::string_view text);

/// The lines of a text, without the last if it is empty.
[[nodiscard]] std::vector<std::string_view> lines_of(std::string_view text);

}  // namespace dgm::formats
