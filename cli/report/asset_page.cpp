// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/asset_page.cpp
#include "report/asset_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "baking/bake_report.h"
#include "batch/report_text.h"
#include "dgm/dgm_reader.h"
#include "exr/exr_reader.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "model/element.h"
#include "render/canvas.h"
#include "render/layer_picture.h"
#include "render/pictures.h"
#include "render/textures.h"
#include "report/html.h"
#include "report/page_parts.h"
#include "report/verdict.h"
#include "report/viewer_data.h"

namespace dgm::report {
namespace {
using bake::BakeReport;
using bake::ChartReport;
using formats::Image;
using nlohmann::json;

constexpr std::uint32_t kPanel = 440, kHeight = 500, kCaption = 28,
                        kLegend = 34;  // of the comparison, captions twice as large
constexpr std::uint32_t kThumb = 112;
constexpr std::uint32_t kMapSide = 260;
constexpr std::size_t kChartsShown = 6;  // pictures of more charts than these would make the page heavy
constexpr std::size_t kChartsListed = 100;
constexpr std::size_t kMostPngBytes = 24'000;

Image cut_out(const Image& from, std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height) {
    Image out = render::blank(width, height);
    render::paste(out, from, -std::int64_t{x}, -std::int64_t{y});
    return out;
}

/// A panel of the comparison, small.
std::string thumbnail(const Image& comparison, std::uint32_t panel) {
    const Image cut = cut_out(comparison, panel * kPanel, kLegend, kPanel, kHeight - kCaption - kLegend);
    return photo_uri(render::fitted(cut, kThumb, kThumb), 82);
}

std::string figure(const std::string& uri, std::string_view title, std::string_view note) {
    return fmt::format("<figure><img src=\"{}\" alt=\"{}\"><figcaption><b>{}</b> {}</figcaption></figure>\n", uri,
                       escaped(title), escaped(title), escaped(note));
}

/// The colour scale of a quantity with the words at its ends and in its middle.
std::string legend(Quantity quantity, const std::array<std::string, 3>& words) {
    Image bar = render::blank(128, 1);
    for (std::uint32_t x = 0; x < bar.width; ++x) bar.pixels[x] = quantity_colour(quantity, x / (bar.width - 1.0));
    return fmt::format(
        "<div class=\"legend\"><img src=\"{}\" alt=\"\"><div><span>{}</span><span>{}</span><span>{}"
        "</span></div></div>",
        picture_uri(bar, kMostPngBytes), escaped(words[0]), escaped(words[1]), escaped(words[2]));
}

std::array<std::string, 3> legend_words(Quantity quantity, const Scales& scales, double diagonal) {
    if (quantity == Quantity::kDistance)
        return {"inside " + length_text(scales.distance, diagonal), "0",
                "outside " + length_text(scales.distance, diagonal)};
    if (quantity == Quantity::kArea)
        return {fmt::format("1/{:.2g} of the mean", std::exp2(scales.area)), "1",
                fmt::format("{:.2g} times", std::exp2(scales.area))};
    return {"1 (none)", fmt::format("{:.2g}", std::exp2(scales.angle / 2)),
            fmt::format("{:.2g}", std::exp2(scales.angle))};
}

struct Made {
    model::MapSet maps;
    std::vector<bake::Reconstruction> surfaces;
    std::vector<SurfaceValues> values;
    Scales scales;
};

class Page {
 public:
    explicit Page(const AssetPage& page)
        : page_(page),
          report_(bake::report_from_json(page.asset.at("report").dump())),
          diagonal_(report_.error.diagonal) {}

