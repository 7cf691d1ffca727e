// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/io_failure.h
// What an error number of the system says: about the file, or about this machine for now.
#pragma once
#include <filesystem>
#include <system_error>

#include "model/error.h"

namespace dgm::formats {

/// True if the disk, the network or the system failed for the moment (no descriptor, no memory, EIO): nothing is known
/// of the file. Whoever takes it for one that is not there makes another map of the same input.
[[nodiscard]] bool may_pass(int error_number);

/// kNoSpace for a full disk or quota, kIoTrouble for what may pass, else kWriteFailed.
[[nodiscard]] const model::Code& write_failure(int error_number);

/// kIoTrouble for what may pass, else kReadFailed.
[[nodiscard]] const model::Code& read_failure(int error_number);

/// For a look at a file or folder, which may be missing. @throws model::Error kIoTrouble if it was what may pass
void check_look(const std::error_code& error, const std::filesystem::path& at);

/// What is there, links followed; file_type::not_found and ::none as std::filesystem::status() has them.
/// @throws model::Error as check_look()
[[nodiscard]] std::filesystem::file_status look_at(const std::filesystem::path& path);

}  // namespace dgm::formats
