// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/touch_page.cpp
#include "export/touch_page.h"

#include <sstream>
#include <string>
#include <utility>

#include "files/regular_file.h"
#include "files/whole_file.h"
#include "image/image.h"
#include "path/tool_path.h"
#include "render/chart_surface.h"
#include "render/pictures.h"

namespace dgm::exporter {
namespace {
constexpr std::uint32_t kStillWidth = 480, kStillHeight = 360;
constexpr int kStillQuality = 75;  // about 12 KB

std::vector<std::byte> still_of(const model::MapSet& maps, render::UpAxis up) {
    render::PictureOptions how;
    how.width = kStillWidth, how.height = kStillHeight;
    how.up = up;
    return formats::encode_jpeg(render::surface_picture(render::chart_surface(maps.charts), how), kStillQuality);
}

/// The text of each path, once it is known to be one.
std::vector<page::PagedPath> paths_of(const ExportOptions& options) {
    constexpr std::size_t kMostBytes = std::size_t{16} << 20;  // an hour of strokes at 60 frames a second
    std::vector<page::PagedPath> out;
    for (const std::filesystem::path& file : options.paths) {
        std::istringstream text(formats::read_small_file(file, kMostBytes));
        static_cast<void>(formats::ToolPath(text, file));
        out.push_back({file.stem().string(), std::move(text).str()});
    }
    return out;
}
}  // namespace

void write_touch_page(const std::vector<page::PagedMap>& maps, const std::filesystem::path& output,
                      const ExportOptions& options, StagingFolder& staging) {
    page::PageSettings settings;
    settings.title = output.stem().string();
    settings.z_is_up = options.up == render::UpAxis::kZ;
    settings.cover = options.cover;
    settings.paths = paths_of(options);
    if (!maps.empty()) settings.still = still_of(*maps.front().maps, options.up);
    const std::string text = page::page_file(settings, maps, staging.where("map.dgm"));
    formats::write_whole_file(staging.add(output.filename()), text, output);
}

}  // namespace dgm::exporter
