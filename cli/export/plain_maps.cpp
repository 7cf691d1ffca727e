// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/plain_maps.cpp
// [sRGB] IEC 61966-2-1:1999, the transfer function between 8-bit codes and linear light.
#include "export/plain_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "export/resample_plane.h"
#include "export/staging_folder.h"
#include "exr/exr_image.h"
#include "files/whole_file.h"
#include "image/image.h"
#include "math/portable.h"
#include "model/codes.h"
#include "model/element.h"
#include "model/layer_names.h"
#include "model/octahedral.h"
#include "render/chart_surface.h"

namespace dgm::exporter {
namespace {

namespace layers = model::layers;
using Json = nlohmann::ordered_json;
using model::Chart;
using model::Layer;

/// Beyond this many diagonals from the origin, single precision loses more than 1e-5 of the shape: positions are then
/// written relative to the chart's offset.
constexpr double kFarDiagonals = 64;

double light_of(std::uint8_t code) {
    const double s = code / 255.0;
    return s <= 0.04045 ? s / 12.92 : math::pow((s + 0.055) / 1.055, 2.4);
}
std::uint8_t code_of_unit(double unit) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(unit, 0.0, 1.0) * 255));
}
std::uint8_t code_of_light(double light) {
    return code_of_unit(light <= 0.0031308 ? light * 12.92 : 1.055 * math::pow(light, 1 / 2.4) - 0.055);
}

/// A layer's numbers; `channels` of them from number `first` of each sample's `stride`.
Plane plane_of(const Layer& layer, std::uint32_t first, std::uint32_t channels, std::uint32_t stride) {
    const bool fits = layer.shape.size() == (stride == 1 ? 2u : 3u) && (stride == 1 || layer.shape[2] == stride);
    if (!fits)
        throw model::Error(model::codes::kBadLayerShape, "a layer of shape " + model::shape_text(layer.shape),
                           layer.name);
    Plane out{static_cast<std::uint32_t>(layer.shape[1]), static_cast<std::uint32_t>(layer.shape[0]), channels, {}};
    out.values.reserve(out.pixels() * channels);
    for (std::size_t k = 0; k < out.pixels(); ++k)
        for (std::uint32_t c = 0; c < channels; ++c)
            out.values.push_back(model::element_value(layer, k * stride + first + c));
    return out;
}

std::array<double, 3> origin_of(const Chart& chart) {
    double diagonal = 0, farthest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        diagonal = math::hypot(diagonal, chart.bbox[k + 3] - chart.bbox[k]);
        farthest = std::max({farthest, std::abs(chart.bbox[k]), std::abs(chart.bbox[k + 3])});
    }
    return farthest > kFarDiagonals * diagonal ? chart.offset : std::array<double, 3>{};
}

Plane normals_of(const Layer& layer) {
    const Plane codes = plane_of(layer, 0, 2, 2);
    Plane out{codes.width, codes.height, 3, {}};
    for (std::size_t k = 0; k < codes.pixels(); ++k)
        for (const float n : dgm::decode_octahedral(static_cast<std::int16_t>(codes.values[2 * k]),
                                                    static_cast<std::int16_t>(codes.values[2 * k + 1])))
            out.values.push_back(static_cast<double>(n));
    return out;
}

/// Description of a map, for its row of the JSON.
struct MapText {
    const char *name, *unit, *meaning;
};

/// The maps of one chart.
class ChartMaps {
 public:
    ChartMaps(const Chart& chart, std::string prefix, bool power_of_two, StagingFolder& staging)
        : chart_(chart), prefix_(std::move(prefix)), staging_(staging) {
        const auto side = [&](std::uint32_t samples) { return power_of_two ? std::bit_ceil(samples) : samples; };
        width_ = side(chart.cols);
        height_ = side(chart.rows);
        if (const Layer* mask = chart.find(layers::kMask)) {
            on_surface_ = plane_of(*mask, 0, 1, 1);
            if (on_surface_.width != chart.cols || on_surface_.height != chart.rows) refuse_size(layers::kMask);
        }
    }

