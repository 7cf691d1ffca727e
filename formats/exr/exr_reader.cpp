// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_reader.cpp
#include "exr/exr_reader.h"

#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOpaqueAttribute.h>
#include <ImfStringAttribute.h>
#include <ImfVecAttribute.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <system_error>

#include "exr/exr_hash.h"
#include "exr/exr_headers.h"
#include "exr/exr_layout.h"
#include "exr/exr_part.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Chart;
using model::Layer;
using model::MapSet;

/// zlib packs at most 1032 to 1: a file that promises more is lying, and is refused before memory is spent on it.
constexpr std::uint64_t kMaxZipRatio = 1032;

class Reader {
 public:
    Reader(const fs::path& path, const ExrReadLimits& limits, std::uint64_t budget)
        : path_(path), limits_(limits), budget_(budget), file_(path.c_str(), 0, false) {}

    MapSet run() {
        const int parts = file_.parts();
        if (parts < 1 || parts > limits_.max_parts) refuse("impossible number of parts");
        std::map<int, int> chart_parts;  // chart -> the part whose header describes it
        for (int k = 0; k < parts; ++k) {
            if (file_.header(k).hasName()) parts_by_name_.emplace(file_.header(k).name(), k);
            const auto* chart = file_.header(k).findTypedAttribute<Imf::IntAttribute>("dgmChart");
            if (chart != nullptr && !chart_parts.emplace(chart->value(), k).second)
                refuse("a chart is described twice");
        }
        read_set(file_.header(0));
        for (std::size_t k = 0; k < maps_.charts.size(); ++k) {
            const auto part = chart_parts.find(static_cast<int>(k));
            if (part == chart_parts.end()) refuse("chart " + std::to_string(k) + " is missing");
            read_chart(k, part->second);
            check_hashes(k, file_.header(part->second));
        }
        const auto* header_hash = file_.header(0).findTypedAttribute<Imf::StringAttribute>("dgmHeaderHash");
        if (header_hash != nullptr && header_hash->value() != exr_header_hash(maps_))
            throw model::Error(codes::kHashMismatch, "header attributes differ from their hash", "/");
        return std::move(maps_);
    }

    ExrHead head() {
        ExrHead out;
        out.multipart = true;
        if (file_.parts() < 1 || file_.parts() > limits_.max_parts) refuse("impossible number of parts");
        for (int k = 0; k < file_.parts(); ++k) {
            // The table of rows stands in front: whether the file ends early is seen at the last row alone.
            const char* row = nullptr;
            int bytes = 0;
            Imf::InputPart(file_, k).rawPixelData(file_.header(k).dataWindow().max.y, row, bytes);
            if (!file_.partComplete(k)) refuse("part " + std::to_string(k) + " lacks rows");
            const auto* list = file_.header(k).findTypedAttribute<Imf::StringAttribute>("dgmLayers");
            std::string_view rest = list == nullptr ? std::string_view() : std::string_view(list->value());
            while (!rest.empty()) {
                const std::size_t end = std::min(rest.find('\n'), rest.size());
                const auto entry = parse_manifest_line(rest.substr(0, end));
                rest.remove_prefix(std::min(end + 1, rest.size()));
                if (entry && entry->storage == Storage::kGrid) out.multipart = false;
            }
        }
        read_set(file_.header(0));
        maps_.charts.clear();
        out.maps = std::move(maps_);
        return out;
    }

 private:
    [[noreturn]] void refuse(const std::string& message) const {
        throw model::Error(codes::kExrUnreadable, message, path_.string());
    }

    /// Files that other programs saved again may have lost the hashes; where they are, they hold.
    void check_hashes(std::size_t number, const Imf::Header& header) const {
        for (const Layer& layer : maps_.charts[number].layers) {
            const auto* hash = header.findTypedAttribute<Imf::StringAttribute>("dgmHash." + layer.name);
            if (hash != nullptr && hash->value() != exr_layer_hash(layer))
                throw model::Error(codes::kHashMismatch, "the layer's values differ from their hash",
                                   "/charts/" + std::to_string(number) + "/" + layer.name);
        }
    }

