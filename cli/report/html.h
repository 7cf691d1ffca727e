// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/html.h
// Text, pictures and data put into a page, so that none of them can become markup.
#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "image/image.h"

namespace dgm::report {

/// `text` for element content and quoted attributes: & < > " ' as entities, control characters as \xNN (a newline
/// stays), bytes that are not UTF-8 as U+FFFD.
[[nodiscard]] std::string escaped(std::string_view text);

/// `text` for a quoted attribute that gives the same characters back, whatever they are: & and " as entities.
[[nodiscard]] std::string attribute_value(std::string_view text);

/// JSON in ASCII for a script element: no < > & in it, so no end tag and no comment can begin.
[[nodiscard]] std::string script_json(const nlohmann::json& value);

/// One segment of a relative link: all bytes but letters, digits, - . _ ~ as %XX.
[[nodiscard]] std::string link_segment(std::string_view name);

/// "data:image/...": a JPEG of that quality.
[[nodiscard]] std::string photo_uri(const formats::Image& image, int quality);
/// "data:image/...": a PNG, or a JPEG of quality 92 if the PNG is beyond `most` bytes.
[[nodiscard]] std::string picture_uri(const formats::Image& image, std::size_t most);

/// "0.0123": three digits; "0" and "unknown" for NaN.
[[nodiscard]] std::string number_text(double value);
/// "0.02 (0.01 %)": source units, and % of the diagonal.
[[nodiscard]] std::string length_text(double value, double diagonal);
/// "1 chart", "2 charts".
[[nodiscard]] std::string counted(std::uint64_t count, std::string_view noun);

/// From the doctype to the opening of the body. `head` is markup for the head, after the encoding and the title.
[[nodiscard]] std::string page_start(std::string_view title, std::string_view head);

}  // namespace dgm::report
