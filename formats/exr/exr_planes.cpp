// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_planes.cpp
// The plan of the map's own layers says which channels to look for; what the file says about itself may be lost.
#include "exr/exr_planes.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "exr/exr_attributes.h"
#include "exr/exr_files.h"
#include "exr/exr_headers.h"
#include "exr/exr_plan.h"
#include "exr/exr_reading.h"
#include "exr/exr_threads.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

/// One channel's pixels, as floats or as the bits of halves.
template <class Pixel>
std::vector<Pixel> read_channel(Imf::MultiPartInputFile& file, int part, const std::string& name, Imf::PixelType type) {
    const Imath::Box2i window = file.header(part).dataWindow();
    const auto width = std::int64_t{window.max.x} + 1, height = std::int64_t{window.max.y} + 1;
    std::vector<Pixel> out(static_cast<std::size_t>(width * height));
    Imf::FrameBuffer frame;
    frame.insert(name, Imf::Slice::Make(type, out.data(), Imath::V2i(0, 0), width, height, sizeof(Pixel),
                                        sizeof(Pixel) * static_cast<std::size_t>(width)));
    Imf::InputPart input(file, part);
    input.setFrameBuffer(frame);
    make_exr_threads();
    input.readPixels(0, window.max.y);
    return out;
}

const Imf::Channel* find_channel(const Imf::MultiPartInputFile& file, int part, const std::string& name) {
    const Imf::Channel* found = file.header(part).channels().findChannel(name);
    return found != nullptr && found->xSampling == 1 && found->ySampling == 1 ? found : nullptr;
}

ExrPlane::Meaning meaning_of(Coding coding) {
    switch (coding) {
        case Coding::kSrgb:
        case Coding::kUnit:
            return ExrPlane::Meaning::kCode;
        case Coding::kLowHalf:
            return ExrPlane::Meaning::kLow16;
        case Coding::kHighHalf:
            return ExrPlane::Meaning::kHigh16;
        default:
            return ExrPlane::Meaning::kValue;
    }
}

/// The planes of one map, gathered from its files.
class PlaneReader {
 public:
    PlaneReader(const fs::path& path, const std::vector<model::Chart>& charts, const ExrReadLimits& limits)
        : path_(path), charts_(charts), limits_(limits) {}

    std::vector<ExrPlane> read() {
        {
            const std::uint64_t budget = exr_budget(path_, limits_);
            static_cast<void>(budget);
            const Imf::MultiPartInputFile own(path_.c_str(), 0, false);
            const auto* side = own.header(0).findTypedAttribute<Imf::StringAttribute>(kSideFileAttribute);
            if (side != nullptr) side_name_ = side->value();
            for (int part = 0; part < own.parts(); ++part)
                for (auto c = own.header(part).channels().begin(); c != own.header(part).channels().end(); ++c)
                    own_channels_.insert(c.name());
        }
        // The layout may be lost with the attributes. It is the one that knows more of the channels: files of layers of
        // another size look alike in both.
        std::vector<ExrPlane> found;
        for (const ExrLayout layout : {ExrLayout::kAuto, ExrLayout::kMultipart}) {
            const ExrPlan plan = plan_exr(charts_, layout);
            planes_.clear();
            for (const PlannedFile& file : plan.files) read_file(file);
            if (planes_.size() > found.size()) std::swap(planes_, found);
        }
        if (!found.empty()) return found;
        std::string names;
        for (const std::string& name : own_channels_) names += (names.empty() ? "" : ", ") + name;
        throw model::Error(codes::kEditUnrelated, "none of its channels is one of the map's; it has " + names,
                           path_.string());
    }

 private:
    /// Where a file of the plan lies, if it is there.
    [[nodiscard]] std::optional<fs::path> place_of(const PlannedFile& plan) const {
        if (side_name_) return plan.name == *side_name_ ? std::optional(path_) : std::nullopt;
        if (plan.name.empty()) return path_;
        fs::path side = exr_side_path(path_, plan.name);
        std::error_code error;
        return fs::is_regular_file(side, error) ? std::optional(std::move(side)) : std::nullopt;
    }

    void read_file(const PlannedFile& plan) {
        const std::optional<fs::path> place = place_of(plan);
        if (!place) return;
        std::uint64_t budget = exr_budget(*place, limits_);
        Imf::MultiPartInputFile file(place->c_str(), 0, false);
        for (const PlannedPart& part : plan.parts)
            for (const PlannedLayer& layer : part.layers)
                for (const Channel& channel : layer.image.channels)
                    if (channel.is_read()) read_plane(file, part, layer, channel, *place, budget);
    }

    void read_plane(Imf::MultiPartInputFile& file, const PlannedPart& plan, const PlannedLayer& layer,
                    const Channel& channel, const fs::path& place, std::uint64_t& budget) {
        int part = 0;
        while (part < file.parts() && find_channel(file, part, channel.name) == nullptr) ++part;
        if (part == file.parts()) return;
        const Imath::Box2i window = file.header(part).dataWindow();
        if (window.max.x + 1 != static_cast<int>(plan.width) || window.max.y + 1 != static_cast<int>(plan.height))
            throw model::Error(codes::kEditUnrelated,
                               "channel " + channel.name + " has " + std::to_string(window.max.x + 1) + " x " +
                                   std::to_string(window.max.y + 1) + " pixels, the map's layer " +
                                   std::to_string(plan.width) + " x " + std::to_string(plan.height),
                               place.string());
        const std::uint64_t bytes = layer.image.pixels * sizeof(float);
        if (bytes > budget) throw model::Error(codes::kExrUnreadable, "the file is impossibly large", place.string());
        budget -= bytes;
        ExrPlane out{
            layer.number.chart, layer.number.layer, channel.component, meaning_of(channel.coding), false, place, {}};
        out.is_half = find_channel(file, part, channel.name)->type == Imf::HALF;
        if (out.meaning == ExrPlane::Meaning::kCode) {
            const auto code = channel.coding == Coding::kSrgb ? srgb_of_half : unit_of_half;
            out.values =
                picked(layer.image, plan.width, read_channel<std::uint16_t>(file, part, channel.name, Imf::HALF), code);
        } else {
            out.values = picked(layer.image, plan.width, read_channel<float>(file, part, channel.name, Imf::FLOAT),
                                [](float value) { return value; });
        }
        planes_.push_back(std::move(out));
    }

