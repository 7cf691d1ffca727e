// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/run.h
// Several files at once: sources, threads, policy.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "validate/policy.h"
#include "validate/validation.h"

namespace dgm::validate {

/// What one file may take.
struct FileLimits {
    double seconds = 600;                                 ///< wall clock
    std::uint64_t memory_bytes = std::uint64_t{8} << 30;  ///< address space beside the program itself; 0: no limit
    std::uint32_t threads = 1;                            ///< of its checks
};

struct RunOptions {
    std::vector<std::filesystem::path> files;
    std::filesystem::path source;  ///< mesh, or a folder with each file's source_name in it; empty: none
    MeshReader read_mesh;          ///< of sources; none: formats::read_mesh
    std::optional<double> max_rms_percent, max_hausdorff_percent;
    SeverityRules severities;
    Baseline baseline;
    unsigned jobs = 1;  ///< files at a time, at least 1
    /// Each file is judged in a process that may die (run_apart.h): then the program must have one thread. None: in
    /// threads of this process.
    std::optional<FileLimits> limits;
};

/// Validates every file and hands each result to `done` in the order of the files, as soon as those before it are done.
/// A source that cannot be read is a finding of its own, under its path, before the others. The results do not depend
/// on `jobs`.
[[nodiscard]] std::vector<FileValidation> run_validation(const RunOptions& options,
                                                         const std::function<void(const FileValidation&)>& done);

/// The worst of all files.
[[nodiscard]] model::ExitCode worst_exit(const std::vector<FileValidation>& files);

}  // namespace dgm::validate