    template <class Attribute>
    const auto& value_of(const Imf::Header& header, const std::string& name) const {
        const auto* attribute = header.findTypedAttribute<Attribute>(name);
        if (attribute == nullptr) refuse("no header attribute " + name + ": the file is not a geometry map of ours");
        return attribute->value();
    }
    const std::string& text_of(const Imf::Header& header, const std::string& name) const {
        return value_of<Imf::StringAttribute>(header, name);
    }
    void read_v3d(const Imf::Header& header, const std::string& name, double* out) const {
        const Imath::V3d& value = value_of<Imf::V3dAttribute>(header, name);
        for (int k = 0; k < 3; ++k) out[k] = value[k];
    }
    std::uint32_t side_of(const Imf::Header& header, const std::string& name) const {
        const int side = value_of<Imf::IntAttribute>(header, name);
        if (side < 1 || side > static_cast<int>(kMaxExrWidth)) refuse("impossible " + name);
        return static_cast<std::uint32_t>(side);
    }

    void read_set(const Imf::Header& header) {
        const int version = value_of<Imf::IntAttribute>(header, "dgmFormatVersion");
        if (version > static_cast<int>(layout::kFormatVersion))
            throw model::Error(codes::kBadVersion, "format version " + std::to_string(version), path_.string());
        if (version < 1) refuse("impossible format version");
        maps_.format_version = static_cast<std::uint32_t>(version);
        maps_.generator = text_of(header, "dgmGenerator");
        maps_.source_name = text_of(header, "dgmSourceName");
        maps_.report_json = text_of(header, "dgmReport");
        if (!parse_hex(text_of(header, "dgmSourceHash"), maps_.source_hash) ||
            !parse_hex(text_of(header, "dgmSettingsHash"), maps_.settings_hash))
            refuse("a hash in the header is not 32 hexadecimal digits");
        const int charts = value_of<Imf::IntAttribute>(header, "dgmChartCount");
        if (charts < 0 || charts > file_.parts()) refuse("impossible number of charts");
        maps_.charts.resize(static_cast<std::size_t>(charts));
    }

