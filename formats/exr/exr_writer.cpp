// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_writer.cpp
#include "exr/exr_writer.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOpaqueAttribute.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfVecAttribute.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <system_error>

#include "exr/exr_hash.h"
#include "exr/exr_layout.h"
#include "model/codes.h"
#include "model/octahedral.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Chart;
using model::Layer;
using model::MapSet;

/// Tables up to here go into the header, so that a plain bake stays a single-part file that every program opens.
constexpr std::uint64_t kMaxHeaderTableBytes = std::uint64_t{4} << 20;
constexpr int kBlockRows = 256;

struct Placed {
    const Layer* layer;
    const Chart* chart;
    LayerImage image;
};

struct Part {
    Imf::Header header;
    std::vector<Placed> layers;
    int width = 1, height = 1;
};

[[noreturn]] void refuse(const std::string& message, const std::string& place) {
    throw model::Error(codes::kBadLayerShape, message, place);
}

bool is_clean_name(const std::string& name) {
    return !name.empty() && name.size() <= 64 && name != kGridPart &&
           std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c != '/' && c != '\x7f'; });
}

void insert_text(Imf::Header& header, const std::string& name, const std::string& text) {
    header.insert(name, Imf::StringAttribute(text));
}

Imf::V3dAttribute v3d(const double* xyz) {
    return Imf::V3dAttribute(Imath::V3d(xyz[0], xyz[1], xyz[2]));
}

/// Bytes as an IStream: the one way to fill an OpaqueAttribute.
class ByteStream : public Imf::IStream {
 public:
    explicit ByteStream(std::span<const std::byte> bytes) : IStream("table"), bytes_(bytes) {}
    bool read(char out[], int count) override {
        if (count < 0 || static_cast<std::size_t>(count) > bytes_.size() - position_)
            throw model::Error(codes::kInternal, "a table attribute asks for more than its bytes");
        std::memcpy(out, bytes_.data() + position_, static_cast<std::size_t>(count));
        position_ += static_cast<std::size_t>(count);
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override { position_ = std::min<std::size_t>(position, bytes_.size()); }

 private:
    std::span<const std::byte> bytes_;
    std::size_t position_ = 0;
};

Imf::OpaqueAttribute table_attribute(std::span<const std::byte> bytes) {
    Imf::OpaqueAttribute out("dgmTable");
    ByteStream stream(bytes);
    out.readValueFrom(stream, static_cast<int>(bytes.size()), 2);
    return out;
}

class Planner {
 public:
    Planner(const MapSet& maps, const ExrOptions& options) : maps_(maps), options_(options) {}

    std::vector<Part> run() {
        for (std::size_t k = 0; k < maps_.charts.size(); ++k) plan_chart(k);
        if (parts_.empty()) add_part(std::string(kGridPart), 1, 1);
        describe_set(parts_.front().header);
        // OpenEXR wants one display window for all parts: the smallest that shows each of them whole.
        Imath::Box2i display({0, 0}, {0, 0});
        for (const Part& part : parts_) display.extendBy(part.header.dataWindow());
        for (Part& part : parts_) part.header.displayWindow() = display;
        for (Part& part : parts_) finish(part);
        return std::move(parts_);
    }

 private:
    Part& add_part(const std::string& name, std::uint32_t width, std::uint32_t height) {
        Part part;
        part.width = static_cast<int>(width);
        part.height = static_cast<int>(height);
        const Imath::Box2i window({0, 0}, {part.width - 1, part.height - 1});
        part.header = Imf::Header(window, window);
        part.header.compression() = Imf::ZIP_COMPRESSION;
        part.header.setName(name);
        part.header.setType(Imf::SCANLINEIMAGE);
        return parts_.emplace_back(std::move(part));
    }

