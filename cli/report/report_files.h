// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/report_files.h
// The HTML report of a batch: an index, and beside it assets/NAME.html for each asset.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "report/index_page.h"
#include "report/page_runner.h"

namespace dgm::report {

struct HtmlReport {
    std::string index;                           ///< the text of the index, for the caller to put in place
    std::size_t made = 0, kept = 0, failed = 0;  ///< pages
    bool interrupted = false;                    ///< by a signal: not all pages were made
};

/// A report in words of its own (docs/schemas/report.schema.json) and what became of it.
struct ReportToShow {
    nlohmann::json report;
    /// Put together from several: pages that show the same contents stay, whatever the run they were made in. Else a
    /// newly baked asset gets a new page, for its times.
    bool merged = false;
    std::vector<std::filesystem::path> asset_roots = {};  ///< as BakeOptions has them
};

/// Makes the pages that are not there yet and the index's text. Meshes and maps are looked for where the report says,
/// from the current folder. A page stays if its asset was up to date and the page was made from the same contents by
/// the same version. A page that cannot be made fails nothing: the index says why. Nothing is rendered after a batch
/// that was interrupted. `on_page` is told how many of how many pages are done.
/// @throws model::Error kWriteFailed if the folder for the pages cannot be made, kReportUnreadable if a merged one
///         is no such report, kInternal if another is none
[[nodiscard]] HtmlReport html_report(const std::filesystem::path& index_path, const ReportToShow& shown,
                                     const PageLimits& limits,
                                     const std::function<void(std::size_t done, std::size_t all)>& on_page);

/// The report that an index carries with it, as JSON; empty if `html` is no index of ours.
[[nodiscard]] std::string report_in_index(std::string_view html);

/// "organs/liver.obj" -> "organs_liver.obj-3f2a9c01": a file name without surprises, another one for each name. Names
/// that are safe already stay.
[[nodiscard]] std::string page_name(std::string_view asset_name);

/// Data in the head of a page; all empty if it is no page of ours.
struct PageHead {
    std::string key, thumbnail, error_thumbnail;
};
[[nodiscard]] PageHead read_page_head(const std::filesystem::path& page);

}  // namespace dgm::report
