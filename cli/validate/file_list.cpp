// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/file_list.cpp
#include "validate/file_list.h"

#include <algorithm>
#include <set>

#include "exr/exr_files.h"
#include "files/folder_list.h"
#include "files/io_failure.h"

namespace dgm::validate {
namespace {
namespace fs = std::filesystem;

std::vector<fs::path> files_like(const std::string& pattern) {
    // The folders before the first wildcard are where the search starts.
    const std::size_t slash = pattern.substr(0, pattern.find_first_of("*?")).rfind('/');
    const fs::path start = slash == std::string::npos ? fs::path(".") : fs::path(pattern.substr(0, slash + 1));
    const std::string wanted = fs::path(pattern).lexically_normal().generic_string();
    std::vector<fs::path> out;
    for (const fs::path& file : formats::files_below(start)) {
        const fs::path name = (start / file).lexically_normal();
        if (matches(wanted, name.generic_string())) out.push_back(name);
    }
    return out;
}

/// True for a file of layers whose map is in the list as well: the two are checked as one.
bool belongs_to_another(const fs::path& file, const std::vector<fs::path>& list) {
    if (file.extension() != ".exr" || !formats::is_exr_side_file(file)) return false;
    const std::string name = file.filename().string();
    return std::any_of(list.begin(), list.end(), [&](const fs::path& map) {
        return map != file && map.extension() == ".exr" && map.parent_path() == file.parent_path() &&
               name.starts_with(map.stem().string() + ".") && !formats::is_exr_side_file(map);
    });
}
}  // namespace

bool matches(std::string_view pattern, std::string_view text) {
    // Only the last star has to give way: an earlier one can keep its characters. A double star that fails behind a
    // single one gives way instead, since it may cross slashes.
    std::size_t p = 0, t = 0;
    constexpr auto kNone = std::string_view::npos;
    std::size_t star = kNone, star_text = 0, wide = kNone, wide_text = 0;
    bool wide_folders = false;
    while (true) {
        if (pattern.substr(p).starts_with("**")) {
            p += 2;
            // "**/" stands for whole folders, or none.
            wide_folders = p < pattern.size() && pattern[p] == '/' && (p == 2 || pattern[p - 3] == '/');
            if (wide_folders) ++p;
            wide = p;
            wide_text = t;
            star = kNone;
            continue;
        }
        if (p < pattern.size() && pattern[p] == '*') {
            star = ++p;
            star_text = t;
            continue;
        }
        if (t < text.size() && p < pattern.size() && (pattern[p] == text[t] || (pattern[p] == '?' && text[t] != '/'))) {
            ++p;
            ++t;
            continue;
        }
        if (t == text.size() && p == pattern.size()) return true;
        if (star != kNone && star_text < text.size() && text[star_text] != '/') {
            p = star;
            t = ++star_text;
        } else if (wide != kNone && wide_text < text.size()) {
            ++wide_text;
            if (wide_folders) {
                const std::size_t slash = text.find('/', wide_text - 1);
                if (slash == kNone) return false;
                wide_text = slash + 1;
            }
            p = wide;
            t = wide_text;
            star = kNone;
        } else {
            return false;
        }
    }
}

std::vector<fs::path> expand_names(const std::vector<std::string>& names) {
    std::vector<fs::path> out;
    std::set<std::string> seen;
    const auto add = [&](const fs::path& file) {
        if (seen.insert(file.lexically_normal().string()).second) out.push_back(file);
    };
    for (const std::string& name : names) {
        const fs::file_status status = formats::look_at(name);
        std::vector<fs::path> found;
        if (fs::is_directory(status)) {
            for (const fs::path& file : formats::files_below(name))
                if (file.extension() == ".dgm" || file.extension() == ".exr") found.push_back(name / file);
        } else if (!fs::exists(status) && name.find_first_of("*?") != std::string::npos) {
            found = files_like(name);
        }
        if (found.empty()) found.emplace_back(name);
        for (const fs::path& file : found) add(file);
    }
    const std::vector<fs::path> all = out;
    std::erase_if(out, [&](const fs::path& file) { return belongs_to_another(file, all); });
    return out;
}

}  // namespace dgm::validate
