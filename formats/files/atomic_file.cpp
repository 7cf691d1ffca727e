// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/atomic_file.cpp
#include "files/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "files/staging_folder.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const char* action, const fs::path& path, int error) {
    throw model::Error(write_failure(error), std::string(action) + ": " + std::generic_category().message(error),
                       path.string());
}

void sync(const fs::path& path, int flags, bool is_folder) {
    const int file = ::open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) fail("open", path, errno);
    const int result = ::fsync(file);
    const int error = errno;
    ::close(file);
    // Some file systems cannot sync folders and say so with EINVAL; the rename itself has happened.
    if (result != 0 && !(is_folder && error == EINVAL)) fail("sync", path, error);
}

}  // namespace

void make_folder_of(const fs::path& file) {
    std::error_code ignored;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);
}

void sync_file(const fs::path& path) {
    sync(path, O_RDONLY, false);
}

void publish_file(const fs::path& temporary, const fs::path& final_path) {
    sync_file(temporary);
    if (::rename(temporary.c_str(), final_path.c_str()) != 0) fail("rename", final_path, errno);
    const fs::path folder = final_path.parent_path();
    sync(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY, true);
}

}  // namespace dgm::formats
