// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/material_files.cpp
#include "mesh/material_files.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>

#include "files/io_failure.h"
#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

/// A folder with more names than this is searched by exact name only.
constexpr std::size_t kMaxListedNames = 100'000;
constexpr std::size_t kMaxName = 4096;
constexpr std::array kTextureFolders{"textures", "texture", "maps", "images", "materials"};

/// @param code  of one that is not there
std::string unread(const model::Code& code, std::string_view what, std::string_view name, FoundFile::Why why) {
    const std::string shown(name);
    if (why == FoundFile::Why::kOutside)
        return codes::kReferenceOutside.id() + ": " + std::string(what) + " outside the mesh's folder: " + shown +
               "; copy it beside the mesh, or allow its folder with --asset-root DIR";
    if (why == FoundFile::Why::kSpecial)
        return codes::kReferenceNoFile.id() + ": " + std::string(what) + " is a pipe or a device: " + shown;
    std::string out =
        code.id() + ": " + std::string(what) + " missing: " + shown + "; looked for beside the mesh and there in";
    for (const char* folder : kTextureFolders) out += std::string(folder == kTextureFolders[0] ? " " : ", ") + folder;
    return out;
}

/// "/C:/My Files/a.png" for "file:///C:/My%20Files/a.png".
std::string url_decoded(std::string_view name) {
    constexpr std::string_view kScheme = "file://";
    if (name.starts_with(kScheme)) name.remove_prefix(kScheme.size());
    std::string out;
    for (std::size_t k = 0; k < name.size(); ++k) {
        unsigned value = 0;
        const char* const digits = name.data() + k + 1;
        const bool is_code =
            name[k] == '%' && name.size() - k > 2 && std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2;
        out += is_code ? static_cast<char>(value) : name[k];
        k += is_code ? 2 : 0;
    }
    return out;
}

}  // namespace

std::string texture_missing(std::string_view name, FoundFile::Why why) {
    return unread(codes::kTextureMissing, "texture", name, why);
}

std::string library_missing(std::string_view name, FoundFile::Why why) {
    return unread(codes::kMaterialsMissing, "material library", name, why);
}

bool FileFinder::may_read(const fs::path& file) {
    if (is_special_file(file)) why_ = FoundFile::Why::kSpecial;
    if (!fs::is_regular_file(look_at(file))) return false;
    if (folders_.hold(file)) return true;
    why_ = FoundFile::Why::kOutside;
    return false;
}

const FileFinder::Listing& FileFinder::listing(const fs::path& folder) {
    const auto [entry, is_new] = listings_.try_emplace(folder);
    if (!is_new) return entry->second;
    std::error_code error;
    fs::directory_iterator files(folder.empty() ? fs::path(".") : folder, error);
    std::size_t count = 0;
    for (; !error && files != fs::directory_iterator(); files.increment(error)) {
        if (++count > kMaxListedNames) break;
        const std::string name = files->path().filename().string();
        entry->second[lower_case(name)].push_back(name);
    }
    check_look(error, folder);
    for (auto& [lowered, names] : entry->second) std::sort(names.begin(), names.end());
    return entry->second;
}

std::optional<fs::path> FileFinder::find_below(const fs::path& folder, std::string_view relative) {
    if (may_read(folder / relative)) return folder / relative;
    fs::path found = folder;
    while (!relative.empty()) {
        const std::size_t slash = std::min(relative.find('/'), relative.size());
        const std::string_view component = relative.substr(0, slash);
        relative.remove_prefix(std::min(slash + 1, relative.size()));
        if (component.empty() || component == ".") continue;
        if (component == "..") {
            found /= "..";
            continue;
        }
        const Listing& names = listing(found);
        const auto match = names.find(lower_case(component));
        if (match == names.end()) return std::nullopt;
        const auto& candidates = match->second;
        const bool exact = std::find(candidates.begin(), candidates.end(), component) != candidates.end();
        found /= exact ? std::string(component) : candidates.front();
    }
    return may_read(found) ? std::optional(found) : std::nullopt;
}

FoundFile FileFinder::find(std::string_view name) {
    why_ = FoundFile::Why::kMissing;
    name = trim(name);
    if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    if (auto found = find_as_it_stands(std::string(name))) return {*found};
    std::string decoded = url_decoded(name);
    if (decoded != name)
        if (auto found = find_as_it_stands(decoded)) return {*found};
    // Without a look at what is there: the report would tell a stranger which files this machine has. An absolute path
    // of Windows leads nowhere here.
    const bool is_of_windows = decoded.starts_with('\\') || (decoded.size() > 2 && decoded[2] == ':');
    std::replace(decoded.begin(), decoded.end(), '\\', '/');
    if (leads_outside(decoded) && !is_of_windows) why_ = FoundFile::Why::kOutside;
    return {{}, why_};
}

std::optional<fs::path> FileFinder::find_as_it_stands(std::string path) {
    std::replace(path.begin(), path.end(), '\\', '/');
    if (path.empty() || path.size() > kMaxName || path.find('\0') != std::string::npos) return std::nullopt;
    if (auto found = find_in(folders_.all().front(), path)) return found;
    if (path.front() == '/' && may_read(path)) return fs::path(path);
    for (std::size_t k = 1; k < folders_.all().size(); ++k)
        if (auto found = find_in(folders_.all()[k], path)) return found;
    return std::nullopt;
}

std::optional<fs::path> FileFinder::find_in(const fs::path& folder, const std::string& path) {
    const bool has_drive = path.size() > 2 && path[1] == ':';
    const bool is_absolute = path.front() == '/' || has_drive;
    if (!is_absolute)
        if (auto found = find_below(folder, path)) return found;
    std::string last = has_drive ? path.substr(2) : path;
    for (std::size_t slash = last.find('/'); slash != std::string::npos; slash = last.find('/')) {
        last.erase(0, slash + 1);
        if (last.empty()) return std::nullopt;
        if (last.front() == '/' || last.starts_with("../")) continue;
        if (auto found = find_below(folder, last)) return found;
    }
    if (auto found = find_below(folder, last)) return found;
    for (const char* beside : kTextureFolders)
        if (auto found = find_below(folder, std::string(beside) + "/" + last)) return found;
    return std::nullopt;
}

}  // namespace dgm::formats
