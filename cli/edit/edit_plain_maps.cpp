// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_plain_maps.cpp
// The map's own plain maps are written anew, by the code that writes them for dgm-export, and each picture is compared
// with its counterpart: so every map can be judged, whether its numbers can be put back or not.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "edit/edit_sources.h"
#include "export/plain_maps.h"
#include "exr/exr_planes.h"
#include "files/temporary_folder.h"
#include "image/image.h"
#include "model/codes.h"
#include "model/layer_names.h"
#include "process/json_apart.h"

namespace dgm::edit {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
namespace layers = model::layers;
using Json = nlohmann::json;

constexpr std::string_view kIndexEnd = "_maps.json";
constexpr std::uintmax_t kMostIndexBytes = std::uintmax_t{256} << 20;

/// The number of a layer that a map shows.
struct MapMeaning {
    std::string_view map, layer;
    std::uint32_t first;
};
constexpr std::array kMeanings{
    MapMeaning{"position", layers::kGeometry, 0},    MapMeaning{"normal", layers::kNormal, 0},
    MapMeaning{"metric", layers::kDeformation, 0},   MapMeaning{"stiffness", layers::kDeformation, 3},
    MapMeaning{"contact_area", layers::kContact, 0}, MapMeaning{"mobility", layers::kContact, 1},
    MapMeaning{"cover", layers::kCover, 0},          MapMeaning{"bump", layers::kBump, 0},
    MapMeaning{"bump_full", layers::kBump, 0},       MapMeaning{"texture", layers::kTexture, 0},
    MapMeaning{"texture_full", layers::kTexture, 0}, MapMeaning{"mask", layers::kMask, 0}};

[[noreturn]] void unrelated(const std::string& message, const fs::path& path, const std::string& hint = {}) {
    throw model::Error(codes::kEditUnrelated, message, path.string()).with_hint(hint);
}

/// Numbers of a picture, as they are there: of a PNG 0..1.
struct Picture {
    std::uint32_t width = 0, height = 0, channels = 1;
    unsigned steps = 0;  ///< codes of a PNG but one; 0 of an EXR
    bool is_half = false;
    std::vector<float> pixels;
    [[nodiscard]] float at(std::size_t pixel, std::uint32_t channel) const {
        return pixels[pixel * channels + std::min(channel, channels - 1)];
    }
};

Picture read_colours(const fs::path& path) {
    const formats::Image image = formats::read_image({path});
    Picture out{image.width, image.height, 4, 255, false, {}};
    for (const model::Rgba8& p : image.pixels)
        for (const std::uint8_t code : {p.r, p.g, p.b, p.a}) out.pixels.push_back(static_cast<float>(code) / 255.0f);
    return out;
}

Picture read_picture(const fs::path& path, bool single) {
    if (path.extension() == ".exr") {
        formats::ExrPicture exr = formats::read_exr_picture(path);
        return {exr.width, exr.height, exr.channels, 0, exr.is_half, std::move(exr.pixels)};
    }
    if (!single || formats::image_bits({path}) == 8) return read_colours(path);
    formats::FloatImage gray = formats::read_height({path});
    return {gray.width, gray.height, 1, 65535, false, std::move(gray.pixels)};
}

/// One number is meant: R, G and B are alike, to what rounding does.
void check_gray(const Picture& picture, const fs::path& path) {
    constexpr float kAlike = 1e-3f;
    if (picture.channels < 3) return;
    for (std::size_t k = 0; k < std::size_t{picture.width} * picture.height; ++k) {
        const auto [low, high] = std::minmax({picture.at(k, 0), picture.at(k, 1), picture.at(k, 2)});
        if (high - low > kAlike * std::max(1.0f, std::abs(high)))
            unrelated(
                fmt::format("the pixel at x {}, y {} has a colour: R {:.4g}, G {:.4g}, B {:.4g}, where one number "
                            "is meant",
                            k % picture.width, k / picture.width, picture.at(k, 0), picture.at(k, 1), picture.at(k, 2)),
                path, "paint this map in gray");
    }
}

Json read_index(const fs::path& path) {
    Json json;
    try {
        json = bake::read_json(path, kMostIndexBytes);
    } catch (const model::Error& error) {
        if (error.code().number != codes::kReportUnreadable.number) throw;
    }
    if (!json.is_object() || json.value("format", Json()) != "dgm-maps" || !json.value("charts", Json()).is_array())
        unrelated("it is no description of plain maps", path, "name the folder that dgm-export --maps wrote");
    return json;
}

/// Whether a JSON of plain maps has a file of this stem.
bool lists(const Json& index, const std::string& stem) {
    for (const Json& chart : index["charts"])
        if (chart.is_object() && chart.value("maps", Json()).is_array())
            for (const Json& row : chart["maps"])
                if (row.is_object() && row.value("file", Json()).is_string() &&
                    fs::path(row["file"].get<std::string>()).stem() == stem)
                    return true;
    return false;
}

std::vector<fs::path> indices_in(const fs::path& folder) {
    std::vector<fs::path> out;
    std::error_code error;
    for (fs::directory_iterator it(folder.empty() ? "." : folder, error), end; !error && it != end; it.increment(error))
        if (it->path().filename().string().ends_with(kIndexEnd)) out.push_back(it->path());
    std::sort(out.begin(), out.end());
    return out;
}

/// The JSON beside a picture that lists it.
std::optional<fs::path> index_of(const fs::path& picture) {
    for (const fs::path& index : indices_in(picture.parent_path())) try {
            if (lists(read_index(index), picture.stem().string())) return index;
        } catch (const model::Error&) {}  // no index of ours
    return std::nullopt;
}

/// What a picture's codes stand for. @throws model::Error kEditUnrelated
Rounding rounding_of(const Picture& picture, const Json& row, std::uint32_t channel, const fs::path& path) {
    if (picture.steps == 0) return picture.is_half ? Rounding::half() : Rounding::exact();
    const std::string unit = row.value("unit", Json("")).is_string() ? row.value("unit", "") : "";
    if (unit == "0..1" || unit == "8-bit code") return Rounding::codes(0, 1, picture.steps);
    const auto limit = [&](const char* key) -> double {
        const Json list = row.value(key, Json());
        if (!list.is_array() || list.empty()) unrelated(fmt::format("its row of the JSON has no \"{}\"", key), path);
        const Json& value = list[std::min<std::size_t>(channel, list.size() - 1)];
        if (!value.is_number()) unrelated(fmt::format("\"{}\" of its row of the JSON is no number", key), path);
        return value.get<double>();
    };
    return Rounding::codes(limit("min"), limit("max"), picture.steps);
}

/// One row of the JSON: the picture, and the one that the map gives.
class PlainMap {
 public:
    PlainMap(PaintedMap& map, std::size_t chart, const Json& row, const fs::path& folder, const fs::path& own)
        : map_(map), chart_(chart), row_(row), folder_(folder), own_(own) {}

