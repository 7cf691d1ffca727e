// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/index_page.cpp
#include "report/index_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "baking/bake_report.h"
#include "batch/report_text.h"
#include "model/codes.h"
#include "report/html.h"
#include "report/page_parts.h"
#include "report/verdict.h"

namespace dgm::report {
namespace {
using nlohmann::json;

struct Row {
    std::string name, grids;
    PageState page;
    bake::BakeReport report;
    Verdict verdict;
    double rms = 0, worst = 0;  // % of the diagonal
    std::uint64_t bytes = 0;
    double seconds = 0;
    bool up_to_date = false;
};

std::string text_of(const json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// Where no number is known, the asset stands with the worst.
double percent(double length, double diagonal) {
    const double value = 100 * length / diagonal;
    return std::isfinite(value) ? value : 1e9;
}

std::string grids_text(const bake::BakeReport& report) {
    if (report.charts.empty()) return {};
    const bake::ChartReport& largest = *std::max_element(
        report.charts.begin(), report.charts.end(), [](const bake::ChartReport& a, const bake::ChartReport& b) {
            return std::uint64_t{a.rows} * a.cols < std::uint64_t{b.rows} * b.cols;
        });
    std::string out = fmt::format("{}x{} {}", largest.rows, largest.cols, largest.method);
    if (report.charts.size() > 1) out += fmt::format(" and {} more", report.charts.size() - 1);
    return out;
}

Row row_of(const json& asset, const PageState& page) {
    Row row;
    row.name = text_of(asset, "name");
    row.page = page;
    row.report = bake::report_from_json(asset.at("report").dump());
    row.verdict = verdict_of(row.report);
    row.grids = grids_text(row.report);
    row.rms = percent(row.report.error.rms, row.report.error.diagonal);
    row.worst = percent(row.report.error.hausdorff, row.report.error.diagonal);
    for (const json& file : asset.at("files")) row.bytes += file.at("bytes").get<std::uint64_t>();
    row.seconds = asset.at("seconds").get<double>();
    row.up_to_date = text_of(asset, "outcome") == "up to date";
    return row;
}

std::string image(const std::string& uri, std::string_view what) {
    if (uri.empty()) return "<span></span>";
    return fmt::format("<img src=\"{}\" alt=\"{}\" title=\"{}\">", escaped(uri), what, what);
}

std::string row_html(const Row& row) {
    const bake::SurfaceError& e = row.report.error;
    std::string note;
    if (row.verdict.grade != Grade::kGood) note = row.verdict.headline.substr(0, row.verdict.headline.find(':'));
    for (const std::string& text : row.verdict.notes) note += (note.empty() ? "" : "; ") + text;
    const std::string name = escaped(row.name);
    const std::string title =
        row.page.link.empty() ? name : fmt::format("<a href=\"{}\">{}</a>", escaped(row.page.link), name);
    std::string out = fmt::format("<tr class=\"{}\" data-text=\"{}\"><td><div class=\"thumbs\">{}{}</div></td>",
                                  class_of(row.verdict.grade), name, image(row.page.thumbnail, "reconstruction"),
                                  image(row.page.error_thumbnail, "error"));
    out += fmt::format("<td class=\"name\" data-v=\"{}\">{}<div class=\"note\">{}</div>", name, title, escaped(note));
    if (!row.page.problem.empty()) out += "<div class=\"note\">no page: " + escaped(row.page.problem) + "</div>";
    out += fmt::format("</td><td class=\"n\" data-v=\"{}\">{:.3g} %<div class=\"sub\">{}</div></td>", row.rms, row.rms,
                       number_text(e.rms));
    out += fmt::format("<td class=\"n\" data-v=\"{}\">{:.3g} %<div class=\"sub\">{}</div></td>", row.worst, row.worst,
                       number_text(e.hausdorff));
    out += fmt::format("<td class=\"n wide-only\" data-v=\"{}\">{}</td>", escaped(row.grids), escaped(row.grids));
    out += fmt::format("<td class=\"n\" data-v=\"{}\">{}</td>", row.bytes, bake::bytes_text(row.bytes));
    out += fmt::format("<td class=\"n run\" data-v=\"{}\">{}</td></tr>\n", row.seconds,
                       row.up_to_date ? std::string("up to date") : fmt::format("{:.1f} s", row.seconds));
    return out;
}

std::string failure_html(const json& asset) {
    const auto error = asset.find("error");
    const std::string name = escaped(text_of(asset, "name"));
    if (error == asset.end() || !error->is_object())
        return fmt::format("<div class=\"failure\"><h3>{}: {}</h3></div>\n", name, escaped(text_of(asset, "outcome")));
    std::string out =
        fmt::format("<div class=\"failure\"><h3>{}: {}</h3>\n<p><b>{}</b> {}{}</p>\n", name,
                    escaped(text_of(asset, "outcome")), escaped(text_of(*error, "code")),
                    text_of(*error, "stage").empty() ? std::string() : escaped(text_of(*error, "stage")) + ": ",
                    escaped(text_of(*error, "message")));
    if (const std::string place = text_of(*error, "place"); !place.empty() && place != text_of(asset, "source"))
        out += "<p>at: " + escaped(place) + "</p>\n";
    if (const std::string said = text_of(*error, "worker_output"); !said.empty())
        out += "<p class=\"small\">it said: " + escaped(said.substr(0, 2000)) + "</p>\n";
    return out + "<p><b>Next:</b> " + escaped(text_of(*error, "hint")) + "</p></div>\n";
}

std::string setting_text(const json& value) {
    if (value.is_null()) return "as the mesh has it";
    if (value.is_string()) return value.get<std::string>();
    if (value.is_object() && value.contains("rows"))
        return value["rows"].dump() + "x" + value.value("cols", json()).dump();
    if (!value.is_array()) return value.dump();
    std::string out;
    for (const json& item : value) out += (out.empty() ? "" : ", ") + setting_text(item);
    return out;
}

/// Settings that all assets share; nothing for a batch whose assets differ.
std::string settings_html(const json& report) {
    const json& assets = report.at("assets");
    if (assets.empty()) return {};
    const json first = assets[0].value("settings", json::object());
    for (const json& asset : assets)
        if (asset.value("settings", json::object()) != first)
            return "<section><h2>Settings</h2><p>They differ from asset to asset; each page has its "
                   "own.</p></section>\n";
    std::string out = "<section><h2>Settings</h2>\n<table class=\"plain\"><tbody>\n";
    for (const auto& [key, value] : first.items())
        out += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(key), escaped(setting_text(value)));
    return out + "</tbody></table></section>\n";
}

constexpr const char* kReload = "<meta http-equiv=\"refresh\" content=\"5\">\n";

/// Files that are no assets of the batch: meshes that were not taken, and maps without a mesh.
std::string other_files_html(const json& report) {
    std::string out;
    const auto list = [&](const char* key, const char* title, const auto& text) {
        if (!report.contains(key)) return;
        out += fmt::format("<section><h2>{}</h2>\n<ul>\n", title);
        for (const json& file : report.at(key))
            out += fmt::format("<li>{}: {}</li>\n", escaped(text_of(file, "path")), escaped(text(file)));
        out += "</ul></section>\n";
    };
    list("left_out", "Left out", [](const json& file) { return text_of(file, "why"); });
    list("left_over", "Left over", [](const json& file) {
        const std::string replacement = text_of(file, "replacement");
        return fmt::format("its mesh {} {}{}", text_of(file, "source_name"),
                           replacement.empty() ? "is gone" : "becomes " + replacement + " now",
                           file.value("removed", false) ? "; removed" : "");
    });
    return out;
}

class Index {
 public:
    Index(const json& report, const std::vector<PageState>& pages) : report_(report) {
        const json& assets = report.at("assets");
        for (std::size_t k = 0; k < assets.size(); ++k) {
            ++outcomes_[text_of(assets[k], "outcome")];
            if (assets[k].contains("report"))
                rows_.push_back(row_of(assets[k], k < pages.size() ? pages[k] : PageState{}));
            else
                failures_.push_back(assets[k]);
        }
        std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) {
            return std::tuple(-a.rms, -a.worst, a.name) < std::tuple(-b.rms, -b.worst, b.name);
        });
    }

