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

#include "pipeline/batch_plan.h"
#include "pipeline/batch_runner.h"
#include "report/index_page.h"

namespace dgm::report {

struct HtmlReport {
    std::string index;                           ///< the text of the index, for the caller to put in place
    std::size_t made = 0, kept = 0, failed = 0;  ///< pages
    bool interrupted = false;                    ///< by a signal: not all pages were made
};

/// Makes the pages that are not there yet and the index's text. A page stays if its asset was up to date and the page
/// was made from the same contents by the same version. A page that cannot be made fails nothing: the index says why.
/// Nothing is rendered after a batch that was interrupted. `on_page` is told how many of how many pages are done.
/// @throws model::Error kWriteFailed if the folder for the pages cannot be made
[[nodiscard]] HtmlReport html_report(const std::filesystem::path& index_path, const bake::BatchPlan& plan,
                                     const bake::BatchOptions& batch, const std::vector<bake::AssetResult>& results,
                                     const std::function<void(std::size_t done, std::size_t all)>& on_page);

/// "organs/liver.obj" -> "organs_liver.obj-3f2a9c01": a file name without surprises, another one for each name. Names
/// that are safe already stay.
[[nodiscard]] std::string page_name(std::string_view asset_name);

/// What the head of a page says about it; all empty if it is no page of ours.
struct PageHead {
    std::string key, thumbnail, error_thumbnail;
};
[[nodiscard]] PageHead read_page_head(const std::filesystem::path& page);

}  // namespace dgm::report
