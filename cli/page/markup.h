// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/markup.h
// Bytes and text put into a page, so that none of them can become markup.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace dgm::page {

[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// `bytes` in zlib's format (RFC 1950), as small as it makes them. Same bytes, same answer.
[[nodiscard]] std::string deflated(std::span<const std::byte> bytes);

/// A name in an attribute or a title: & < > " ' as entities, control characters and bytes beyond ASCII that are not
/// UTF-8 as "?".
[[nodiscard]] std::string attribute_text(std::string_view text);

}  // namespace dgm::page
