// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/report_text.h
// Text for people: results, failures as one sentence each, the sum of a batch. And the same as JSON for programs.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "batch/batch_plan.h"
#include "batch/batch_runner.h"
#include "batch/left_over.h"
#include "model/printable.h"

namespace dgm::bake {

using model::printable;

/// "1.2 MB": powers of 1000.
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);

/// "stomach.dgm: good, max 0.05 % (0.1 units), rms 0.0086 % (0.017 units), stretch 257x257, 1.2 MB, 3.4 s", and what is
/// wrong with it. Errors are in % of the source's diagonal and in source units. No newline.
[[nodiscard]] std::string result_line(const AssetResult& result);

/// "stomach.dgm: up to date, good, max 0.05 % (0.1 units), rms 0.0086 % (0.017 units), 1.2 MB". No newline.
[[nodiscard]] std::string up_to_date_line(const AssetResult& result);

/// "left out: 2 .max files: there is no importer for it: ..."; one line a kind, or one a file if `each`.
[[nodiscard]] std::vector<std::string> left_out_lines(const std::vector<LeftOutFile>& files, bool each);

/// "left over: out/y.dgm: its mesh y.3ds is gone", "removed: ...", and how to remove those that stay.
[[nodiscard]] std::vector<std::string> left_over_lines(const std::vector<LeftOver>& files);

/// The request, the result on which grid, and what the next grid would have given, in one line.
[[nodiscard]] std::string search_story(const GridSearch& search, double diagonal);

/// dB, repairs, warnings, charts and the candidates of `auto`, one fact a line, indented; for -v.
[[nodiscard]] std::vector<std::string> detail_lines(const BakeReport& report);

/// "dgm-bake: FILE: stage: DGM3002: message", what the worker said last if it crashed, and what to do next.
[[nodiscard]] std::string failure_story(std::string_view subject, const model::Error& error,
                                        std::string_view worker_output = {});

/// "12 assets: 10 baked, 1 refused, 1 failed"; outcomes that did not occur are left out.
[[nodiscard]] std::string summary_line(const std::vector<AssetResult>& results);

/// The whole batch: sums, exit code, and for each asset its source, settings, outcome, files, times, report or error
/// (docs/schemas/report.schema.json). Indented JSON with sorted keys.
[[nodiscard]] std::string batch_report_json(const BatchPlan& plan, const BatchOptions& batch,
                                            const std::vector<AssetResult>& results, std::string_view generator);

}  // namespace dgm::bake
