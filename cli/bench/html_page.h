// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/html_page.h
// Files that every page carries with it; embed_page.cmake puts the files' text behind these names.
#pragma once

namespace dgm::bench::page {

extern const char* const kHtml;    ///< page/page.html, with @TITLE@, @CSS@, @DATA@, @D3@ and @SCRIPT@ to fill in
extern const char* const kCss;     ///< page/page.css
extern const char* const kScript;  ///< page/page.js
extern const char* const kD3;      ///< d3.min.js of Debian's libjs-d3

}  // namespace dgm::bench::page
