// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_part.cpp
#include "exr/exr_part.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "exr/exr_threads.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using layout::ElementType;
using model::Layer;

constexpr int kBlockRows = 256;

struct Rows {
    int first = 0, count = 0;
};

/// A channel of the file, the layer that it belongs to, and its pixels of a few rows.
struct Target {
    Layer* layer;
    const LayerImage* image;
    const Channel* channel;
    Imf::PixelType type;  ///< of the pixels as they are asked for
    std::vector<char> buffer;
    [[nodiscard]] std::size_t pixel_bytes() const { return type == Imf::HALF ? 2 : 4; }
};

bool is_light(Coding coding) {
    return coding == Coding::kSrgb || coding == Coding::kUnit;
}

/// As what to ask for the pixels, so that each number comes as it was stored: other programs save halves and whole
/// numbers as floats. A half holds whole numbers up to 2048, so those of 8 bits alone.
Imf::PixelType asked_type(Imf::PixelType stored, const Channel& channel, ElementType type, const std::string& place) {
    const auto lost = [&](const std::string& what) {
        throw model::Error(codes::kMissingChannel,
                           "channel " + channel.name + " was saved as half, which lost " + what + "; save it as float",
                           place);
    };
    if (is_light(channel.coding)) return Imf::HALF;
    if (type == ElementType::kF16) return stored == Imf::HALF ? Imf::HALF : Imf::FLOAT;
    if (stored == Imf::HALF && type == ElementType::kF32) lost("digits");
    if (stored == Imf::HALF && type != ElementType::kU8) lost("numbers beyond 2048");
    if (stored == Imf::UINT && type == ElementType::kF32)
        throw model::Error(codes::kMissingChannel,
                           "channel " + channel.name + " was saved as uint, which lost fractions", place);
    return Imf::FLOAT;
}

std::vector<Target> targets_of(const Imf::Header& header, const PlannedPart& part, std::vector<model::Chart>& charts,
                               const fs::path& path) {
    const auto miss = [&](const std::string& message) {
        throw model::Error(codes::kMissingChannel, message, path.string());
    };
    const Imath::Box2i window = header.dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} + 1, height = std::int64_t{window.max.y} + 1;
    if (width != part.width || height != part.height)
        miss("the image " + part.name + (part.name.empty() ? "" : " ") + "is " + std::to_string(width) + " x " +
             std::to_string(height) + " pixels, and its layers have " + std::to_string(part.width) + " x " +
             std::to_string(part.height));
    std::vector<Target> targets;
    for (const PlannedLayer& planned : part.layers) {
        Layer& layer = charts[planned.number.chart].layers[planned.number.layer];
        for (const Channel& channel : planned.image.channels) {
            if (!channel.is_read()) continue;
            const Imf::Channel* stored = header.channels().findChannel(channel.name);
            if (stored == nullptr || stored->xSampling != 1 || stored->ySampling != 1)
                miss("channel " + channel.name + " is missing");
            targets.push_back(
                {&layer, &planned.image, &channel, asked_type(stored->type, channel, layer.type, path.string()), {}});
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
            target.channel->name,
            Imf::Slice::Make(target.type, target.buffer.data(), Imath::V2i(0, rows.first), std::int64_t{width},
                             std::int64_t{rows.count}, std::size_t{0}, size * static_cast<std::size_t>(width)));
    }
    input.setFrameBuffer(frame);
    make_exr_threads();
    input.readPixels(rows.first, rows.first + rows.count - 1);
}

[[noreturn]] void refuse_number(const Target& target, float number, const fs::path& path) {
    throw model::Error(codes::kExrUnreadable,
                       "channel " + target.channel->name + " holds " + std::to_string(number) + ", which layer " +
                           target.layer->name + " cannot",
                       path.string());
}

/// The whole number that a pixel stands for, within [least, most].
std::uint32_t whole_number(const Target& target, std::uint32_t bits, int least, int most, const fs::path& path) {
    const float number = std::bit_cast<float>(bits);
    if (!(number >= static_cast<float>(least) && number <= static_cast<float>(most)) || number != std::floor(number))
        refuse_number(target, number, path);
    return static_cast<std::uint32_t>(static_cast<int>(number));
}

/// Bits of the element, of which a half of a u32 is the part that the channel holds.
std::uint32_t element_of(const Target& target, std::uint32_t bits, const fs::path& path) {
    switch (target.channel->coding) {
        case Coding::kSrgb:
            return srgb_of_half(static_cast<std::uint16_t>(bits));
        case Coding::kUnit:
            return unit_of_half(static_cast<std::uint16_t>(bits));
        case Coding::kLowHalf:
            return whole_number(target, bits, 0, 65535, path);
        case Coding::kHighHalf:
            return whole_number(target, bits, 0, 65535, path) << 16;
        default:
            break;
    }
    switch (target.layer->type) {
        case ElementType::kU8:
            return whole_number(target, bits, 0, 255, path);
        case ElementType::kU16:
            return whole_number(target, bits, 0, 65535, path);
        case ElementType::kI16:
            return whole_number(target, bits, -32768, 32767, path) & 0xFFFFu;
        case ElementType::kF16:
            return target.type == Imf::HALF ? bits : half_bits_of_float(bits);
        default:
            return bits;
    }
}

/// Puts the rows in the target's buffer into its layer; pixels beyond the layer's are left out.
void store_rows(const Target& target, const Rows& rows, const fs::path& path) {
    const std::size_t size = target.pixel_bytes();
    const LayerImage& image = *target.image;
    const std::uint32_t bytes = layout::element_size(target.layer->type);
    const bool joins = target.channel->coding == Coding::kLowHalf || target.channel->coding == Coding::kHighHalf;
    const char* in = target.buffer.data();
    for (int y = rows.first; y < rows.first + rows.count; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x, in += size) {
            const std::uint64_t pixel = static_cast<std::uint64_t>(y) * image.row + x;
            if (x >= image.row || pixel >= image.pixels) continue;
            std::uint32_t bits = 0;
            std::memcpy(&bits, in, size);
            std::uint32_t element = element_of(target, bits, path);
            std::byte* out =
                target.layer->bytes.data() + (pixel * image.components + target.channel->component) * bytes;
            if (joins) {
                std::uint32_t other = 0;
                std::memcpy(&other, out, sizeof other);
                element |= other;
            }
            std::memcpy(out, &element, bytes);
        }
}

}  // namespace

void read_exr_part(Imf::MultiPartInputFile& file, int number, const PlannedPart& part,
                   std::vector<model::Chart>& charts, const fs::path& path, std::uint64_t& budget) {
    std::vector<Target> targets = targets_of(file.header(number), part, charts, path);
    for (const PlannedLayer& planned : part.layers) {
        Layer& layer = charts[planned.number.chart].layers[planned.number.layer];
        const std::uint64_t bytes = exr_layer_bytes(layer.type, layer.shape).value_or(~std::uint64_t{0});
        if (bytes > budget)
            throw model::Error(codes::kExrUnreadable, "layer " + layer.name + " is impossibly large", path.string());
        budget -= bytes;
        layer.bytes.assign(bytes, std::byte{0});
    }
    Imf::InputPart input(file, number);
    const int width = static_cast<int>(part.width), height = static_cast<int>(part.height);
    for (int top = 0; top < height; top += kBlockRows) {
        const Rows rows{top, std::min(kBlockRows, height - top)};
        read_rows(input, targets, width, rows);
        for (const Target& target : targets) store_rows(target, rows, path);
    }
}

}  // namespace dgm::formats
