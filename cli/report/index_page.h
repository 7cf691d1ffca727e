// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/index_page.h
// The one page to look at in the morning.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::report {

/// State of the page of an asset.
struct PageState {
    std::string link;                        ///< relative to the index; empty: there is no page
    std::string thumbnail, error_thumbnail;  ///< data URIs; may be empty
    std::string problem;                     ///< why there is no page, for people; empty if there is or need not be one
};

/// Around the report that the index carries with it.
inline constexpr std::string_view kReportStart = "<script type=\"application/json\" id=\"report\" class=\"run\">",
                                  kReportEnd = "</script>";

/// The index of a batch report (docs/schemas/report.schema.json): failures and refusals first, then all others, worst
/// rms in % of the diagonal first, then by name. `pages` goes with the report's assets. What differs from run to run
/// stands in elements of class "run" and in the script element "report", which holds the whole report. A report with
/// "running": {"done", "of"} is shown as one that is not yet whole, on a page that loads itself again.
/// @throws model::Error kInternal if `report` is not such a report
[[nodiscard]] std::string index_page(const nlohmann::json& report, const std::vector<PageState>& pages);

}  // namespace dgm::report
