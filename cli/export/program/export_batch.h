// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/program/export_batch.h
// Many maps in one run of dgm-export: which files they become, and what came of each.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "export/export_files.h"
#include "model/error.h"

namespace dgm::exporter {

struct ExportRequest {
    std::vector<std::string> inputs;   ///< files, folders and patterns, in the order given
    std::string output;                ///< -o; empty: the current folder
    std::vector<std::string> formats;  ///< of --format, as extensions with their dots; empty: what -o ends in
};

/// One map and the files that are made of it, or all maps of a page.
struct ExportJob {
    std::filesystem::path source;
    std::vector<std::filesystem::path> outputs;
    std::vector<std::filesystem::path> others{};  ///< further maps of the same page; of several one fails for all
    std::optional<model::Error> refusal;  ///< set if there is nothing to read: a missing file, a folder without maps
};

struct ExportPlan {
    std::filesystem::path folder;  ///< of the outputs
    bool make_folder = false;      ///< unless it is there; its parent must exist
    std::vector<ExportJob> jobs;
};

/// Names outputs as dgm-bake does (batch/batch_plan.h): folders are searched recursively, for .dgm and .exr; hidden
/// files and folders are skipped; a file met twice is exported once; inside a folder the order is that of the bytes of
/// the paths. `a/robe.dgm` becomes `robe.glb`; below an input folder the relative path is kept. Where robe.dgm and
/// robe.exr stand side by side, the latter becomes robe.exr.glb. Where two maps still would write the same file, each
/// goes below a folder named like the input folder (for a file: the folder it is in).
///
/// One page (-o NAME.html) holds all maps.
///
/// @throws model::Error kUsage: one output file of another kind for several maps, a folder and no format, an output
///         that is an input, two maps that still write one file
[[nodiscard]] ExportPlan plan_exports(const ExportRequest& request);

struct ExportListener {
    std::function<void(const std::filesystem::path& output)> on_written;
    std::function<void(const std::filesystem::path& source, const model::Error& error)> on_failure;
    std::function<void(const std::string& text)> on_warning;
};

struct ExportOutcome {
    std::size_t exported = 0;  ///< maps of which all files were written
    std::vector<std::pair<std::filesystem::path, model::Error>> failures;
    model::ExitCode exit = model::ExitCode::kOk;  ///< the worst
};

/// Exports each job; what goes wrong with one is told and never stops the others. Of an option that not all formats of
/// a job know, those that do not are written without it.
[[nodiscard]] ExportOutcome run_exports(const ExportPlan& plan, const ExportOptions& options,
                                        const ExportListener& listener);

/// A line for each failure, below a line with their number; empty if there is none.
[[nodiscard]] std::string failure_list(const ExportOutcome& outcome);

/// "12 maps: 10 exported, 2 failed". No newline.
[[nodiscard]] std::string summary_line(const ExportOutcome& outcome);

}  // namespace dgm::exporter
