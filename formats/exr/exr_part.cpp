// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_part.cpp
#include "exr/exr_part.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>

#include <algorithm>
#include <cstring>

#include "exr/exr_layout.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Layer;

constexpr int kBlockRows = 256;

struct Rows {
    int first = 0, count = 0;
};

/// A channel of the file, the layer that it belongs to, and its pixels of a few rows.
struct Target {
    Layer* layer;
    LayerImage image;
    Channel channel;
    std::vector<char> buffer;
    [[nodiscard]] std::size_t pixel_bytes() const { return channel.type == Imf::HALF ? 2 : 4; }
};

/// Light may have been saved again as float; everything else must be of the type that was written.
bool suits(const Imf::Channel* stored, const Channel& channel) {
    const bool is_light = channel.coding == Coding::kSrgb || channel.coding == Coding::kUnit;
    return stored != nullptr && stored->xSampling == 1 && stored->ySampling == 1 &&
           (stored->type == channel.type || (is_light && stored->type == Imf::FLOAT));
}

std::vector<Target> targets_of(const Imf::Header& header, const ExrPart& part, const std::vector<Layer*>& layers,
                               int width, int height, const fs::path& path) {
    const auto miss = [&](const std::string& message) {
        throw model::Error(codes::kMissingChannel, message, path.string());
    };
    std::vector<LayerImage> images;
    images.reserve(layers.size());
    for (const Layer* layer : layers)
        images.push_back(image_of_layer(layer->name, layer->type, layer->shape, part.is_grid));
    std::vector<Target> targets;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        if (static_cast<int>(images[k].width) != width || static_cast<int>(images[k].height) != height)
            miss("part " + part.name + " and layer " + layers[k]->name + " differ in size");
        for (const Channel& channel : images[k].channels) {
            if (!channel.is_read()) continue;
            if (!suits(header.channels().findChannel(channel.name), channel))
                miss("channel " + channel.name + " is missing or of another type");
            targets.push_back({layers[k], images[k], channel, {}});
        }
    }
    return targets;
}

void read_rows(Imf::InputPart& input, std::vector<Target>& targets, int width, const Rows& rows) {
    Imf::FrameBuffer frame;
    for (Target& target : targets) {
        const std::size_t size = target.pixel_bytes();
        target.buffer.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(rows.count) * size);
        frame.insert(
            target.channel.name,
            Imf::Slice::Make(target.channel.type, target.buffer.data(), Imath::V2i(0, rows.first), std::int64_t{width},
                             std::int64_t{rows.count}, std::size_t{0}, size * static_cast<std::size_t>(width)));
    }
    input.setFrameBuffer(frame);
    input.readPixels(rows.first, rows.first + rows.count - 1);
}

/// Puts the rows in the target's buffer into its layer; pixels beyond the layer's are left out.
void store_rows(const Target& target, const Rows& rows, const fs::path& path) {
    const auto& [layer, image, channel, buffer] = target;
    const std::size_t size = target.pixel_bytes();
    const std::uint32_t element = layout::element_size(layer->type);
    const std::uint32_t largest = element == 4 ? 0xFFFFFFFFu : (1u << (8 * element)) - 1;
    const char* in = buffer.data();
    for (int y = rows.first; y < rows.first + rows.count; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x, in += size) {
            const std::uint64_t pixel = static_cast<std::uint64_t>(y) * image.row + x;
            if (x >= image.row || pixel >= image.pixels) continue;
            std::uint32_t bits = 0;
            std::memcpy(&bits, in, size);
            if (channel.coding == Coding::kSrgb) bits = srgb_of_half(static_cast<std::uint16_t>(bits));
            if (channel.coding == Coding::kUnit) bits = unit_of_half(static_cast<std::uint16_t>(bits));
            if (bits > largest)
                throw model::Error(codes::kExrUnreadable, "channel " + channel.name + " holds a number beyond its type",
                                   path.string());
            std::memcpy(layer->bytes.data() + (pixel * image.components + channel.component) * element, &bits, element);
        }
}

}  // namespace

void read_exr_part(Imf::MultiPartInputFile& file, const ExrPart& part, const std::vector<Layer*>& layers,
                   const fs::path& path) {
    const Imf::Header& header = file.header(part.number);
    const Imath::Box2i window = header.dataWindow();
    const int width = window.max.x + 1, height = window.max.y + 1;
    std::vector<Target> targets = targets_of(header, part, layers, width, height, path);
    Imf::InputPart input(file, part.number);
    for (int top = 0; top < height; top += kBlockRows) {
        const Rows rows{top, std::min(kBlockRows, height - top)};
        read_rows(input, targets, width, rows);
        for (const Target& target : targets) store_rows(target, rows, path);
    }
}

}  // namespace dgm::formats
