// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/run_apart.h
// Files of strangers are validated in disposable processes: whatever one of them does, the others are judged.
#pragma once
#include <functional>
#include <vector>

#include "validate/run.h"

namespace dgm::validate {

/// Validates each of `count` files by `validate` in copies of this program, `jobs` at a time; a copy takes the next
/// file when it is through with one, so that its memory serves again. A file that makes its copy crash, or exceeds the
/// limits, has a finding that says so (`name` gives its path), and another copy takes the rest. `done` gets the results
/// in order. The program must have one thread. Results as by calls of `validate` one after another.
/// @throws model::Error kSystemBusy if no copy can be made; what `done` throws
[[nodiscard]] std::vector<FileValidation> validate_apart(
    std::size_t count, unsigned jobs, const FileLimits& limits,
    const std::function<FileValidation(std::size_t file)>& validate,
    const std::function<std::filesystem::path(std::size_t file)>& name,
    const std::function<void(std::size_t file, FileValidation& result)>& done);

/// A result as text without line ends, and back; nullopt for text that is none. The path is not in it.
[[nodiscard]] std::string encode_result(const FileValidation& result);
[[nodiscard]] std::optional<FileValidation> decode_result(std::string_view text);

}  // namespace dgm::validate
