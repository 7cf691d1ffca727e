// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/output_files.cpp
#include "worker/output_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "dgm/dgm_reader.h"
#include "dgm/dgm_writer.h"
#include "exr/exr_files.h"
#include "exr/exr_reader.h"
#include "exr/exr_writer.h"
#include "files/atomic_file.h"
#include "files/staging_folder.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

constexpr std::uint64_t kLeastBytes = 65536;
constexpr const char* kOtherName = "choose another name with -o, or move what has it";

formats::ExrLayout file_layout(ExrLayout layout) {
    return layout == ExrLayout::kMultipart ? formats::ExrLayout::kMultipart : formats::ExrLayout::kAuto;
}

void write_and_compare(const fs::path& path, const model::MapSet& maps, OutputFormat format, ExrLayout exr_layout) {
    if (format == OutputFormat::kDgm)
        formats::write_dgm(maps, path);
    else
        formats::write_exr(maps, path, {file_layout(exr_layout)});
    const model::MapSet back = format == OutputFormat::kDgm ? formats::read_dgm(path) : formats::read_exr(path);
    if (!(back == maps))
        throw model::Error(codes::kInternal, "the written file reads back differently from what was baked",
                           format == OutputFormat::kDgm ? "dgm" : "exr");
}

/// Why `bytes` cannot be written to `path`, as the system says when asked once more; 0 if they can. The libraries that
/// write do not tell, and may have given back already what was too little.
int trouble_at(const fs::path& path, std::uint64_t bytes) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0) return errno;
    int error = ::posix_fallocate(fd, 0, static_cast<off_t>(bytes));
    if (error == 0 && ::fsync(fd) != 0) error = errno;
    ::close(fd);
    return error;
}

/// About what the file of `maps` takes.
std::uint64_t bytes_of(const model::MapSet& maps) {
    std::uint64_t out = kLeastBytes;
    for (const model::Chart& chart : maps.charts)
        for (const model::Layer& layer : chart.layers) out += layer.bytes.size();
    return out;
}

}  // namespace

model::Error explained(const model::Error& error, const fs::path& temporary, std::uint64_t bytes) {
    const int trouble = trouble_at(temporary, std::max(bytes, kLeastBytes));
    const model::Code& why = formats::write_failure(trouble);
    if (trouble == 0 || why.number == codes::kWriteFailed.number) return error;
    return model::Error(why, std::strerror(trouble) + std::string("; ") + error.what(), error.place());
}

void write_verified(const fs::path& path, const model::MapSet& maps, OutputFormat format, ExrLayout exr_layout) {
    try {
        write_and_compare(path, maps, format, exr_layout);
    } catch (const model::Error& error) { throw explained(error, path, bytes_of(maps)); }
}

void publish_output(const fs::path& temporary, const fs::path& final_path) {
    if (final_path.extension() != ".exr") return formats::publish_file(temporary, final_path);
    const std::vector<std::string> names = formats::read_exr_head(temporary).beside;
    const std::vector<std::string> old_names = formats::exr_side_names(final_path);
    for (const std::string& name : names) formats::check_exr_side_place(formats::exr_side_path(final_path, name));
    for (const std::string& name : names)
        formats::publish_file(formats::exr_side_path(temporary, name), formats::exr_side_path(final_path, name));
    formats::publish_file(temporary, final_path);
    formats::remove_old_exr_sides(final_path, old_names);
}

std::uintmax_t output_bytes(const fs::path& path, bool is_exr, std::error_code& error) {
    std::uintmax_t bytes = fs::file_size(path, error);
    if (error || !is_exr) return bytes;
    for (const std::string& name : formats::exr_side_names(path)) {
        const std::uintmax_t more = fs::file_size(formats::exr_side_path(path, name), error);
        if (error) return more;
        bytes += more;
    }
    return bytes;
}

OutputFolders::~OutputFolders() {
    if (shared_) return;
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder)
        ::rmdir(folder->c_str());  // refuses where something was baked into it
}

void OutputFolders::make(const fs::path& folder) {
    std::error_code error;
    if (fs::is_directory(folder, error)) return;
    if (fs::exists(fs::status(folder, error)))
        throw model::Error(codes::kWriteFailed, "the output folder's name is taken by a file", folder.string())
            .with_hint(kOtherName);
    const fs::path parent = fs::absolute(folder).lexically_normal().parent_path();
    if (!parent.empty() && !fs::exists(fs::status(parent, error))) make(parent);
    if (::mkdir(folder.c_str(), 0777) != 0) {
        const int reason = errno;
        if (reason == EEXIST && fs::is_directory(folder, error)) return;  // another program was as quick
        throw model::unwritable_folder(folder, std::strerror(reason), formats::write_failure(reason));
    }
    made_.push_back(fs::absolute(folder));
}

void OutputFolders::make_below(const fs::path& root, const fs::path& file) {
    fs::path folder = root;
    for (const fs::path& part : file.parent_path().lexically_relative(root)) {
        if (part == ".") continue;
        folder /= part;
        make(folder);
    }
}

void check_place(const fs::path& final_path) {
    std::error_code error;
    const auto refuse = [&](const char* why) {
        throw model::Error(codes::kWriteFailed, why, final_path.string()).with_hint(kOtherName);
    };
    const long longest =
        ::pathconf(final_path.has_parent_path() ? final_path.parent_path().c_str() : ".", _PC_NAME_MAX);
    if (longest > 0 && final_path.filename().native().size() > static_cast<std::size_t>(longest))
        refuse("the output's name is longer than the file system can have");
    switch (fs::symlink_status(final_path, error).type()) {
        case fs::file_type::not_found:
        case fs::file_type::none:
        case fs::file_type::regular:
            return;
        case fs::file_type::symlink:  // replaced itself, unless it leads to a folder
            if (!fs::is_directory(final_path, error)) return;
            [[fallthrough]];
        case fs::file_type::directory:
            refuse("the output's name is taken by a folder");
            break;
        default:
            refuse("the output's name is taken by a device, a pipe or a socket");
    }
}

}  // namespace dgm::bake
