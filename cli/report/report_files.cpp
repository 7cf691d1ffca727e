// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/report_files.cpp
#include "report/report_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <span>
#include <thread>

#include "baking/up_to_date.h"
#include "batch/batch_runner.h"
#include "dgm/hash.h"
#include "files/staging_folder.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "report/html.h"
#include "report/page_runner.h"

namespace dgm::report {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFolder = "assets";
constexpr std::size_t kHeadBytes = 64'000, kMostThumbnailBytes = 20'000;
/// Of a mesh and of a map; larger ones are never baked, but a merged report may name anything.
constexpr std::uint64_t kMostBytes = std::uint64_t{64} << 30;

std::string hex_of(std::string_view text) {
    return formats::to_hex(formats::hash_bytes(std::as_bytes(std::span(text))));
}

/// The quoted content of the meta element of that name.
std::string meta(std::string_view head, std::string_view name) {
    const std::string start = fmt::format("<meta name=\"{}\" content=\"", name);
    const std::size_t at = head.find(start);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = head.substr(at + start.size());
    const std::size_t end = rest.find('"');
    return end == std::string_view::npos ? std::string() : std::string(rest.substr(0, end));
}

std::string thumbnail_in(std::string_view head, std::string_view name) {
    const std::string uri = meta(head, name);
    const bool good = uri.size() <= kMostThumbnailBytes && uri.starts_with("data:image/jpeg;base64,");
    return good ? uri : std::string();
}

/// Content of a page: the page stays while this does.
std::string page_key(const AssetPage& page) {
    json asset = page.asset;
    for (const char* of_run : {"seconds", "outcome"}) asset.erase(of_run);
    for (const char* of_run : {"times", "cpu_seconds", "peak_memory_bytes"}) asset["report"].erase(of_run);
    for (json& chart : asset["report"]["charts"])
        for (json& candidate : chart["candidates"]) candidate.erase("cpu_seconds");
    const auto search = asset["report"].find("search");
    if (search != asset["report"].end())
        for (const char* list : {"shapes", "trials"})
            for (json& trial : (*search)[list]) trial.erase("cpu_seconds");
    if (search != asset["report"].end() && search->contains("next")) (*search)["next"].erase("cpu_seconds");
    return hex_of(fmt::format("{} {} {} {} {} {} {}", kPageVersion, bake::generator(),
                              formats::to_hex(formats::hash_file(page.source, kMostBytes)),
                              formats::to_hex(formats::hash_file(page.map, kMostBytes)), page.command, page.index_link,
                              asset.dump(-1, ' ', false, json::error_handler_t::replace)));
}

bool is_outcome(const json& asset, bake::Outcome outcome) {
    return asset.at("outcome").get_ref<const std::string&>() == bake::name_of(outcome);
}

bool has_map(const json& asset) {
    return (is_outcome(asset, bake::Outcome::kBaked) || is_outcome(asset, bake::Outcome::kUpToDate)) &&
           !asset.at("files").empty() && asset.contains("report");
}

class Report {
 public:
    Report(const fs::path& index_path, const ReportToShow& shown, const PageLimits& limits)
        : folder_(index_path.parent_path() / kFolder),
          index_link_("../" + link_segment(index_path.filename().string())),
          report_(shown.report),
          assets_(report_.at("assets")),
          merged_(shown.merged),
          asset_roots_(shown.asset_roots),
          limits_(limits),
          states_(assets_.size()),
          keys_(assets_.size()) {}

    HtmlReport write(const std::function<void(std::size_t, std::size_t)>& on_page) {
        const bool interrupted = !merged_ && report_.at("exit_code") == static_cast<int>(model::ExitCode::kInterrupted);
        name_pages();
        for (std::size_t k = 0; k < assets_.size(); ++k)
            if (has_map(assets_[k])) prepare(k, !interrupted);
        if (!tasks_.empty()) {
            std::error_code error;
            fs::create_directories(folder_, error);
            if (error) throw model::unwritable_folder(folder_, error.message());
            const formats::StagingFolder staging(tasks_.front().final_path);
            for (PageTask& task : tasks_) task.job.output = staging.where(task.final_path.filename());
            run(on_page);
        }
        for (std::size_t k = 0; k < assets_.size(); ++k) take_head(k);
        out_.interrupted = out_.interrupted || interrupted;
        out_.index = index_page(report_, states_);
        return std::move(out_);
    }

 private:
    void name_pages() {
        std::set<std::string> taken;
        for (const json& asset : assets_) {
            const std::string name = page_name(asset.at("name").get<std::string>());
            std::string unique = name;
            for (int k = 2; !taken.insert(unique).second; ++k) unique = fmt::format("{}-{}", name, k);
            pages_.push_back(folder_ / (unique + ".html"));
        }
    }

