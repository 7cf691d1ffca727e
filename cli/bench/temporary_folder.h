// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/temporary_folder.h
#pragma once
#include <filesystem>

namespace dgm::bench {

/// A new empty folder, removed with all that is in it.
class TemporaryFolder {
 public:
    /// @throws model::Error kWriteFailed
    TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

}  // namespace dgm::bench
