// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output.h
// Findings as text for people and JSON for programs.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "model/error.h"
#include "validate/validation.h"

namespace dgm::validate {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// One line a finding, `DGM1003 error: FILE: /charts/0/normal: message (measured 3, limit 0) — hint`, then, unless
/// quiet, one line for the file. Quiet leaves warnings out; verbose adds the measured error. Control characters become
/// `?`.
[[nodiscard]] std::string to_text(const FileValidation& file, Verbosity verbosity);

/// Array of files in the order given, keys in a fixed order, numbers as short as they read back. Ends with a newline.
[[nodiscard]] std::string to_json(std::span<const FileValidation> files);

/// "DGM1003", "1003", "HASH_MISMATCH" or "DGM1003_HASH_MISMATCH", in any case; null if there is no such code.
[[nodiscard]] const model::Code* find_code(std::string_view name);

/// What --explain prints.
[[nodiscard]] std::string explain(const model::Code& code);

}  // namespace dgm::validate
