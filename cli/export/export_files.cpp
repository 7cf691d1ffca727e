// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/export_files.cpp
#include "export/export_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "dgm/dgm_reader.h"
#include "dgm/dgm_writer.h"
#include "export/chart_mesh.h"
#include "export/compared_map.h"
#include "export/mesh_files.h"
#include "export/staging_folder.h"
#include "export/touch_page.h"
#include "exr/exr_files.h"
#include "exr/exr_reader.h"
#include "exr/exr_writer.h"
#include "files/atomic_file.h"
#include "files/nesting.h"
#include "image/image.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "render/canvas.h"
#include "render/chart_surface.h"
#include "render/layer_picture.h"
#include "render/pictures.h"
#include "render/textures.h"
#include "tool/words.h"

namespace dgm::exporter {
namespace {
using formats::Image;
using model::Chart;
using model::MapSet;
using std::filesystem::path;
using Warn = std::function<void(const std::string&)>;

constexpr std::uint32_t kPictureGap = 8;  // between pictures of several charts
constexpr const char* kNeedsTwo = "--cover goes with an .html output of two maps or more";

[[noreturn]] void usage(const std::string& message) {
    throw model::Error(model::codes::kUsage, message);
}

bool is_mesh(const std::string& extension) {
    return extension == ".obj" || extension == ".ply" || extension == ".glb";
}

void check_lods(const ExportOptions& options, const std::string& extension) {
    const std::vector<std::uint32_t>& lods = options.lods;
    constexpr std::size_t kMostLevels = 8;
    if (lods.empty() || lods[0] == 0) usage("--lod counts from 1");
    if (lods.size() > kMostLevels) usage(fmt::format("--lod takes at most {} levels", kMostLevels));
    if (std::adjacent_find(lods.begin(), lods.end(), std::greater_equal<>()) != lods.end())
        usage("--lod: name levels from fine to coarse, such as 1,4,16");
    if (lods != std::vector<std::uint32_t>{1} && !is_mesh(extension))
        usage("--lod goes with an .obj, .ply or .glb output");
    if (lods.size() > 1 && extension != ".glb") usage("several levels of detail in one file go with a .glb output");
}

void check_options(const MapSet& maps, const path& output, const ExportOptions& options) {
    const std::string extension = lower_extension(output);
    if (extension == ".gltf")
        throw model::Error(model::codes::kUnsupported, "glTF is written in its binary form; end the output in .glb");
    const std::vector<std::string>& known = known_extensions();
    if (std::find(known.begin(), known.end(), extension) == known.end())
        usage(fmt::format("the output \"{}\" must end in .obj, .ply, .glb, .exr, .dgm, .png or .html",
                          output.filename().string()));
    check_lods(options, extension);
    if ((options.quantize || options.compress) && extension != ".glb")
        usage("--quantize and --compress go with a .glb output");
    if (options.power_of_two && !is_mesh(extension)) usage("--power-of-two goes with an .obj, .ply or .glb output");
    const bool picture = extension == ".png";
    const bool asks_picture =
        !options.layer.empty() || options.sheet || options.width || options.height || options.view;
    if (!picture && asks_picture) usage("--layer, --sheet, --size and --view go with a .png output");
    if (!options.source.empty() && !picture && extension != ".html") usage("--source goes with a .png or .html output");
    if (int{!options.layer.empty()} + int{options.sheet} + int{!options.source.empty()} > 1)
        usage("--layer, --sheet and --source exclude each other");
    if (!options.paths.empty() && extension != ".html") usage("--path goes with an .html output");
    if (options.multipart && extension != ".exr") usage("--exr-layout goes with an .exr output");
    if (options.chart && *options.chart >= maps.charts.size())
        usage(fmt::format("there is no chart {}; the file has {}, counted from 0", *options.chart, maps.charts.size()));
}

MapSet only_chart(MapSet maps, std::optional<std::uint32_t> chart) {
    if (chart) maps.charts = {maps.charts[*chart]};
    return maps;
}

/// Layers of other sizes stand in files of their own beside the map.
void write_exr_files(const MapSet& maps, const path& output, bool multipart, StagingFolder& staging) {
    const path map = staging.where(output.filename());
    for (const path& file :
         formats::write_exr(maps, map, {multipart ? formats::ExrLayout::kMultipart : formats::ExrLayout::kAuto})) {
        if (file != map) formats::check_exr_side_place(output.parent_path() / file.filename());
        static_cast<void>(staging.add(file.filename()));
    }
}

/// A chart has the same name alone as among the others.
std::vector<std::string> names_of(const MapSet& maps, std::optional<std::uint32_t> chart) {
    std::vector<std::string> names = chart_names(maps);
    if (chart) names = {names[*chart]};
    return names;
}

render::PictureOptions picture_options(const ExportOptions& options) {
    render::PictureOptions out;
    out.width = options.width.value_or(options.source.empty() ? 1280 : 1920);
    out.height = options.height.value_or(options.source.empty() ? 960 : 560);
    out.view = options.view;
    out.up = options.up;
    return out;
}

Image beside(const std::vector<Image>& images, bool below) {
    std::uint32_t width = 0, height = 0;
    for (const Image& image : images) {
        width = below ? std::max(width, image.width) : width + image.width + (width > 0 ? kPictureGap : 0);
        height = below ? height + image.height + (height > 0 ? kPictureGap : 0) : std::max(height, image.height);
        if (std::max(width, height) > formats::kMaxImageSide)
            throw model::Error(model::codes::kTooLarge,
                               "the pictures of all charts together are too large; use --chart")
                .with_hint("export the charts one by one: --chart 0, --chart 1, ...");
    }
    if (images.size() == 1) return images[0];
    Image out = render::blank(width, height);
    std::int64_t at = 0;
    for (const Image& image : images) {
        render::paste(out, image, below ? 0 : at, below ? at : 0);
        at += (below ? image.height : image.width) + kPictureGap;
    }
    return out;
}

Image layers_picture(const MapSet& maps, const ExportOptions& options) {
    std::vector<Image> images;
    for (const Chart& chart : maps.charts) {
        if (chart.find(options.layer) == nullptr) {
            std::vector<std::string> names;
            for (const model::Layer& layer : chart.layers) names.push_back(layer.name);
            throw model::Error(model::codes::kMissingLayer, tool::unknown_word("layer", options.layer, names));
        }
        images.push_back(render::layer_picture(chart, options.layer).image);
        if (options.width && options.height)
            images.back() = render::fitted(images.back(), *options.width, *options.height);
    }
    return beside(images, false);
}

Image sheets_picture(const MapSet& maps, const ExportOptions& options) {
    std::vector<Image> sheets;
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        const Chart& chart = maps.charts[k];
        const std::uint32_t number = options.chart.value_or(static_cast<std::uint32_t>(k));
        const std::string title = fmt::format("{}, chart {}: {} x {}, {}", maps.source_name, number, chart.rows,
                                              chart.cols, chart.domain == model::Domain::kFree ? "free" : "square");
        sheets.push_back(render::contact_sheet(chart, title, picture_options(options)));
    }
    return beside(sheets, true);
}

formats::ImportedMesh read_source(const ExportOptions& options, const Warn& warn) {
    formats::ImportedMesh source =
        options.read_mesh ? options.read_mesh(options.source) : formats::read_mesh(options.source);
    for (const std::string& warning : source.warnings) warn(warning);
    return source;
}

Image compared_picture(const MapSet& maps, const ExportOptions& options, const Warn& warn) {
    const formats::ImportedMesh source = read_source(options, warn);
    return render::comparison_picture(source.mesh, render::read_textures(source.mesh, warn),
                                      render::chart_surface(maps.charts), picture_options(options));
}

Image picture(const MapSet& maps, const ExportOptions& options, const Warn& warn) {
    if (!options.layer.empty()) return layers_picture(maps, options);
    if (options.sheet) return sheets_picture(maps, options);
    if (!options.source.empty()) return compared_picture(maps, options, warn);
    return render::surface_picture(render::chart_surface(maps.charts), picture_options(options));
}

nlohmann::json report_of(const MapSet& maps, const ExportOptions& options) {
    if (options.read_report) return options.read_report(maps.report_json);
    if (formats::too_deep_json(maps.report_json, formats::kMostNesting)) return nullptr;
    nlohmann::json out = nlohmann::json::parse(maps.report_json, nullptr, false);
    return out.is_discarded() ? nlohmann::json(nullptr) : out;
}

page::PagedMap paged_map(std::string name, const MapSet& maps, const ExportOptions& options, const Warn& warn) {
    page::PagedMap out{std::move(name), &maps};
    if (!options.source.empty()) compare_with(read_source(options, warn).mesh, out);
    add_bump(out);
    out.facts = measured_errors(report_of(maps, options));
    return out;
}
}  // namespace

