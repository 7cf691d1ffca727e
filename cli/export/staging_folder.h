// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/staging_folder.h
// A folder beside the output in which files are completed before they are moved into place together.
#pragma once
#include <filesystem>
#include <vector>

#include "files/staging_folder.h"

namespace dgm::exporter {

class StagingFolder {
 public:
    /// A new empty folder in the folder of `output`. @throws model::Error as formats::StagingFolder; kWriteFailed if
    /// `output` is a folder, a device or a pipe
    explicit StagingFolder(const std::filesystem::path& output);

    /// Where to write a file that is added later.
    [[nodiscard]] std::filesystem::path where(const std::filesystem::path& name) const { return folder_.where(name); }
    /// Where to write the file that will be called `name`. The last one added is published last.
    [[nodiscard]] std::filesystem::path add(const std::filesystem::path& name);
    /// Moves all added files into the output's folder, in order. @throws model::Error kWriteFailed
    void publish();

 private:
    std::filesystem::path final_folder_;
    formats::StagingFolder folder_;
    std::vector<std::filesystem::path> names_;
};

}  // namespace dgm::exporter
