// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_image.cpp
#include "exr/exr_image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

#include <cstddef>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "exr/exr_stream.h"
#include "model/codes.h"

namespace dgm::formats {

namespace fs = std::filesystem;

void write_exr_image(const fs::path& path, std::uint32_t width, std::uint32_t height, std::string_view channels,
                     std::span<const float> pixels) {
    const std::size_t stride = channels.size() * sizeof(float);
    if (width == 0 || height == 0 || channels.empty() || pixels.size() != std::size_t{width} * height * channels.size())
        throw model::Error(model::codes::kInternal, "a picture's pixels do not fit its size", path.string());
    try {
        Imf::Header header(static_cast<int>(width), static_cast<int>(height));
        header.compression() = Imf::ZIP_COMPRESSION;
        Imf::FrameBuffer frame;
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::string name(1, channels[c]);
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
            // OpenEXR reads through a pointer to char that is not const.
            char* first = const_cast<char*>(reinterpret_cast<const char*>(pixels.data() + c));
            frame.insert(name, Imf::Slice(Imf::FLOAT, first, stride, stride * width));
        }
        ExrStream stream(path);
        {
            Imf::OutputFile file(stream, header, 0);
            file.setFrameBuffer(frame);
            file.writePixels(static_cast<int>(height));
        }
        stream.finish();
    } catch (const std::exception& e) {
        std::error_code error;
        if (fs::is_regular_file(path, error)) fs::remove(path, error);
        if (dynamic_cast<const std::bad_alloc*>(&e) != nullptr) throw;
        throw exr_failure(e, path);
    }
}

}  // namespace dgm::formats
