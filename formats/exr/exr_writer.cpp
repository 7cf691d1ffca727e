// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_writer.cpp
#include "exr/exr_writer.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <system_error>
#include <utility>

#include "exr/exr_attributes.h"
#include "exr/exr_hash.h"
#include "exr/exr_layout.h"
#include "exr/exr_plan.h"
#include "exr/exr_stream.h"
#include "exr/exr_text.h"
#include "files/staging_folder.h"
#include "model/codes.h"
#include "model/octahedral.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using layout::ElementType;
using model::Chart;
using model::Layer;
using model::MapSet;

constexpr int kBlockRows = 256;

[[noreturn]] void refuse(const std::string& message, const std::string& place) {
    throw model::Error(codes::kBadLayerShape, message, place);
}

void insert_text(Imf::Header& header, const std::string& name, const std::string& text) {
    header.insert(name, Imf::StringAttribute(text));
}
void insert_int(Imf::Header& header, const std::string& name, std::uint64_t value) {
    header.insert(name, Imf::IntAttribute(static_cast<int>(value)));
}

template <std::size_t N>
std::string numbers_text(const std::array<double, N>& numbers) {
    return attribute_text(std::vector<double>(numbers.begin(), numbers.end()));
}

void describe_chart(Imf::Header& header, const Chart& chart, std::size_t number) {
    const auto name_of = [&](const std::string& name) { return chart_attribute(number, name); };
    insert_int(header, name_of("rows"), chart.rows);
    insert_int(header, name_of("cols"), chart.cols);
    insert_text(header, name_of("domain"), chart.domain == model::Domain::kFree ? "free" : "square");
    insert_text(header, name_of("method"), chart.method);
    insert_text(header, name_of("bbox"), numbers_text(chart.bbox));
    insert_text(header, name_of("offset"), numbers_text(chart.offset));
    insert_text(header, name_of("scale"), numbers_text(chart.scale));
    std::string manifest;
    for (const Layer& layer : chart.layers) {
        manifest += manifest_line({layer.name, layer.type, layer.shape, layer.required}) + "\n";
        insert_text(header, name_of("hash." + layer.name), exr_layer_hash(layer));
        for (const auto& [name, value] : layer.attributes) {
            if (name.empty() || name.size() > 100 || name.find('\0') != std::string::npos)
                refuse("an attribute's name is empty, too long or holds a zero byte", layer.name);
            insert_text(header, name_of("attribute." + layer.name + "/" + name), attribute_text(value));
        }
    }
    insert_text(header, name_of("layers"), manifest);
}

void describe_set(Imf::Header& header, const MapSet& maps, ExrLayout layout) {
    insert_int(header, kLayoutVersionAttribute, kExrLayoutVersion);
    insert_text(header, kLayoutNameAttribute, layout == ExrLayout::kMultipart ? "multipart" : "auto");
    insert_int(header, kFormatVersionAttribute, maps.format_version);
    insert_int(header, kChartCountAttribute, maps.charts.size());
    insert_text(header, kGeneratorAttribute, maps.generator);
    insert_text(header, kSourceNameAttribute, maps.source_name);
    insert_text(header, kSourceHashAttribute, hex_of(maps.source_hash));
    insert_text(header, kSettingsHashAttribute, hex_of(maps.settings_hash));
    insert_text(header, kReportAttribute, maps.report_json);
    insert_text(header, kHeaderHashAttribute, exr_header_hash(maps));
    for (std::size_t k = 0; k < maps.charts.size(); ++k) describe_chart(header, maps.charts[k], k);
}

Imf::Header header_of(const PlannedPart& part) {
    const Imath::Box2i window({0, 0}, {static_cast<int>(part.width) - 1, static_cast<int>(part.height) - 1});
    Imf::Header header(window, window);
    header.compression() = Imf::ZIP_COMPRESSION;
    header.setType(Imf::SCANLINEIMAGE);
    if (!part.name.empty()) header.setName(part.name);
    for (const PlannedLayer& layer : part.layers)
        for (const Channel& channel : layer.image.channels)
            header.channels().insert(channel.name, Imf::Channel(channel.type));
    if (part.layers.empty()) header.channels().insert(kEmptyChannel, Imf::Channel(Imf::FLOAT));
    return header;
}

std::uint32_t element_at(const Layer& layer, std::uint64_t index) {
    const std::uint32_t size = layout::element_size(layer.type);
    std::uint32_t value = 0;  // little-endian hosts only: the low bytes
    std::memcpy(&value, layer.bytes.data() + index * size, size);
    return value;
}

std::uint32_t bits_of(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}

/// An element of a layer as a pixel of the channel's type.
std::uint32_t exact_bits(ElementType type, std::uint32_t element, Imf::PixelType pixel) {
    if (type == ElementType::kF32) return element;
    if (type == ElementType::kF16)
        return pixel == Imf::HALF ? element : float_bits_of_half(static_cast<std::uint16_t>(element));
    return bits_of(type == ElementType::kI16 ? static_cast<float>(static_cast<std::int16_t>(element))
                                             : static_cast<float>(element));
}

/// A half as a pixel of the channel's type.
std::uint32_t light_bits(std::uint16_t half, Imf::PixelType pixel) {
    return pixel == Imf::HALF ? half : float_bits_of_half(half);
}

struct Placed {
    const Chart* chart;
    const Layer* layer;
    const LayerImage* image;
};