    [[nodiscard]] std::string text() const {
        std::string out = page_start("Bakes", running() ? kReload : "") + "<body>\n<main>\n<header><h1>Bakes</h1>\n" +
                          totals() + "</header>\n";
        if (!failures_.empty()) {
            out += "<section><h2>Not baked</h2>\n";
            for (const json& asset : failures_) out += failure_html(asset);
            out += "</section>\n";
        }
        if (!rows_.empty()) out += table();
        out += other_files_html(report_) + settings_html(report_);
        out += "<footer class=\"small\">" + escaped(text_of(report_, "generator")) +
               ". Errors are distances between mesh and map, in % of the bounding box's diagonal and in the mesh's "
               "units; rms over the surface, max at the worst spot.</footer>\n</main>\n";
        out += fmt::format("{}{}{}\n", kReportStart, script_json(report_), kReportEnd);
        return out + "<script>\n" + kIndexScript + "</script>\n</body>\n</html>\n";
    }

 private:
    [[nodiscard]] bool running() const { return report_.contains("running"); }
    [[nodiscard]] std::string totals() const {
        std::string out = "<ul class=\"totals\">";
        const auto chip = [&](std::string_view kind, const std::string& text) {
            out += fmt::format("<li class=\"{}\">{}</li>", kind, escaped(text));
        };
        if (running())
            chip("look", fmt::format("still running: {} of {}", report_["running"].at("done").dump(),
                                     report_["running"].at("of").dump()));
        chip("", counted(report_.at("assets").size(), "asset"));
        for (const auto& [outcome, count] : outcomes_)
            if (outcome != "baked" && outcome != "up to date") chip("bad", fmt::format("{} {}", count, outcome));
        std::map<Grade, std::size_t> grades;
        std::uint64_t bytes = 0;
        double seconds = 0;
        for (const Row& row : rows_) ++grades[row.verdict.grade], bytes += row.bytes, seconds += row.seconds;
        if (grades[Grade::kBad] > 0) chip("bad", fmt::format("{} wrong or far from the mesh", grades[Grade::kBad]));
        if (grades[Grade::kLook] > 0) chip("look", fmt::format("{} worth a look", grades[Grade::kLook]));
        if (grades[Grade::kGood] > 0) chip("good", fmt::format("{} good", grades[Grade::kGood]));
        chip("", bake::bytes_text(bytes));
        if (seconds >= 0.5) out += fmt::format("<li class=\"run\">{:.0f} s of baking</li>", seconds);
        return out + "</ul>\n";
    }