    /// Writes all maps; their rows of the JSON.
    Json write(std::size_t number) {
        write_positions();
        if (const Layer* normal = chart_.find(layers::kNormal)) write_normals(*normal);
        write_numbers(layers::kDeformation, 4, 0, 3,
                      {"metric", "source units squared", "E, F, G of one grid step in R, G, B"});
        write_numbers(layers::kDeformation, 4, 3, 1, {"stiffness", "0..1", "factor of the stiffness"});
        write_numbers(layers::kContact, 2, 0, 1, {"contact_area", "source units squared", "area of a sample"});
        write_numbers(layers::kContact, 2, 1, 1, {"mobility", "0..1", "0 attached, 1 free"});
        write_numbers(layers::kCover, 1, 0, 1, {"cover", "source units", "reach of a sample's quads"});
        if (const Layer* bump = chart_.find(layers::kBump)) write_bump(*bump);
        if (const Layer* texture = chart_.find(layers::kTexture); texture != nullptr) write_texture();
        if (!on_surface_.values.empty()) write_mask();
        Json out{{"chart", number}, {"width", width_}, {"height", height_}};
        out["grid"] = {{"rows", chart_.rows}, {"cols", chart_.cols}};
        out["resampled"] = width_ != chart_.cols || height_ != chart_.rows;
        out["domain"] = chart_.domain == model::Domain::kFree ? "free" : "square";
        out["origin"] = origin_of(chart_);
        out["bbox"] = {{"min", {chart_.bbox[0], chart_.bbox[1], chart_.bbox[2]}},
                       {"max", {chart_.bbox[3], chart_.bbox[4], chart_.bbox[5]}}};
        out["maps"] = std::move(rows_);
        return out;
    }

 private:
    [[noreturn]] static void refuse_size(const char* layer) {
        throw model::Error(model::codes::kBadLayerShape, "the layer has not the size of the grid", layer);
    }

    [[nodiscard]] Plane in_size(const Plane& plane, const Plane& weights) const {
        return resampled(plane, weights, width_, height_);
    }
    [[nodiscard]] Plane on_grid(const Plane& plane, const char* layer) const {
        if (plane.width != chart_.cols || plane.height != chart_.rows) refuse_size(layer);
        return in_size(plane, on_surface_);
    }

    /// 1 where every sample that a pixel reads is on the surface, else 0.
    [[nodiscard]] std::vector<double> coverage() const {
        if (on_surface_.values.empty()) return std::vector<double>(std::size_t{width_} * height_, 1.0);
        std::vector<double> out = in_size(on_surface_, {}).values;
        for (double& covered : out) covered = covered > 1 - 1e-9 ? 1 : 0;
        return out;
    }

    /// Ranges are those of pixels on the surface.
    void add_row(const MapText& text, const std::string& file, const std::string& channels, const Plane& plane,
                 const std::vector<double>& covered) {
        Json row{{"name", text.name}, {"file", file}, {"channels", channels}};
        row["width"] = plane.width, row["height"] = plane.height;
        row["unit"] = text.unit, row["meaning"] = text.meaning;
        Json least = Json::array(), most = Json::array();
        for (std::uint32_t c = 0; c < plane.channels; ++c) {
            float low = INFINITY, high = -INFINITY;
            for (std::size_t k = 0; k < plane.pixels(); ++k) {
                if (!covered.empty() && covered[k] == 0) continue;
                low = std::min(low, static_cast<float>(plane.values[k * plane.channels + c]));
                high = std::max(high, static_cast<float>(plane.values[k * plane.channels + c]));
            }
            least.push_back(low <= high ? low : 0), most.push_back(low <= high ? high : 0);
        }
        row["min"] = std::move(least), row["max"] = std::move(most);
        rows_.push_back(std::move(row));
    }

