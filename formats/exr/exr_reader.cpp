// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_reader.cpp
#include "exr/exr_reader.h"

#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

#include "exr/exr_attributes.h"
#include "exr/exr_files.h"
#include "exr/exr_hash.h"
#include "exr/exr_headers.h"
#include "exr/exr_part.h"
#include "exr/exr_plan.h"
#include "exr/exr_reading.h"
#include "exr/exr_text.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Chart;
using model::Layer;
using model::MapSet;

/// A file whose headers were looked at, and how many bytes its pixels may become.
class OpenFile {
 public:
    OpenFile(const fs::path& path, const ExrReadLimits& limits)
        : budget_(exr_budget(path, limits)), file_(path.c_str(), 0, false) {
        if (file_.parts() < 1 || file_.parts() > limits.max_parts)
            throw model::Error(codes::kExrUnreadable, "impossible number of parts", path.string());
    }

    [[nodiscard]] const Imf::Header& header() const { return file_.header(0); }
    [[nodiscard]] std::uint64_t& budget() { return budget_; }
    Imf::MultiPartInputFile& pixels() { return file_; }

    /// By name; other programs drop names, but keep the order.
    [[nodiscard]] int part_of(const PlannedFile& plan, std::size_t number, const fs::path& path) const {
        const std::string& name = plan.parts[number].name;
        bool has_names = false;
        for (int k = 0; k < file_.parts(); ++k) {
            if (file_.header(k).hasName() && file_.header(k).name() == name) return k;
            has_names = has_names || (file_.header(k).hasName() && name_is_planned(plan, file_.header(k).name()));
        }
        if (has_names || file_.parts() != static_cast<int>(plan.parts.size()))
            throw model::Error(codes::kMissingChannel,
                               "no part " + name + ": the program that saved the file dropped it", path.string());
        return static_cast<int>(number);
    }

 private:
    static bool name_is_planned(const PlannedFile& plan, const std::string& name) {
        return std::any_of(plan.parts.begin(), plan.parts.end(),
                           [&](const PlannedPart& part) { return part.name == name; });
    }

    std::uint64_t budget_;
    Imf::MultiPartInputFile file_;
};

/// The attributes of the map's own file.
class Description {
 public:
    Description(const Imf::Header& header, const fs::path& path) : header_(header), path_(path) {}

    /// All but the layers' values; tables have theirs.
    MapSet read(std::uint64_t& budget) const {
        check_version();
        MapSet maps;
        maps.format_version = static_cast<std::uint32_t>(number(kFormatVersionAttribute));
        maps.generator = text(kGeneratorAttribute);
        maps.source_name = text(kSourceNameAttribute);
        maps.report_json = text(kReportAttribute);
        if (!parse_hex(text(kSourceHashAttribute), maps.source_hash) ||
            !parse_hex(text(kSettingsHashAttribute), maps.settings_hash))
            refuse("a hash in the header is not 32 hexadecimal digits");
        const int charts = number(kChartCountAttribute);
        if (charts < 0) refuse("impossible number of charts");
        for (int k = 0; k < charts; ++k) maps.charts.push_back(read_chart(static_cast<std::size_t>(k), budget));
        return maps;
    }

    [[nodiscard]] ExrLayout layout() const {
        const std::string& name = text(kLayoutNameAttribute);
        if (name != "auto" && name != "multipart") refuse("unknown layout " + name);
        return name == "auto" ? ExrLayout::kAuto : ExrLayout::kMultipart;
    }

    /// Hashes that another program dropped are not checked; where they are, they hold.
    void check_hashes(const MapSet& maps) const {
        for (std::size_t k = 0; k < maps.charts.size(); ++k)
            for (const Layer& layer : maps.charts[k].layers) {
                const std::string* hash = find_text(chart_attribute(k, "hash." + layer.name));
                if (hash != nullptr && *hash != exr_layer_hash(layer))
                    throw model::Error(codes::kHashMismatch, "the layer's values differ from their hash",
                                       "/charts/" + std::to_string(k) + "/" + layer.name);
            }
        const std::string* hash = find_text(kHeaderHashAttribute);
        if (hash != nullptr && *hash != exr_header_hash(maps))
            throw model::Error(codes::kHashMismatch, "header attributes differ from their hash", "/");
    }

 private:
    [[noreturn]] void refuse(const std::string& message) const {
        throw model::Error(codes::kExrUnreadable, message, path_.string());
    }