    std::string text() {
        const formats::ImportedMesh source = formats::read_mesh(page_.source);
        made_.maps = page_.map.extension() == ".exr" ? formats::read_exr(page_.map) : formats::read_dgm(page_.map);
        if (made_.maps.charts.empty())
            throw model::Error(model::codes::kMissingLayer, "the file has no charts", page_.map.string());
        const bake::ClosestPointIndex index(source.mesh.positions, source.mesh.faces);
        for (const model::Chart& chart : made_.maps.charts) {
            made_.surfaces.push_back(bake::reconstruct(chart));
            made_.values.push_back(surface_values(chart, made_.surfaces.back(), index));
        }
        const render::ChartSurface all = render::chart_surface(made_.maps.charts);
        const std::vector<double> source_values = source_distances(source.mesh, all.mesh);
        made_.scales = scales_of(made_.values, source_values);
        render::PictureOptions options;
        options.width = 4 * kPanel, options.height = kHeight;
        options.samples_per_pixel = 4;
        options.view = render::choose_view(source.mesh);
        const Image comparison = render::comparison_picture(
            source.mesh, render::read_textures(source.mesh, [](const std::string&) {}), all, options);
        const json data = viewer_data({source.mesh, source_values}, {made_.maps.charts, made_.surfaces, made_.values},
                                      made_.scales, diagonal_, *options.view);

        const std::string head = fmt::format(
            "<meta name=\"dgm-page\" content=\"{}\">\n<meta name=\"dgm-thumbnail\" content=\"{}\">\n"
            "<meta name=\"dgm-error-thumbnail\" content=\"{}\">\n",
            escaped(page_.key), thumbnail(comparison, 1), thumbnail(comparison, 3));
        const std::string name = page_.asset.at("name").get<std::string>();
        std::string out = page_start(name, head) + "<body>\n<main>\n";
        out += title(name);
        out += fmt::format(
            "<section><img class=\"wide\" src=\"{}\" alt=\"Source, reconstruction, grid and error\">"
            "</section>\n",
            photo_uri(comparison, 88));
        out += viewer(data);
        out += maps() + layers() + measures() + charts() + search() + repairs() + command() + times();
        out += "</main>\n<script type=\"application/json\" id=\"viewer-data\">" + script_json(data) + "</script>\n";
        out += "<script type=\"application/json\" id=\"asset\">" + script_json(timeless()) + "</script>\n";
        return out + "<script>\n" + kViewerScript + "</script>\n</body>\n</html>\n";
    }

 private:
    [[nodiscard]] json timeless() const {
        json asset = page_.asset;
        asset.erase("seconds");
        asset["outcome"] = "baked";
        asset["report"] = json::parse(bake::to_json(report_, false));
        return asset;
    }

    [[nodiscard]] std::string title(const std::string& name) const {
        const Verdict verdict = verdict_of(report_);
        std::string out = fmt::format(
            "<header><p class=\"back\"><a href=\"{}\">All assets</a></p>\n<h1>{}</h1>\n<p class=\"verdict "
            "{}\">{}</p>\n",
            escaped(page_.index_link), escaped(name), class_of(verdict.grade), escaped(verdict.headline));
        if (!verdict.notes.empty()) {
            out += "<ul class=\"notes\">";
            for (const std::string& note : verdict.notes) out += "<li>" + escaped(note) + "</li>";
            out += "</ul>\n";
        }
        return out + "</header>\n";
    }

    [[nodiscard]] std::string viewer(const json& data) const {
        const std::size_t shown = data.at("charts"), stride = data.at("stride");
        std::string note = stride == 1 ? std::string("Every sample of the grid is drawn.")
                                       : fmt::format(
                                             "One sample in {} is drawn in each direction, and all along seams "
                                             "and borders; a colour is the worst of the samples around.",
                                             stride);
        if (data.at("source").at("simplified")) note += " The source is drawn simplified.";
        if (shown < made_.maps.charts.size())
            note += fmt::format(" The first {} of {} charts are shown.", shown, made_.maps.charts.size());
        return fmt::format(
            "<section id=\"viewer\"><h2>Turn it</h2>\n<div class=\"tools\"><label>Colour by <select id=\"mode\">"
            "<option value=\"distance\">distance between the two</option><option value=\"none\">nothing, lit</option>"
            "<option value=\"area\">area distortion</option><option value=\"angle\">angle distortion</option>"
            "</select></label><label><input type=\"checkbox\" id=\"grid\"> grid</label>"
            "<label><input type=\"checkbox\" id=\"seams\"> seams <i class=\"seam\"></i> borders "
            "<i class=\"border\"></i></label><div class=\"legend\" id=\"legend\" hidden><canvas width=\"256\" "
            "height=\"1\"></canvas><div><span></span><span></span><span></span></div></div></div>\n"
            "<div class=\"captions\"><span>source</span><span>reconstruction</span></div>\n"
            "<canvas id=\"view\" tabindex=\"0\" aria-label=\"Source and reconstruction, turned together\"></canvas>\n"
            "<p class=\"small\">Drag to turn, wheel to zoom, arrow keys too, double-click to go back. {}</p>\n"
            "<p class=\"small\" id=\"no-viewer\" hidden>This browser cannot draw in three dimensions (WebGL 2 is "
            "missing); the pictures above and below show the same.</p></section>\n",
            escaped(note));
    }

    [[nodiscard]] std::size_t shown_charts() const { return std::min(kChartsShown, made_.maps.charts.size()); }
    [[nodiscard]] std::string chart_heading(std::size_t k) const {
        return made_.maps.charts.size() == 1 ? std::string() : fmt::format("<h3>Chart {}</h3>\n", k);
    }
    [[nodiscard]] std::string left_out() const {
        if (shown_charts() == made_.maps.charts.size()) return {};
        return fmt::format(
            "<p class=\"small\">Pictures of the first {} of {} charts; dgm-export --sheet makes all of "
            "them.</p>\n",
            shown_charts(), made_.maps.charts.size());
    }

