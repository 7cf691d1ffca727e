// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/io_failure.cpp
#include "files/io_failure.h"

#include <cerrno>

#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {

namespace codes = model::codes;

bool may_pass(int error_number) {
    switch (error_number) {
        case EIO:
        case ESTALE:
        case ETIMEDOUT:
        case EAGAIN:
        case ENFILE:
        case EMFILE:
        case ENOMEM:
            return true;
        default:
            return false;
    }
}

const model::Code& write_failure(int error_number) {
    if (error_number == ENOSPC || error_number == EDQUOT) return codes::kNoSpace;
    return may_pass(error_number) ? codes::kIoTrouble : codes::kWriteFailed;
}

const model::Code& read_failure(int error_number) {
    return may_pass(error_number) ? codes::kIoTrouble : codes::kReadFailed;
}

void check_look(const std::error_code& error, const std::filesystem::path& at) {
    if (error && may_pass(error.value())) throw model::unreadable_file(at, error.message(), codes::kIoTrouble);
}

std::filesystem::file_status look_at(const std::filesystem::path& path) {
    std::error_code error;
    const std::filesystem::file_status out = std::filesystem::status(path, error);
    check_look(error, path);
    return out;
}

}  // namespace dgm::formats
