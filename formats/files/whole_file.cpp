// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/whole_file.cpp
#include "files/whole_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "files/staging_folder.h"

namespace dgm::formats {

void write_whole_file(const std::filesystem::path& path, std::string_view bytes, const std::filesystem::path& place) {
    errno = 0;
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    const bool is_made = file.is_open();
    if (is_made) {
        file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        file.close();
        if (file) return;
    }
    const int failure = errno != 0 ? errno : EIO;
    std::error_code ignored;
    if (is_made && std::filesystem::is_regular_file(path, ignored)) std::filesystem::remove(path, ignored);
    throw model::Error(
        write_failure(failure),
        std::string(is_made ? "the file cannot be written: " : "the file cannot be created: ") + std::strerror(failure),
        (place.empty() ? path : place).string());
}

}  // namespace dgm::formats