    [[nodiscard]] std::string maps() const {
        constexpr std::array kRows{std::pair(Quantity::kDistance, "distance to the source"),
                                   std::pair(Quantity::kArea, "area of a grid cell"),
                                   std::pair(Quantity::kAngle, "angle distortion")};
        std::string out = "<section><h2>Error and distortion in the map</h2>\n";
        for (std::size_t k = 0; k < shown_charts(); ++k) {
            out += chart_heading(k) + "<div class=\"pictures\">\n";
            for (const auto& [quantity, title] : kRows) {
                const Image picture = grid_picture(made_.maps.charts[k], made_.values[k], quantity, made_.scales);
                out +=
                    fmt::format("<figure><img src=\"{}\" alt=\"{}\"><figcaption><b>{}</b> {}</figcaption></figure>\n",
                                picture_uri(render::fitted(picture, kMapSide, kMapSide), kMostPngBytes), title, title,
                                legend(quantity, legend_words(quantity, made_.scales, diagonal_)));
            }
            out += "</div>\n";
        }
        out +=
            "<p class=\"small\">Row u runs down, column v to the right. Red cells cover more of the surface than "
            "the mean, blue ones less. Angle distortion is the quasi-conformal dilatation: 1 keeps every angle, 2 "
            "draws a circle out to twice its width.</p>\n";
        return out + left_out() + "</section>\n";
    }

    [[nodiscard]] std::string layers() const {
        std::string out = "<section><h2>Layers</h2>\n";
        for (std::size_t k = 0; k < shown_charts(); ++k) {
            const model::Chart& chart = made_.maps.charts[k];
            out += chart_heading(k) + "<div class=\"pictures\">\n";
            for (const model::Layer& layer : chart.layers) {
                const std::string shape =
                    fmt::format("{} {}", model::shape_text(layer.shape), model::type_name(layer.type));
                try {
                    const render::LayerPicture picture = render::layer_picture(chart, layer.name);
                    out += figure(picture_uri(render::fitted(picture.image, kMapSide, kMapSide), kMostPngBytes),
                                  layer.name, shape + ". " + picture.note);
                } catch (const model::Error& error) {
                    if (&error.code() != &model::codes::kUnsupported) throw;
                    out += fmt::format("<p class=\"small\">{}: {}, no picture</p>\n", escaped(layer.name), shape);
                }
            }
            out += "</div>\n";
        }
        return out + "</section>\n";
    }

