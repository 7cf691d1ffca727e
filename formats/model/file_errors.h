// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/file_errors.h
// Says in one wording, whichever room finds out, why a file cannot be read or written.
#pragma once
#include <filesystem>
#include <string>
#include <system_error>

#include "model/codes.h"

namespace dgm::model {

/// kFileMissing
[[nodiscard]] inline Error missing_file(const std::filesystem::path& path) {
    return {codes::kFileMissing, "there is no such file", path.string()};
}

/// kFileMissing, where a folder would do as well
[[nodiscard]] inline Error missing_file_or_folder(const std::filesystem::path& path) {
    return {codes::kFileMissing, "there is no such file or folder", path.string()};
}

/// kReadFailed: a folder, a pipe or a device where a file is needed
[[nodiscard]] inline Error no_regular_file(const std::filesystem::path& path) {
    return {codes::kReadFailed, "not a regular file", path.string()};
}

/// @param reason  what the system says, or empty. @param code  kReadFailed, or a reason that may pass
[[nodiscard]] inline Error unreadable_file(const std::filesystem::path& path, const std::string& reason = {},
                                           const Code& code = codes::kReadFailed) {
    return {code, "the file cannot be read" + (reason.empty() ? "" : ": " + reason), path.string()};
}

/// For a file that did not open: missing_file() or unreadable_file().
[[nodiscard]] inline Error unopened_file(const std::filesystem::path& path) {
    std::error_code error;
    const bool missing = std::filesystem::status(path, error).type() == std::filesystem::file_type::not_found;
    return missing ? missing_file(path) : unreadable_file(path);
}

/// kWriteFailed. @param reason  what the system says, or empty
[[nodiscard]] inline Error unwritable_file(const std::filesystem::path& path, const std::string& reason = {}) {
    return {codes::kWriteFailed, "the file cannot be written" + (reason.empty() ? "" : ": " + reason), path.string()};
}

/// For a folder that is needed for an output. @param code  kWriteFailed, or a reason that may pass
[[nodiscard]] inline Error unwritable_folder(const std::filesystem::path& path, const std::string& reason,
                                             const Code& code = codes::kWriteFailed) {
    return {code, "the folder cannot be made: " + reason, path.string()};
}

}  // namespace dgm::model