    void plan_chart(std::size_t number) {
        const Chart& chart = maps_.charts[number];
        const std::size_t first_part = parts_.size();
        const auto name_of = [&](std::string_view layer) { return part_name(layer, number, maps_.charts.size()); };
        if (chart.rows == 0 || chart.cols == 0 || chart.rows > kMaxExrWidth || chart.cols > kMaxExrWidth)
            refuse("a grid of " + std::to_string(chart.rows) + " x " + std::to_string(chart.cols),
                   "chart " + std::to_string(number));

        std::vector<LayerEntry> entries;
        std::set<std::string> names;
        Part grid_part;
        std::vector<std::pair<const Layer*, LayerImage>> own_parts;
        std::vector<const Layer*> tables;
        for (const Layer& layer : chart.layers) {
            const std::string place = "chart " + std::to_string(number) + ", layer " + layer.name;
            if (!is_clean_name(layer.name) || !names.insert(layer.name).second)
                refuse("the layer's name is not clean text, or used twice", place);
            const auto bytes = exr_layer_bytes(layer.type, layer.shape);
            if (!bytes || *bytes != layer.bytes.size())
                refuse(std::to_string(layer.bytes.size()) + " bytes do not fit type and shape", place);
            LayerEntry entry{layer.name, layer.type, layer.shape, layer.required, Storage::kPart};
            const LayerImage in_grid = image_of_layer(layer.name, layer.type, layer.shape, true);
            const bool multipart = options_.layout == ExrLayout::kMultipart;
            if (layer.bytes.empty()) {
                entry.storage = Storage::kNothing;
            } else if (!multipart && fits_grid(in_grid, chart.rows, chart.cols)) {
                entry.storage = Storage::kGrid;
                grid_part.layers.push_back({&layer, &chart, in_grid});
            } else if (!multipart && in_grid.is_table && layer.bytes.size() <= kMaxHeaderTableBytes) {
                entry.storage = Storage::kTable;
                tables.push_back(&layer);
            } else {
                own_parts.emplace_back(&layer, image_of_layer(layer.name, layer.type, layer.shape, false));
            }
            entries.push_back(std::move(entry));
        }
        if (!grid_part.layers.empty())
            add_part(name_of(kGridPart), chart.cols, chart.rows).layers = std::move(grid_part.layers);
        for (auto& [layer, image] : own_parts) {
            Part& part = add_part(name_of(layer->name), image.width, image.height);
            part.layers.push_back({layer, &chart, std::move(image)});
        }
        if (parts_.size() == first_part) add_part(name_of(kGridPart), 1, 1);
        Imf::Header& header = parts_[first_part].header;
        describe_chart(header, chart, number, entries);
        for (const Layer* table : tables) header.insert("dgmTable." + table->name, table_attribute(table->bytes));
    }

    static void describe_chart(Imf::Header& header, const Chart& chart, std::size_t number,
                               const std::vector<LayerEntry>& entries) {
        header.insert("dgmChart", Imf::IntAttribute(static_cast<int>(number)));
        header.insert("dgmRows", Imf::IntAttribute(static_cast<int>(chart.rows)));
        header.insert("dgmCols", Imf::IntAttribute(static_cast<int>(chart.cols)));
        insert_text(header, "dgmDomain", chart.domain == model::Domain::kFree ? "free" : "square");
        insert_text(header, "dgmMethod", chart.method);
        header.insert("dgmBboxMin", v3d(chart.bbox.data()));
        header.insert("dgmBboxMax", v3d(chart.bbox.data() + 3));
        header.insert("dgmOffset", v3d(chart.offset.data()));
        header.insert("dgmScale", v3d(chart.scale.data()));
        std::string manifest;
        for (const LayerEntry& entry : entries) manifest += manifest_line(entry) + "\n";
        insert_text(header, "dgmLayers", manifest);
        for (const Layer& layer : chart.layers) {
            insert_text(header, "dgmHash." + layer.name, exr_layer_hash(layer));
            for (const auto& [name, value] : layer.attributes) {
                if (name.empty() || name.size() > 100 || name.find('\0') != std::string::npos)
                    refuse("an attribute's name is empty, too long or holds a zero byte", layer.name);
                insert_text(header, "dgmAttribute." + layer.name + "/" + name, attribute_text(value));
            }
        }
    }

    void describe_set(Imf::Header& header) const {
        header.insert("dgmFormatVersion", Imf::IntAttribute(static_cast<int>(maps_.format_version)));
        header.insert("dgmChartCount", Imf::IntAttribute(static_cast<int>(maps_.charts.size())));
        insert_text(header, "dgmGenerator", maps_.generator);
        insert_text(header, "dgmSourceName", maps_.source_name);
        insert_text(header, "dgmSourceHash", hex_of(maps_.source_hash));
        insert_text(header, "dgmSettingsHash", hex_of(maps_.settings_hash));
        insert_text(header, "dgmReport", maps_.report_json);
        insert_text(header, "dgmHeaderHash", exr_header_hash(maps_));
    }

    static void finish(Part& part) {
        auto& channels = part.header.channels();
        for (const Placed& placed : part.layers)
            for (const Channel& channel : placed.image.channels) {
                if (channels.findChannel(channel.name) != nullptr)
                    refuse("two layers need the channel " + channel.name, placed.layer->name);
                channels.insert(channel.name, Imf::Channel(channel.type));
            }
        // A part needs a channel even where a chart has no data.
        if (part.layers.empty()) channels.insert("empty", Imf::Channel(Imf::HALF));
    }