    template <class Attribute>
    const auto& value(const std::string& name) const {
        const auto* attribute = header_.findTypedAttribute<Attribute>(name);
        if (attribute == nullptr)
            refuse("no header attribute " + name +
                   ": the file was not written by dgm-bake or dgm-export, or another "
                   "program dropped the attribute");
        return attribute->value();
    }
    [[nodiscard]] int number(const std::string& name) const { return value<Imf::IntAttribute>(name); }
    [[nodiscard]] const std::string& text(const std::string& name) const { return value<Imf::StringAttribute>(name); }
    [[nodiscard]] const std::string* find_text(const std::string& name) const {
        const auto* attribute = header_.findTypedAttribute<Imf::StringAttribute>(name);
        return attribute == nullptr ? nullptr : &attribute->value();
    }

    void check_version() const {
        if (const std::string* side = find_text(kSideFileAttribute); side != nullptr)
            refuse("the file holds layers of a map that another file describes: read that one, without \"." + *side +
                   "\" in its name");
        const auto* version = header_.findTypedAttribute<Imf::IntAttribute>(kLayoutVersionAttribute);
        if (version == nullptr && header_.findTypedAttribute<Imf::IntAttribute>(kFormatVersionAttribute) != nullptr)
            refuse("the file is of EXR layout 1, which earlier versions wrote and this one does not read");
        const int layout = number(kLayoutVersionAttribute), format = number(kFormatVersionAttribute);
        if (layout > kExrLayoutVersion)
            throw model::Error(codes::kBadVersion, "EXR layout " + std::to_string(layout), path_.string());
        if (format > static_cast<int>(layout::kFormatVersion))
            throw model::Error(codes::kBadVersion, "format version " + std::to_string(format), path_.string());
        if (layout != kExrLayoutVersion || format < 1) refuse("impossible version");
    }

    template <std::size_t N>
    void read_numbers(const std::string& name, std::array<double, N>& out) const {
        const auto value = parse_attribute_text(text(name));
        const auto* numbers = value ? std::get_if<std::vector<double>>(&*value) : nullptr;
        if (numbers == nullptr || numbers->size() != N) refuse("the header attribute " + name + " cannot be read");
        std::copy(numbers->begin(), numbers->end(), out.begin());
    }

    [[nodiscard]] std::uint32_t side(const std::string& name) const {
        const int side = number(name);
        if (side < 1 || side > static_cast<int>(kMaxExrWidth)) refuse("impossible " + name);
        return static_cast<std::uint32_t>(side);
    }

    [[nodiscard]] Chart read_chart(std::size_t number, std::uint64_t& budget) const {
        const auto name_of = [&](const char* name) { return chart_attribute(number, name); };
        Chart chart;
        chart.rows = side(name_of("rows"));
        chart.cols = side(name_of("cols"));
        const std::string& domain = text(name_of("domain"));
        if (domain != "square" && domain != "free") refuse("unknown domain");
        chart.domain = domain == "free" ? model::Domain::kFree : model::Domain::kSquare;
        chart.method = text(name_of("method"));
        read_numbers(name_of("bbox"), chart.bbox);
        read_numbers(name_of("offset"), chart.offset);
        read_numbers(name_of("scale"), chart.scale);
        for (const std::string_view line : lines_of(text(name_of("layers")))) {
            const auto entry = parse_manifest_line(line);
            if (!entry || chart.find(entry->name) != nullptr) refuse("the list of layers cannot be read");
            Layer& layer = chart.layers.emplace_back();
            layer.name = entry->name;
            layer.type = entry->type;
            layer.shape = entry->shape;
            layer.required = entry->required;
            read_table(number, layer, budget);
        }
        read_attributes(number, chart);
        return chart;
    }

    /// The values, if the header has them.
    void read_table(std::size_t chart, Layer& layer, std::uint64_t& budget) const {
        const std::string* table = find_text(chart_attribute(chart, "table." + layer.name));
        if (table == nullptr) return;
        auto bytes = parse_base64(*table);
        if (!bytes || bytes->size() > budget || exr_layer_bytes(layer.type, layer.shape) != bytes->size())
            refuse("the table of layer " + layer.name + " has another size, or is no text of ours");
        budget -= bytes->size();
        layer.bytes = std::move(*bytes);
    }

    void read_attributes(std::size_t number, Chart& chart) const {
        const std::string prefix = chart_attribute(number, "attribute.");
        for (auto entry = header_.begin(); entry != header_.end(); ++entry) {
            const std::string_view name = entry.name();
            if (!name.starts_with(prefix)) continue;
            const std::size_t slash = name.find('/');
            if (slash == std::string_view::npos) refuse("an attribute has no name");
            Layer* layer = chart.find(name.substr(prefix.size(), slash - prefix.size()));
            const auto* text = dynamic_cast<const Imf::StringAttribute*>(&entry.attribute());
            auto value = text == nullptr ? std::nullopt : parse_attribute_text(text->value());
            if (layer == nullptr || !value) refuse("an attribute cannot be read");
            layer->attributes.emplace(name.substr(slash + 1), std::move(*value));
        }
    }

