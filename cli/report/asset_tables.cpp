// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/asset_tables.cpp
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "batch/report_text.h"
#include "report/asset_sections.h"
#include "report/html.h"

namespace dgm::report {
namespace {
using bake::ChartReport;
using nlohmann::json;

constexpr std::size_t kChartsListed = 100;

std::string measures_section(const BakedAsset& baked) {
    const bake::SurfaceError& e = baked.report.error;
    std::string out = "<section><h2>Measures</h2>\n<table class=\"plain\"><tbody>\n";
    const auto row = [&](std::string_view name, const std::string& value, std::string_view meaning) {
        out += fmt::format("<tr><th>{}</th><td class=\"n\">{}</td><td>{}</td></tr>\n", name, escaped(value), meaning);
    };
    std::uint64_t flips = 0, turned = 0;
    double gap = 0, stretch = 0;
    for (const ChartReport& chart : baked.report.charts) {
        flips += chart.map.flips;
        turned += chart.turned_faces;
        gap = std::max(gap, chart.seam_gap);
        stretch = std::max(stretch, chart.map.stretch_l2);
    }
    row("rms", length_text(e.rms, e.diagonal),
        "distance between source and reconstruction, the worse of the two directions, in the mesh's units and as % "
        "of the bounding box's diagonal");
    row("max", length_text(e.hausdorff, e.diagonal), "the largest such distance (Hausdorff)");
    row("PSNR", fmt::format("{:.1f} dB", e.psnr()), "60 dB is 0.1 %, 80 dB is 0.01 % of the diagonal");
    row("normals", number_text(e.normal_rms_degrees) + " degrees", "rms angle between the normals of both");
    if (!std::isnan(e.normal_rms_bump_degrees))
        row("normals with bump", number_text(e.normal_rms_bump_degrees) + " degrees",
            "the same, shaded with the bump layer");
    row("stretch", number_text(stretch), "L2 stretch of the map, the worst chart's; 1 is isometric");
    row("flips", std::to_string(flips), "triangles of the map that are turned over; always 0 in a baked file");
    row("turned faces", std::to_string(turned), "triangles of the reconstruction that look against the source");
    row("seam gap", number_text(gap), "between samples that are one point of the surface; always exactly 0");
    if (baked.report.worst_quantisation > 0)
        row("rounding", length_text(baked.report.worst_quantisation, e.diagonal), "half a step of the u16 positions");
    row("diagonal", number_text(e.diagonal), "of the source's bounding box, in its units");
    row("mesh", fmt::format("{} vertices, {} faces", baked.report.source_vertices, baked.report.source_faces),
        "as imported");
    std::uint64_t bytes = 0;
    for (const json& file : baked.page.asset.at("files")) bytes += file.at("bytes").get<std::uint64_t>();
    row("file", bake::bytes_text(bytes), "all that was written");
    return out + "</tbody></table>\n</section>\n";
}

std::string charts_section(const BakedAsset& baked) {
    std::string out =
        "<section><h2>Charts</h2>\n<div class=\"scroll\"><table class=\"plain\"><thead><tr><th>#</th>"
        "<th>method</th><th>domain</th><th>grid</th><th>rms</th><th>max</th><th>stretch</th>"
        "<th>area</th><th>angle</th><th>used</th><th>genus</th><th>borders</th></tr></thead><tbody>\n";
    for (std::size_t k = 0; k < std::min(kChartsListed, baked.report.charts.size()); ++k) {
        const ChartReport& c = baked.report.charts[k];
        out += fmt::format("<tr><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"n\">{}x{}</td>", k,
                           escaped(c.method), escaped(c.domain), c.rows, c.cols);
        for (const std::string& cell :
             {length_text(c.error.rms, baked.diagonal()), length_text(c.error.hausdorff, baked.diagonal()),
              number_text(c.map.stretch_l2), number_text(c.map.area), number_text(c.map.angle),
              fmt::format("{:.0f} %", 100 * c.utilisation), std::to_string(c.source_topology.genus),
              std::to_string(c.source_topology.boundary_loops)})
            out += "<td class=\"n\">" + escaped(cell) + "</td>";
        out += "</tr>\n";
    }
    out += "</tbody></table></div>\n";
    if (baked.report.charts.size() > kChartsListed)
        out += fmt::format("<p class=\"small\">The first {} of {}.</p>\n", kChartsListed, baked.report.charts.size());
    return out + "<p class=\"small\">Area and angle are means over the surface; 1 is no distortion.</p>\n</section>\n";
}

std::string search_section(const BakedAsset& baked) {
    std::string out;
    if (baked.report.search) {
        const bake::GridSearch& s = *baked.report.search;
        out += "<p>" + escaped(bake::search_story(s, baked.diagonal())) +
               "</p>\n<table class=\"plain\"><thead><tr><th>grid"
               "</th><th>rms</th><th>max</th><th>file</th><th>outcome</th></tr></thead><tbody>\n";
        for (const auto* list : {&s.shapes, &s.trials})
            for (const bake::GridTrial& t : *list)
                out += fmt::format(
                    "<tr><td class=\"n\">{}x{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
                    "<td class=\"n\">{}</td><td>{}</td></tr>\n",
                    t.rows, t.cols, length_text(t.rms, baked.diagonal()), length_text(t.hausdorff, baked.diagonal()),
                    t.bytes > 0 ? bake::bytes_text(t.bytes) : std::string("-"), escaped(t.outcome));
        out += "</tbody></table>\n";
    }
    std::string tried;
    for (std::size_t k = 0; k < std::min(kChartsListed, baked.report.charts.size()); ++k)
        for (const bake::CandidateReport& c : baked.report.charts[k].candidates)
            tried += fmt::format("<tr><td class=\"n\">{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n", k,
                                 escaped(c.method), c.psnr > 0 ? fmt::format("{:.1f} dB", c.psnr) : std::string("-"),
                                 escaped(c.outcome));
    if (!tried.empty())
        out +=
            "<table class=\"plain\"><thead><tr><th>chart</th><th>method</th><th>PSNR</th><th>outcome</th></tr>"
            "</thead><tbody>\n" +
            tried + "</tbody></table>\n";
    return out.empty() ? out : "<section><h2>What was tried</h2>\n" + out + "</section>\n";
}

std::string repairs_section(const BakedAsset& baked) {
    std::string out = "<section><h2>Repaired</h2>\n";
    if (baked.report.repairs.empty()) return out + "<p>Nothing had to be repaired.</p>\n</section>\n";
    out += "<ul>";
    for (const auto& [kind, count] : baked.report.repairs) out += fmt::format("<li>{} {}</li>", count, escaped(kind));
    return out + "</ul>\n</section>\n";
}

std::string command_section(const BakedAsset& baked) {
    return fmt::format(
        "<section><h2>Bake it again</h2>\n<pre>{}</pre>\n<p class=\"small\">Add --force if nothing has "
        "changed.</p></section>\n",
        escaped(baked.page.command));
}
}  // namespace

std::string table_sections(const BakedAsset& baked) {
    return measures_section(baked) + charts_section(baked) + search_section(baked) + repairs_section(baked) +
           command_section(baked);
}

std::string times_section(const BakedAsset& baked) {
    std::string out = std::string(kRunStart) + "\n<section><h2>Times</h2>\n";
    if (baked.report.times.empty()) {
        out += "<p>It was up to date; nothing was baked in this run.</p>\n";
    } else {
        out += "<table class=\"plain\"><thead><tr><th>stage</th><th>seconds</th><th>of CPU</th></tr></thead><tbody>\n";
        for (const bake::StageTime& t : baked.report.times)
            out += fmt::format("<tr><td>{}</td><td class=\"n\">{:.2f}</td><td class=\"n\">{:.2f}</td></tr>\n",
                               escaped(t.stage), t.seconds, t.cpu_seconds);
        out += fmt::format("</tbody></table>\n<p>{:.1f} s of CPU in all, {} of memory at most.</p>\n",
                           baked.report.cpu_seconds, bake::bytes_text(baked.report.peak_memory_bytes));
    }
    return out + "</section>\n" + kRunEnd + "\n";
}

}  // namespace dgm::report