    [[nodiscard]] std::string table() const {
        std::string out =
            "<section><h2>Baked, worst first</h2>\n<label>Filter <input id=\"filter\" type=\"search\" "
            "placeholder=\"part of a name\"></label> <span id=\"shown\" class=\"small\"></span>\n"
            "<table class=\"assets\"><thead><tr><th>map and error</th>"
            "<th data-first=\"up\"><button type=\"button\">name</button></th>"
            "<th class=\"n\" aria-sort=\"descending\"><button type=\"button\">rms</button></th>"
            "<th class=\"n\"><button type=\"button\">max</button></th>"
            "<th class=\"n wide-only\" data-first=\"up\"><button type=\"button\">grid</button></th>"
            "<th class=\"n\"><button type=\"button\">bytes</button></th>"
            "<th class=\"n\"><button type=\"button\">time</button></th></tr></thead>\n<tbody>\n";
        for (const Row& row : rows_) out += row_html(row);
        return out + "</tbody></table></section>\n";
    }

    const json& report_;
    std::vector<Row> rows_;
    std::vector<json> failures_;
    std::map<std::string, std::size_t> outcomes_;
};
}  // namespace

std::string index_page(const json& report, const std::vector<PageState>& pages) {
    try {
        return Index(report, pages).text();
    } catch (const json::exception& error) {
        throw model::Error(model::codes::kInternal, std::string("the report cannot be shown: ") + error.what());
    }
}

}  // namespace dgm::report