    const Imf::Header& header_;
    const fs::path& path_;
};

ExrPlan plan_of(const MapSet& maps, ExrLayout layout, const fs::path& path) {
    try {
        return plan_exr(maps.charts, layout);
    } catch (const model::Error& error) { throw model::Error(codes::kExrUnreadable, error.what(), path.string()); }
}

void check_tables(const MapSet& maps, const ExrPlan& plan, const fs::path& path) {
    for (const auto& [chart, number] : plan.tables)
        if (const Layer& layer = maps.charts[chart].layers[number]; layer.bytes.empty())
            throw model::Error(codes::kMissingChannel,
                               "the header attribute " + chart_attribute(chart, "table." + layer.name) +
                                   " is missing: the program that saved the file dropped it",
                               path.string());
}

/// A file of layers beside the map's own.
OpenFile open_side(const fs::path& side, const fs::path& map, const ExrReadLimits& limits) {
    std::error_code error;
    if (!fs::exists(side, error))
        throw model::Error(codes::kFileMissing,
                           "a file with layers of " + map.filename().string() + " is not beside it; both move together",
                           side.string());
    return {side, limits};
}

void read_pixels(OpenFile& file, const PlannedFile& plan, std::vector<Chart>& charts, const fs::path& path) {
    for (std::size_t k = 0; k < plan.parts.size(); ++k)
        if (!plan.parts[k].layers.empty())
            read_exr_part(file.pixels(), file.part_of(plan, k, path), plan.parts[k], charts, path, file.budget());
}

/// The table of rows stands in front: whether a file ends early is seen at the last row alone.
void check_rows(OpenFile& file, const fs::path& path) {
    for (int k = 0; k < file.pixels().parts(); ++k) {
        const char* row = nullptr;
        int bytes = 0;
        Imf::InputPart(file.pixels(), k).rawPixelData(file.pixels().header(k).dataWindow().max.y, row, bytes);
        if (!file.pixels().partComplete(k))
            throw model::Error(codes::kExrUnreadable, "part " + std::to_string(k) + " lacks rows", path.string());
    }
}

ExrReader& exr_reader() {
    static ExrReader reader;
    return reader;
}

MapSet with_pixels(const fs::path& path, const ExrReadLimits& limits) {
    OpenFile own(path, limits);
    const Description description(own.header(), path);
    MapSet maps = description.read(own.budget());
    const ExrPlan plan = plan_of(maps, description.layout(), path);
    check_tables(maps, plan, path);
    read_pixels(own, plan.files.front(), maps.charts, path);
    for (std::size_t k = 1; k < plan.files.size(); ++k) {
        const fs::path side = exr_side_path(path, plan.files[k].name);
        OpenFile file = open_side(side, path, limits);
        read_pixels(file, plan.files[k], maps.charts, side);
    }
    description.check_hashes(maps);
    return maps;
}

ExrHead without_pixels(const fs::path& path, const ExrReadLimits& limits) {
    OpenFile own(path, limits);
    const Description description(own.header(), path);
    ExrHead head;
    head.maps = description.read(own.budget());
    const ExrLayout layout = description.layout();
    head.multipart = layout == ExrLayout::kMultipart;
    check_rows(own, path);
    for (const PlannedFile& file : plan_of(head.maps, layout, path).files) {
        if (file.name.empty()) continue;
        const fs::path side_path = exr_side_path(path, file.name);
        OpenFile side = open_side(side_path, path, limits);
        check_rows(side, side_path);
        head.beside.push_back(file.name);
    }
    return head;
}

ExrHead read_anywhere(const fs::path& path, const ExrReadLimits& limits, ExrPixels pixels) {
    return exr_reader() ? exr_reader()(path, limits, pixels) : read_exr_here(path, limits, pixels);
}

}  // namespace

ExrHead read_exr_here(const fs::path& path, const ExrReadLimits& limits, ExrPixels pixels) {
    return reading(path, [&] {
        if (pixels == ExrPixels::kSkip) return without_pixels(path, limits);
        ExrHead out;
        out.maps = with_pixels(path, limits);
        return out;
    });
}

MapSet read_exr(const fs::path& path, const ExrReadLimits& limits) {
    return read_anywhere(path, limits, ExrPixels::kRead).maps;
}

ExrHead read_exr_head(const fs::path& path, const ExrReadLimits& limits) {
    return read_anywhere(path, limits, ExrPixels::kSkip);
}

void set_exr_reader(ExrReader reader) {
    exr_reader() = std::move(reader);
}

}  // namespace dgm::formats
