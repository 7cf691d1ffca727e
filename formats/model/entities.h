// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/entities.h
// Characters that markup has a meaning for, for XML and HTML alike. What becomes of control characters is each
// document's own.
#pragma once
#include <string_view>

namespace dgm::model {

/// "&amp;" for '&', and so on for < > " '; empty for a character that stands for itself. The apostrophe's has a number,
/// since HTML 4 has no name for it.
[[nodiscard]] constexpr std::string_view entity_of(char c) {
    switch (c) {
        case '&':
            return "&amp;";
        case '<':
            return "&lt;";
        case '>':
            return "&gt;";
        case '"':
            return "&quot;";
        case '\'':
            return "&#39;";
        default:
            return {};
    }
}

}  // namespace dgm::model