    void offer() {
        const std::string name = row_.value("name", "");
        const auto* meaning = std::find_if(kMeanings.begin(), kMeanings.end(),
                                           [&](const MapMeaning& known) { return known.map == name; });
        if (meaning == kMeanings.end()) return;
        const model::Chart& chart = map_.original().charts[chart_];
        const model::Layer* layer = chart.find(meaning->layer);
        const std::optional<fs::path> painted = find();
        if (layer == nullptr || !painted) return;
        PartEdit* edit =
            map_.edit_of(chart_, static_cast<std::size_t>(layer - chart.layers.data()), meaning->first, *painted);
        if (edit == nullptr) return;
        const fs::path reference_file = own_ / fs::path(row_.value("file", "")).filename();
        std::error_code error;
        if (!fs::exists(reference_file, error))
            unrelated("the map has no such picture now", *painted, "export the map again");
        const bool single = edit->part.count == 1 && name != "mask";
        const Picture reference = read_picture(reference_file, single), picture = read_picture(*painted, single);
        if (picture.width != reference.width || picture.height != reference.height)
            unrelated(fmt::format("it is {} x {} pixels, the map gives {} x {}", picture.width, picture.height,
                                  reference.width, reference.height),
                      *painted, "save it in the size it had");
        if (single) check_gray(picture, *painted);
        compare(*edit, *layer, meaning->first, reference, picture, *painted);
    }

 private:
    /// The painter's file: as it is called in the JSON, or with another ending.
    [[nodiscard]] std::optional<fs::path> find() const {
        const fs::path named = fs::path(row_.value("file", "")).filename();  // a name must not lead elsewhere
        std::vector<fs::path> found;
        std::error_code error;
        for (const char* ending : {".exr", ".png"}) {
            const fs::path file = folder_ / fs::path(named).replace_extension(ending);
            if (!named.empty() && fs::is_regular_file(file, error)) found.push_back(file);
        }
        if (found.size() > 1)
            throw model::Error(codes::kUsage,
                               fmt::format("{} and {} are both there; keep the one that was painted",
                                           found[0].filename().string(), found[1].filename().string()),
                               folder_.string());
        if (found.empty()) return std::nullopt;
        return found[0];
    }

    void compare(PartEdit& edit, const model::Layer& layer, std::uint32_t first, const Picture& reference,
                 const Picture& picture, const fs::path& path) {
        const bool fits =
            layer.shape.size() >= 2 && layer.shape[0] == picture.height && layer.shape[1] == picture.width;
        const bool is_colour = edit.part.layer == layers::kTexture;
        if (is_colour && picture.steps != 255)
            unrelated("a texture is a PNG of 8 bits", path, "save it as PNG, in sRGB, 8 bits a channel");
        const bool shows_numbers = fits && edit.part.is_editable;
        const double scale = is_colour ? 255 : 1 / std::max(unit_of(layer), 1e-300);
        const std::uint32_t channels = edit.part.count == 1 ? 1 : std::min(reference.channels, 4u);
        for (std::uint32_t c = 0; c < channels; ++c) {
            const Rounding rounding = rounding_of(picture, row_, c, path);
            for (std::size_t k = 0; k < std::size_t{picture.width} * picture.height; ++k) {
                const double before = static_cast<double>(reference.at(k, c)),
                             now = rounding.value_of(static_cast<double>(picture.at(k, c)));
                if (is_untouched(before, now, rounding) || is_unseen(is_colour, reference, picture, k)) continue;
                if (!fits && edit.part.is_editable) refuse_resampled(edit, path);
                if (shows_numbers)
                    map_.put(edit, first + c, k, now * scale);
                else
                    map_.note(edit, std::min(k, edit.changed.size() - 1), now - before);
            }
        }
    }

