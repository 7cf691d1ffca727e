// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/file_pattern.cpp
#include "batch/file_pattern.h"

#include <fnmatch.h>

#include <algorithm>
#include <span>
#include <string>

#include "files/folder_list.h"
#include "files/io_failure.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;

/// `folder` must stand for a folder that is below `root`; components[0] is what its entries must match.
void collect(const fs::path& root, const fs::path& folder, std::span<const std::string> components,
             std::vector<fs::path>& out) {
    const bool any_depth = components.front() == "**";
    if (any_depth && components.size() > 1) collect(root, folder, components.subspan(1), out);
    std::error_code error;
    const fs::path listed = root / folder;
    fs::directory_iterator it(listed.empty() ? fs::path(".") : listed, error);
    for (; !error && it != fs::directory_iterator(); it.increment(error)) {
        const std::string name = it->path().filename().string();
        std::error_code of_entry, ignored;
        const bool is_folder = it->is_directory(of_entry) && !it->is_symlink(ignored);
        formats::check_look(of_entry, it->path());
        if (any_depth) {
            if (name.front() == '.') continue;
            if (is_folder) collect(root, folder / name, components, out);
            if (components.size() == 1 && it->is_regular_file(ignored)) out.push_back(folder / name);
        } else if (fnmatch(components.front().c_str(), name.c_str(), FNM_PERIOD) == 0) {
            if (components.size() > 1 && it->is_directory(ignored))
                collect(root, folder / name, components.subspan(1), out);
            if (components.size() == 1 && it->is_regular_file(ignored)) out.push_back(folder / name);
        }
    }
    formats::check_listed(error, listed);
}

/// Sorted, and each once.
std::vector<fs::path> collected(const fs::path& root, const std::vector<std::string>& components) {
    std::vector<fs::path> out;
    if (!components.empty()) collect(root, {}, components, out);
    formats::sort_paths(out);
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

}  // namespace

bool is_pattern(std::string_view text) {
    return text.find_first_of("*?[") != std::string_view::npos;
}

std::pair<fs::path, std::vector<fs::path>> files_matching(const fs::path& pattern) {
    fs::path root;
    std::vector<std::string> components;
    for (const fs::path& part : pattern) {
        const std::string& text = part.native();
        if (components.empty() && !is_pattern(text))
            root /= part;
        else if (!text.empty() && text != "." && !(text == "**" && !components.empty() && components.back() == "**"))
            components.push_back(text);
    }
    return {root, collected(root, components)};
}

}  // namespace dgm::bake
