// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/raw_options.h
// Names and purposes of the options of dgm-bake; options.cpp defines their meaning.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tool/help.h"

namespace dgm::bake {

/// Values from CLI11: plain text, checked afterwards with messages of ours.
struct Raw {
    std::vector<std::string> inputs, asset_roots;
    std::string output, size, max_error, max_error_kind, budget,
        method = "auto", domain = "auto", fit = "l2", precision = "f32", layers, texture, texture_size, bump_size, unit,
        material, ablate, format, exr_layout = "auto", report, report_format, memory_limit = "8GiB", progress = "auto",
        shard, depfile;
    int jobs = 0;
    double time_limit = 600;
    bool merge_reports = false, force = false, prune = false, keep_going = false, stop_on_error = false,
         dry_run = false, verbose = false, quiet = false;
};

/// Declares every option, in groups. `raw` must outlive `app`.
void describe(CLI::App& app, Raw& raw);

/// Text of the man page beside the options.
[[nodiscard]] tool::Manual manual();

}  // namespace dgm::bake
