// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/options.h
// The command line of dgm-bake.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batch/batch_plan.h"
#include "batch/batch_runner.h"

namespace dgm::bake {

enum class ProgressStyle { kAuto, kBar, kPlain, kNone };

struct CommandLine {
    PlanRequest plan;
    BakeOptions bake;
    BatchOptions batch;
    std::filesystem::path scene;  ///< a scene file instead of meshes; `bake` says nothing then
    std::optional<Shard> shard;
    std::filesystem::path report;                 ///< empty: none
    bool html_report = false;                     ///< the report is an index with pages beside it, not JSON
    std::filesystem::path depfile;                ///< -MF; empty: none
    std::vector<std::filesystem::path> to_merge;  ///< --merge-reports: the reports; then nothing is baked
    ProgressStyle progress = ProgressStyle::kAuto;
    bool dry_run = false, verbose = false, quiet = false;
    bool prune = false;  ///< remove what is left over in the output folder
};

/// Text to print on stdout instead of doing anything: --help, --version.
using Answer = std::string;

/// @throws model::Error kUsage with what is wrong and what would be right; kUnsupported for what this version lacks
[[nodiscard]] std::variant<CommandLine, Answer> parse_command_line(int argc, const char* const* argv);

}  // namespace dgm::bake
