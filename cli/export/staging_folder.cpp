// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/staging_folder.cpp
#include "export/staging_folder.h"

#include "files/atomic_file.h"
#include "files/output_file.h"
#include "model/file_errors.h"

namespace dgm::exporter {
namespace {

/// The folder of a file that may be put there.
std::filesystem::path folder_for(const std::filesystem::path& output) {
    if (formats::destination_of(output).is_through) throw model::unwritable_file(output, "it is a device or a pipe");
    return output.has_parent_path() ? output.parent_path() : std::filesystem::path(".");
}

}  // namespace

StagingFolder::StagingFolder(const std::filesystem::path& output)
    : final_folder_(folder_for(output)), folder_(output) {}

std::filesystem::path StagingFolder::add(const std::filesystem::path& name) {
    names_.push_back(name);
    return folder_.where(name);
}

void StagingFolder::publish() {
    for (const std::filesystem::path& name : names_) formats::publish_file(folder_.where(name), final_folder_ / name);
}

}  // namespace dgm::exporter