    /// Single numbers are gray: loaders of engines want R, G and B.
    void write_exr(const MapText& text, const Plane& plane, const std::vector<double>& covered) {
        const char* channels = plane.channels == 4 ? "RGBA" : "RGB";
        const std::size_t copies = plane.channels == 1 ? 3 : 1;
        const std::string file = prefix_ + text.name + ".exr";
        std::vector<float> pixels;
        pixels.reserve(plane.values.size() * copies);
        for (const double value : plane.values) pixels.insert(pixels.end(), copies, static_cast<float>(value));
        formats::write_exr_image(staging_.add(file), plane.width, plane.height, channels, pixels);
        add_row(text, file, channels, plane, covered);
    }

    /// Zero outside the surface, where the numbers of a file have no meaning.
    static void clear_uncovered(Plane& plane, const std::vector<double>& covered) {
        for (std::size_t k = 0; k < plane.pixels(); ++k)
            if (covered[k] == 0)
                std::fill_n(plane.values.begin() + static_cast<std::ptrdiff_t>(k * plane.channels), plane.channels,
                            0.0);
    }

    void write_positions() {
        const Layer* geometry = chart_.find(layers::kGeometry);
        if (geometry == nullptr) throw model::Error(model::codes::kMissingLayer, "the chart has no positions", "");
        Plane stored = plane_of(*geometry, 0, 3, 3);
        const std::array<double, 3> origin = origin_of(chart_);
        for (std::size_t k = 0; k < stored.values.size(); ++k)
            stored.values[k] = (chart_.offset[k % 3] - origin[k % 3]) + chart_.scale[k % 3] * stored.values[k];
        const Plane position = on_grid(stored, layers::kGeometry);
        const std::vector<double> covered = coverage();
        Plane out{width_, height_, 4, {}};
        for (std::size_t k = 0; k < out.pixels(); ++k) {
            for (std::size_t c = 0; c < 3; ++c) out.values.push_back(position.values[3 * k + c]);
            out.values.push_back(covered[k]);
        }
        clear_uncovered(out, covered);
        write_exr({"position", "source units", "x, y, z minus origin in R, G, B; A is 1 on the surface, else 0"}, out,
                  covered);
    }

    void write_normals(const Layer& layer) {
        Plane normals = on_grid(normals_of(layer), layers::kNormal);
        for (std::size_t k = 0; k < normals.pixels(); ++k) {
            double* n = normals.values.data() + 3 * k;
            const double length = math::hypot(n[0], n[1], n[2]);
            const bool is_new = width_ != chart_.cols || height_ != chart_.rows;
            for (std::size_t c = 0; is_new && length > 0 && c < 3; ++c) n[c] /= length;
        }
        const std::vector<double> covered = coverage();
        clear_uncovered(normals, covered);
        write_exr({"normal", "1", "x, y, z of the unit normal in object space, -1..1"}, normals, covered);
    }

    void write_numbers(const char* name, std::uint32_t stride, std::uint32_t first, std::uint32_t channels,
                       const MapText& text) {
        const Layer* layer = chart_.find(name);
        if (layer == nullptr) return;
        Plane plane = on_grid(plane_of(*layer, first, channels, stride), name);
        const std::vector<double> covered = coverage();
        clear_uncovered(plane, covered);
        write_exr(text, plane, covered);
    }

    void write_bump(const Layer& layer) {
        Plane heights = plane_of(layer, 0, 1, 1);
        const auto scale = layer.attributes.find("scale");
        if (scale != layer.attributes.end())
            if (const auto* factor = std::get_if<std::vector<double>>(&scale->second); factor && factor->size() == 1)
                for (double& height : heights.values) height *= factor->front();
        const char* meaning = "signed height along the normal";
        write_exr({"bump", "source units", meaning}, in_size(heights, {}), coverage());
        if (heights.width != width_ || heights.height != height_)
            write_exr({"bump_full", "source units", meaning}, heights, {});
    }

