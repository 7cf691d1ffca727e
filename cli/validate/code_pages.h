// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/code_pages.h
// The table of codes (model/codes.h) for people: --explain, and docs/codes.md.
#pragma once
#include <string>
#include <string_view>

#include "model/error.h"

namespace dgm::validate {

/// "DGM1003", "1003", "HASH_MISMATCH" or "DGM1003_HASH_MISMATCH", in any case; null if there is no such code.
[[nodiscard]] const model::Code* find_code(std::string_view name);

/// Text of --explain: what, why it matters, what to do, exit code.
[[nodiscard]] std::string explain(const model::Code& code);
/// The same of every code.
[[nodiscard]] std::string explain_all();

/// docs/codes.md, all of it.
[[nodiscard]] std::string codes_markdown();

/// "container and index" for 1003: subject of a range of numbers.
[[nodiscard]] const char* subject_of(const model::Code& code);

}  // namespace dgm::validate
