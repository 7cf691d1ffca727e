// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/run.h
// Several files at once: sources, threads, policy.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "validate/policy.h"
#include "validate/validation.h"

namespace dgm::validate {

struct RunOptions {
    std::vector<std::filesystem::path> files;
    std::filesystem::path source;  ///< mesh, or a folder with each file's source_name in it; empty: none
    MeshReader read_mesh;          ///< of sources; none: formats::read_mesh
    std::optional<double> max_rms_percent, max_hausdorff_percent;
    SeverityRules severities;
    Baseline baseline;
    unsigned jobs = 1;  ///< files at a time, at least 1
};

/// Validates every file and hands each result to `done` in the order of the files, as soon as those before it are done.
/// A source that cannot be read is a finding of its own, under its path, before the others. The results do not depend
/// on `jobs`.
[[nodiscard]] std::vector<FileValidation> run_validation(const RunOptions& options,
                                                         const std::function<void(const FileValidation&)>& done);

/// The worst of all files.
[[nodiscard]] model::ExitCode worst_exit(const std::vector<FileValidation>& files);

}  // namespace dgm::validate