    void read_chart(std::size_t number, int part) {
        const Imf::Header& header = file_.header(part);
        Chart& chart = maps_.charts[number];
        chart.rows = side_of(header, "dgmRows");
        chart.cols = side_of(header, "dgmCols");
        const std::string& domain = text_of(header, "dgmDomain");
        if (domain != "square" && domain != "free") refuse("unknown domain");
        chart.domain = domain == "free" ? model::Domain::kFree : model::Domain::kSquare;
        chart.method = text_of(header, "dgmMethod");
        read_v3d(header, "dgmBboxMin", chart.bbox.data());
        read_v3d(header, "dgmBboxMax", chart.bbox.data() + 3);
        read_v3d(header, "dgmOffset", chart.offset.data());
        read_v3d(header, "dgmScale", chart.scale.data());
        std::vector<std::size_t> in_grid;
        std::string_view rest = text_of(header, "dgmLayers");
        while (!rest.empty()) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            const auto entry = parse_manifest_line(rest.substr(0, end));
            rest.remove_prefix(std::min(end + 1, rest.size()));
            if (!entry || chart.find(entry->name) != nullptr) refuse("the list of layers cannot be read");
            add_layer(chart, number, *entry, header);
            if (entry->storage == Storage::kGrid) in_grid.push_back(chart.layers.size() - 1);
        }
        read_attributes(header, chart);
        if (in_grid.empty()) return;
        std::vector<Layer*> layers;
        layers.reserve(in_grid.size());
        for (const std::size_t k : in_grid) layers.push_back(&chart.layers[k]);
        read_part(part_name(kGridPart, number, maps_.charts.size()), layers, true);
    }

    void add_layer(Chart& chart, std::size_t number, const LayerEntry& entry, const Imf::Header& header) {
        Layer& layer = chart.layers.emplace_back();
        layer.name = entry.name;
        layer.type = entry.type;
        layer.shape = entry.shape;
        layer.required = entry.required;
        const auto bytes = exr_layer_bytes(entry.type, entry.shape);
        if (!bytes || *bytes > budget_) refuse("layer " + entry.name + " is impossibly large");
        budget_ -= *bytes;
        switch (entry.storage) {
            case Storage::kNothing:
                if (*bytes != 0) refuse("layer " + entry.name + " has no data");
                return;
            case Storage::kTable: {
                const auto* table = header.findTypedAttribute<Imf::OpaqueAttribute>("dgmTable." + entry.name);
                if (table == nullptr || static_cast<std::uint64_t>(table->dataSize()) != *bytes)
                    refuse("the table of layer " + entry.name + " is missing or has another size");
                layer.bytes.resize(*bytes);
                if (*bytes > 0) std::memcpy(layer.bytes.data(), static_cast<const char*>(table->data()), *bytes);
                return;
            }
            case Storage::kGrid:
                layer.bytes.resize(*bytes);
                return;
            case Storage::kPart:
                layer.bytes.resize(*bytes);
                read_part(part_name(entry.name, number, maps_.charts.size()), {&layer}, false);
                return;
        }
    }

    void read_attributes(const Imf::Header& header, Chart& chart) {
        for (auto entry = header.begin(); entry != header.end(); ++entry) {
            const std::string_view name = entry.name();
            constexpr std::string_view kPrefix = "dgmAttribute.";
            if (!name.starts_with(kPrefix)) continue;
            const std::size_t slash = name.find('/');
            if (slash == std::string_view::npos) refuse("an attribute has no name");
            Layer* layer = chart.find(name.substr(kPrefix.size(), slash - kPrefix.size()));
            const auto* text = dynamic_cast<const Imf::StringAttribute*>(&entry.attribute());
            auto value = text == nullptr ? std::nullopt : parse_attribute_text(text->value());
            if (layer == nullptr || !value) refuse("an attribute cannot be read");
            layer->attributes.emplace(name.substr(slash + 1), std::move(*value));
        }
    }

    void read_part(const std::string& name, const std::vector<Layer*>& layers, bool in_grid) {
        // A file of one part carries no part name when other programs have saved it again.
        const auto found = parts_by_name_.find(name);
        if (found == parts_by_name_.end() && file_.parts() != 1)
            throw model::Error(codes::kMissingChannel, "no part " + name, path_.string());
        const int number = found == parts_by_name_.end() ? 0 : found->second;
        read_exr_part(file_, {number, name, in_grid}, layers, path_);
    }

    const fs::path& path_;
    const ExrReadLimits& limits_;
    std::uint64_t budget_;
    Imf::MultiPartInputFile file_;
    std::map<std::string, int, std::less<>> parts_by_name_;
    MapSet maps_;
};

template <class Read>
auto reading(const fs::path& path, const ExrReadLimits& limits, Read read) {
    std::error_code error;
    const auto status = fs::status(path, error);
    if (!fs::exists(status)) throw model::missing_file(path);
    const std::uint64_t bytes = fs::is_regular_file(status) ? fs::file_size(path, error) : 0;
    if (!fs::is_regular_file(status) || error) throw model::unreadable_file(path);
    const std::uint64_t budget = std::min(limits.max_total_bytes, bytes * kMaxZipRatio);
    check_exr_headers(path, bytes, limits.max_pixels_per_part, limits.max_parts, budget);
    try {
        Reader reader(path, limits, budget);
        return read(reader);
    } catch (const model::Error&) { throw; } catch (const std::bad_alloc&) {
        throw model::Error(codes::kExrUnreadable, "the file needs more memory than there is", path.string());
    } catch (const std::exception& e) {
        throw model::Error(codes::kExrUnreadable, std::string("OpenEXR: ") + e.what(), path.string());
    }
}

}  // namespace

MapSet read_exr(const fs::path& path, const ExrReadLimits& limits) {
    return reading(path, limits, [](Reader& reader) { return reader.run(); });
}

ExrHead read_exr_head(const fs::path& path, const ExrReadLimits& limits) {
    return reading(path, limits, [](Reader& reader) { return reader.head(); });
}

}  // namespace dgm::formats