    [[nodiscard]] std::string measures() const {
        const bake::SurfaceError& e = report_.error;
        std::string out = "<section><h2>Measures</h2>\n<table class=\"plain\"><tbody>\n";
        const auto row = [&](std::string_view name, const std::string& value, std::string_view meaning) {
            out +=
                fmt::format("<tr><th>{}</th><td class=\"n\">{}</td><td>{}</td></tr>\n", name, escaped(value), meaning);
        };
        std::uint64_t flips = 0, turned = 0;
        double gap = 0, stretch = 0;
        for (const ChartReport& chart : report_.charts) {
            flips += chart.map.flips, turned += chart.turned_faces;
            gap = std::max(gap, chart.seam_gap), stretch = std::max(stretch, chart.map.stretch_l2);
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
        if (report_.worst_quantisation > 0)
            row("rounding", length_text(report_.worst_quantisation, e.diagonal), "half a step of the u16 positions");
        row("diagonal", number_text(e.diagonal), "of the source's bounding box, in its units");
        row("mesh", fmt::format("{} vertices, {} faces", report_.source_vertices, report_.source_faces), "as imported");
        std::uint64_t bytes = 0;
        for (const json& file : page_.asset.at("files")) bytes += file.at("bytes").get<std::uint64_t>();
        row("file", bake::bytes_text(bytes), "all that was written");
        return out + "</tbody></table>\n</section>\n";
    }

    [[nodiscard]] std::string charts() const {
        std::string out =
            "<section><h2>Charts</h2>\n<div class=\"scroll\"><table class=\"plain\"><thead><tr><th>#</th>"
            "<th>method</th><th>domain</th><th>grid</th><th>rms</th><th>max</th><th>stretch</th>"
            "<th>area</th><th>angle</th><th>used</th><th>genus</th><th>borders</th></tr></thead><tbody>\n";
        for (std::size_t k = 0; k < std::min(kChartsListed, report_.charts.size()); ++k) {
            const ChartReport& c = report_.charts[k];
            out += fmt::format("<tr><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"n\">{}x{}</td>", k,
                               escaped(c.method), escaped(c.domain), c.rows, c.cols);
            for (const std::string& cell :
                 {length_text(c.error.rms, diagonal_), length_text(c.error.hausdorff, diagonal_),
                  number_text(c.map.stretch_l2), number_text(c.map.area), number_text(c.map.angle),
                  fmt::format("{:.0f} %", 100 * c.utilisation), std::to_string(c.source_topology.genus),
                  std::to_string(c.source_topology.boundary_loops)})
                out += "<td class=\"n\">" + escaped(cell) + "</td>";
            out += "</tr>\n";
        }
        out += "</tbody></table></div>\n";
        if (report_.charts.size() > kChartsListed)
            out += fmt::format("<p class=\"small\">The first {} of {}.</p>\n", kChartsListed, report_.charts.size());
        return out +
               "<p class=\"small\">Area and angle are means over the surface; 1 is no distortion.</p>\n</section>\n";
    }

    [[nodiscard]] std::string search() const {
        std::string out;
        if (report_.search) {
            const bake::GridSearch& s = *report_.search;
            out += "<p>" + escaped(bake::search_story(s, diagonal_)) +
                   "</p>\n<table class=\"plain\"><thead><tr><th>grid"
                   "</th><th>rms</th><th>max</th><th>file</th><th>outcome</th></tr></thead><tbody>\n";
            for (const auto* list : {&s.shapes, &s.trials})
                for (const bake::GridTrial& t : *list)
                    out += fmt::format(
                        "<tr><td class=\"n\">{}x{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
                        "<td class=\"n\">{}</td><td>{}</td></tr>\n",
                        t.rows, t.cols, length_text(t.rms, diagonal_), length_text(t.hausdorff, diagonal_),
                        t.bytes > 0 ? bake::bytes_text(t.bytes) : std::string("-"), escaped(t.outcome));
            out += "</tbody></table>\n";
        }
        std::string tried;
        for (std::size_t k = 0; k < std::min(kChartsListed, report_.charts.size()); ++k)
            for (const bake::CandidateReport& c : report_.charts[k].candidates)
                tried +=
                    fmt::format("<tr><td class=\"n\">{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n", k,
                                escaped(c.method), c.psnr > 0 ? fmt::format("{:.1f} dB", c.psnr) : std::string("-"),
                                escaped(c.outcome));
        if (!tried.empty())
            out +=
                "<table class=\"plain\"><thead><tr><th>chart</th><th>method</th><th>PSNR</th><th>outcome</th></tr>"
                "</thead><tbody>\n" +
                tried + "</tbody></table>\n";
        return out.empty() ? out : "<section><h2>What was tried</h2>\n" + out + "</section>\n";
    }

    [[nodiscard]] std::string repairs() const {
        std::string out = "<section><h2>Repaired</h2>\n";
        if (report_.repairs.empty()) return out + "<p>Nothing had to be repaired.</p>\n</section>\n";
        out += "<ul>";
        for (const auto& [kind, count] : report_.repairs) out += fmt::format("<li>{} {}</li>", count, escaped(kind));
        return out + "</ul>\n</section>\n";
    }

    [[nodiscard]] std::string command() const {
        return fmt::format(
            "<section><h2>Bake it again</h2>\n<pre>{}</pre>\n<p class=\"small\">Add --force if nothing has "
            "changed.</p></section>\n",
            escaped(page_.command));
    }

    [[nodiscard]] std::string times() const {
        std::string out = std::string(kRunStart) + "\n<section><h2>Times</h2>\n";
        if (report_.times.empty()) {
            out += "<p>It was up to date; nothing was baked in this run.</p>\n";
        } else {
            out +=
                "<table class=\"plain\"><thead><tr><th>stage</th><th>seconds</th><th>of CPU</th></tr></thead><tbody>\n";
            for (const bake::StageTime& t : report_.times)
                out += fmt::format("<tr><td>{}</td><td class=\"n\">{:.2f}</td><td class=\"n\">{:.2f}</td></tr>\n",
                                   escaped(t.stage), t.seconds, t.cpu_seconds);
            out += fmt::format("</tbody></table>\n<p>{:.1f} s of CPU in all, {} of memory at most.</p>\n",
                               report_.cpu_seconds, bake::bytes_text(report_.peak_memory_bytes));
        }
        return out + "</section>\n" + kRunEnd + "\n";
    }

    const AssetPage& page_;
    BakeReport report_;
    double diagonal_;
    Made made_;
};
}  // namespace

std::string asset_page(const AssetPage& page) {
    return Page(page).text();
}

}  // namespace dgm::report
