// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/pictures.cpp
#include "render/pictures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/spatial/closest_point.h"
#include "model/codes.h"
#include "model/element.h"
#include "render/canvas.h"
#include "render/layer_picture.h"
#include "render/layer_values.h"
#include "render/percentile.h"

namespace dgm::render {
namespace {
using formats::Image;
using model::Rgba8;
using model::TriMesh;
using model::Vec3d;

constexpr Rgba8 kGridColour{70, 74, 84, 255}, kSeamColour{214, 30, 36, 255}, kBorderColour{24, 88, 196, 255};
constexpr Rgba8 kBare{222, 219, 213, 255};

double diagonal_of(const TriMesh& mesh) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face) {
            const Vec3d& p = mesh.positions[v];
            if (!is_finite(p)) continue;
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], p[k]);
                high[k] = std::max(high[k], p[k]);
            }
        }
    return low.x <= high.x ? length(high - low) : 0;
}

/// Positions that faces use: strays must not decide the frame.
std::vector<Vec3d> shown_points(const TriMesh& mesh) {
    std::vector<bool> used(mesh.positions.size(), false);
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face) used[v] = true;
    std::vector<Vec3d> points;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) points.push_back(mesh.positions[v]);
    return points;
}

View view_of(const TriMesh& mesh, const PictureOptions& options) {
    return options.view ? *options.view : choose_view(mesh, options.up);
}

RenderOptions render_options(const PictureOptions& options, std::uint32_t width, std::uint32_t height) {
    RenderOptions out;
    out.width = width;
    out.height = height;
    out.samples_per_pixel = options.samples_per_pixel;
    out.background = kPaper;
    return out;
}

Surface textured(const ChartSurface& charts) {
    Surface surface;
    surface.mesh = &charts.mesh;
    surface.textures = charts.textures;
    return surface;
}

Surface with_grid(const ChartSurface& charts, double pixel) {
    Surface surface;
    surface.mesh = &charts.mesh;
    surface.plain = kBare;
    surface.only_plain = true;
    add_segments(surface, charts.grid, kGridColour, 0.55 * pixel);
    add_segments(surface, charts.borders, kBorderColour, 1.7 * pixel);
    add_segments(surface, charts.seams, kSeamColour, 1.7 * pixel);
    return surface;
}

/// Error at every vertex in % of the diagonal: the largest distance to the source among the middles of its faces. The
/// vertices themselves would show nothing, since a bake puts them on the source. 0 for vertices that no face uses.
std::vector<double> face_errors(const TriMesh& source, const TriMesh& mesh, double diagonal) {
    const bake::ClosestPointIndex index(source.positions, source.faces);
    std::vector<double> middle(mesh.faces.size(), 0), out(mesh.positions.size(), 0);
    tbb::parallel_for(std::size_t{0}, middle.size(), [&](std::size_t f) {
        const auto q = mesh.corners(f);
        middle[f] = 100 * index.query((q[0] + q[1] + q[2]) / 3).distance / diagonal;
    });
    for (std::size_t f = 0; f < middle.size(); ++f)
        for (const std::uint32_t v : mesh.faces[f]) out[v] = std::max(out[v], middle[f]);
    return out;
}

/// A text wider than `width` in two lines, if it has a comma to break at.
std::vector<std::string> broken(const std::string& text, std::uint32_t width, std::uint32_t scale) {
    constexpr std::string_view kBreak = ", ";
    const std::size_t comma = text.rfind(kBreak);
    if (text_width(text, scale) <= width || comma == std::string::npos) return {text};
    return {text.substr(0, comma), text.substr(comma + kBreak.size())};
}
}  // namespace

Image surface_picture(const ChartSurface& charts, const PictureOptions& options) {
    const Camera camera =
        fit_camera(shown_points(charts.mesh), view_of(charts.mesh, options), options.width, options.height);
    return render_mesh(textured(charts), camera, render_options(options, options.width, options.height));
}

