// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/page_parts.h
// The files of cli/page/web and the runtime's module, built in.
#pragma once
#include <string_view>

namespace dgm::page {
[[nodiscard]] std::string_view page_html();    ///< web/page.html, with @TITLE@, @BODY@, @STYLE@ and @DATA@ to fill in
[[nodiscard]] std::string_view page_style();   ///< web/style.css
[[nodiscard]] std::string_view page_script();  ///< web/*.js, one after the other
[[nodiscard]] std::string_view page_module();  ///< libdgm/web as WebAssembly; empty in a build without it
}  // namespace dgm::page
