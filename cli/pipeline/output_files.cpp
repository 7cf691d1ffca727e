// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/output_files.cpp
#include "pipeline/output_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "dgm/dgm_reader.h"
#include "dgm/dgm_writer.h"
#include "exr/exr_reader.h"
#include "exr/exr_writer.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

formats::ExrLayout file_layout(ExrLayout layout) {
    return layout == ExrLayout::kMultipart ? formats::ExrLayout::kMultipart : formats::ExrLayout::kAuto;
}

}  // namespace

void write_verified(const fs::path& path, const model::MapSet& maps, OutputFormat format, ExrLayout exr_layout) {
    if (format == OutputFormat::kDgm)
        formats::write_dgm(maps, path);
    else
        formats::write_exr(maps, path, {file_layout(exr_layout)});
    const model::MapSet back = format == OutputFormat::kDgm ? formats::read_dgm(path) : formats::read_exr(path);
    if (!(back == maps))
        throw model::Error(codes::kInternal, "the written file reads back differently from what was baked",
                           format == OutputFormat::kDgm ? "dgm" : "exr");
}

fs::path temporary_for(const fs::path& final_path) {
    fs::path name = ".";
    name += final_path.filename();
    name += fmt::format(".{}.tmp", getpid());
    return final_path.parent_path() / name;
}

OutputFolders::~OutputFolders() {
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder)
        ::rmdir(folder->c_str());  // refuses where something was baked into it
}

void OutputFolders::make(const fs::path& folder) {
    std::error_code error;
    if (fs::is_directory(folder, error)) return;
    if (fs::exists(fs::status(folder, error)))
        throw model::Error(codes::kWriteFailed, "the output folder's name is taken by a file", folder.string());
    if (::mkdir(folder.c_str(), 0777) != 0)
        throw model::Error(codes::kWriteFailed,
                           std::string("the output folder cannot be made: ") + std::strerror(errno), folder.string());
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

void check_writable(const fs::path& final_path) {
    std::error_code error;
    if (fs::is_directory(final_path, error))
        throw model::Error(codes::kWriteFailed, "the output's name is taken by a folder", final_path.string());
    const fs::path probe = temporary_for(final_path);
    const int fd = ::open(probe.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0)
        throw model::Error(codes::kWriteFailed,
                           std::string("no file can be created in the output folder: ") + std::strerror(errno),
                           final_path.string());
    ::close(fd);
    ::unlink(probe.c_str());
}

}  // namespace dgm::bake