    /// The pixels that are the layer's, in its order.
    template <class Pixel, class Decode>
    static std::vector<float> picked(const LayerImage& image, std::uint32_t width, const std::vector<Pixel>& pixels,
                                     const Decode& decode) {
        std::vector<float> out(image.pixels);
        for (std::uint64_t k = 0; k < image.pixels; ++k)
            out[k] = static_cast<float>(decode(pixels[k / image.row * width + k % image.row]));
        return out;
    }

    const fs::path& path_;
    const std::vector<model::Chart>& charts_;
    const ExrReadLimits& limits_;
    std::optional<std::string> side_name_;
    std::set<std::string> own_channels_;
    std::vector<ExrPlane> planes_;
};

/// Which channels of a picture to take: of R G B (A), of Y, or the only one.
std::vector<std::string> picture_channels(const Imf::Header& header, const fs::path& path) {
    const Imf::ChannelList& channels = header.channels();
    const auto has = [&](const char* name) { return channels.findChannel(name) != nullptr; };
    if (has("R") && has("G") && has("B"))
        return has("A") ? std::vector<std::string>{"R", "G", "B", "A"} : std::vector<std::string>{"R", "G", "B"};
    if (has("Y")) return {"Y"};
    auto first = channels.begin();
    if (first == channels.end()) throw model::Error(codes::kExrUnreadable, "it has no channel", path.string());
    auto second = first;
    if (++second != channels.end())
        throw model::Error(codes::kExrUnreadable, "its channels are neither R, G, B nor Y nor a single one",
                           path.string());
    return {first.name()};
}

std::vector<ExrPlane> planes_here(const fs::path& path, const std::vector<model::Chart>& charts,
                                  const ExrReadLimits& limits) {
    return reading(path, [&] { return PlaneReader(path, charts, limits).read(); });
}

ExrPicture picture_here(const fs::path& path, const ExrReadLimits& limits) {
    return reading(path, [&] {
        const std::uint64_t budget = exr_budget(path, limits);
        Imf::MultiPartInputFile file(path.c_str(), 0, false);
        const std::vector<std::string> names = picture_channels(file.header(0), path);
        const Imath::Box2i window = file.header(0).dataWindow();
        ExrPicture out;
        out.width = static_cast<std::uint32_t>(window.max.x) + 1;
        out.height = static_cast<std::uint32_t>(window.max.y) + 1;
        out.channels = static_cast<std::uint32_t>(names.size());
        const std::size_t pixels = std::size_t{out.width} * out.height;
        if (pixels * out.channels * sizeof(float) > 2 * budget)  // halves come as floats
            throw model::Error(codes::kExrUnreadable, "the file is impossibly large", path.string());
        out.pixels.resize(pixels * out.channels);
        for (std::size_t c = 0; c < names.size(); ++c) {
            const Imf::Channel* channel = find_channel(file, 0, names[c]);
            if (channel == nullptr)
                throw model::Error(codes::kExrUnreadable, "channel " + names[c] + " has fewer pixels than the picture",
                                   path.string());
            out.is_half = out.is_half || channel->type == Imf::HALF;
            const auto values = read_channel<float>(file, 0, names[c], Imf::FLOAT);
            for (std::size_t k = 0; k < pixels; ++k) out.pixels[k * out.channels + c] = values[k];
        }
        return out;
    });
}

bool has_description_here(const fs::path& path) {
    return reading(path, [&] {
        static_cast<void>(exr_budget(path, {}));
        const Imf::MultiPartInputFile file(path.c_str(), 0, false);
        return file.header(0).find(kLayoutVersionAttribute) != file.header(0).end();
    });
}

ExrPlaneReader& plane_reader() {
    static ExrPlaneReader reader = exr_plane_reader_here();
    return reader;
}

}  // namespace

std::vector<ExrPlane> read_exr_planes(const fs::path& path, const std::vector<model::Chart>& charts,
                                      const ExrReadLimits& limits) {
    return plane_reader().planes(path, charts, limits);
}

ExrPicture read_exr_picture(const fs::path& path, const ExrReadLimits& limits) {
    return plane_reader().picture(path, limits);
}

bool has_exr_description(const fs::path& path) noexcept {
    try {
        return plane_reader().has_description(path);
    } catch (const std::exception&) { return false; }
}

const ExrPlaneReader& exr_plane_reader_here() {
    static const ExrPlaneReader here{planes_here, picture_here, has_description_here};
    return here;
}

void set_exr_plane_reader(ExrPlaneReader reader) {
    plane_reader() = reader.planes ? std::move(reader) : exr_plane_reader_here();
}

}  // namespace dgm::formats