Image comparison_picture(const TriMesh& source, std::vector<Image> source_textures, const ChartSurface& charts,
                         const PictureOptions& options) {
    const std::uint32_t columns = options.width > 2 * std::uint64_t{options.height} ? 4 : 2, lines = 4 / columns;
    if (options.width < 320 || options.height < 160)
        throw model::Error(model::codes::kTooLarge,
                           fmt::format("four panels do not fit into {} x {} pixels; take 320x160 or more",
                                       options.width, options.height))
            .with_hint("ask for a larger --size");
    const double diagonal = diagonal_of(source);
    if (!(diagonal > 0)) throw model::Error(model::codes::kNoFaces, "the source has no surface to compare with");
    Image sheet = blank(options.width, options.height);
    const std::uint32_t cell_width = options.width / columns, cell_height = options.height / lines;
    const std::uint32_t scale = std::max(1u, std::min(cell_width / 220, cell_height / 180));
    const std::uint32_t caption = 14 * scale, panel_height = cell_height - caption;

    std::vector<Vec3d> shown = shown_points(source);
    for (const Vec3d& p : shown_points(charts.mesh)) shown.push_back(p);
    const Camera camera = fit_camera(shown, view_of(source, options), cell_width, panel_height);
    const double pixel = diagonal / std::min(cell_width, panel_height);

    Surface first;
    first.mesh = &source;
    first.textures = std::move(source_textures);
    Surface heat;
    heat.mesh = &charts.mesh;
    heat.scalars = face_errors(source, charts.mesh, diagonal);
    const double worst = *std::max_element(heat.scalars.begin(), heat.scalars.end());
    heat.scalar_high = percentile(heat.scalars, 0.99);
    constexpr double kRounding = 1e-9;  // %; below it there is no error to show, only the last bits
    heat.scalar_high = std::max(heat.scalar_high, kRounding);

    const std::pair<Surface, std::string> panels[] = {
        {std::move(first), fmt::format("source, {} faces", source.faces.size())},
        {textured(charts), fmt::format("reconstruction, {} triangles", charts.mesh.faces.size())},
        {with_grid(charts, pixel), charts.seams.empty() ? "grid and border" : "grid and seam"},
        {std::move(heat), fmt::format("error, % of diagonal (max {:.2g})", worst)}};
    for (std::uint32_t k = 0; k < 4; ++k) {
        const Surface& surface = panels[k].first;
        const bool is_map = !surface.scalars.empty();
        RenderOptions render = render_options(options, cell_width, panel_height);
        if (is_map) render.shading = 0.35;
        const std::int64_t x = std::int64_t{k % columns} * cell_width, y = std::int64_t{k / columns} * cell_height;
        paste(sheet, render_mesh(surface, camera, render), x, y);
        if (is_map) {
            const std::uint32_t bar = cell_width * 2 / 5;
            draw_legend(sheet, x + cell_width - bar - 8 * scale, y + 6 * scale, bar, 6 * scale, surface.scalar_low,
                        surface.scalar_high, worst > surface.scalar_high, scale);
        }
        draw_text_centred(sheet, x + cell_width / 2, y + panel_height + 3 * scale, panels[k].second, scale);
    }
    return sheet;
}

Image contact_sheet(const model::Chart& chart, const std::string& title, const PictureOptions& options) {
    constexpr std::uint32_t kColumns = 4, kScale = 2, kGap = 20, kCaption = 4 * 9 * kScale + 14;
    const std::uint32_t side =
        std::clamp((options.width - std::min(options.width, (kColumns + 1) * kGap)) / kColumns, 120u, 2048u);
    struct Cell {
        Image image;
        std::string name, shape, note;
    };
    std::vector<Cell> cells;
    PictureOptions view = options;
    view.width = view.height = side;
    const ChartSurface surface = chart_surface({&chart, 1});
    cells.push_back({surface_picture(surface, view), "reconstruction",
                     fmt::format("{} triangles", surface.mesh.faces.size()), fmt::format("method {}", chart.method)});
    for (const model::Layer& layer : chart.layers) {
        LayerPicture picture;
        try {
            picture = layer_picture(chart, layer.name);
        } catch (const model::Error& error) {
            if (&error.code() != &model::codes::kUnsupported) throw;
            continue;  // a layer of a newer format, say: the sheet shows the known ones
        }
        cells.push_back({fitted(picture.image, side, side), layer.name,
                         fmt::format("{} {}", model::shape_text(layer.shape), model::type_name(layer.type)),
                         picture.note});
    }
    const auto lines = static_cast<std::uint32_t>((cells.size() + kColumns - 1) / kColumns);
    const std::uint32_t head = 9 * kScale + 2 * kGap;
    Image sheet = blank(kColumns * side + (kColumns + 1) * kGap, head + lines * (side + kCaption + kGap));
    draw_text(sheet, kGap, kGap, title, kScale);
    for (std::uint32_t k = 0; k < cells.size(); ++k) {
        const Cell& cell = cells[k];
        const std::int64_t x = kGap + std::int64_t{k % kColumns} * (side + kGap);
        const std::int64_t y = head + std::int64_t{k / kColumns} * (side + kCaption + kGap);
        paste(sheet, cell.image, x + (side - cell.image.width) / 2, y + (side - cell.image.height) / 2);
        std::int64_t line = y + side + 8;
        std::vector<std::string> texts{cell.name, cell.shape};
        for (std::string& part : broken(cell.note, side, kScale)) texts.push_back(std::move(part));
        for (std::size_t t = 0; t < texts.size(); ++t) {
            const std::uint32_t fit = text_width(texts[t], kScale) <= side ? kScale : 1;
            draw_text(sheet, x, line, texts[t], fit, t == 0 ? kInk : Rgba8{120, 122, 128, 255});
            line += 9 * kScale + 2;
        }
    }
    return sheet;
}

}  // namespace dgm::render
