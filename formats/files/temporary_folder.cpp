// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/temporary_folder.cpp
#include "files/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "model/file_errors.h"

namespace dgm::formats {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(std::string_view program) {
    std::error_code error;
    const fs::path parent = fs::temp_directory_path(error);
    std::string name = ((error ? fs::path("/tmp") : parent) / (std::string(program) + "-XXXXXX")).string();
    if (::mkdtemp(name.data()) == nullptr) throw model::unwritable_folder(name, std::strerror(errno));
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace dgm::formats
