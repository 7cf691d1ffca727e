// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/asset_page.cpp
#include "report/asset_page.h"

#include <fmt/format.h>

#include <vector>

#include "baking/bake_report.h"
#include "batch/report_text.h"
#include "dgm/dgm_reader.h"
#include "exr/exr_reader.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "model/element.h"
#include "render/canvas.h"
#include "render/pictures.h"
#include "render/textures.h"
#include "report/asset_sections.h"
#include "report/html.h"
#include "report/verdict.h"

namespace dgm::report {
namespace {
using formats::Image;
using nlohmann::json;

// Pixels of the comparison, whose captions are twice as large.
constexpr std::uint32_t kPanel = 440, kHeight = 500, kCaption = 28, kLegend = 34;
constexpr std::uint32_t kThumb = 112;

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

json timeless(const BakedAsset& baked) {
    json asset = baked.page.asset;
    asset.erase("seconds");
    asset["outcome"] = "baked";
    asset["report"] = json::parse(bake::to_json(baked.report, false));
    return asset;
}

std::string title(const BakedAsset& baked, const std::string& name) {
    const Verdict verdict = verdict_of(baked.report);
    std::string out = fmt::format(
        "<header><p class=\"back\"><a href=\"{}\">All assets</a></p>\n<h1>{}</h1>\n<p class=\"verdict "
        "{}\">{}</p>\n",
        escaped(baked.page.index_link), escaped(name), class_of(verdict.grade), escaped(verdict.headline));
    if (!verdict.notes.empty()) {
        out += "<ul class=\"notes\">";
        for (const std::string& note : verdict.notes) out += "<li>" + escaped(note) + "</li>";
        out += "</ul>\n";
    }
    return out + "</header>\n";
}

BakedAsset read_back(const AssetPage& page, const model::TriMesh& source) {
    BakedAsset baked{page, bake::report_from_json(page.asset.at("report").dump()), {}, {}, {}, {}};
    baked.maps = page.map.extension() == ".exr" ? formats::read_exr(page.map) : formats::read_dgm(page.map);
    if (baked.maps.charts.empty())
        throw model::Error(model::codes::kMissingLayer, "the file has no charts", page.map.string());
    const bake::ClosestPointIndex index(source.positions, source.faces);
    for (const model::Chart& chart : baked.maps.charts) {
        baked.surfaces.push_back(bake::reconstruct(chart));
        baked.values.push_back(render::surface_values(chart, baked.surfaces.back(), index));
    }
    return baked;
}

/// Source, reconstruction, grid and error side by side, and how they are seen.
struct Comparison {
    Image picture;
    std::vector<double> source_values;  ///< render::source_distances()
    render::View view;
};

Comparison compare(BakedAsset& baked, const model::TriMesh& source) {
    const render::ChartSurface all = render::chart_surface(baked.maps.charts);
    Comparison out;
    out.source_values = render::source_distances(source, all.mesh);
    baked.scales = render::scales_of(baked.values, out.source_values);
    render::PictureOptions options;
    options.width = 4 * kPanel;
    options.height = kHeight;
    options.samples_per_pixel = 4;
    out.view = render::choose_view(source);
    options.view = out.view;
    out.picture =
        render::comparison_picture(source, render::read_textures(source, [](const std::string&) {}), all, options);
    return out;
}

}  // namespace

std::string asset_page(const AssetPage& page, const std::filesystem::path& scratch) {
    const formats::ImportedMesh source = formats::read_mesh(page.source, {.asset_roots = page.asset_roots});
    BakedAsset baked = read_back(page, source.mesh);
    const Comparison comparison = compare(baked, source.mesh);
    const std::string head = fmt::format(
        "<meta name=\"dgm-page\" content=\"{}\">\n<meta name=\"dgm-thumbnail\" content=\"{}\">\n"
        "<meta name=\"dgm-error-thumbnail\" content=\"{}\">\n",
        escaped(page.key), thumbnail(comparison.picture, 1), thumbnail(comparison.picture, 3));
    const std::string name = page.asset.at("name").get<std::string>();
    std::string out = page_start(name, head) + "<body>\n<main>\n";
    out += title(baked, name);
    out += fmt::format(
        "<section><img class=\"wide\" src=\"{}\" alt=\"Source, reconstruction, grid and error\">"
        "</section>\n",
        photo_uri(comparison.picture, 88));
    out += viewer_section(baked, source.mesh, comparison.source_values, comparison.view, scratch) +
           picture_sections(baked) + table_sections(baked) + times_section(baked);
    out += "</main>\n";
    out += "<script type=\"application/json\" id=\"asset\">" + script_json(timeless(baked)) + "</script>\n";
    return out + "</body>\n</html>\n";
}

}  // namespace dgm::report