    const MapSet& maps_;
    const ExrOptions& options_;
    std::vector<Part> parts_;
};

std::uint32_t element_at(const Layer& layer, std::uint64_t index) {
    const std::uint32_t size = layout::element_size(layer.type);
    std::uint32_t value = 0;  // little-endian hosts only: the low bytes
    std::memcpy(&value, layer.bytes.data() + index * size, size);
    return value;
}

/// The bits of one pixel in one channel.
std::uint32_t pixel_bits(const Placed& placed, const Channel& channel, std::uint64_t pixel) {
    const Layer& layer = *placed.layer;
    const std::uint64_t first = pixel * placed.image.components;
    float value = 0;
    switch (channel.coding) {
        case Coding::kExact:
            return element_at(layer, first + channel.component);
        case Coding::kSrgb:
            return half_of_srgb(static_cast<std::uint8_t>(element_at(layer, first + channel.component)));
        case Coding::kUnit:
            return half_of_unit(static_cast<std::uint8_t>(element_at(layer, first + channel.component)));
        case Coding::kPosition:
            value = static_cast<float>(placed.chart->scale[channel.component] *
                                       element_at(layer, first + channel.component));
            break;
        case Coding::kNormal:
            value = dgm::decode_octahedral(static_cast<std::int16_t>(element_at(layer, first)),
                                           static_cast<std::int16_t>(element_at(layer, first + 1)))[channel.component];
            break;
    }
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}

/// Rows [top, top + rows) of one channel, in its pixel type.
void fill_rows(const Placed& placed, const Channel& channel, int top, int rows, std::vector<char>& buffer) {
    const std::size_t size = channel.type == Imf::HALF ? 2 : 4;
    const LayerImage& image = placed.image;
    buffer.assign(static_cast<std::size_t>(rows) * image.width * size, 0);
    char* out = buffer.data();
    for (int y = top; y < top + rows; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x, out += size) {
            const std::uint64_t pixel = static_cast<std::uint64_t>(y) * image.row + x;
            if (x >= image.row || pixel >= image.pixels) continue;
            const std::uint32_t bits = pixel_bits(placed, channel, pixel);
            std::memcpy(out, &bits, size);
        }
}

void write_part(Imf::MultiPartOutputFile& file, int number, const Part& part) {
    Imf::OutputPart output(file, number);
    const auto width = static_cast<std::size_t>(part.width);
    std::vector<std::vector<char>> buffers;
    for (int top = 0; top < part.height; top += kBlockRows) {
        const int rows = std::min(kBlockRows, part.height - top);
        Imf::FrameBuffer frame;
        buffers.clear();
        const auto add = [&](const std::string& name, Imf::PixelType type) {
            frame.insert(name,
                         Imf::Slice::Make(type, buffers.back().data(), Imath::V2i(0, top), std::int64_t{part.width},
                                          std::int64_t{rows}, std::size_t{0}, (type == Imf::HALF ? 2 : 4) * width));
        };
        for (const Placed& placed : part.layers)
            for (const Channel& channel : placed.image.channels) {
                fill_rows(placed, channel, top, rows, buffers.emplace_back());
                add(channel.name, channel.type);
            }
        if (part.layers.empty()) {
            buffers.emplace_back(std::size_t{2} * width * static_cast<std::size_t>(rows), '\0');
            add("empty", Imf::HALF);
        }
        output.setFrameBuffer(frame);
        output.writePixels(rows);
    }
}

}  // namespace

void write_exr(const MapSet& maps, const fs::path& path, const ExrOptions& options) {
    const std::vector<Part> parts = Planner(maps, options).run();
    const int probe = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (probe < 0)
        throw model::Error(codes::kWriteFailed, "create: " + std::generic_category().message(errno), path.string());
    ::close(probe);
    try {
        std::vector<Imf::Header> headers;
        headers.reserve(parts.size());
        for (const Part& part : parts) headers.push_back(part.header);
        // No threads: the bytes do not depend on them, but neither does a bake's speed.
        Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()), false, 0);
        for (std::size_t k = 0; k < parts.size(); ++k) write_part(file, static_cast<int>(k), parts[k]);
    } catch (const std::exception& e) {
        std::error_code error;
        if (fs::is_regular_file(path, error)) fs::remove(path, error);
        if (dynamic_cast<const std::bad_alloc*>(&e) != nullptr) throw;
        throw model::Error(codes::kWriteFailed, std::string("OpenEXR: ") + e.what(), path.string());
    }
}

}  // namespace dgm::formats
