// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/folder_list.cpp
#include "files/folder_list.h"

#include <algorithm>
#include <system_error>

#include "files/io_failure.h"
#include "model/codes.h"

namespace dgm::formats {

namespace fs = std::filesystem;

void sort_paths(std::vector<fs::path>& paths) {
    std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) { return a.native() < b.native(); });
}

void check_listed(const std::error_code& error, const fs::path& folder) {
    if (!error || error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory) return;
    throw model::Error(read_failure(error.value()), "the folder cannot be listed: " + error.message(), folder.string());
}

std::vector<fs::path> files_below(const fs::path& folder, fs::directory_options options) {
    std::vector<fs::path> out;
    std::error_code error;
    fs::recursive_directory_iterator it(folder, options, error);
    for (const fs::recursive_directory_iterator end; !error && it != end; it.increment(error)) {
        const fs::path& path = it->path();
        std::error_code of_entry;
        if (path.filename().native().front() == '.') {
            if (it->is_directory(of_entry)) it.disable_recursion_pending();
            continue;
        }
        if (it->is_regular_file(of_entry)) out.push_back(path.lexically_relative(folder));
        check_look(of_entry, path);
    }
    check_listed(error, folder);
    sort_paths(out);
    return out;
}

}  // namespace dgm::formats
