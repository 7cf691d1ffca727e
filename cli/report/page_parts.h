// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/page_parts.h
// The files of cli/report/page, built in.
#pragma once

namespace dgm::report {
extern const char* const kStyle;        ///< page/style.css
extern const char* const kIndexScript;  ///< page/index.js
}  // namespace dgm::report