    /// Painters change the colour of what is transparent before and after.
    [[nodiscard]] static bool is_unseen(bool is_colour, const Picture& reference, const Picture& picture,
                                        std::size_t k) {
        return is_colour && reference.at(k, 3) == 0 && picture.channels == 4 && picture.at(k, 3) == 0;
    }
    [[noreturn]] static void refuse_resampled(const PartEdit& edit, const fs::path& path) {
        unrelated(
            fmt::format("{} was painted in another size than the layer has, and cannot be put back", edit.part.name),
            path, "paint the picture whose name ends in _full, or maps that were exported without --power-of-two");
    }

    PaintedMap& map_;
    std::size_t chart_;
    const Json& row_;
    const fs::path &folder_, &own_;
};

/// Which chart of the map a JSON's entry is about. @throws model::Error kEditUnrelated
std::size_t chart_of(const Json& entry, const model::MapSet& maps, const fs::path& index) {
    const auto number = [&](const Json& from, const char* key) -> std::size_t {
        const Json value = from.is_object() ? from.value(key, Json()) : Json();
        if (!value.is_number_unsigned()) unrelated(fmt::format("an entry has no \"{}\"", key), index);
        return value.get<std::size_t>();
    };
    const std::size_t chart = number(entry, "chart");
    if (chart >= maps.charts.size())
        unrelated(fmt::format("it has a chart {}, the map has {}", chart, maps.charts.size()), index);
    const Json grid = entry.value("grid", Json());
    const std::size_t rows = number(grid, "rows"), cols = number(grid, "cols");
    if (rows != maps.charts[chart].rows || cols != maps.charts[chart].cols)
        unrelated(fmt::format("chart {} is {} x {}, the map's {} x {}", chart, rows, cols, maps.charts[chart].rows,
                              maps.charts[chart].cols),
                  index);
    if (!entry.value("maps", Json()).is_array()) unrelated("an entry has no \"maps\"", index);
    return chart;
}

/// The JSON to go by, and the picture that was named, if one was.
struct Named {
    fs::path index;
    std::string stem;
};
Named find_index(const fs::path& maps) {
    std::error_code error;
    if (!fs::is_directory(maps, error)) {
        if (maps.extension() == ".json") return {maps, ""};
        const std::optional<fs::path> index = index_of(maps);
        if (!index) unrelated("no maps.json beside it lists it", maps);
        return {*index, maps.stem().string()};
    }
    const std::vector<fs::path> found = indices_in(maps);
    if (found.empty())
        unrelated("the folder has no maps.json", maps, "name a folder that dgm-export --maps wrote, with its JSON");
    if (found.size() > 1)
        throw model::Error(codes::kUsage,
                           fmt::format("the folder has maps of several assets; name one of: {}, {}",
                                       found[0].filename().string(), found[1].filename().string()),
                           maps.string());
    return {found[0], ""};
}

}  // namespace

bool is_plain_map(const fs::path& picture) {
    return index_of(picture).has_value();
}

void offer_plain_maps(PaintedMap& map, const fs::path& maps) {
    const auto [index, only] = find_index(maps);
    const Json json = read_index(index);
    const std::string name = index.filename().string();
    if (!name.ends_with(kIndexEnd)) unrelated("its name does not end in _maps.json", index);
    const fs::path folder = index.parent_path();
    const formats::TemporaryFolder own("dgm-edit");
    const Json& entries = json["charts"];
    const bool power_of_two = std::any_of(entries.begin(), entries.end(), [](const Json& entry) {
        return entry.is_object() && entry.value("resampled", Json()) == true;
    });
    exporter::export_plain_maps(map.original(), own.path(), name.substr(0, name.size() - kIndexEnd.size()),
                                {.chart = std::nullopt, .power_of_two = power_of_two});
    for (const Json& entry : entries) {
        const std::size_t chart = chart_of(entry, map.original(), index);
        for (const Json& row : entry["maps"]) {
            if (!row.is_object() || !row.value("file", Json()).is_string() || !row.value("name", Json()).is_string())
                unrelated("a row has no \"name\" or \"file\"", index);
            if (!only.empty() && fs::path(row["file"].get<std::string>()).stem() != only) continue;
            PlainMap(map, chart, row, folder, own.path()).offer();
        }
    }
}

}  // namespace dgm::edit