const std::vector<std::string>& known_extensions() {
    static const std::vector<std::string> known{".obj", ".ply", ".glb", ".exr", ".dgm", ".png", ".html"};
    return known;
}

std::string lower_extension(const path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

MapSet read_maps(const path& file) {
    formats::check_map_name(file);
    constexpr std::array<char, 4> kExrMagic{'\x76', '\x2f', '\x31', '\x01'};
    std::array<char, 4> start{};
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) std::ifstream(file, std::ios::binary).read(start.data(), 4);
    return start == kExrMagic ? formats::read_exr(file) : formats::read_dgm(file);
}

void export_maps(const MapSet& maps, const path& output, const ExportOptions& options, const Warn& warn) {
    check_options(maps, output, options);
    if (options.cover) usage(kNeedsTwo);
    const MapSet chosen = only_chart(maps, options.chart);
    if (chosen.charts.empty()) throw model::Error(model::codes::kMissingLayer, "the file has no charts");
    const std::string extension = lower_extension(output);
    formats::make_folder_of(output);
    StagingFolder staging(output);
    const bool exr = extension == ".exr";
    const std::vector<std::string> old_names = exr ? formats::exr_side_names(output) : std::vector<std::string>();
    if (is_mesh(extension))
        write_mesh_files(chosen, names_of(maps, options.chart), output, options, staging);
    else if (extension == ".png")
        formats::write_png(staging.add(output.filename()), picture(chosen, options, warn));
    else if (extension == ".dgm")
        formats::write_dgm(chosen, staging.add(output.filename()));
    else if (extension == ".html")
        write_touch_page({paged_map(asset_name(maps), chosen, options, warn)}, output, options, staging);
    else
        write_exr_files(chosen, output, options.multipart, staging);
    staging.publish();
    if (exr) formats::remove_old_exr_sides(output, old_names);
}

void export_page(const std::vector<NamedMaps>& maps, const path& output, const ExportOptions& options) {
    std::vector<MapSet> chosen;
    std::vector<page::PagedMap> paged;
    if (!options.source.empty() && maps.size() > 1) usage("--source goes with one map");
    if (options.cover && maps.size() < 2) usage(kNeedsTwo);
    for (const NamedMaps& named : maps) {
        check_options(named.maps, output, options);
        chosen.push_back(only_chart(named.maps, options.chart));
    }
    for (std::size_t k = 0; k < maps.size(); ++k)
        paged.push_back(paged_map(maps[k].name, chosen[k], options, [](const std::string&) {}));
    formats::make_folder_of(output);
    StagingFolder staging(output);
    write_touch_page(paged, output, options, staging);
    staging.publish();
}

}  // namespace dgm::exporter
