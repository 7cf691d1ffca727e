// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/viewer_section.cpp
#include <fmt/format.h>

#include <utility>

#include "export/compared_map.h"
#include "page/page_file.h"
#include "report/asset_sections.h"
#include "report/html.h"

namespace dgm::report {
namespace {
// A page carries every sample of its map, so that what is touched is what was baked: about 1 MB for this many.
constexpr std::size_t kMostSamples = 300'000;

std::string without_viewer(const std::string& why) {
    return "<section id=\"viewer\"><h2>Touch it</h2>\n<p class=\"small\" id=\"no-viewer\">" + why + "</p></section>\n";
}

std::size_t samples_of(const model::MapSet& maps) {
    std::size_t out = 0;
    for (const model::Chart& chart : maps.charts) out += std::size_t{chart.rows} * chart.cols;
    return out;
}
}  // namespace

std::string viewer_section(const BakedAsset& baked, const model::TriMesh& source, std::span<const double> distances,
                           const render::View& view, const std::filesystem::path& scratch) {
    if (!page::can_make_pages())
        return without_viewer("This build of dgm-bake has no viewer (DGM_PAGE); the pictures show the same.");
    if (samples_of(baked.maps) > kMostSamples)
        return without_viewer(
            fmt::format("The map has {} samples, too many for this page. <code>dgm-export -o "
                        "page.html</code> makes a page of its own to touch.",
                        samples_of(baked.maps)));
    page::PagedMap map{baked.page.asset.at("name").get<std::string>(), &baked.maps};
    exporter::add_comparison({source, distances, baked.values, baked.scales}, map);
    exporter::add_bump(map);
    page::PageSettings settings;
    settings.title = map.name;
    settings.view = {view.yaw_degrees, view.pitch_degrees};
    settings.z_is_up = view.up == render::UpAxis::kZ;
    settings.look = exporter::kDistanceName;
    settings.framed = true;
    const std::string text = page::page_file(settings, {&map, 1}, scratch);
    return fmt::format(
        "<section id=\"viewer\"><h2>Touch it</h2>\n<iframe id=\"touch\" title=\"The source, and the map to be "
        "touched\" "
        "srcdoc=\"{}\"></iframe>\n<p class=\"small\">The source, and every sample of the map. "
        "1 value in 100 at most is beyond the ends of a scale.</p></section>\n",
        attribute_value(text));
}

}  // namespace dgm::report
