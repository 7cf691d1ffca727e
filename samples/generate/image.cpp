// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/image.cpp
#include "image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "model/codes.h"

namespace dgm::samples {
namespace {

std::uint8_t to_byte(double v) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 1.0) * 255));
}

// The simplified interface writes no time and no text chunks, so equal pixels give equal files.
void write_png(const std::vector<std::uint8_t>& bytes, int width, int height, png_uint_32 format,
               const std::filesystem::path& path) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = format;
    if (png_image_write_to_file(&image, path.c_str(), 0, bytes.data(), 0, nullptr) == 0)
        throw model::Error(model::codes::kWriteFailed, std::string("PNG: ") + image.message, path.string());
}
}  // namespace

void write_colour_png(const Picture& picture, const std::filesystem::path& path) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(picture.colour.size() * 3);
    for (const Colour& c : picture.colour)
        for (int k = 0; k < 3; ++k) bytes.push_back(to_byte(c[k]));
    write_png(bytes, picture.width, picture.height, PNG_FORMAT_RGB, path);
}

void write_relief_png(const Picture& picture, const std::filesystem::path& path) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(picture.relief.size());
    for (const double h : picture.relief) bytes.push_back(to_byte(h));
    write_png(bytes, picture.width, picture.height, PNG_FORMAT_GRAY, path);
}

}  // namespace dgm::samples