    void prepare(std::size_t k, bool may_render) {
        const json& asset = assets_[k];
        PageTask task;
        task.final_path = pages_[k];
        task.job.page = {asset,
                         asset.at("source").get<std::string>(),
                         asset.at("files").at(0).at("path").get<std::string>(),
                         asset.value("command", std::string()),
                         {},
                         index_link_,
                         asset_roots_};
        try {
            task.job.page.key = page_key(task.job.page);
        } catch (const model::Error& error) {
            states_[k].problem = error.what();
            ++out_.failed;
            return;
        }
        keys_[k] = task.job.page.key;
        const bool is_there = read_page_head(pages_[k]).key == keys_[k];
        if (is_there && (merged_ || is_outcome(asset, bake::Outcome::kUpToDate))) {
            ++out_.kept;
            return;
        }
        if (!may_render) {
            if (!is_there) states_[k].problem = "the batch was interrupted";
            return;
        }
        task.job.memory_bytes = limits_.memory_bytes;
        asset_of_.push_back(k);
        tasks_.push_back(std::move(task));
    }

    void run(const std::function<void(std::size_t, std::size_t)>& on_page) {
        const auto at_once =
            static_cast<unsigned>(std::clamp<std::size_t>(tasks_.size(), 1, std::max(1U, limits_.jobs)));
        const unsigned threads = std::max(1U, std::thread::hardware_concurrency() / at_once);
        for (PageTask& task : tasks_) task.job.threads = threads;
        std::size_t done = 0;
        const std::vector<PageOutcome> outcomes =
            run_pages(tasks_, {at_once, limits_.time_limit_seconds, limits_.memory_bytes}, [&](std::size_t) {
                if (on_page) on_page(++done, tasks_.size());
            });
        for (std::size_t t = 0; t < outcomes.size(); ++t) {
            PageState& state = states_[asset_of_[t]];
            if (outcomes[t].interrupted) {
                state.problem = "the report was interrupted";
                out_.interrupted = true;
            } else if (outcomes[t].error) {
                state.problem = outcomes[t].error->code().id() + ": " + outcomes[t].error->what();
                ++out_.failed;
            } else {
                ++out_.made;
            }
        }
    }

    /// Links to the page if it shows what was baked; an older one must not pass for it.
    void take_head(std::size_t k) {
        const PageHead head = read_page_head(pages_[k]);
        if (keys_[k].empty() || head.key != keys_[k]) return;
        states_[k].link = std::string(kFolder) + "/" + link_segment(pages_[k].filename().string());
        states_[k].thumbnail = head.thumbnail;
        states_[k].error_thumbnail = head.error_thumbnail;
    }

    fs::path folder_;
    std::string index_link_;
    const json& report_;
    const json& assets_;
    bool merged_;
    std::vector<fs::path> asset_roots_;
    PageLimits limits_;
    std::vector<PageState> states_;
    std::vector<std::string> keys_;
    std::vector<fs::path> pages_;
    std::vector<PageTask> tasks_;
    std::vector<std::size_t> asset_of_;
    HtmlReport out_;
};
}  // namespace

std::string page_name(std::string_view asset_name) {
    std::string out;
    for (const char c : asset_name) {
        const bool safe = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
                          c == '-' || c == '_';
        out += safe ? c : '_';
    }
    constexpr std::size_t kMost = 120;
    if (out != asset_name || out.size() > kMost || out.starts_with('.'))
        out = (out.starts_with('.') ? "_" : "") + out.substr(0, kMost) + "-" + hex_of(asset_name).substr(0, 8);
    return out;
}

PageHead read_page_head(const fs::path& page) {
    std::string head(kHeadBytes, '\0');
    std::ifstream file(page, std::ios::binary);
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
    return {meta(head, "dgm-page"), thumbnail_in(head, "dgm-thumbnail"), thumbnail_in(head, "dgm-error-thumbnail")};
}

HtmlReport html_report(const fs::path& index_path, const ReportToShow& shown, const PageLimits& limits,
                       const std::function<void(std::size_t, std::size_t)>& on_page) {
    try {
        return Report(index_path, shown, limits).write(on_page);
    } catch (const json::exception& error) {
        // A merged report comes from files, which may be damaged; any other is our own.
        throw model::Error(shown.merged ? model::codes::kReportUnreadable : model::codes::kInternal,
                           std::string("the report cannot be shown: ") + error.what());
    } catch (const model::Error& error) {
        if (!shown.merged || error.code().number != model::codes::kInternal.number) throw;
        throw model::Error(model::codes::kReportUnreadable, error.what());
    }
}

std::string report_in_index(std::string_view html) {
    const std::size_t start = html.find(kReportStart);
    if (start == std::string_view::npos) return {};
    const std::string_view rest = html.substr(start + kReportStart.size());
    const std::size_t end = rest.find(kReportEnd);
    return end == std::string_view::npos ? std::string() : std::string(rest.substr(0, end));
}

}  // namespace dgm::report
