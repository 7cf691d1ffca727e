// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/folder_list.cpp
#include "files/folder_list.h"

#include <algorithm>
#include <system_error>

#include "files/io_failure.h"
#include "model/codes.h"

namespace dgm::formats {

namespace fs = std::filesystem;

namespace {

model::Error unlisted(const std::error_code& error, const fs::path& folder) {
    return {read_failure(error.value()), "the folder cannot be listed: " + error.message(), folder.string()};
}

}  // namespace

void sort_paths(std::vector<fs::path>& paths) {
    std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) { return a.native() < b.native(); });
}

void check_listed(const std::error_code& error, const fs::path& folder) {
    if (!error || error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory) return;
    throw unlisted(error, folder);
}

std::vector<fs::path> files_below(const fs::path& folder, fs::directory_options options) {
    std::vector<fs::path> out;
    std::error_code error, ignored;
    fs::path last = folder;  // where a failure happens, in it or beside it
    fs::recursive_directory_iterator it(folder, options, error);
    for (const fs::recursive_directory_iterator end; !error && it != end; it.increment(error)) {
        const fs::path& path = last = it->path();
        std::error_code of_entry;
        if (path.filename().native().front() == '.') {
            if (it->is_directory(of_entry)) it.disable_recursion_pending();
            continue;
        }
        if (it->is_regular_file(of_entry)) out.push_back(path.lexically_relative(folder));
        check_look(of_entry, path);
    }
    if (error && last != folder)  // also one that goes away meanwhile: it takes the rest of the list with it
        throw unlisted(error, fs::is_directory(last, ignored) ? last : last.parent_path());
    check_listed(error, folder);
    sort_paths(out);
    return out;
}

}  // namespace dgm::formats
