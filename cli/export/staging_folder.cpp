// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/staging_folder.cpp
#include "export/staging_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "dgm/atomic_file.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::exporter {

StagingFolder::StagingFolder(const std::filesystem::path& output) : final_folder_(output.parent_path()) {
    if (final_folder_.empty()) final_folder_ = ".";
    std::string pattern = (final_folder_ / ".").string();
    pattern.append(output.filename().string()).append(".XXXXXX");
    if (::mkdtemp(pattern.data()) == nullptr) throw model::unwritable_file(output, std::strerror(errno));
    folder_ = pattern;
}

StagingFolder::~StagingFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

std::filesystem::path StagingFolder::add(const std::filesystem::path& name) {
    names_.push_back(name);
    return folder_ / name;
}

void StagingFolder::publish() {
    for (const std::filesystem::path& name : names_) formats::publish_file(folder_ / name, final_folder_ / name);
}

}  // namespace dgm::exporter