    void write_picture(const MapText& text, const formats::Image& image, const std::string& channels) {
        const std::string file = prefix_ + text.name + ".png";
        formats::write_png(staging_.add(file), image);
        Json row{{"name", text.name}, {"file", file}, {"channels", channels}};
        row["width"] = image.width, row["height"] = image.height;
        row["unit"] = text.unit, row["meaning"] = text.meaning;
        rows_.push_back(std::move(row));
    }

    void write_texture() {
        const formats::Image image = render::texture_picture(chart_);
        const MapText text{"texture", "8-bit code", "colour, sRGB; alpha is straight"};
        if (image.width == width_ && image.height == height_) return write_picture(text, image, "RGBA");
        Plane light{image.width, image.height, 4, {}};
        for (const model::Rgba8& p : image.pixels)
            light.values.insert(light.values.end(), {light_of(p.r), light_of(p.g), light_of(p.b), p.a / 255.0});
        const Plane small = in_size(light, {});
        formats::Image out{width_, height_, {}};
        for (std::size_t k = 0; k < small.pixels(); ++k) {
            const double* p = small.values.data() + 4 * k;
            out.pixels.push_back({code_of_light(p[0]), code_of_light(p[1]), code_of_light(p[2]), code_of_unit(p[3])});
        }
        write_picture(text, out, "RGBA");
        write_picture({"texture_full", text.unit, text.meaning}, image, "RGBA");
    }

    void write_mask() {
        formats::Image image{width_, height_, {}};
        for (const double covered : coverage()) {
            const std::uint8_t gray = covered == 0 ? 0 : 255;
            image.pixels.push_back({gray, gray, gray, 255});
        }
        write_picture({"mask", "8-bit code", "255 on the surface, else 0"}, image, "RGBA");
    }

    const Chart& chart_;
    std::string prefix_;
    StagingFolder& staging_;
    std::uint32_t width_ = 0, height_ = 0;
    Plane on_surface_;  ///< empty in the square domain
    Json rows_ = Json::array();
};

Json head_of(const model::MapSet& maps) {
    Json out{{"format", "dgm-maps"}, {"version", 1}, {"generator", maps.generator}, {"source", maps.source_name}};
    out["pixels"] =
        "pixel (x, y), row 0 at the top, is the sample of row u = y / (height - 1) and column v = x / (width "
        "- 1); corner pixels are corner samples. A texture unit reads it at ((x + 0.5) / width, (y + 0.5) / "
        "height) from the top left";
    out["positions"] = "origin + (R, G, B) of the map position, in units and axes of the source";
    out["resampling"] = "tent filter with corners on corners; light for colours; normals made unit vectors again";
    return out;
}

}  // namespace

void export_plain_maps(const model::MapSet& maps, const std::filesystem::path& folder, const std::string& stem,
                       const PlainMapOptions& options) {
    if (options.chart && *options.chart >= maps.charts.size())
        throw model::Error(model::codes::kUsage, fmt::format("there is no chart {}; the file has {}, counted from 0",
                                                             *options.chart, maps.charts.size()));
    if (maps.charts.empty()) throw model::Error(model::codes::kMissingLayer, "the file has no charts");
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw model::Error(model::codes::kWriteFailed, "the folder cannot be made: " + error.message(),
                           folder.string());
    const std::filesystem::path index = stem + "_maps.json";
    StagingFolder staging(folder / index);
    Json json = head_of(maps);
    json["charts"] = Json::array();
    for (std::size_t k = 0; k < maps.charts.size(); ++k) {
        if (options.chart && *options.chart != k) continue;
        const std::string prefix = stem + (maps.charts.size() > 1 ? fmt::format("_chart{}_", k) : "_");
        json["charts"].push_back(ChartMaps(maps.charts[k], prefix, options.power_of_two, staging).write(k));
    }
    formats::write_whole_file(staging.add(index), json.dump(1) + "\n", folder / index);
    staging.publish();
}

}  // namespace dgm::exporter
