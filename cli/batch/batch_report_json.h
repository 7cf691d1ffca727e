// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/batch_report_json.h
// The frame of a batch report, shared by the one who writes it and the one who merges several
// (docs/schemas/report.schema.json).
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "batch/batch_runner.h"
#include "batch/left_over.h"
#include "model/error.h"

namespace dgm::bake {

/// Raised when a key changes its meaning or goes; new keys may come at any time.
inline constexpr int kReportVersion = 2;

/// Generator, version and exit code.
[[nodiscard]] nlohmann::json report_frame(std::string_view generator, model::ExitCode exit);
/// One entry of "assets".
[[nodiscard]] nlohmann::json asset_json(const PlannedAsset& asset, const AssetResult& result);
/// Puts "left_out" and "left_over", where there is anything to tell.
void add_other_files(nlohmann::json& report, const std::vector<LeftOutFile>& left_out,
                     const std::vector<LeftOver>& left_over);
/// Puts summary.up_to_date and the like.
void set_count(nlohmann::json& report, Outcome outcome, std::uint64_t count);

}  // namespace dgm::bake
