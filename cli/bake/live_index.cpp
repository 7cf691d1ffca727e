// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/live_index.cpp
#include "bake/live_index.h"

#include <string>

#include "baking/up_to_date.h"
#include "batch/batch_report_json.h"
#include "files/output_file.h"
#include "report/index_page.h"

namespace dgm::bake {
namespace {

constexpr auto kPause = std::chrono::seconds(1);
constexpr int kShare = 20;  ///< of the time is the most that indices may take: one part in so many

}  // namespace

void LiveIndex::add(std::size_t asset, const AssetResult& result) {
    if (index_.empty()) return;
    assets_[asset] = asset_json(plan_.assets[asset], result);
    const auto begin = Clock::now();
    if (begin < next_) return;
    try {
        write();
    } catch (const model::Error&) { index_.clear(); }
    const auto end = Clock::now();
    next_ = end + std::max<Clock::duration>(kPause, kShare * (end - begin));
}

void LiveIndex::write() {
    nlohmann::json report = report_frame(generator(), model::ExitCode::kOk);
    std::map<std::string, std::uint64_t> counts;
    report["assets"] = nlohmann::json::array();
    for (const auto& [k, asset] : assets_) {
        ++counts[asset.at("outcome").get<std::string>()];
        report["assets"].push_back(asset);
    }
    for (const Outcome outcome : kOutcomes) set_count(report, outcome, counts[std::string(name_of(outcome))]);
    report["summary"]["assets"] = assets_.size();
    report["running"] = {{"done", assets_.size()}, {"of", plan_.assets.size()}};
    formats::write_output(index_, report::index_page(report, {}));
}

}  // namespace dgm::bake
