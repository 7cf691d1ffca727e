// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/merge_reports.h
// One report from those of several runs: the shards of a batch, and its second tries.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/error.h"

namespace dgm::bake {

struct NamedReport {
    std::string name;       ///< for messages
    nlohmann::json report;  ///< any JSON (process/json_apart.h)
};

struct MergedReport {
    std::string text;      ///< a batch report like any other (docs/schemas/report.schema.json)
    model::ExitCode exit;  ///< the worst of what is in it
};

/// Every asset once, in the byte order of the sources' paths. Where several reports have the same source and outputs,
/// the best outcome stands: baked, up to date, refused, failed for good, failed for now, interrupted, not started; of
/// equals the one whose JSON comes first in byte order. So the order of the reports makes no difference, and a second
/// try replaces the first. Sums and exit code are those of the assets that stand; `run` is kept where all agree.
/// @throws model::Error kUsage without reports, kReportUnreadable naming what is not a report, or of another version
[[nodiscard]] MergedReport merge_reports(std::vector<NamedReport> reports);

}  // namespace dgm::bake