/// The bits of one pixel in one channel.
std::uint32_t pixel_bits(const Placed& placed, const Channel& channel, std::uint64_t pixel) {
    const Layer& layer = *placed.layer;
    const std::uint64_t first = pixel * placed.image->components;
    const std::uint64_t own = first + channel.component;
    switch (channel.coding) {
        case Coding::kExact:
            return exact_bits(layer.type, element_at(layer, own), channel.type);
        case Coding::kLowHalf:
            return bits_of(static_cast<float>(element_at(layer, own) & 0xFFFFu));
        case Coding::kHighHalf:
            return bits_of(static_cast<float>(element_at(layer, own) >> 16));
        case Coding::kSrgb:
            return light_bits(half_of_srgb(static_cast<std::uint8_t>(element_at(layer, own))), channel.type);
        case Coding::kUnit:
            return light_bits(half_of_unit(static_cast<std::uint8_t>(element_at(layer, own))), channel.type);
        case Coding::kPosition:
            return bits_of(static_cast<float>(placed.chart->scale[channel.component] * element_at(layer, own)));
        case Coding::kNormal:
            return bits_of(
                dgm::decode_octahedral(static_cast<std::int16_t>(element_at(layer, first)),
                                       static_cast<std::int16_t>(element_at(layer, first + 1)))[channel.component]);
    }
    return 0;
}

/// Rows [top, top + rows) of one channel, in its pixel type.
void fill_rows(const Placed& placed, const Channel& channel, int top, int rows, std::vector<char>& buffer) {
    const std::size_t size = channel.type == Imf::HALF ? 2 : 4;
    const LayerImage& image = *placed.image;
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

void write_part(Imf::MultiPartOutputFile& file, int number, const PlannedPart& part, const MapSet& maps) {
    Imf::OutputPart output(file, number);
    const int height = static_cast<int>(part.height);
    std::vector<std::vector<char>> buffers;
    for (int top = 0; top < height; top += kBlockRows) {
        const int rows = std::min(kBlockRows, height - top);
        Imf::FrameBuffer frame;
        buffers.clear();
        const auto add = [&](const std::string& name, Imf::PixelType type) {
            frame.insert(name, Imf::Slice::Make(type, buffers.back().data(), Imath::V2i(0, top),
                                                std::int64_t{part.width}, std::int64_t{rows}, std::size_t{0},
                                                (type == Imf::HALF ? 2 : 4) * std::size_t{part.width}));
        };
        for (const PlannedLayer& layer : part.layers) {
            const Chart& chart = maps.charts[layer.number.chart];
            for (const Channel& channel : layer.image.channels) {
                fill_rows({&chart, &chart.layers[layer.number.layer], &layer.image}, channel, top, rows,
                          buffers.emplace_back());
                add(channel.name, channel.type);
            }
        }
        if (part.layers.empty()) {
            buffers.emplace_back(std::size_t{4} * part.width * static_cast<std::size_t>(rows), '\0');
            add(kEmptyChannel, Imf::FLOAT);
        }
        output.setFrameBuffer(frame);
        output.writePixels(rows);
    }
}

void check_bytes(const MapSet& maps) {
    for (std::size_t k = 0; k < maps.charts.size(); ++k)
        for (const Layer& layer : maps.charts[k].layers)
            if (exr_layer_bytes(layer.type, layer.shape) != layer.bytes.size())
                refuse(std::to_string(layer.bytes.size()) + " bytes do not fit type and shape",
                       "chart " + std::to_string(k) + ", layer " + layer.name);
}

void remove_file(const fs::path& path) {
    std::error_code error;
    if (fs::is_regular_file(path, error)) fs::remove(path, error);
}

void write_file(const fs::path& path, const PlannedFile& file, const MapSet& maps, std::vector<Imf::Header> headers) {
    const int probe = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (probe < 0)
        throw model::Error(write_failure(errno), "create: " + std::generic_category().message(errno), path.string());
    ::close(probe);
    try {
        // No threads: the bytes do not depend on them, but neither does a bake's speed.
        ExrStream stream(path);
        {
            Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()), false, 0);
            for (std::size_t k = 0; k < file.parts.size(); ++k)
                write_part(output, static_cast<int>(k), file.parts[k], maps);
        }
        stream.finish();
    } catch (const std::exception& e) {
        remove_file(path);
        if (dynamic_cast<const std::bad_alloc*>(&e) != nullptr) throw;
        throw exr_failure(e, path);
    }
}

std::vector<Imf::Header> headers_of(const PlannedFile& file, const ExrPlan& plan, const MapSet& maps,
                                    ExrLayout layout) {
    std::vector<Imf::Header> headers;
    headers.reserve(file.parts.size());
    for (const PlannedPart& part : file.parts) headers.push_back(header_of(part));
    if (!file.name.empty()) {
        insert_int(headers.front(), kLayoutVersionAttribute, kExrLayoutVersion);
        insert_text(headers.front(), kSideFileAttribute, file.name);
        return headers;
    }
    describe_set(headers.front(), maps, layout);
    for (const auto& [chart, number] : plan.tables) {
        const Layer& layer = maps.charts[chart].layers[number];
        insert_text(headers.front(), chart_attribute(chart, "table." + layer.name), base64_of(layer.bytes));
    }
    return headers;
}

}  // namespace

std::vector<fs::path> write_exr(const MapSet& maps, const fs::path& path, const ExrOptions& options) {
    const ExrPlan plan = plan_exr(maps.charts, options.layout);
    check_bytes(maps);
    std::vector<fs::path> written;
    try {
        for (auto file = plan.files.rbegin(); file != plan.files.rend(); ++file) {  // the map's own last
            const fs::path name = file->name.empty() ? path : exr_side_path(path, file->name);
            write_file(name, *file, maps, headers_of(*file, plan, maps, options.layout));
            written.push_back(name);
        }
    } catch (...) {
        for (const fs::path& file : written) remove_file(file);
        throw;
    }
    return written;
}

}  // namespace dgm::formats
