// SPDX-License-Identifier: GPL-3.0-or-later
// formats/image/jpeg_write.cpp
#include <algorithm>
#include <cstring>

#include "image/image.h"
#include "model/codes.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image_write.h>
#pragma GCC diagnostic pop

namespace dgm::formats {

std::vector<std::byte> encode_jpeg(const Image& image, int quality) {
    if (image.width == 0 || image.height == 0 || image.width > kMaxImageSide || image.height > kMaxImageSide)
        throw model::Error(model::codes::kTooLarge, "a picture of " + std::to_string(image.width) + " x " +
                                                        std::to_string(image.height) + " pixels cannot be written");
    if (image.pixels.size() != std::size_t{image.width} * image.height)
        throw model::Error(model::codes::kInternal, "pixels do not fit the picture's size");
    std::vector<std::byte> out;
    const auto append = [](void* to, void* data, int size) {
        const auto* begin = static_cast<const std::byte*>(data);
        static_cast<std::vector<std::byte>*>(to)->insert(static_cast<std::vector<std::byte>*>(to)->end(), begin,
                                                         begin + size);
    };
    if (stbi_write_jpg_to_func(append, &out, static_cast<int>(image.width), static_cast<int>(image.height), 4,
                               image.pixels.data(), std::clamp(quality, 1, 100)) == 0)
        throw model::Error(model::codes::kInternal, "the picture cannot be encoded");
    return out;
}

}  // namespace dgm::formats
